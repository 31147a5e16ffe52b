//! O words, M98 and M99: the choice of the line that is read next. The program knows the calls and open
//! blocks; the job knows its files.

use core::fmt::Write as _;

use base::failure::{Answer, Failure, Outcome};
use base::paths::Path;
use base::sessions::Reply;
use base::{Ports, World};
use gcode::{FlowLine, FlowWord};
use jobs::files::Files;
use jobs::files::logs::Logs;
use jobs::player::{Jobs, Starter};
use program::{FlowFault, Interpreter, Next};

use crate::machine::effects::EffectHands;
use crate::machine::program_io::OverrideHands;
use crate::machine::source::{Origin, Source};
use crate::machine::{Machine, effects, program_files, program_io, program_logs};

/// A program, and where its lines are read and written.
pub(crate) struct Flow<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    jobs: &'m mut Jobs,
    files: &'m Files,
    program: &'m mut Interpreter,
    /// Files that programs write.
    logs: &'m mut Logs,
}

/// The machine for the flow of a program.
pub(crate) trait FlowHands<'c>: EffectHands<'c> + OverrideHands<'c> {
    /// Returns the program, and where its lines are read and written.
    fn flow(&mut self) -> Flow<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> FlowHands<'c> for Machine<'c, P> {
    fn flow(&mut self) -> Flow<'_, 'c, P> {
        let Self { world, jobs, files, program, logs, .. } = self;
        Flow { world, jobs, files, program, logs }
    }
}

/// Runs a line with an O word.
pub(crate) fn run_line<'c>(hands: &mut impl FlowHands<'c>, line: &FlowLine<'_>, source: Source) -> Outcome {
    let Flow { world, jobs, files, program, .. } = hands.flow();
    if source.origin == Origin::Job {
        let (here, after) = jobs.places();
        let next = program.flow_line(line, here, after);
        return go_on(world, jobs, program, next);
    }
    open_called(world, jobs, files, line, source)?;
    if let Err(fault) = program.flow_line(line, Default::default(), Default::default()) {
        end(&mut hands.flow());
        let Flow { world, jobs, .. } = hands.flow();
        jobs.close(&mut world.ports);
        return Err(world.texts.refused(format_args!("{fault}")));
    }
    program.enter_file();
    Ok(Answer::Ok)
}

/// Opens the file of an O word outside of files: only a subroutine that is a file is called there, and
/// becomes a job.
fn open_called<P: Ports>(
    World { ports, texts, sessions, .. }: &mut World<'_, P>,
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
    jobs.open(texts, &path, Starter::of(&Reply::new(sessions, source.to)), ports, now).map(drop)
}

/// Calls a subroutine by number (M98).
pub(crate) fn call<P: Ports>(
    Flow { world, jobs, program, .. }: Flow<'_, '_, P>,
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
pub(crate) fn end_call<'c>(hands: &mut impl FlowHands<'c>) -> Outcome {
    if !hands.jobs().is_playing() {
        return Err(Failure::refused(&"M99 works in files that are played"));
    }
    let next = hands.program().end_call().unwrap_or(Next::At(program::Place::default()));
    let Flow { world, jobs, program, .. } = hands.flow();
    let ended = go_on(world, jobs, program, Ok(next))?;
    while let Some(what) = hands.program().next_effect() {
        effects::change(hands, what)?;
    }
    Ok(ended)
}

/// Ends the program (M2): speeds are as programmed again.
pub(crate) fn end_program<'c>(hands: &mut impl FlowHands<'c>) -> Outcome {
    if !hands.is_halted() {
        hands.standstill()?;
        program_io::reset_overrides(hands.overrides());
    }
    end(&mut hands.flow());
    program_files::save(hands);
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
fn end<P: Ports>(Flow { world, jobs, program, logs, .. }: &mut Flow<'_, '_, P>) {
    program_logs::close(logs, world);
    program.end_program();
    jobs.end_program(&mut world.ports);
}
