//! Messages to the operator, and pauses that wait for him: M0, M1, M60.

use base::Ports;
use base::failure::{Answer, Failure, Outcome, ShortText};
use base::ports::Wake;
use base::safety::Event;
use base::sessions::Recipient;
use base::wait::Waited;
use program::{Pause, Remark, ScriptModes, State};
use units::Micros;

use crate::machine::Machine;
use crate::machine::end_requests::Asked;
use crate::machine::frames::Frame;
use crate::machine::program_logs;

/// Carries out a comment that says something, or writes it to a file.
///
/// # Errors
/// When that cannot be written.
pub(crate) fn remark<P: Ports>(machine: &mut Machine<'_, P>, comment: &[u8]) -> Result<(), Failure> {
    if machine.passed.is_some() {
        // The remark was heard when the job ran before.
        return Ok(());
    }
    let values = |machine: &Machine<'_, P>, said: &str| {
        let mut text = ShortText::NONE;
        // Text that does not fit is cut.
        let _ = program::write_values(&machine.program, said, &mut text);
        text
    };
    match Remark::read(comment) {
        Some(Remark::Message(said)) => machine.announce(format_args!("// {said}\n")),
        Some(Remark::Printed(said)) => {
            let text = values(machine, said);
            machine.announce(format_args!("// {text}\n"));
        }
        Some(Remark::Debug(said)) if machine.program.debugs() => {
            let text = values(machine, said);
            machine.announce(format_args!("// {text}\n"));
        }
        // Programs that are only checked write nothing.
        Some(_) if machine.safety.state() == State::Check => {}
        Some(other) => return program_logs::carry_out(machine, &other),
        None => {}
    }
    Ok(())
}

/// Waits until the operator goes on (M0, M1, M60), or so long.
pub(crate) fn pause<P: Ports>(
    machine: &mut Machine<'_, P>,
    why: Pause,
    time: Option<Micros>,
    text: Option<&str>,
) -> Outcome {
    machine.standstill()?;
    if let Some(text) = text {
        machine.announce(format_args!("// {text}\n"));
    }
    if let Some(time) = time {
        return wait_for(machine, time, |asked| asked.wait_is_over()).map(|_| Answer::Ok);
    }
    let code = match why {
        Pause::Program => "M0",
        Pause::Optional => "M1",
        Pause::Pallet => "M60",
    };
    wait(machine, format_args!("the program waits ({code})"))
}

/// Dwells (G4). A pause leaves a dwell that is the whole line of a job.
pub(crate) fn dwell<P: Ports>(machine: &mut Machine<'_, P>, time: Micros) -> Result<(), Failure> {
    if wait_for(machine, time, Asked::leaves_wait)? { Err(Failure::HALTED) } else { Ok(()) }
}

/// Waits for a length of time, or until something ends the wait; returns whether it has.
fn wait_for<P: Ports>(
    machine: &mut Machine<'_, P>,
    time: Micros,
    ends: fn(&mut Asked) -> bool,
) -> Result<bool, Failure> {
    let since = machine.world.ports.now();
    machine.urgent.begin_wait();
    while machine.world.ports.now().since(since) < time {
        machine.wait(Wake::Time).unless_halted()?;
        if ends(&mut machine.urgent) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Waits for the operator: a job is paused, with the rest of its line; lines of a session are held.
pub(crate) fn wait<P: Ports>(machine: &mut Machine<'_, P>, what: core::fmt::Arguments<'_>) -> Outcome {
    if machine.jobs.is_playing() {
        machine.announce(format_args!("// {what}: ~ or M24 goes on, abort ends the job\n"));
        machine.world.sessions.tell_hosts("paused", Recipient::Nobody);
        let modes = ScriptModes::beside(&machine.program);
        if !machine.frames.push(Frame::Operator(modes)) {
            return Err(Failure::refused(&"scripts start each other without end"));
        }
        machine.jobs.wait_for_operator();
        return Ok(Answer::Ok);
    }
    machine.announce(format_args!("// {what}: ~ goes on\n"));
    // The state is that of a hold by `!`, so that everybody sees why nothing moves, and `~` goes on.
    if !machine.safety.apply(Event::Started) || !machine.safety.apply(Event::Hold) {
        return Err(Failure::HALTED);
    }
    machine.urgent.awaits_operator = true;
    let mut waited = Waited::Held;
    while waited != Waited::Halted && matches!(machine.safety.state(), State::Hold | State::Door) {
        waited = machine.wait(Wake::Any);
    }
    machine.urgent.awaits_operator = false;
    waited.unless_halted()?;
    if machine.safety.is_halted() { Err(Failure::HALTED) } else { Ok(Answer::Ok) }
}
