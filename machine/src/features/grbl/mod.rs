//! GRBL 1.1, as its senders expect it: its commands, its settings, its reports. Its numbers of errors and
//! alarms, and its one answer for each line, are where text meets a sender: [`base::grbl`].
//!
//! Lines are read and written by modules that know no machine; `commands.rs` carries the commands out, and
//! [`Feature`] takes the bytes that act at once.
//! Facts: Grbl 1.1's interface, configuration, jogging and real-time pages (github.com/gnea/grbl,
//! `doc/markdown`).

use base::failure::{Failure, Outcome};
use base::reason::Reason;
use base::sessions::{Consoles as _, Listing, Recipient, Reply, SessionId};
use config::MachineConfig;
use gcode::Code;
use gcode::realtime::Realtime;
use program::Dialect;

use self::hands::{GrblHands, Spoken};
use crate::machine::jogging;
use crate::machine::moments::{Moments, StartupLine};

pub(crate) mod commands;
pub(crate) mod hal;
pub(crate) mod hands;
pub(crate) mod jog;
pub(crate) mod last_report;
pub(crate) mod numbered_settings;
pub(crate) mod overrides;
pub(crate) mod reports;
pub(crate) mod startup;
pub(crate) mod state;
pub(crate) mod status;
pub(crate) mod stored;

/// GRBL's dialect at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: GrblHands<'c>> Moments<M> for Feature {
    fn banner(config: &MachineConfig) -> Option<&'static str> {
        config.general.grblhal.then_some(hal::BANNER)
    }

    fn read_files(hands: &mut M) {
        let Spoken { world, grbl, .. } = hands.spoken();
        startup::read(world, &mut grbl.own);
        if world.config.general.usual_dialect() == Dialect::Grbl {
            hands.begin_startup();
        }
    }

    fn take_request(hands: &mut M, request: Realtime, id: SessionId) -> bool {
        let to = Recipient::Session(id);
        let is_grbl = hands.sessions().dialect_of(to) == Dialect::Grbl;
        match request {
            Realtime::Status if is_grbl => {
                hands.follow_job();
                commands::report_status(hands.spoken(), id);
            }
            Realtime::StatusInFull if !hands.world().config.general.grblhal => {}
            Realtime::StatusInFull => {
                let Spoken { grbl, world, .. } = hands.spoken();
                if let Some(told) = grbl.told.get_mut(usize::from(id.0)) {
                    told.wants_all = true;
                }
                world.ports.inbox(id).request(Realtime::Status);
            }
            Realtime::Abort if is_grbl => commands::reset(hands, id),
            Realtime::Hold if commands::jogs(hands, to) => {
                let Spoken { world, safety, .. } = hands.spoken();
                jogging::cancel(world, safety, id);
            }
            request if overrides::are_changed_by(request) => commands::change(hands.spoken(), request, id),
            _ => return false,
        }
        true
    }

    fn owns_console_line(hands: &M, line: &str, to: Recipient) -> bool {
        commands::owns(hands.sessions(), line, to)
    }

    fn run_console_line(hands: &mut M, line: &str, to: Recipient) -> Option<Outcome> {
        let command = line.strip_prefix('$').filter(|_| commands::owns(hands.sessions(), line, to))?;
        Some(commands::run(hands, command, to))
    }

    fn refuse_codes(hands: &mut M, to: Recipient) -> bool {
        let jogs = commands::jogs(hands, to);
        if jogs {
            hands.world().sessions.refuse(to, Reason::Locked, format_args!("a jog is under way: 0x85 ends it"));
        }
        jogs
    }

    fn accepts(code: Code) -> bool {
        state::accepts(code)
    }

    fn long_answer(hands: &mut M, listing: &mut Listing, to: Recipient) -> Option<Result<bool, Failure>> {
        let Listing::Enumeration { list, line } = listing else { return None };
        *line += 1;
        Some(Ok(hal::list_line(*list, *line - 1, &mut Reply::new(hands.world().sessions, to))))
    }

    fn startup_line_ended(hands: &mut M, number: u8, outcome: &Outcome) {
        let Spoken { world, grbl, .. } = hands.spoken();
        startup::ended(world.sessions, &grbl.own, number, outcome);
    }

    fn startup_line(hands: &M, number: u8) -> Option<StartupLine> {
        hands.grbl().own.startup.get(usize::from(number)).cloned()
    }
}
