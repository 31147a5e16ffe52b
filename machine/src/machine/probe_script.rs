//! The lines of the configuration that deploy and stow a probe: moves, waits, modes and switches, carried out
//! on the spot in the middle of a sequence. A line may name a template of the printer.cfg instead.
//!
//! Modes are the program's own again afterwards, and a script begins as [`ScriptModes::begin`]
//! says, so that it means the same wherever it is run.

use core::fmt::Arguments;

use base::failure::{Failure, Texts};
use base::needs::failure_of;
use base::own_frame::apart;
use base::ports::HeatPort as _;
use base::program_setup::PartNames;
use base::sessions::LineBytes;
use base::{Ports, World};
use gcode::{Block, Blocks, Extended};
use parts::outputs::Outputs;
use program::extended::{self, Asked, CodeLine};
use program::{Action, Dialect, Effect, Meaning, ScriptModes};

use crate::machine::Machine;
use crate::machine::effects::EffectHands;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::moves::{self, DrawHands};

/// What is wrong with a code of another kind.
const NEITHER: &str = "is none of moves, waits, modes and switches";

/// The machine for scripts of moves, waits, modes and switches.
pub(crate) trait ScriptHands<'c>: DrawHands<'c> + EffectHands<'c> {
    /// Begins what a line names in the printer.cfg: see the moment of that name, as for the next two.
    fn begin_template(&mut self, line: &str, is_first: bool) -> Option<Result<usize, Failure>>;

    /// Takes the next line of what has been begun.
    fn template_line(&mut self, above: usize, line: &mut LineBytes) -> Option<Result<(), Failure>>;

    /// Ends what has been begun.
    fn end_templates(&mut self, above: usize);
}

impl<'c, P: Ports> ScriptHands<'c> for Machine<'c, P> {
    fn begin_template(&mut self, line: &str, is_first: bool) -> Option<Result<usize, Failure>> {
        Features::<P>::begin_template(self, line, is_first)
    }

    fn template_line(&mut self, above: usize, line: &mut LineBytes) -> Option<Result<(), Failure>> {
        Features::<P>::template_line(self, above, line)
    }

    fn end_templates(&mut self, above: usize) {
        Features::<P>::end_templates(self, above);
    }
}

/// Carries out a script; messages about it name its setting.
pub(crate) fn run<'c>(hands: &mut impl ScriptHands<'c>, key: &str, script: &str) -> Result<(), Failure> {
    hands.standstill()?;
    let kept = hands.program().keep();
    // Sequences move without telling the program.
    hands.resynchronise();
    // The modes that the script changes are kept already.
    let _modes = ScriptModes::begin(hands.program());
    let done = match apart(|| hands.begin_template(script, true)) {
        Some(begun) => begun.and_then(|above| {
            let ran = run_template(hands, key, above);
            hands.end_templates(above);
            ran
        }),
        None => script.split('|').try_for_each(|line| run_named_or_codes(hands, key, line.trim())),
    };
    let stands = match done {
        Err(Failure::HALTED) => Ok(()),
        _ => hands.standstill(),
    };
    hands.program().come_back_to(kept);
    hands.resynchronise_if_still();
    done.and(stands)
}

/// Carries out the lines of a template.
fn run_template<'c>(hands: &mut impl ScriptHands<'c>, key: &str, above: usize) -> Result<(), Failure> {
    let mut line = LineBytes::new();
    while let Some(taken) = hands.template_line(above, &mut line) {
        taken?;
        let text = core::str::from_utf8(&line).unwrap_or("");
        match apart(|| hands.begin_template(text, false)) {
            Some(begun) => drop(begun?),
            None => run_named_or_codes(hands, key, text)?,
        }
    }
    Ok(())
}

/// Carries out a line of codes, or one of Klipper's commands that become codes.
fn run_named_or_codes<'c>(hands: &mut impl ScriptHands<'c>, key: &str, text: &str) -> Result<(), Failure> {
    let is_letter = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'_';
    if !text.as_bytes().get(..2).is_some_and(|begin| begin.iter().all(is_letter)) {
        return run_codes(hands, key, text);
    }
    let (command, mut codes) = (Extended::new(text), CodeLine::new());
    let World { config, texts, .. } = hands.world();
    let names = PartNames { config, dialect: Dialect::Klipper };
    match extended::translate(&command, &names, &mut codes) {
        Ok(Asked::Codes) => run_codes(hands, key, &codes),
        Ok(Asked::PassedOver(_)) => Ok(()),
        Ok(Asked::Console(_) | Asked::Tower | Asked::Macros) => {
            Err(texts.refused(format_args!("[zprobe] {key}: {} {NEITHER}", command.name())))
        }
        Err(fault) => Err(texts.refused(format_args!("[zprobe] {key}: {} {fault}", command.name()))),
    }
}

fn run_codes<'c>(hands: &mut impl ScriptHands<'c>, key: &str, line: &str) -> Result<(), Failure> {
    let texts = hands.world().texts;
    Blocks::new(line.as_bytes()).try_for_each(|block| {
        let block = block.map_err(|error| texts.refused(format_args!("[zprobe] {key}: {error}")))?;
        run_block(hands, key, &block)
    })
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
        | Action::Function(..) => Err(refused(hands.world().texts, key, block, format_args!("{NEITHER}"))),
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
