//! The lines of the configuration that deploy and stow a probe: moves, waits, modes and switches, carried out
//! on the spot in the middle of a sequence.
//!
//! Modes are the program's own again afterwards, and a script begins as [`ScriptModes::begin`]
//! says, so that it means the same wherever it is run.

use core::fmt::Arguments;

use base::World;
use base::failure::{Failure, Texts};
use base::needs::failure_of;
use base::ports::HeatPort as _;
use gcode::{Block, Blocks};
use parts::outputs::Outputs;
use program::{Action, Dialect, Effect, Meaning, ScriptModes};

use crate::machine::effects::EffectHands;
use crate::machine::moves::{self, DrawHands};

/// The machine for scripts of moves, waits, modes and switches.
pub(crate) trait ScriptHands<'c>: DrawHands<'c> + EffectHands<'c> {}

impl<'c, H: DrawHands<'c> + EffectHands<'c>> ScriptHands<'c> for H {}

/// Carries out a script; messages about it name its setting.
pub(crate) fn run<'c>(hands: &mut impl ScriptHands<'c>, key: &str, script: &str) -> Result<(), Failure> {
    hands.standstill()?;
    let kept = hands.program().keep();
    // Sequences move without telling the program.
    hands.resynchronise();
    // The modes that the script changes are kept already.
    let _modes = ScriptModes::begin(hands.program());
    let texts = hands.world().texts;
    let mut blocks = script.split('|').flat_map(|line| Blocks::new(line.as_bytes()));
    let done = blocks.try_for_each(|block| {
        let block = block.map_err(|error| texts.refused(format_args!("[zprobe] {key}: {error}")))?;
        run_block(hands, key, &block)
    });
    let stands = match done {
        Err(Failure::HALTED) => Ok(()),
        _ => hands.standstill(),
    };
    hands.program().come_back_to(kept);
    hands.resynchronise_if_still();
    done.and(stands)
}

fn refused(texts: &Texts, key: &str, block: &Block<'_>, why: Arguments<'_>) -> Failure {
    match block.code {
        Some(code) => texts.refused(format_args!("[zprobe] {key}: {code} {why}")),
        None => texts.refused(format_args!("[zprobe] {key}: {why}")),
    }
}

fn run_block<'c>(hands: &mut impl ScriptHands<'c>, key: &str, block: &Block<'_>) -> Result<(), Failure> {
    let Some(row) = hands.program().row(block, Dialect::Smoothie) else {
        return Err(refused(hands.world().texts, key, block, format_args!("is not known here")));
    };
    let (facts, is_playing) = (hands.facts(), hands.jobs().is_playing());
    let meaning = hands.program().run(block, row, facts, Dialect::Smoothie);
    let World { texts, config, .. } = hands.world();
    let meaning = meaning.map_err(|fault| failure_of(texts, config, &fault, is_playing))?;
    while let Some(effect) = hands.program().next_effect() {
        switch(hands, key, block, effect)?;
    }
    let mut next = match meaning {
        Meaning::Nothing | Meaning::PassedOver => None,
        Meaning::Unknown => return Err(refused(hands.world().texts, key, block, format_args!("is not known here"))),
        Meaning::Action(action) => Some(action),
    };
    while let Some(action) = next {
        carry_out(hands, key, block, &action)?;
        next = hands.program().next_action();
    }
    Ok(())
}

fn carry_out<'c>(
    hands: &mut impl ScriptHands<'c>,
    key: &str,
    block: &Block<'_>,
    action: &Action<'_>,
) -> Result<(), Failure> {
    match *action {
        Action::Move(ref request) => {
            let moved = match hands.may_move().and_then(|()| hands.rest_stays_within(&request.target)) {
                Ok(()) => moves::submit(hands, request),
                Err(failure) => Err(failure),
            };
            if moved.is_err() {
                hands.program().take_back();
            }
            moved
        }
        Action::Effect(effect) => switch(hands, key, block, effect),
        Action::Dwell(time) => hands.standstill().and_then(|()| hands.wait_for(time)),
        Action::Finish => hands.standstill(),
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
            Err(refused(hands.world().texts, key, block, format_args!("is none of moves, waits, modes and switches")))
        }
    }
}

/// Turns a switch, once earlier moves have been made.
fn switch<'c>(hands: &mut impl ScriptHands<'c>, key: &str, block: &Block<'_>, effect: Effect) -> Result<(), Failure> {
    let Effect::Switch { switch, on, value } = effect else {
        return Err(refused(hands.world().texts, key, block, format_args!("heats: a probe's script does not")));
    };
    let (_, jobs, world) = hands.outputs_in_world();
    Outputs::check(world.texts, world.config, switch, on, value, jobs.is_playing())?;
    hands.standstill()?;
    let (outputs, _, world) = hands.outputs_in_world();
    if let Some(output) = outputs.turn(world.config, switch, on, value) {
        world.ports.heat(|heat| heat.apply(output)).map_err(|_| Failure::HALTED)?;
    }
    Ok(())
}
