//! Macros for the look ahead at a file: rendered as in a call, but nothing of them is carried out.
//!
//! A call is rendered for the machine as it is now, in one piece of work, while the executor has nothing else
//! to do. Its lines stand at the end of the memory that macros under way use from the start.

use core::mem::take;

use base::failure::Failure;
use gcode::Extended;
use preflight::forecast::Wanted;
use preflight::{Called, MacroName, MacroPlace};
use printer_cfg::Section;

use super::calls::{name_of, render};
use super::hands::{MacroHands, Seen};
use super::look::{Acts, Parameters};

/// Reason why nothing is known of the rest of a macro.
const LOST: Called = Called::Unknown(Failure::refused(&"other macros needed its memory"));
const NO_ROOM: Called = Called::Unknown(Failure::refused(&"the macros under way have too many lines"));

/// Answers what the look ahead at a file wishes to know of macros. True: it has wished.
pub(super) fn serve<'c>(hands: &mut impl MacroHands<'c>) -> bool {
    let forecast = hands.look_ahead();
    let may_run = forecast.may_run() && forecast.is_under_way();
    let wanted = if may_run { forecast.take_wanted(true) } else { None };
    let Some(wanted) = wanted else { return false };
    let answer = match wanted {
        Wanted::Macro(line, is_code) => {
            let line = core::str::from_utf8(&line).unwrap_or("");
            Wanted::Called(enter(hands, line, is_code))
        }
        _ => next_line(hands),
    };
    forecast.answer_macros(answer);
    true
}

/// Renders the macro that a line calls, or writes what a macro has replaced.
fn enter<'c>(hands: &mut impl MacroHands<'c>, line: &str, is_code: bool) -> Called {
    let command = Extended::new(line);
    let name = if is_code { line.split(' ').next().unwrap_or("") } else { command.name() };
    let store = &mut hands.macros().memory.store;
    if store.looks().is_plain() {
        return Called::Nothing;
    }
    store.looks().changes_variables |= command.is("SET_GCODE_VARIABLE") || command.is("SAVE_VARIABLE");
    let (named, renamed) = (store.named("gcode_macro", name), store.renamed(name));
    let Some(section) = named.or(renamed) else { return Called::Nothing };
    let fault = if named.is_some() && store.looks().has(section) {
        Some("a macro that is under way is called recursively")
    } else if store.looks().may_enter() {
        None
    } else {
        Some("macros call each other more than 12 deep")
    };
    if let Some(fault) = fault {
        return Called::Refused(hands.world().texts.refused(format_args!("{name}: {fault}")));
    }
    // A text behind a code may have a mark of a comment in it.
    let words = line.get(name.len()..).unwrap_or("").trim_start();
    if named.is_none() {
        return replaced(hands, section, if is_code { words } else { command.rest() });
    }
    let parameters = if is_code { Parameters::Coded(words) } else { Parameters::Named(command) };
    let memory = &mut hands.macros().memory;
    let (code, lines) = (take(&mut memory.code), take(&mut memory.lines));
    let (from, to) = (memory.store.lines_end(), memory.store.looks().room_ends(lines.len()));
    let place = from + name.len() + 1;
    let room = lines.get_mut(place..to).unwrap_or(&mut []);
    let rendered = render(hands, (section, "gcode"), &parameters, (code, room), Acts::Never);
    let memory = &mut hands.macros().memory;
    (memory.code, memory.lines) = (code, lines);
    match rendered {
        Ok((length, is_sure)) => put(hands, section, [name, ""], length, (false, is_sure)),
        Err((failure, true)) => Called::Refused(failure),
        Err((failure, false)) => Called::Unknown(failure),
    }
}

/// Enters what a macro has replaced, with these words.
fn replaced<'c>(hands: &mut impl MacroHands<'c>, section: Section, words: &str) -> Called {
    match name_of(hands, section) {
        Ok(name) => put(hands, section, [&name, words], name.len() + 1 + words.len(), (true, true)),
        Err(failure) => Called::Unknown(failure),
    }
}

/// Puts a macro's name and lines of this length to the end of the room; the lines of one that was rendered
/// stand behind the place of the name, those of another are its name and words.
fn put<'c>(
    hands: &mut impl MacroHands<'c>,
    section: Section,
    [name, words]: [&str; 2],
    length: usize,
    (is_plain, is_sure): (bool, bool),
) -> Called {
    let memory = &mut hands.macros().memory;
    let (from, end) = (memory.store.lines_end(), memory.store.looks().room_ends(memory.lines.len()));
    let whole = name.len() + 1 + length;
    let Some(room) = memory.lines.get_mut(from..end).filter(|room| room.len() >= whole) else { return NO_ROOM };
    let text = name.bytes().chain([b'\n']);
    if is_plain {
        let text = text.chain(name.bytes()).chain([b' ']).chain(words.bytes());
        room.iter_mut().zip(text).for_each(|(place, byte)| *place = byte);
    } else {
        room.iter_mut().zip(text).for_each(|(place, byte)| *place = byte);
    }
    // Both ends have been looked at.
    room.copy_within(..whole, room.len() - whole);
    let looks = memory.store.looks();
    looks.enter(section, end - whole..end, name.len(), (is_plain, is_sure));
    Called::Macro { is_sure: looks.are_sure() }
}

/// Returns the next line of the macros entered.
fn next_line<'c>(hands: &mut impl MacroHands<'c>) -> Wanted {
    let Seen { macros, world, .. } = hands.seen();
    let memory = &mut macros.memory;
    if memory.store.looks().take_lost() {
        return Wanted::Called(LOST);
    }
    let Some(taken) = memory.store.looks().take_line(memory.lines) else { return Wanted::Called(Called::Nothing) };
    let text = |range: core::ops::Range<usize>| memory.lines.get(range).unwrap_or(&[]);
    let whole = core::str::from_utf8(text(taken.name)).unwrap_or("");
    let Ok(line) = heapless::Vec::from_slice(text(taken.line)) else {
        let failure = world.texts.refused(format_args!("{whole}: a line has more than 255 bytes"));
        return Wanted::Called(Called::Refused(failure));
    };
    let mut name = MacroName::new();
    // As much as fits.
    let _ = name.push_str(whole.get(..whole.floor_char_boundary(name.capacity())).unwrap_or(""));
    Wanted::Line(line, MacroPlace { name, row: taken.row }, taken.is_sure)
}
