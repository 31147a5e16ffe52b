//! Values that programs keep over a power cycle, read at boot and written when they have changed: see
//! [`jobs::files::program_files`].

use base::failure::{Answer, Outcome};
use base::ports::{StorageError, Wake};
use base::{Ports, World};
use jobs::files::program_files::{
    PARAMETERS, Progress, SavingParameters, SavingTools, TOOLS, load_parameters, load_tools,
};
use program::Interpreter;

use crate::machine::{Machine, card};

/// Greatest number of bad lines of the tool table that are told.
const MOST_SAID: u32 = 5;

/// Reads parameters and tools at boot. There need not be any.
pub(crate) fn load<P: Ports>(world: &mut World<'_, P>, program: &mut Interpreter) {
    match load_parameters(&mut world.ports, program) {
        Ok(0) | Err(StorageError::NotFound | StorageError::NoCard) => {}
        Ok(bad) => {
            world.announce(format_args!("WARNING: {PARAMETERS}: {bad} lines are no parameters and were left out\n"));
        }
        Err(error) => world.announce(format_args!("WARNING: {PARAMETERS} was not read: {}\n", error.text())),
    }
    match read_tools(world, program) {
        Ok(()) | Err(StorageError::NotFound | StorageError::NoCard) => {}
        Err(error) => world.announce(format_args!("WARNING: {TOOLS} was not read: {}\n", error.text())),
    }
}

/// Reloads the tool table from its file (G10 L0).
pub(crate) fn reload_tools<P: Ports>(world: &mut World<'_, P>, program: &mut Interpreter) -> Outcome {
    match read_tools(world, program) {
        Ok(()) => Ok(Answer::Ok),
        Err(error) => Err(world.texts.about_file(TOOLS, error.text())),
    }
}

fn read_tools<P: Ports>(world: &mut World<'_, P>, program: &mut Interpreter) -> Result<(), StorageError> {
    let World { ports, sessions, .. } = &mut *world;
    let mut flaws = 0;
    let read = load_tools(ports, program, |line, flaw| {
        flaws += 1;
        if flaws > MOST_SAID {
            return;
        }
        let all = base::sessions::Recipient::All;
        match flaw {
            Some(flaw) => sessions.say(all, format_args!("WARNING: {TOOLS}, line {line} is left out: {flaw}\n")),
            None => sessions
                .say(all, format_args!("WARNING: {TOOLS}, line {line} is left out: it is too long, or no text\n")),
        }
    });
    if flaws > MOST_SAID {
        world.announce(format_args!("WARNING: {TOOLS}: and {} more\n", flaws - MOST_SAID));
    }
    read
}

/// Saves values that a code has changed, unless a file is played: its end saves them.
pub(crate) fn save_unless_playing<P: Ports>(machine: &mut Machine<'_, P>) {
    if !machine.jobs.is_playing() {
        save(machine);
    }
}

/// Writes changed parameters and tools. At a power loss each file is the old one or the new one.
pub(crate) fn save<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.program.take_parameters_changed()
        && let Err(error) = write_parameters(machine)
    {
        machine.announce(format_args!("WARNING: the parameters were not saved in {PARAMETERS}: {}\n", error.text()));
    }
    if machine.program.tools().table().is_unsaved() {
        match write_tools(machine) {
            Ok(()) => machine.program.tool_table().saved(),
            Err(error) => {
                machine.announce(format_args!("WARNING: the tool table was not saved in {TOOLS}: {}\n", error.text()));
            }
        }
    }
}

fn write_parameters<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), StorageError> {
    card::at_rest(machine);
    let mut saving = SavingParameters::begin(&mut machine.world.ports)?;
    loop {
        machine.wait(Wake::Any).whatever_happens();
        card::at_rest(machine);
        if saving.step(&mut machine.world.ports, &machine.program)? == Progress::Done {
            return card::kept(machine);
        }
    }
}

fn write_tools<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), StorageError> {
    card::at_rest(machine);
    let mut saving = SavingTools::begin(&mut machine.world.ports, &machine.program)?;
    loop {
        machine.wait(Wake::Any).whatever_happens();
        card::at_rest(machine);
        if saving.step(&mut machine.world.ports, &machine.program)? == Progress::Done {
            return card::kept(machine);
        }
    }
}
