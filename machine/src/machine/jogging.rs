//! Jogs that are let go of: planned, under way, or waiting in a session.

use base::safety::{Event, Safety};
use base::sessions::{SessionId, Sessions};
use base::{Ports, World};
use program::{Dialect, State};

/// Whether a line is a jog that its sender has let go of since: it is answered, for the count, and not begun.
pub(crate) fn is_dropped(sessions: &mut Sessions, id: SessionId, line: &[u8]) -> bool {
    let Some(session) = sessions.get_mut(id).filter(|session| session.let_go_behind_line()) else {
        return false;
    };
    let is_jog = line.trim_ascii_start().get(..2).is_some_and(|word| word.eq_ignore_ascii_case(b"$J"));
    // Smoothieware's jog is answered here only with one of these options.
    let is_answered = session.dialect != Dialect::Grbl && line.windows(2).any(|option| matches!(option, b"-c" | b"-r"));
    if is_jog && is_answered {
        session.say(format_args!("ok\n"));
    }
    is_jog
}

/// Cancels jogs (0x85, Ctrl-Y, and `!` while jogging): brakes, and drops those that wait, planned or not.
pub(crate) fn cancel<P: Ports>(World { ports, sessions, .. }: &mut World<'_, P>, safety: &mut Safety, id: SessionId) {
    if let Some(session) = sessions.get_mut(id) {
        session.drop_jogs(ports.inbox(id));
    }
    if !safety.mode().is_in(State::Jog) {
        return;
    }
    if safety.state() != State::Jog {
        safety.apply(Event::Resume);
    }
    ports.motion(motion::Motion::stop);
}
