//! Startup lines (`$N0`, `$N1`): run at boot behind the saved settings, and after a reset.

use base::failure::Outcome;
use base::reason::Reason;
use base::sessions::{Recipient, Sessions};
use base::{Ports, World};
use program::State;

use super::state::Own;
use super::stored;
use crate::machine::frames::{Frame, Frames};

/// Reads the stored settings of GRBL's dialect at boot.
pub(crate) fn read<P: Ports>(world: &mut World<'_, P>, own: &mut Own) {
    match stored::read(&mut world.ports) {
        Ok(stored) => *own = stored,
        Err(error) => world.announce(format_args!("ERROR: {}: {}\n", stored::PATH, error.text())),
    }
}

/// Has the startup lines run next, where the machine is ready.
pub(crate) fn begin<S>(own: &Own, state: State, frames: &mut Frames<'_, S>) {
    let has_lines = own.startup.iter().any(|line| !line.is_empty());
    if has_lines && state == State::Idle {
        // A full stack means that too much is under way to begin.
        let _ = frames.push(Frame::Startup(0));
    }
}

/// Says a startup line that has ended, with its answer.
pub(crate) fn ended(sessions: &mut Sessions, own: &Own, number: u8, outcome: &Outcome) {
    let Some(text) = own.startup.get(usize::from(number)) else { return };
    match outcome {
        Ok(_) => sessions.say(Recipient::All, format_args!(">{text}:ok\n")),
        Err(why) => {
            let error = if why.has_text() { why.reason } else { Reason::Locked };
            sessions.say(Recipient::All, format_args!(">{text}:error:{}\n", error.number()));
        }
    }
}
