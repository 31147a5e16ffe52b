//! GRBL 1.1, as its senders expect it: its commands, its settings, its reports. Its numbers of errors and
//! alarms, and its one answer for each line, are where text meets a sender: [`base::grbl`].
//!
//! Lines are read and written by modules that know no machine; `commands.rs` carries the commands out, and
//! [`Feature`] takes the bytes that act at once.
//! Facts: Grbl 1.1's interface, configuration, jogging and real-time pages (github.com/gnea/grbl,
//! `doc/markdown`).

use base::Ports;
use base::failure::{Failure, Outcome};
use base::reason::Reason;
use base::sessions::{Listing, Recipient, Reply, SessionId};
use config::MachineConfig;
use gcode::Code;
use gcode::realtime::Realtime;
use program::Dialect;

use crate::features::States;
use crate::machine::moments::{Moments, StartupLine};
use crate::machine::{Machine, jogging};

pub(crate) mod commands;
pub(crate) mod hal;
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

impl<'c, P: Ports> Moments<Machine<'c, P>> for Feature {
    fn banner(config: &MachineConfig) -> Option<&'static str> {
        config.general.grblhal.then_some(hal::BANNER)
    }

    fn read_files(machine: &mut Machine<'_, P>) {
        let Machine { safety, frames, features: States { grbl, .. }, world, .. } = machine;
        startup::read(world, &mut grbl.own);
        if world.config.general.usual_dialect() == Dialect::Grbl {
            startup::begin(&grbl.own, safety.state(), frames);
        }
    }

    fn take_request(machine: &mut Machine<'_, P>, request: Realtime, id: SessionId) -> bool {
        let to = Recipient::Session(id);
        let is_grbl = machine.world.sessions.dialect_of(to) == Dialect::Grbl;
        match request {
            Realtime::Status if is_grbl => commands::report_status(machine, id),
            Realtime::StatusInFull if !machine.world.config.general.grblhal => {}
            Realtime::StatusInFull => {
                if let Some(told) = machine.features.grbl.told.get_mut(usize::from(id.0)) {
                    told.wants_all = true;
                }
                machine.world.ports.inbox(id).request(Realtime::Status);
            }
            Realtime::Abort if is_grbl => commands::reset(machine, id),
            Realtime::Hold if commands::jogs(machine, to) => {
                jogging::cancel(&mut machine.world, &mut machine.safety, id)
            }
            request if overrides::are_changed_by(request) => commands::change(machine, request, id),
            _ => return false,
        }
        true
    }

    fn owns_console_line(machine: &Machine<'_, P>, line: &str, to: Recipient) -> bool {
        commands::owns(machine.world.sessions, line, to)
    }

    fn run_console_line(machine: &mut Machine<'_, P>, line: &str, to: Recipient) -> Option<Outcome> {
        let command = line.strip_prefix('$').filter(|_| commands::owns(machine.world.sessions, line, to))?;
        Some(commands::run(machine, command, to))
    }

    fn refuse_codes(machine: &mut Machine<'_, P>, to: Recipient) -> bool {
        let jogs = commands::jogs(machine, to);
        if jogs {
            machine.world.sessions.refuse(to, Reason::Locked, format_args!("a jog is under way: 0x85 ends it"));
        }
        jogs
    }

    fn accepts(code: Code) -> bool {
        state::accepts(code)
    }

    fn long_answer(
        machine: &mut Machine<'_, P>,
        listing: &mut Listing,
        to: Recipient,
    ) -> Option<Result<bool, Failure>> {
        let Listing::Enumeration { list, line } = listing else { return None };
        *line += 1;
        Some(Ok(hal::list_line(*list, *line - 1, &mut Reply::new(machine.world.sessions, to))))
    }

    fn startup_line_ended(machine: &mut Machine<'_, P>, number: u8, outcome: &Outcome) {
        startup::ended(machine.world.sessions, &machine.features.grbl.own, number, outcome);
    }

    fn startup_line(machine: &Machine<'_, P>, number: u8) -> Option<StartupLine> {
        machine.features.grbl.own.startup.get(usize::from(number)).cloned()
    }
}
