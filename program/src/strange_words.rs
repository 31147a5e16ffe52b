//! Words that a code does not take.

use gcode::Letter;

use crate::action::Effect;
use crate::codes::{CodeInfo, Handler};
use crate::dialect::Dialect;
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::words::Words;

/// Letters that say in some firmware where a G-code goes, how it goes there or what it extrudes: R is a
/// restore point of RepRapFirmware, H how its G1 stops, U to W are axes, T
/// is a tool.
const OF_A_MOVE: &str = "XYZABCUVWEIJKRHT@^";

/// Words that the row of a code does not take. What might move the tool elsewhere is refused; of what
/// changes nothing the first is noted. In GRBL's dialect lines are looked through as a whole.
///
/// # Errors
/// The word that is refused.
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
    // Homing and splines look at their own words.
    let looks_itself = code.letter == Letter::G && matches!(code.number, 5 | 28);
    if has_words_of_its_own || looks_itself || dialect == Dialect::Grbl {
        return Ok(());
    }
    // Other words of these say how the bed is measured.
    let measures = matches!(code.number, 29..=32 | 34 | 35 | 38 | 80);
    let mut idle = None;
    for letter in words.strange(row.letters) {
        // RepRapFirmware's H0 is a move like any other.
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
