//! O words, M98 and M99: the choice of the line that is read next. The program knows the calls and open
//! blocks; the job knows its files.

use core::fmt::Write as _;

use base::failure::{Answer, Failure, Outcome};
use base::paths::Path;
use base::{Ports, World};
use gcode::{FlowLine, FlowWord};
use jobs::player::Listeners;
use program::Next;

use crate::machine::Machine;
use crate::machine::effects;
use crate::machine::program_files;
use crate::machine::program_io;
use crate::machine::program_logs;
use crate::machine::source::{Origin, Source};

/// Runs a line with an O word.
pub(crate) fn run_line<P: Ports>(machine: &mut Machine<'_, P>, line: &FlowLine<'_>, source: Source) -> Outcome {
    if source.origin != Origin::Job {
        return run_elsewhere(machine, line, source);
    }
    let (here, after) = machine.jobs.places();
    match machine.program.flow_line(line, here, after) {
        Ok(next) => go_on(machine, next),
        Err(fault) => Err(machine.world.texts.refused(format_args!("{fault}"))),
    }
}

/// Runs an O word outside of files: only the call of a subroutine that is a file, which becomes a job.
fn run_elsewhere<P: Ports>(machine: &mut Machine<'_, P>, line: &FlowLine<'_>, source: Source) -> Outcome {
    if line.word != FlowWord::Call || source.origin != Origin::Session {
        return Err(Failure::refused(&"here only O<name> call works; other O words belong in a file that is played"));
    }
    let mut name = Path::new();
    if write!(name, "{}.ngc", line.label).is_err() {
        return Err(Failure::refused(&"the name is too long"));
    }
    let path = machine.files.absolute(&name);
    let now = machine.world.ports.now();
    machine.jobs.open(
        machine.world.texts,
        &path,
        Listeners { tells_end: source.to, ..Listeners::default() },
        &mut machine.world.ports,
        now,
    )?;
    let called = machine.program.flow_line(line, Default::default(), Default::default());
    if let Err(fault) = called {
        end(machine);
        machine.jobs.close(&mut machine.world.ports);
        return Err(machine.world.texts.refused(format_args!("{fault}")));
    }
    machine.program.enter_file();
    Ok(Answer::Ok)
}

/// Calls a subroutine by number (M98).
pub(crate) fn call<P: Ports>(machine: &mut Machine<'_, P>, number: u32, times: u32) -> Outcome {
    if !machine.jobs.is_playing() {
        return Err(Failure::refused(&"M98 works in files that are played"));
    }
    let (_, after) = machine.jobs.places();
    match machine.program.call(number, times, after) {
        Ok(next) => go_on(machine, next),
        Err(fault) => Err(machine.world.texts.refused(format_args!("{fault}"))),
    }
}

/// Returns from a subroutine (M99), and carries out the effects that this has.
pub(crate) fn end_call<P: Ports>(machine: &mut Machine<'_, P>) -> Outcome {
    if !machine.jobs.is_playing() {
        return Err(Failure::refused(&"M99 works in files that are played"));
    }
    let next = machine.program.end_call().unwrap_or(Next::At(program::Place::default()));
    let ended = go_on(machine, next)?;
    while let Some(what) = machine.program.next_effect() {
        effects::change(machine, what)?;
    }
    Ok(ended)
}

/// Ends the program (M2): speeds are as programmed again.
pub(crate) fn end_program<P: Ports>(machine: &mut Machine<'_, P>) -> Outcome {
    if !machine.safety.is_halted() {
        machine.standstill()?;
        let Machine { world, program, outputs, hold, feed_waits, .. } = &mut *machine;
        program_io::reset_overrides(&mut world.ports, program, outputs, hold, feed_waits);
    }
    end(machine);
    program_files::save(machine);
    Ok(Answer::Ok)
}

fn go_on<P: Ports>(machine: &mut Machine<'_, P>, next: Next) -> Outcome {
    let Machine { jobs, program, world: World { ports, .. }, .. } = machine;
    match next {
        Next::Following => {}
        Next::At(place) => jobs.go_to(place, ports).map_err(|error| machine.world.texts.because(error.text()))?,
        Next::FirstOf(name) if jobs.call_file(&name, ports)? => program.enter_file(),
        Next::FirstOf(_) => program.search_sub(),
        Next::Returned if jobs.return_from_file(ports) => {}
        // The subroutine was called from a session: nothing follows it.
        Next::Returned => jobs.end_program(ports),
    }
    Ok(Answer::Ok)
}

/// Ends the program at M2, M30 or a stop: nothing of it goes on.
pub(crate) fn end<P: Ports>(machine: &mut Machine<'_, P>) {
    program_logs::close(machine);
    machine.program.end_program();
    machine.jobs.end_program(&mut machine.world.ports);
}
