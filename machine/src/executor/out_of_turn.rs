//! Commands that do not wait for the line in work: `abort`, M524 and M410 end it, M108 ends its wait, and
//! pauses leave a wait of the job, which is read again when the job resumes.
//!
//! A line is ended as a halt ends it: each of its waits returns `Halted`, and so do those of everything it
//! has started. Motion comes to rest before any other line is read.

use base::failure::Failure;
use base::reason::Alarm;
use base::sessions::{Recipient, SessionId, Sessions};
use base::{Ports, World};
use config::{ButtonWord, MachineConfig};
use gcode::{Blocks, Code, Letter, Line};
use jobs::player::Jobs;
use jobs::player::line_numbers::decoder_expecting;
use parts::buttons::Buttons;
use parts::outputs::Outputs;
use program::{Dialect, Dialects};

use super::stack;
use crate::machine::abort::AbortHands;
use crate::machine::end_requests::{Asked, Ends, Requester};
use crate::machine::feed_hold::FeedHoldHands;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::{Machine, abort, feed_hold};

/// The machine for requests that do not wait for the line in work.
pub(crate) trait UrgentHands<'c>: AbortHands<'c> + FeedHoldHands<'c> {
    /// Returns the requests.
    fn urgent(&mut self) -> &mut Asked;

    /// Returns the requests, and the jobs that they end.
    fn urgent_and_jobs(&mut self) -> (&mut Asked, &Jobs);

    /// Returns the requests, and the world that they come from.
    fn urgent_in_world(&mut self) -> (&mut Asked, &mut World<'c, Self::Ports>);

    /// Whether lines of a job are read over.
    fn reads_over(&self) -> bool;

    /// Returns the lines that inputs have sent and that have not been carried out.
    fn input_lines(&self) -> impl Iterator<Item = &str>;
}

impl<'c, P: Ports> UrgentHands<'c> for Machine<'c, P> {
    fn urgent(&mut self) -> &mut Asked {
        &mut self.urgent
    }

    fn urgent_and_jobs(&mut self) -> (&mut Asked, &Jobs) {
        (&mut self.urgent, &self.jobs)
    }

    fn urgent_in_world(&mut self) -> (&mut Asked, &mut World<'c, P>) {
        (&mut self.urgent, &mut self.world)
    }

    fn reads_over(&self) -> bool {
        self.passed.is_some()
    }

    fn input_lines(&self) -> impl Iterator<Item = &str> {
        let wished = Features::<P>::line(self);
        inputs(&self.outputs, &self.buttons, self.world.config, wished)
    }
}

/// Returns how much of the work in progress a line ends; `None` if it waits its turn.
pub(crate) fn of_line(line: &Line<'_>, dialect: Dialect) -> Option<Ends> {
    match line {
        Line::Console(command) => of_command(command),
        Line::Extended(command) => of_command(command.name()),
        Line::Code(blocks) => of_codes(blocks, dialect),
        _ => None,
    }
}

fn of_command(line: &str) -> Option<Ends> {
    match line {
        "abort" | "CANCEL_PRINT" => Some(Ends::Everything),
        "pause" | "PAUSE" => Some(Ends::Wait),
        _ => line.starts_with("suspend").then_some(Ends::Wait),
    }
}

fn of_codes(blocks: &Blocks<'_>, dialect: Dialect) -> Option<Ends> {
    match m_number(blocks)? {
        524 => Some(Ends::Everything),
        25 | 26 | 600 => Some(Ends::Wait),
        601 if Dialects::PRINTERS.has(dialect) => Some(Ends::Wait),
        _ => None,
    }
}

/// Returns the number of the M-code that a line begins with.
fn m_number(blocks: &Blocks<'_>) -> Option<u16> {
    let Code { letter, number, .. } = blocks.clone().next()?.ok()?.code?;
    (letter == Letter::M).then_some(number)
}

/// Ends the operator's pause of a job, or else the wait in progress (M108).
pub(crate) fn end_wait<'c>(hands: &mut impl UrgentHands<'c>) {
    if !hands.operator_is_done() {
        hands.urgent().end_wait();
    }
}

/// Notes a request that does not wait for its turn, as long as there is a job.
pub(crate) fn ask(urgent: &mut Asked, jobs: &Jobs, requester: Requester, ends: Option<Ends>) {
    // A pause does not take back a request to end everything.
    let ends_everything = matches!(urgent.asked, Some((_, Ends::Everything)));
    let counts = !ends_everything && (jobs.is_open() || jobs.is_suspended());
    if let Some(ends) = ends.filter(|_| counts) {
        urgent.asked = Some((requester, ends));
    }
}

