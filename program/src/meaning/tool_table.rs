//! Spindle tools: their offsets (G43, G49), their table (G10 L1, L10, L11), and the number of the tool in the
//! spindle (M61). Machines with extruders lack all of these: T selects a tool and its offset there.

use units::Axis;

use crate::action::Action;
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::state::tool_table::{MOST_ORIENTATION, ToolEntry};
use crate::words::Words;

/// Index of G59.3, the coordinate system in which G10 L11 measures.
const FIXTURE: usize = 8;

/// G43, G43.1 and G43.2: sets the tool offset. G43 does nothing on a machine with extruders.
pub(crate) fn tool_length<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let subcode = words.code().subcode;
    if !context.dialect.replaces_offsets() && subcode != 0 {
        return shift(program, words);
    }
    if program.tools.has_extruders() && (subcode == 0 || words.has('H')) {
        let about = words.has('H').then(|| Problem::NoSpindleTools.refused(words.column_of('H')));
        return about.map_or(NOTHING, Err);
    }
    if subcode == 0 && !words.has('H') && !context.dialect.replaces_offsets() && program.tools.table.all().is_empty() {
        // A machine without a tool table accepts G43, as Smoothieware does.
        return NOTHING;
    }
    let axes = Axis::PRIMARY.map(|axis| words.axis(axis));
    let offset = match subcode {
        0 => offset_of(program, words)?,
        1 => {
            let mut offset = program.modal.own_tool_offset();
            offset.iter_mut().zip(axes).for_each(|(offset, word)| *offset = word.unwrap_or(*offset));
            offset
        }
        _ => {
            let has_axes = axes.iter().any(Option::is_some);
            if has_axes == words.has('H') {
                let problem = if has_axes { Problem::ToolOrAxes } else { Problem::MustSupply('H') };
                return Err(problem.refused(words.column()));
            }
            let more = if has_axes { axes.map(Option::unwrap_or_default) } else { offset_of(program, words)? };
            let mut offset = program.modal.own_tool_offset();
            offset.iter_mut().zip(more).for_each(|(offset, more)| *offset += more);
            offset
        }
    };
    program.modal.set_tool_offset(offset);
    program.modal.has_tool_length = true;
    NOTHING
}

/// G43.1 and G43.2 in dialects where both add to the offset; G43.2 also moves by the same distance.
fn shift<'b>(program: &mut Interpreter, words: &Words<'b>) -> Result<Meaning<'b>, Fault> {
    let mut target = program.position;
    for (axis, offset) in Axis::PRIMARY.into_iter().zip(&mut program.modal.tool_offset) {
        let mm = words.axis(axis).unwrap_or(0.0);
        *offset += mm;
        target[axis] += mm;
    }
    program.modal.has_tool_length = true;
    if words.code().subcode == 2 && target != program.position {
        return Ok(Meaning::Action(program.rapid_to(target)));
    }
    NOTHING
}

/// Returns the offset of the tool that H names, or of the tool in the spindle.
fn offset_of(program: &Interpreter, words: &Words<'_>) -> Result<[f64; 3], Fault> {
    let number = match words.get('H') {
        Some(number) if number != 0.0 => number as u16,
        _ => program.tools.in_spindle,
    };
    if number == 0 {
        return Ok([0.0; 3]);
    }
    let column = words.column_of('H');
    let tool = program.tools.table.get(number).ok_or(Problem::NotInTable(number).refused(column))?;
    match tool.rotary_axis() {
        Some(letter) => Err(Problem::RotaryOffset(number, letter).refused(column)),
        None => Ok(tool.offset),
    }
}

/// G49: cancels the tool offset.
pub(crate) fn no_tool_length<'b>(program: &mut Interpreter, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.set_tool_offset([0.0; 3]);
    program.modal.has_tool_length = false;
    NOTHING
}

