//! Values that programs keep over a power cycle, read at boot and written when they have changed: see
//! [`jobs::files::program_files`].

use base::failure::{Answer, Outcome};
use base::ports::{StorageError, Wake};
use base::{Ports, World};
use jobs::files::program_files::{
    PARAMETERS, Progress, SavingParameters, SavingTools, TOOLS, load_parameters, load_tools,
};
use program::Interpreter;

use crate::machine::card;
use crate::machine::work_hands::{JobHands, ProgramHands};

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
pub(crate) fn save_unless_playing<'c>(hands: &mut impl JobHands<'c>) {
    if !hands.jobs().is_playing() {
        save(hands);
    }
}

/// Writes changed parameters and tools. At a power loss each file is the old one or the new one.
pub(crate) fn save<'c>(hands: &mut impl ProgramHands<'c>) {
    if hands.program().take_parameters_changed()
        && let Err(error) = write_parameters(hands)
    {
        hands.announce(format_args!("WARNING: the parameters were not saved in {PARAMETERS}: {}\n", error.text()));
    }
    if hands.program().tools().table().is_unsaved() {
        match write_tools(hands) {
            Ok(()) => hands.program().tool_table().saved(),
            Err(error) => {
                hands.announce(format_args!("WARNING: the tool table was not saved in {TOOLS}: {}\n", error.text()));
            }
        }
    }
}

fn write_parameters<'c>(hands: &mut impl ProgramHands<'c>) -> Result<(), StorageError> {
    card::at_rest(hands);
    let mut saving = SavingParameters::begin(&mut hands.world().ports)?;
    loop {
        hands.wait(Wake::Any).whatever_happens();
        card::at_rest(hands);
        let (program, world) = hands.program_in_world();
        if saving.step(&mut world.ports, program)? == Progress::Done {
            return card::kept(hands);
        }
    }
}

fn write_tools<'c>(hands: &mut impl ProgramHands<'c>) -> Result<(), StorageError> {
    card::at_rest(hands);
    let (program, world) = hands.program_in_world();
    let mut saving = SavingTools::begin(&mut world.ports, program)?;
    loop {
        hands.wait(Wake::Any).whatever_happens();
        card::at_rest(hands);
        let (program, world) = hands.program_in_world();
        if saving.step(&mut world.ports, program)? == Progress::Done {
            return card::kept(hands);
        }
    }
}
