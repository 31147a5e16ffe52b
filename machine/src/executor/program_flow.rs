//! O words, M98 and M99: the choice of the line that is read next. The program knows the calls and open
//! blocks; the job knows its files.

use core::fmt::Write as _;

use base::failure::{Answer, Failure, Outcome};
use base::paths::Path;
use base::{Ports, World};
use gcode::{FlowLine, FlowWord};
use jobs::files::Files;
use jobs::player::{Jobs, Listeners};
use program::{FlowFault, Interpreter, Next};

use crate::machine::program_io::OverrideHands as _;
use crate::machine::source::{Origin, Source};
use crate::machine::{Machine, effects, program_files, program_io, program_logs};

/// Runs a line with an O word.
pub(crate) fn run_line<P: Ports>(machine: &mut Machine<'_, P>, line: &FlowLine<'_>, source: Source) -> Outcome {
    let Machine { world, jobs, files, program, .. } = machine;
    if source.origin == Origin::Job {
        let (here, after) = jobs.places();
        let next = program.flow_line(line, here, after);
        return go_on(world, jobs, program, next);
    }
    open_called(world, jobs, files, line, source)?;
    if let Err(fault) = program.flow_line(line, Default::default(), Default::default()) {
        end(machine);
        machine.jobs.close(&mut machine.world.ports);
        return Err(machine.world.texts.refused(format_args!("{fault}")));
    }
    program.enter_file();
    Ok(Answer::Ok)
}

/// Opens the file of an O word outside of files: only a subroutine that is a file is called there, and
/// becomes a job.
fn open_called<P: Ports>(
    World { ports, texts, .. }: &mut World<'_, P>,
    jobs: &mut Jobs,
    files: &Files,
    line: &FlowLine<'_>,
    source: Source,
) -> Result<(), Failure> {
    if line.word != FlowWord::Call || source.origin != Origin::Session {
        return Err(Failure::refused(&"here only O<name> call works; other O words belong in a file that is played"));
    }
    let mut name = Path::new();
    if write!(name, "{}.ngc", line.label).is_err() {
        return Err(Failure::refused(&"the name is too long"));
    }
    let (path, now) = (files.absolute(&name), ports.now());
    jobs.open(texts, &path, Listeners { tells_end: source.to, ..Listeners::default() }, ports, now).map(drop)
}

/// Calls a subroutine by number (M98).
pub(crate) fn call<P: Ports>(
    world: &mut World<'_, P>,
    jobs: &mut Jobs,
    program: &mut Interpreter,
    (number, times): (u32, u32),
) -> Outcome {
    if !jobs.is_playing() {
        return Err(Failure::refused(&"M98 works in files that are played"));
    }
    let (_, after) = jobs.places();
    let next = program.call(number, times, after);
    go_on(world, jobs, program, next)
}

/// Returns from a subroutine (M99), and carries out the effects that this has.
pub(crate) fn end_call<P: Ports>(machine: &mut Machine<'_, P>) -> Outcome {
    if !machine.jobs.is_playing() {
        return Err(Failure::refused(&"M99 works in files that are played"));
    }
    let next = machine.program.end_call().unwrap_or(Next::At(program::Place::default()));
    let Machine { world, jobs, program, .. } = &mut *machine;
    let ended = go_on(world, jobs, program, Ok(next))?;
    while let Some(what) = machine.program.next_effect() {
        effects::change(machine, what)?;
    }
    Ok(ended)
}

/// Ends the program (M2): speeds are as programmed again.
pub(crate) fn end_program<P: Ports>(machine: &mut Machine<'_, P>) -> Outcome {
    if !machine.safety.is_halted() {
        machine.standstill()?;
        program_io::reset_overrides(machine.overrides());
    }
    end(machine);
    program_files::save(machine);
    Ok(Answer::Ok)
}

/// Goes on where an O word or a call leads.
fn go_on<P: Ports>(
    World { ports, texts, .. }: &mut World<'_, P>,
    jobs: &mut Jobs,
    program: &mut Interpreter,
    next: Result<Next, FlowFault>,
) -> Outcome {
    match next.map_err(|fault| texts.refused(format_args!("{fault}")))? {
        Next::Following => {}
        Next::At(place) => jobs.go_to(place, ports).map_err(|error| texts.because(error.text()))?,
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
    program_logs::close(&mut machine.logs, &mut machine.world);
    machine.program.end_program();
    machine.jobs.end_program(&mut machine.world.ports);
}
