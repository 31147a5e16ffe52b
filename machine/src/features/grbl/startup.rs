//! Startup lines (`$N0`, `$N1`): run at boot behind the saved settings, and after a reset.

use base::failure::Outcome;
use base::reason::Reason;
use base::sessions::Recipient;
use base::{Ports, World};
use program::{Dialect, State};

use crate::features::grbl::stored;
use crate::features::state::States;
use crate::machine::Machine;
use crate::machine::frames::Frame;

/// Reads the stored settings of GRBL's dialect at boot, and has its startup lines run.
pub(crate) fn read<P: Ports>(machine: &mut Machine<'_, P>) {
    match stored::read(&mut machine.world.ports) {
        Ok(own) => machine.features.grbl.own = own,
        Err(error) => machine.announce(format_args!("ERROR: {}: {}\n", stored::PATH, error.text())),
    }
    if machine.world.config.general.usual_dialect() == Dialect::Grbl {
        begin(machine);
    }
}

/// Has the startup lines run next, where the machine is ready.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>) {
    let has_lines = machine.features.grbl.own.startup.iter().any(|line| !line.is_empty());
    if has_lines && machine.safety.state() == State::Idle {
        // A full stack means that too much is under way to begin.
        let _ = machine.frames.push(Frame::Startup(0));
    }
}

/// Says a startup line that has ended, with its answer.
pub(crate) fn ended<P: Ports>(machine: &mut Machine<'_, P>, number: u8, outcome: &Outcome) {
    let Machine { features: States { grbl, .. }, world: World { sessions, .. }, .. } = machine;
    let Some(text) = grbl.own.startup.get(usize::from(number)) else { return };
    match outcome {
        Ok(_) => sessions.say(Recipient::All, format_args!(">{text}:ok\n")),
        Err(why) => {
            let error = if why.has_text() { why.reason } else { Reason::Locked };
            sessions.say(Recipient::All, format_args!(">{text}:error:{}\n", error.number()));
        }
    }
}
