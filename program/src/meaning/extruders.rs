//! Extruders: tool selection (T), firmware retraction, and their settings.

use gcode::NO_TOOL;
use units::{Axis, MmPerSecond, PowerLaw};

use crate::action::{Action, Corner, Move, Rate, Shape};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Part, Problem};
use crate::function::{Function, Standing};
use crate::interpreter::Interpreter;
use crate::words::{MM_PER_INCH, Words};

/// Selects a tool by its number (T).
pub(crate) fn select_tool<'b>(program: &mut Interpreter, number: u16, column: u16) -> Result<Meaning<'b>, Fault> {
    if number == NO_TOOL {
        return Err(Problem::NoSuchTool(-1.0).refused(column));
    }
    if !program.tools.has_extruders() {
        program.tools.selected = number;
        return NOTHING;
    }
    let place = program.tools.numbered(f64::from(number));
    program.tools.active = place.ok_or(Problem::NoSuchTool(f64::from(number)).refused(column))?;
    if let Some(offset) = program.tools.active().map(|tool| tool.settings.offset) {
        program.modal.set_tool_offset(offset);
    }
    NOTHING
}

/// G10 without L: pulls the filament back, then lifts.
pub(crate) fn retract<'b>(program: &mut Interpreter) -> Result<Meaning<'b>, Fault> {
    needs_extruder(program)?;
    let Some(tool) = program.tools.active_mut() else { return Ok(Meaning::Unknown) };
    if tool.retracted.is_some() {
        return NOTHING;
    }
    tool.retracted = Some(tool.settings.z_lift);
    let settings = tool.settings.clone();
    let pull = move_by(program, settings.axis, -settings.retract_length, settings.retract_rate);
    if settings.z_lift > 0.0 {
        let lift = move_by(program, Axis::Z, settings.z_lift, settings.z_lift_rate);
        program.then(lift);
    }
    Ok(Meaning::Action(pull))
}

/// Returns a move of one axis at its own rate, and moves the program's position to its end.
fn move_by<'b>(program: &mut Interpreter, axis: Axis, by: f64, rate: MmPerSecond) -> Action<'b> {
    program.position[axis] += by;
    // Filament, and lifts of a retraction: nothing to burn by.
    let power = if program.setup.laser.is_some() { 0.0 } else { program.modal.power };
    let (target, shape, rate) = (program.position, Shape::Line { names_xy: false }, Rate::Feed(rate));
    Action::Move(Move { target, shape, rate, power, power_law: PowerLaw::Off, corner: Corner::Sharp })
}

/// G11: lowers the tool, then pushes the filament forward.
pub(crate) fn recover<'b>(program: &mut Interpreter, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    needs_extruder(program)?;
    let Some(tool) = program.tools.active_mut() else { return Ok(Meaning::Unknown) };
    let Some(lift) = tool.retracted.take() else { return NOTHING };
    let settings = tool.settings.clone();
    let length = settings.retract_length + settings.recover_length;
    if lift > 0.0 {
        let down = move_by(program, Axis::Z, -lift, settings.z_lift_rate);
        let push = move_by(program, settings.axis, length, settings.recover_rate);
        program.then(push);
        return Ok(Meaning::Action(down));
    }
    Ok(Meaning::Action(move_by(program, settings.axis, length, settings.recover_rate)))
}

/// Returns the E word: mm of filament or mm3, also after G20; other printer firmwares use inches then.
#[inline]
pub(crate) fn e_word(program: &Interpreter, context: &Context<'_>) -> Option<f64> {
    let is_inches = program.modal.inches && context.dialect.is_other_printers();
    context.words.number('E').map(|word| if is_inches { word * MM_PER_INCH } else { word })
}

fn needs_extruder(program: &Interpreter) -> Result<(), Fault> {
    let off = program.tools.active().filter(|tool| tool.settings.is_off);
    off.map_or(Ok(()), |tool| Err(Problem::PartIsOff(Part::Extruder(tool.settings.id)).refused(0)))
}

