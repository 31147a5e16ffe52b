//! Sends the reports that sessions get without asking: temperatures (M155), progress of the file (M27 S), and
//! `busy` while a line is in work (M113).

use base::failure::{Answer, Failure, Outcome};
use base::sessions::{Listing, Periodic, Recipient, Reply, SessionId, Sessions};
use base::{Ports, World};
use gcode::{Code, Line};
use parts::heat_codes;
use program::{Dialect, State, Words};
use units::Micros;

use crate::features::forecast::{self, ForecastHands};
use crate::machine::Machine;
use crate::machine::moments::Moments;

/// Time between two looks at what is due.
const PERIOD: Micros = Micros(20_000);

/// The code that asks for temperatures.
const M105: u16 = 105;

/// The machine for reports that nobody asks for.
pub(crate) trait ReportHands<'c>: ForecastHands<'c> {
    /// Returns the earliest time of the next reports, and the sessions that get them.
    fn due(&mut self) -> (&mut Micros, &Sessions);

    /// Whether the operator or the door holds the machine.
    fn is_held(&self) -> bool;

    /// Whether the lines of this session go into a file.
    fn takes_lines_of(&self, id: SessionId) -> bool;
}

impl<'c, P: Ports> ReportHands<'c> for Machine<'c, P> {
    fn due(&mut self) -> (&mut Micros, &Sessions) {
        (&mut self.polls.reports_due, self.world.sessions)
    }

    fn is_held(&self) -> bool {
        matches!(self.safety.state(), State::Hold | State::Door)
    }

    fn takes_lines_of(&self, id: SessionId) -> bool {
        self.files.takes_lines_of(id)
    }
}

/// Reports that nobody asks for, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: ReportHands<'c>> Moments<M> for Feature {
    fn each_10_ms(hands: &mut M, now: Micros) {
        tell(hands, now);
    }

    fn answer_in_upload(hands: &mut M, line: &Line<'_>, to: Recipient) -> bool {
        answers_in_upload(hands.world(), line, to)
    }
}

/// Sets the reports of M155, M27 S and M113.
pub(crate) fn command<P: Ports>(world: &mut World<'_, P>, what: Periodic, words: &Words<'_>, to: Recipient) -> Outcome {
    let now = world.ports.now();
    let Some(session) = to.session().and_then(|id| world.sessions.get_mut(id)) else { return Ok(Answer::Ok) };
    if session.dialect == Dialect::Grbl {
        return Err(Failure::refused(&"senders of GRBL's dialect ask with ?"));
    }
    match words.get('S') {
        Some(seconds) => session.periods.set(what, seconds as u8, now),
        None if what == Periodic::Busy => {
            let seconds = session.periods.seconds(what, session.dialect);
            session.say(format_args!("M113 S{seconds}\n"));
        }
        None => {}
    }
    Ok(Answer::Ok)
}

/// Answers M105 within a file that is sent, as well as taking it as a line: hosts go on asking.
fn answers_in_upload<P: Ports>(world: &mut World<'_, P>, line: &Line<'_>, to: Recipient) -> bool {
    let Line::Code(blocks) = line else { return false };
    let asks = blocks.clone().next().and_then(Result::ok).is_some_and(|block| block.is(Code::m(M105)));
    if asks {
        let World { ports, config, sessions, .. } = world;
        heat_codes::report_temperatures(ports, config, M105, ("ok ", &mut Reply::new(sessions, to)));
    }
    asks
}

/// Sends all reports that are due. Periods are whole seconds: not each turn of a wait needs to look.
pub(crate) fn tell<'c>(hands: &mut impl ReportHands<'c>, now: Micros) {
    let (due, sessions) = hands.due();
    if now < *due {
        return;
    }
    *due = now.plus(PERIOD);
    for id in sessions.ids() {
        let to = Recipient::Session(id);
        let (is_held, takes_lines) = (hands.is_held(), hands.takes_lines_of(id));
        let Some(session) = hands.world().sessions.get_mut(id) else { continue };
        let [temperatures, job, busy] = session.take_due(now);
        let sends_file = takes_lines || matches!(session.listing, Some(Listing::Transfer));
        if sends_file || !session.has_room_for_listing() {
            continue;
        }
        if busy {
            session.say(format_args!("echo:busy: {}\n", if is_held { "paused for user" } else { "processing" }));
        }
        if temperatures {
            let World { ports, config, sessions, .. } = hands.world();
            heat_codes::report_temperatures(ports, config, M105, ("", &mut Reply::new(sessions, to)));
        }
        if job {
            forecast::say_bytes(&mut hands.forecast(), to);
        }
    }
}
