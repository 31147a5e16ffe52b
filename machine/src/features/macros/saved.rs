//! `[save_variables]`: variables of macros that outlast a power cycle, in Klipper's own file.

use base::failure::{Answer, Failure, Outcome};
use base::paths::{self, Path};
use gcode::Extended;
use printer_cfg::Use;

use super::hands::{MacroHands, Seen, has_option, refused};
use crate::machine::card;

/// Reason for which nothing can be saved.
const NONE: &str = "SAVE_VARIABLE needs [save_variables] with filename in the printer.cfg";

/// Returns the path of the file: it lies beside the configuration, whatever folder of a computer it names.
fn path<'c>(hands: &mut impl MacroHands<'c>) -> Result<Option<Path>, Failure> {
    let Seen { macros, world, .. } = hands.seen();
    let memory = &mut macros.memory;
    let Some(section) = memory.store.section("save_variables") else { return Ok(None) };
    let read = memory.store.read((section, "filename"), &mut world.ports, |text| memory.text.fill(text));
    match read {
        Err(trouble) => Err(refused(hands, &trouble)),
        Ok(None) => Ok(None),
        Ok(Some(_)) => {
            let name = memory.text.text().unwrap_or("");
            let name = name.rsplit_once('/').map_or(name, |(_, name)| name);
            let folder = memory.store.main_file().rsplit_once('/').map_or("", |(folder, _)| folder);
            Ok(Some(paths::absolute(folder, name)))
        }
    }
}

/// Reads a variable into memory. None: there is none, or it cannot be read.
pub(super) fn read<'c>(hands: &mut impl MacroHands<'c>, name: &str) -> Option<()> {
    let path = path(hands).ok().flatten()?;
    let Seen { macros, world, .. } = hands.seen();
    printer_cfg::read_saved(&mut world.ports, &path, name, macros.memory.text)
        .ok()
        .filter(|is_there| *is_there)
        .map(drop)
}

/// Reads the name of the variable at a place into memory.
pub(super) fn name_at<'c>(hands: &mut impl MacroHands<'c>, place: usize) -> Option<()> {
    let path = path(hands).ok().flatten()?;
    let Seen { macros, world, .. } = hands.seen();
    printer_cfg::saved_name(&mut world.ports, &path, place, macros.memory.text)
        .ok()
        .filter(|is_there| *is_there)
        .map(drop)
}

/// Saves a variable (SAVE_VARIABLE).
pub(super) fn save<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>) -> Outcome {
    let (Some(name), Some(value)) = (command.get("VARIABLE"), command.get("VALUE")) else {
        return Err(Failure::refused(&"SAVE_VARIABLE needs VARIABLE= and VALUE="));
    };
    if name.bytes().any(|byte| byte.is_ascii_uppercase()) {
        return Err(Failure::refused(&"SAVE_VARIABLE: the name of a variable has no upper case"));
    }
    let Some(path) = path(hands)? else { return Err(hands.world().texts.because(NONE)) };
    let mut literal = heapless::Vec::<u8, { printer_cfg::SCRATCH }>::new();
    rewrite(hands, value, &mut literal)?;
    card::at_rest(hands);
    let Seen { macros, world, .. } = hands.seen();
    let value = core::str::from_utf8(&literal).unwrap_or("");
    let saved = printer_cfg::save(&mut world.ports, &path, (name, value), macros.memory.text);
    saved.map_err(|why| world.texts.about_file(&path, why.text()))?;
    card::kept(hands).map_err(|error| hands.world().texts.about_file(&path, error.text()))?;
    Ok(Answer::Ok)
}

/// Writes a literal as Python would write it.
///
/// # Errors
/// The text is no literal.
pub(super) fn rewrite<'c, const N: usize>(
    hands: &mut impl MacroHands<'c>,
    value: &str,
    into: &mut heapless::Vec<u8, N>,
) -> Result<(), Failure> {
    let memory = &mut hands.macros().memory;
    // The rest of the code's room is free: nothing is rendered now.
    let (work, output) = memory.code.split_at_mut(memory.code.len().saturating_sub(N));
    match ::macros::rewrite_literal(value, work, output) {
        Ok(length) => {
            into.clear();
            // The output has as much room.
            let _ = into.extend_from_slice(output.get(..length).unwrap_or(&[]));
            Ok(())
        }
        Err(error) => Err(hands.world().texts.refused(format_args!("{value}: {}", error.words))),
    }
}

/// Sets a variable of a macro (SET_GCODE_VARIABLE).
pub(super) fn set<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>) -> Outcome {
    let words = [command.get("MACRO"), command.get("VARIABLE"), command.get("VALUE")];
    let [Some(of), Some(name), Some(value)] = words else {
        return Err(Failure::refused(&"SET_GCODE_VARIABLE needs MACRO=, VARIABLE= and VALUE="));
    };
    let texts = hands.world().texts;
    let Some(section) = hands.macros().memory.store.named("gcode_macro", of) else {
        return Err(texts.refused(format_args!("SET_GCODE_VARIABLE: there is no macro {of}")));
    };
    if !is_variable(hands, section, name)? {
        return Err(texts.refused(format_args!("SET_GCODE_VARIABLE: {of} has no variable_{name}")));
    }
    let mut literal = heapless::Vec::<u8, 512>::new();
    rewrite(hands, value, &mut literal)?;
    let value = core::str::from_utf8(&literal).unwrap_or("");
    if hands.macros().memory.variables.set(section, name, value) {
        return Ok(Answer::Ok);
    }
    Err(Failure::refused(&"SET_GCODE_VARIABLE: variables that were changed have 2 KB with their names: shorten one"))
}

/// Whether a macro has a variable.
fn is_variable<'c>(
    hands: &mut impl MacroHands<'c>,
    section: printer_cfg::Section,
    name: &str,
) -> Result<bool, Failure> {
    if !hands.macros().memory.store.has(section, Use::Variables) {
        return Ok(false);
    }
    let mut key = heapless::String::<96>::new();
    match core::fmt::Write::write_fmt(&mut key, format_args!("variable_{name}")) {
        Ok(()) => has_option(hands, section, &key),
        Err(_) => Ok(false),
    }
}