/// G10 L1 Pn: sets the offset of tool n - 1.
pub(crate) fn set_tool_offset<'b>(program: &mut Interpreter, words: &Words<'b>) -> Result<Meaning<'b>, Fault> {
    let place = words.get('P').and_then(|p| program.tools.numbered(p - 1.0));
    offset_tool(program, words, place, 'P')?;
    NOTHING
}

/// Sets the offset of a tool, whose number a word gives, by X, Y and Z.
pub(crate) fn offset_tool(
    program: &mut Interpreter,
    words: &Words<'_>,
    place: Option<usize>,
    letter: char,
) -> Result<(), Fault> {
    let active = program.tools.active_id();
    let tool = place.and_then(|place| program.tools.tools.get_mut(place));
    let tool = tool.ok_or(
        match letter {
            'P' if words.code().number == 10 && words.has('L') => Problem::ToolOfOffset,
            letter => Problem::NoSuchTool(words.get(letter).unwrap_or(0.0)),
        }
        .refused(words.column_of(letter)),
    )?;
    for (offset, axis) in tool.settings.offset.iter_mut().zip(Axis::PRIMARY) {
        *offset = words.axis(axis).unwrap_or(*offset);
    }
    if tool.settings.id == active {
        let offset = tool.settings.offset;
        program.modal.set_tool_offset(offset);
    }
    Ok(())
}

/// M200: sets the filament diameter.
pub(crate) fn filament_diameter<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let tool = program.tools.selected_by(words, &['P', 'T'])?;
    let now = tool.settings.filament_diameter;
    let diameter = words.get('D').map_or(now, |diameter| (diameter > 0.01).then_some(diameter));
    match words.get('S').filter(|_| context.dialect.is_other_printers()) {
        Some(0.0) => tool.settings.filament_diameter = None,
        Some(_) if diameter.is_none() => return Err(Problem::MustSupply('D').refused(words.column())),
        None if !words.has('D') => return Ok(context.function()),
        _ => tool.settings.filament_diameter = diameter,
    }
    NOTHING
}

/// M207: sets the retraction of G10.
pub(crate) fn retraction<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let settings = &mut program.tools.selected_mut(words)?.settings;
    let word = |letter: char, now: f64| words.get(letter).unwrap_or(now);
    settings.retract_length = word('S', settings.retract_length);
    settings.retract_rate.0 = word('F', settings.retract_rate.0);
    settings.z_lift = word('Z', settings.z_lift);
    settings.z_lift_rate.0 = word('Q', settings.z_lift_rate.0);
    NOTHING
}

/// M208: sets the recovery of G11.
pub(crate) fn recovery<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let settings = &mut program.tools.selected_mut(words)?.settings;
    settings.recover_length = words.get('S').unwrap_or(settings.recover_length);
    settings.recover_rate.0 = words.get('F').unwrap_or(settings.recover_rate.0);
    NOTHING
}

/// M203 V: sets the greatest flow; the machine handles the other words.
pub(crate) fn flow_limit<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if let Some(most) = words.get('V') {
        let tool = program.tools.selected_mut(words)?;
        tool.settings.flow_limit = (most > 0.0).then_some(most);
        if !"XYZES".chars().any(|letter| words.has(letter)) {
            return NOTHING;
        }
    }
    Ok(context.function())
}

/// M221: sets the flow factor, or how a laser's power is scaled on a machine without extruders.
pub(crate) fn flow<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    if program.setup.laser.is_some() && !program.tools.has_extruders() {
        return Ok(Meaning::Action(Action::Function(Function::Standing(Standing::Laser), context.words)));
    }
    if context.words.has('R') {
        return Err(Problem::Needs(context.words.code(), "a laser").refused(context.words.column_of('R')));
    }
    // Marlin's T and RepRapFirmware's D select the tool, as P does.
    let tool = program.tools.selected_by(&context.words, &['P', 'T', 'D'])?;
    let Some(factor) = context.words.get('S') else { return Ok(context.function()) };
    tool.flow = factor;
    NOTHING
}
