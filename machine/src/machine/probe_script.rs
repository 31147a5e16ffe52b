//! The lines of the configuration that deploy and stow a probe: moves, waits, modes and switches, carried out
//! on the spot in the middle of a sequence.
//!
//! Modes are the program's own again afterwards, and a script begins as [`ScriptModes::begin`]
//! says, so that it means the same wherever it is run.

use core::fmt::Arguments;

use base::Ports;
use base::failure::{Failure, Texts};
use base::needs::failure_of;
use gcode::{Block, Blocks};
use parts::outputs::Outputs;
use program::{Action, Dialect, Effect, Meaning, ScriptModes};

use crate::machine::{Machine, moves};

/// Carries out a script; messages about it name its setting.
pub(crate) fn run<P: Ports>(machine: &mut Machine<'_, P>, key: &str, script: &str) -> Result<(), Failure> {
    machine.standstill()?;
    let kept = machine.program.keep();
    // Sequences move without telling the program.
    machine.resynchronise();
    // The modes that the script changes are kept already.
    let _modes = ScriptModes::begin(&mut machine.program);
    let texts = machine.world.texts;
    let mut blocks = script.split('|').flat_map(|line| Blocks::new(line.as_bytes()));
    let done = blocks.try_for_each(|block| {
        let block = block.map_err(|error| texts.refused(format_args!("[zprobe] {key}: {error}")))?;
        run_block(machine, key, &block)
    });
    let stands = match done {
        Err(Failure::HALTED) => Ok(()),
        _ => machine.standstill(),
    };
    machine.program.come_back_to(kept);
    machine.resynchronise_if_still();
    done.and(stands)
}

fn refused(texts: &Texts, key: &str, block: &Block<'_>, why: Arguments<'_>) -> Failure {
    match block.code {
        Some(code) => texts.refused(format_args!("[zprobe] {key}: {code} {why}")),
        None => texts.refused(format_args!("[zprobe] {key}: {why}")),
    }
}

fn run_block<P: Ports>(machine: &mut Machine<'_, P>, key: &str, block: &Block<'_>) -> Result<(), Failure> {
    let Some(row) = machine.program.row(block, Dialect::Smoothie) else {
        return Err(refused(machine.world.texts, key, block, format_args!("is not known here")));
    };
    let (facts, is_playing) = (machine.facts(), machine.jobs.is_playing());
    let meaning = machine.program.run(block, row, facts, Dialect::Smoothie);
    let meaning = meaning.map_err(|fault| failure_of(machine.world.texts, machine.world.config, &fault, is_playing))?;
    while let Some(effect) = machine.program.next_effect() {
        switch(machine, key, block, effect)?;
    }
    let mut next = match meaning {
        Meaning::Nothing | Meaning::PassedOver => None,
        Meaning::Unknown => return Err(refused(machine.world.texts, key, block, format_args!("is not known here"))),
        Meaning::Action(action) => Some(action),
    };
    while let Some(action) = next {
        match action {
            Action::Move(ref request) => {
                let moved = match machine.may_move().and_then(|()| machine.rest_stays_within(&request.target)) {
                    Ok(()) => moves::submit(machine, request),
                    Err(failure) => Err(failure),
                };
                if moved.is_err() {
                    machine.program.take_back();
                }
                moved?;
            }
            Action::Effect(effect) => switch(machine, key, block, effect)?,
            Action::Dwell(time) => {
                machine.standstill()?;
                machine.wait_for(time)?;
            }
            Action::Finish => machine.standstill()?,
            Action::HeatAndWait { .. }
            | Action::Home(_)
            | Action::SetPosition { .. }
            | Action::ForgetHoming(_)
            | Action::ProbeDown(_)
            | Action::ProbeAlong(_)
            | Action::EndProgram
            | Action::Halt
            | Action::Release
            | Action::Suspend { .. }
            | Action::Resume
            | Action::Message(_)
            | Action::Pause { .. }
            | Action::Call { .. }
            | Action::Return
            | Action::ChangeTool(_)
            | Action::Overrides { .. }
            | Action::RetractByHand
            | Action::AwaitInput(_)
            | Action::RigidTap { .. }
            | Action::Orient { .. }
            | Action::SurfaceSpeed(_)
            | Action::ReadTools
            | Action::Keep
            | Action::Note(_)
            | Action::Acceleration(_)
            | Action::Function(..) => {
                return Err(refused(
                    machine.world.texts,
                    key,
                    block,
                    format_args!("is none of moves, waits, modes and switches"),
                ));
            }
        }
        next = machine.program.next_action();
    }
    Ok(())
}

/// Turns a switch, once earlier moves have been made.
fn switch<P: Ports>(machine: &mut Machine<'_, P>, key: &str, block: &Block<'_>, effect: Effect) -> Result<(), Failure> {
    let Effect::Switch { switch, on, value } = effect else {
        return Err(refused(machine.world.texts, key, block, format_args!("heats: a probe's script does not")));
    };
    Outputs::check(machine.world.texts, machine.world.config, switch, on, value, machine.jobs.is_playing())?;
    machine.standstill()?;
    if let Some(output) = machine.outputs.turn(machine.world.config, switch, on, value) {
        machine.world.ports.heat(|heat| heat.apply(output)).map_err(|_| Failure::HALTED)?;
    }
    Ok(())
}