/// Looks at the lines that inputs have sent and that have not been carried out. M112, M410 and M108 act now,
/// as they do for a session; their lines do no more in their turn.
#[cold]
pub(crate) fn ask_for_inputs<'c>(hands: &mut impl UrgentHands<'c>) {
    let sends = |code| hands.input_lines().any(|line| code_of(line) == Some(code));
    let [stops, quick_stops, ends_wait] = [112, 410, 108].map(sends);
    if stops {
        hands.halt(Alarm::Abort, format_args!("ALARM: Emergency stop (M112)\n"));
    } else if quick_stops {
        quick_stop(hands);
    } else if ends_wait && hands.urgent().awaits_operator {
        feed_hold::resume(hands);
    } else if ends_wait {
        end_wait(hands);
    }
    let dialect = hands.world().config.general.own_dialect();
    let of_input = |line: &str| match ButtonWord::of(line) {
        Some(_) => Some(Ends::Wait),
        None => {
            decoder_expecting(line.as_bytes()).decode(line.as_bytes()).ok().and_then(|line| of_line(&line, dialect))
        }
    };
    let all = hands.input_lines().filter_map(of_input);
    let ends = all.reduce(|one, other| if one == Ends::Everything { one } else { other });
    if ends.is_some() {
        let (urgent, jobs) = hands.urgent_and_jobs();
        ask(urgent, jobs, Requester::Input, ends);
    }
}

/// Returns the number of the M-code that an input's line begins with.
fn code_of(line: &str) -> Option<u16> {
    match decoder_expecting(line.as_bytes()).decode(line.as_bytes()) {
        Ok(Line::Code(blocks)) => m_number(&blocks),
        _ => None,
    }
}

/// Returns the lines that inputs have sent and that have not been carried out; `wished`: the line that a
/// feature would like to have run.
fn inputs<'m>(
    outputs: &'m Outputs,
    buttons: &'m Buttons,
    config: &'m MachineConfig,
    wished: Option<&'m str>,
) -> impl Iterator<Item = &'m str> {
    outputs
        .commands(config)
        .map(|line| line.as_str())
        .chain(wished)
        .chain(buttons.lines(config).map(|line| line.as_str()))
}

/// Returns the session whose turn it is.
pub(crate) fn next_session<'c>(hands: &mut impl UrgentHands<'c>, path_is_full: bool) -> Option<SessionId> {
    match hands.urgent().first() {
        None => hands.world().sessions.next_ready(path_is_full),
        Some(Requester::Session(first)) => {
            let (urgent, world) = hands.urgent_in_world();
            take_first(urgent, world.sessions, first)
        }
        Some(Requester::Input) => {
            if hands.input_lines().next().is_none() {
                hands.urgent().asked = None;
            }
            None
        }
    }
}

/// Returns the session whose line comes before all others, if that can be read.
#[cold]
fn take_first(urgent: &mut Asked, sessions: &Sessions, first: SessionId) -> Option<SessionId> {
    let session = sessions.get(first).filter(|session| session.waiting().is_some());
    let is_ready = session.is_some_and(|session| session.is_ready(false));
    if is_ready || session.is_none() {
        urgent.asked = None;
    }
    is_ready.then_some(first)
}

/// Ends the work in progress, if that was asked for. A fast-forward ends by itself.
pub(crate) fn follow<'c>(hands: &mut impl UrgentHands<'c>) {
    let is_asked = matches!(hands.urgent().asked, Some((_, Ends::Everything)));
    if is_asked && !hands.urgent().ends_everything() && !hands.reads_over() {
        end_everything(hands);
    }
}

/// Stops the work in progress (M410), and pauses the file.
pub(crate) fn quick_stop<'c>(hands: &mut impl UrgentHands<'c>) {
    if hands.is_halted() || hands.reads_over() {
        return;
    }
    if hands.jobs().is_playing() {
        hands.announce(format_args!("// NOTE stopped (M410): M24 goes on with the next line, abort ends the job\n"));
        hands.world().sessions.tell_hosts("paused", Recipient::Nobody);
    }
    end_everything(hands);
}

/// Brakes the motors, drops the queue, and pauses the file.
fn end_everything<'c>(hands: &mut impl UrgentHands<'c>) {
    hands.jobs().set_paused(true);
    abort::drop_queued(hands);
    hands.urgent().ends = Some(Ends::Everything);
}

/// Ends everything that the ended line has started, and brings motion to rest.
#[cold]
pub(crate) fn settle<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.urgent.ends_everything() {
        if !machine.frames.is_empty() {
            stack::fail(machine, Failure::HALTED);
        }
        Features::<P>::work_ends(machine);
        machine.urgent.ends = None;
        if let Some((_, ends)) = &mut machine.urgent.asked {
            // The request has ended everything already.
            *ends = Ends::Wait;
        }
        // A halt meanwhile ends everything all the same.
        let _ = machine.standstill();
        machine.resynchronise();
        Features::<P>::work_was_ended(machine);
    }
    machine.urgent.ends = None;
}
