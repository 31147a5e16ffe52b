//! Codes claimed by heaters: selection of the heater and its target temperature.

use gcode::Code;
use units::{Celsius, HeaterId, ToolId};

use crate::action::{Action, Effect};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::function::{Function, Report};
use crate::interpreter::Interpreter;
use crate::state::claims::Claim;
use gcode::Dialect;

/// Lowest number of temperature controls that are addressed whatever tool is selected.
const ALWAYS_ACTIVE: ToolId = ToolId(250);

/// Carries out a code that heaters claim.
pub(crate) fn heat<'b>(
    program: &mut Interpreter,
    claim: Claim,
    claims: &[Claim],
    context: &Context<'b>,
) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if matches!(claim, Claim::Temperature(_)) {
        return Ok(Meaning::Action(Action::Function(Function::Report(Report::ReportTemperatures), *words)));
    }
    if let Some(letter) = other_name(context) {
        return Err(Problem::NotTaken(words.code(), letter).refused(words.column_of(letter)));
    }
    // Marlin's R is a target that also waits for cooling.
    let waits = claims.iter().any(|claim| matches!(claim, Claim::TargetAndWait(_)));
    let dialect = context.dialect;
    let takes_r = waits || dialect == Dialect::RepRapFirmware && words.code().number == 104;
    // Klipper's S defaults to 0.
    let left_out = (dialect == Dialect::Klipper).then_some(0.0);
    let celsius = words.get('S').or(words.get('R').filter(|_| takes_r)).or(left_out);
    let Some(celsius) = celsius else { return NOTHING };
    let (heater, waits) = match addressed(program, claims, context) {
        // Slicers switch off heaters that only other machines have.
        Err(_) if celsius == 0.0 && context.dialect.is_other_printers() => return Ok(Meaning::PassedOver),
        addressed => addressed?,
    };
    let target = meant(program, heater, celsius);
    if waits {
        let cools = !words.has('S') || context.dialect.waits_for_cooling();
        return Ok(Meaning::Action(Action::HeatAndWait { heater, target, cools }));
    }
    program.by_the_way(Effect::Target { heater, target });
    NOTHING
}

/// Returns a letter by which other firmware selects the heater or the temperature: ignoring the letter would
/// set a wrong heater, or none. RepRapFirmware's first bed and chamber are P0.
fn other_name(context: &Context<'_>) -> Option<char> {
    let words = &context.words;
    let is_one = |letter: &char| match letter {
        'H' => words.has('H'),
        _ if !context.dialect.is_other_printers() => false,
        'P' => words.get('P').is_some_and(|place| place != 0.0),
        _ => words.has(*letter),
    };
    ['H', 'P', 'I'].into_iter().find(is_one)
}

/// Returns the heater that a code addresses, and whether the code waits: by T, else the active tool's, else a
/// heater that is always active.
fn addressed(program: &Interpreter, claims: &[Claim], context: &Context<'_>) -> Result<(HeaterId, bool), Fault> {
    let active = program.tools.active_id();
    let word = context.words.get('T');
    let wanted = word.and_then(ToolId::from_word);
    let is_meant = |id: ToolId| match word {
        Some(_) => wanted == Some(id),
        None => id == active || id >= ALWAYS_ACTIVE,
    };
    let listening = claims.iter().filter_map(|claim| match *claim {
        Claim::Target(heater) => Some((heater, false)),
        Claim::TargetAndWait(heater) => Some((heater, true)),
        _ => None,
    });
    let mut meant = listening.filter(|(heater, _)| program.heaters.get(heater.index()).is_some_and(|h| is_meant(h.id)));
    let code = context.words.code();
    meant.next().ok_or_else(|| match word {
        Some(word) => Problem::NoHeaterOf(code, word).refused(context.words.column_of('T')),
        None => Problem::ToolWithoutHeater(code.number, active).refused(0),
    })
}

/// Returns heater and target for a tool number.
pub(crate) fn of_tool(
    program: &Interpreter,
    code: Code,
    tool: f64,
    celsius: f64,
    column: u16,
) -> Result<(HeaterId, Celsius), Fault> {
    let wanted = ToolId::from_word(tool);
    let heater = HeaterId::all().zip(&program.heaters).find(|(_, heater)| Some(heater.id) == wanted);
    let (heater, _) = heater.ok_or(Problem::NoHeaterOf(code, tool).refused(column))?;
    Ok((heater, meant(program, heater, celsius)))
}

/// Resolves a target: 1 and 2 stand for the presets.
fn meant(program: &Interpreter, heater: HeaterId, celsius: f64) -> Celsius {
    match (celsius, program.heaters.get(heater.index()).map(|heater| heater.presets)) {
        (1.0, Some([first, _])) => first,
        (2.0, Some([_, second])) => second,
        _ => Celsius(celsius as f32),
    }
}