/// G10 L0: reads the table again from the card.
pub(crate) fn reload<'b>(program: &Interpreter, words: &Words<'b>) -> Result<Meaning<'b>, Fault> {
    may_have_table(program, words)?;
    Ok(Meaning::Action(Action::ReadTools))
}

/// G10 L1, L10 and L11: sets a tool's entry in the table.
pub(crate) fn set_tool<'b>(program: &mut Interpreter, words: &Words<'b>) -> Result<Meaning<'b>, Fault> {
    may_have_table(program, words)?;
    let number = words.get('P').ok_or(Problem::MustSupply('P').refused(words.column()))?;
    let is_number = libm::floor(number) == number && (1.0..=f64::from(u16::MAX)).contains(&number);
    if !is_number {
        return Err(Problem::ToolNumber.refused(words.column_of('P')));
    }
    let number = number as u16;
    if !"XYZABCRIJQ".chars().any(|letter| words.has(letter)) {
        return Err(Problem::NothingOfTool.refused(words.column()));
    }
    let mut tool = program.tools.table.get(number).copied().unwrap_or(ToolEntry { number, ..ToolEntry::default() });
    let kind = words.get('L').unwrap_or_default();
    for (axis, offset) in Axis::PRIMARY.into_iter().zip(&mut tool.offset) {
        let Some(mm) = words.axis(axis) else { continue };
        *offset = if kind == 1.0 { mm } else { reading(program, axis, kind == 11.0) - mm };
    }
    for (letter, offset) in ['A', 'B', 'C'].into_iter().zip(&mut tool.rotary) {
        match words.get(letter) {
            Some(_) if kind != 1.0 => return Err(Problem::NoRotaryOffset.refused(words.column_of(letter))),
            Some(degrees) => *offset = degrees as f32,
            None => {}
        }
    }
    // The program gives a radius, the table has a diameter.
    tool.diameter = words.as_length('R').map_or(tool.diameter, |radius| 2.0 * radius);
    for (letter, angle) in ['I', 'J'].into_iter().zip(&mut tool.angles) {
        *angle = words.as_written(letter).map_or(*angle, |degrees| degrees as f32);
    }
    if let Some(orientation) = words.get('Q') {
        let is_one =
            libm::floor(orientation) == orientation && (0.0..=f64::from(MOST_ORIENTATION)).contains(&orientation);
        if !is_one {
            return Err(Problem::Orientation.refused(words.column_of('Q')));
        }
        tool.orientation = orientation as u8;
    }
    if !program.tools.table.set(tool) {
        return Err(Problem::TableFull.refused(words.column_of('P')));
    }
    Ok(Meaning::Action(Action::Keep))
}

/// Returns an axis' coordinate without a tool offset: in the system in force, or in G59.3 without G92.
fn reading(program: &Interpreter, axis: Axis, in_fixture: bool) -> f64 {
    let (modal, place) = (&program.modal, axis as usize);
    let system = if in_fixture { FIXTURE } else { modal.system };
    let of = |offsets: &[f64; 3]| offsets.get(place).copied().unwrap_or_default();
    let g92 = if in_fixture { 0.0 } else { of(&modal.g92) };
    // Shifts by M290 and by temperature are not part of the tool's offset.
    program.position[axis] - modal.systems.get(system).map_or(0.0, of) + g92 - of(&modal.added())
}

fn may_have_table(program: &Interpreter, words: &Words<'_>) -> Result<(), Fault> {
    if program.tools.has_extruders() { Err(Problem::NoSpindleTools.refused(words.column_of('L'))) } else { Ok(()) }
}

/// M61: sets the number of the tool in the spindle.
pub(crate) fn set_current_tool<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let number = words.get('Q').ok_or(Problem::MustSupply('Q').refused(words.column()))?;
    if program.tools.has_extruders() {
        return Err(Problem::NoSpindleTools.refused(words.column()));
    }
    program.tools.in_spindle = number as u16;
    NOTHING
}
