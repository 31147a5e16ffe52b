//! Handling of words that a code does not take.

use gcode::Letter;

use crate::action::Effect;
use crate::codes::{CodeInfo, Handler};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::words::Words;
use gcode::Dialect;

/// Letters that give a G-code's target, manner or extrusion in some firmware: R is a restore point of
/// RepRapFirmware, H how its G1 stops, U to W are axes, T is a tool.
const OF_A_MOVE: &str = "XYZABCUVWEIJKRHT@^";

/// Checks words that the row of a code does not take. Words that might change a move are refused; of harmless
/// words the first is noted. GRBL's dialect checks whole lines elsewhere.
///
/// # Errors
/// When a word is refused, with that word.
#[cold]
pub(crate) fn look(
    program: &mut Interpreter,
    words: &Words<'_>,
    row: &CodeInfo,
    dialect: Dialect,
) -> Result<(), Fault> {
    let code = words.code();
    let has_words_of_its_own = match row.handler {
        Handler::Interpret(_) | Handler::Function(_) | Handler::Both(..) => program.setup.claims.may_have(code),
        Handler::Tool | Handler::Claimed | Handler::Nothing | Handler::PassedOver | Handler::Missing => true,
    };
    // Handlers of homing and splines check their own words.
    let looks_itself = code.letter == Letter::G && matches!(code.number, 5 | 28);
    if has_words_of_its_own || looks_itself || dialect == Dialect::Grbl {
        return Ok(());
    }
    // Other words of these codes say how the bed is measured.
    let measures = matches!(code.number, 29..=32 | 34 | 35 | 38 | 80);
    let mut idle = None;
    for letter in words.strange(row.letters) {
        // H0 of RepRapFirmware is an ordinary move.
        let is_plain = letter == 'H' && words.as_written('H') == Some(0.0);
        if code.letter == Letter::G && !measures && !is_plain && OF_A_MOVE.contains(letter) {
            return Err(Problem::NotTaken(code, letter).refused(words.column_of(letter)));
        }
        idle = idle.or(Some(letter));
    }
    if let Some(letter) = idle {
        program.by_the_way(Effect::Ignored { code, letter });
    }
    Ok(())
}
