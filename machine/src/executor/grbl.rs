//! Carries out GRBL's commands: what begins with `$`, and the bytes that act at once.

use gcode::realtime::Realtime;
use program::{Dialect, State};
use units::{Axis, AxisSet};

use super::{Hands, Machine, commands};
use crate::failure::{Answer, Failure, Outcome};
use crate::files::listings;
use crate::grbl::numbers::Error;
use crate::grbl::{BANNER, HELP, LOCKED, jog};
use crate::ports::Ports;
use crate::reports;
use crate::safety::Event;
use crate::sessions::{Recipient, Reply, SessionId};

/// Carries out a line that begins with `$`, which is taken off.
pub(super) async fn run<P: Ports>(machine: &mut Machine<'_, P>, command: &str, to: Recipient) -> Outcome {
    machine.follow_motion();
    if let Some(words) = command.strip_prefix("J=") {
        let modal = machine.program.modal().clone();
        let jog = jog::read(words, &modal)?;
        let jogged = jog::jog(&mut Hands::new(machine, to), &jog, &modal).await;
        machine.resynchronise();
        return jogged.map(|()| Answer::Ok);
    }
    if let Some(axes) = command.strip_prefix('H') {
        return home(machine, axes, to).await;
    }
    say_or_set(machine, command, to)
}

/// What never waits.
fn say_or_set<P: Ports>(machine: &mut Machine<'_, P>, command: &str, to: Recipient) -> Outcome {
    match command {
        "" => machine.say(to, format_args!("{HELP}")),
        "X" if machine.safety.is_halted() => machine.unlock(to),
        "X" => {}
        "C" => return commands::check_mode(machine, to).map_err(not_idle),
        "SLP" => {
            machine.sleep().map_err(not_idle)?;
            machine.say(to, format_args!("[MSG:Sleeping]\n"));
        }
        "G" => {
            let Machine { program, outputs, sessions, config, .. } = machine;
            reports::modal(config, program, outputs, &mut Reply::new(sessions, to));
        }
        "#" => {
            let Machine { program, sessions, .. } = machine;
            reports::offsets(program, false, &mut Reply::new(sessions, to));
        }
        _ => return Err(Failure::numbered(Error::Statement, "this $ command is not known: $ lists them")),
    }
    Ok(Answer::Ok)
}

/// A refusal that the machine is not idle is the reason of.
fn not_idle(failure: Failure) -> Failure {
    match failure {
        Failure::Refused(text) => Failure::Refused(text.numbered(Error::NotIdle)),
        failure => failure,
    }
}

/// `$H`, `$HX` and so on: ends an alarm, too.
async fn home<P: Ports>(machine: &mut Machine<'_, P>, axes: &str, to: Recipient) -> Outcome {
    let mut named = AxisSet::NONE;
    for letter in axes.chars() {
        let axis = Axis::from_letter(letter.to_ascii_uppercase());
        let unknown = || Failure::numbered(Error::Statement, "$H homes all axes, $HX, $HY and $HZ one");
        named = named.with(axis.ok_or_else(unknown)?);
    }
    if machine.can_home.is_empty() {
        return Err(Failure::numbered(Error::NotEnabled, "no endstop has a homing_direction: [endstops]"));
    }
    match machine.safety.state() {
        State::Idle | State::Suspended => {}
        // Read, and not carried out.
        State::Check => return Ok(Answer::Ok),
        State::Alarm => {
            machine.release();
            machine.wait_release().await;
        }
        _ => return Err(Failure::numbered(Error::NotIdle, "homing begins from standstill")),
    }
    let homed = crate::homing::home(&mut Hands::new(machine, to), named).await;
    machine.resynchronise_if_still();
    homed.map(|()| Answer::Ok)
}

/// Whether the machine jogs, for a session of this dialect: then it takes nothing but jogs.
pub(super) fn jogs<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> bool {
    if machine.safety.state() != State::Jog || machine.sessions.dialect_of(to) != Dialect::Grbl {
        return false;
    }
    machine.follow_motion();
    machine.safety.state() == State::Jog
}

/// 0x85, and `!` while jogging: brakes, and drops the jogs that wait.
pub(super) fn cancel_jog<P: Ports>(machine: &mut Machine<'_, P>) {
    if !machine.safety.mode().is_in(State::Jog) {
        return;
    }
    if machine.safety.state() != State::Jog {
        machine.safety.apply(Event::Resume);
    }
    machine.ports.motion(motion::Motion::stop);
}

/// Ctrl-X: stops what goes on, drops what was sent, and greets anew. Where nothing goes on it is no alarm.
pub(super) fn reset<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId) {
    machine.follow_motion();
    let Machine { sessions, ports, .. } = machine;
    if let Some(session) = sessions.get_mut(id) {
        session.reset(ports.inbox(id));
        if let Some(listing) = session.listing.take() {
            listings::close(&listing, ports);
        }
    }
    machine.safety.apply(Event::CheckEnds);
    let stands = matches!(machine.safety.state(), State::Idle | State::Alarm | State::Invalid);
    if stands && machine.frames.is_empty() && !machine.jobs.is_playing() && !machine.sessions.are_busy() {
        machine.stop_outputs();
    } else {
        machine.abort();
    }
    machine.program.reset();
    machine.resynchronise();
    let halted = machine.safety.is_halted();
    if let Some(session) = machine.sessions.get_mut(id) {
        session.announce(format_args!("{BANNER}{}", if halted { LOCKED } else { "" }));
    }
}

/// A byte that changes how fast things go, or what turns.
pub(super) fn change<P: Ports>(_machine: &mut Machine<'_, P>, _request: Realtime, _id: SessionId) {}
