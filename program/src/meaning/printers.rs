//! Codes of other printer firmwares, translated to Smoothieware's meaning.

use gcode::Code;
use units::{Axis, Celsius, HeaterId};

use crate::action::{Action, Effect};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::function::{FileFunction, Function, Geometry, LimitCode, Sequence};
use crate::interpreter::Interpreter;
use crate::meaning::{extruders, heat, offsets, program};
use crate::word::{Unit, WordInfo, word};
use crate::words::Words;
use gcode::Dialect;

macro_rules! speeds {
    ($unit:expr) => {
        const { &[word('X', $unit, ""), word('Y', $unit, ""), word('Z', $unit, ""), word('E', $unit, "")] }
    };
}

/// Words of axis speeds in RepRapFirmware; the other list is for S1.
const SPEEDS: &[WordInfo] = speeds!(Unit::MmPerMinute);
const SPEEDS_A_SECOND: &[WordInfo] = speeds!(Unit::MmPerSecond);

/// Returns a function with another code's meaning and without words.
const fn as_code<'b>(function: Function, code: Code) -> Result<Meaning<'b>, Fault> {
    Ok(Meaning::Action(Action::Function(function, Words::bare(code))))
}

/// G29, and Prusa's G80: probes the bed as G31 does, or handles the grid as the words say.
pub(crate) fn level<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let (phase, what) = (words.get('P').unwrap_or(1.0), words.get('S').unwrap_or(0.0));
    // The name of a mesh is among the words.
    let with_words = |function| Ok(Meaning::Action(Action::Function(function, *words)));
    if context.dialect == Dialect::RepRapFirmware {
        return match what {
            0.0 => as_code(Function::Sequence(Sequence::ProbeStrategy), Code::g(31)),
            1.0 => with_words(Function::Geometry(Geometry::LoadGrid)),
            2.0 => as_code(Function::Sequence(Sequence::LevelingOff), Code::m(370)),
            3.0 => with_words(Function::Sequence(Sequence::SaveGrid)),
            _ => Ok(Meaning::PassedOver),
        };
    }
    let has_all = |letters: &str| letters.chars().all(|letter| words.get(letter).is_some());
    match () {
        () if words.has('D') => as_code(Function::Sequence(Sequence::LevelingOff), Code::m(370)),
        () if has_all("XYWH") || has_all("LRFB") => with_words(Function::Sequence(Sequence::MeasureBed)),
        () if words.has('L') => as_code(Function::Geometry(Geometry::LoadGrid), Code::m(375)),
        // Prusa's later steps (more points, filling in, putting into force) are already done.
        () if phase != 1.0 || words.has('C') || words.has('A') && !words.has('P') => NOTHING,
        () => as_code(Function::Sequence(Sequence::ProbeStrategy), Code::g(31)),
    }
}

/// M18 and M84: turns motors off. With S the codes set a time-out for motors, and turn nothing off;
/// Smoothieware's M84 ignores S, and its M18 with S turns off only named motors.
pub(crate) fn motors_off<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let acts = match context.dialect {
        // Klipper's codes turn everything off, whatever words follow.
        Dialect::Klipper => true,
        Dialect::Marlin | Dialect::RepRapFirmware => false,
        _ => words.code().number == 84 || words.has('E') || !words.axes().is_empty(),
    };
    Ok(if words.has('S') && !acts { Meaning::PassedOver } else { context.function() })
}

/// M204: P and T are for printing and travel moves. All moves share an acceleration here: that of printing
/// moves, or in Klipper the lesser.
pub(crate) fn accelerations<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    // Start codes of some slicers have P0 and T0, which Marlin replaces by its minimum.
    let above_zero = |letter| words.get(letter).filter(|acceleration| *acceleration > 0.0);
    let (print, travel) = (above_zero('S').or(above_zero('P')), above_zero('T'));
    let both = match (print, travel) {
        (Some(print), Some(travel)) if context.dialect == Dialect::Klipper => Some(print.min(travel)),
        _ => print,
    };
    Ok(both.map_or(Meaning::PassedOver, |acceleration| Meaning::Action(Action::Acceleration(acceleration))))
}

/// M73: accepts the progress that slicers write; without words, reports progress to hosts.
pub(crate) fn progress<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    if !context.words.is_bare() {
        return Ok(Meaning::PassedOver);
    }
    Ok(Meaning::Action(Action::Function(Function::File(FileFunction::ReportProgress), context.words)))
}

/// RepRapFirmware's G10 P and M568: sets the temperature and the offset of a tool.
pub(crate) fn tool_settings<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let is_offset = words.code().number == 10;
    if is_offset && (words.has('L') || words.is_bare()) {
        return offsets::set_offsets(program, context);
    }
    if !words.has('P') && !"SXYZ".chars().any(|letter| words.has(letter)) {
        return Ok(Meaning::PassedOver);
    }
    let id = words.get('P').unwrap_or(f64::from(program.tools.active_id().0));
    let (code, column) = (words.code(), words.column_of('P'));
    let target = match words.get('S').map(|celsius| heat::of_tool(program, code, id, celsius, column)) {
        // Slicers switch off heaters that only other machines have.
        Some(Err(_)) if words.get('S') == Some(0.0) => return Ok(Meaning::PassedOver),
        target => target.transpose()?,
    };
    if is_offset && "XYZ".chars().any(|letter| words.has(letter)) {
        extruders::offset_tool(program, words, program.tools.numbered(id), 'P')?;
    }
    if let Some((heater, target)) = target {
        program.by_the_way(Effect::Target { heater, target });
    }
    NOTHING
}

/// Marlin's M218: sets the offset of tool T.
pub(crate) fn hotend_offset<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let tool = words.get('T').map_or(Some(program.tools.active), |id| program.tools.numbered(id));
    extruders::offset_tool(program, words, tool, 'T')?;
    NOTHING
}

/// Runs a code whose letters name heaters in the dialect's own way; any other letter is refused, because it
/// would name another heater.
pub(crate) fn by_its_letters<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    match words.not_taken() {
        Some(letter) => Err(Problem::NotTaken(words.code(), letter).refused(words.column_of(letter))),
        None => Ok(context.function()),
    }
}

/// Refuses a code that sets up the hardware, with letters and units of its own.
pub(crate) fn sets_up<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    Err(Problem::SetsUp(context.words.code()).refused(0))
}

/// RepRapFirmware's M0, M1 and M2: ends the job and turns all heaters off. A text behind the code is a
/// question to a person, so the job pauses instead.
pub(crate) fn end_job<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    if context.words.text().is_some() {
        return program::pause(program, context);
    }
    for (heater, _) in HeaterId::all().zip(program.heaters.clone()) {
        program.by_the_way(Effect::Target { heater, target: Celsius(0.0) });
    }
    program::end(program, context)
}

/// RepRapFirmware's M203: sets axis speeds in mm/min, or in mm/s with S1.
pub(crate) fn axis_speeds<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let by_second = context.words.get('S') == Some(1.0);
    let words = context.words.read_as(if by_second { SPEEDS_A_SECOND } else { SPEEDS });
    Ok(Meaning::Action(Action::Function(Function::Limit(LimitCode::AxisSpeeds), words)))
}

/// Prusa's M601: suspends as M600.1 does, ignoring all words.
pub(crate) fn pause_print<'b>(_: &mut Interpreter, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = Words::bare(Code::m(600).sub(1));
    Ok(Meaning::Action(Action::Suspend { heaters_stay: true, words }))
}

/// M290: shifts everything that follows. A move by the same distance comes first, so that the shift is
/// visible at once.
pub(crate) fn babystep<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let moves = words.get('Q') != Some(0.0);
    let mut target = program.position;
    for (place, axis) in Axis::PRIMARY.into_iter().enumerate() {
        let word = words.axis(axis).or(words.get('S').filter(|_| axis == Axis::Z));
        let Some(mm) = word else { continue };
        let now = program.modal.shift.get(place).copied().unwrap_or(0.0);
        let by = if words.get('R') == Some(0.0) { mm - now } else { mm };
        program.modal.add_shift(axis, by);
        target[axis] += by;
    }
    if !moves || target == program.position {
        return NOTHING;
    }
    Ok(Meaning::Action(program.rapid_to(target)))
}

/// Returns the prefix and the text of an M118: the prefix is `// ` with Marlin's A1, which hosts read as an
/// action command, and `echo:` with E1. Words that select a port (P, L, E and A with a number) are not part
/// of the text.
#[must_use]
pub fn said_by_m118(text: &str) -> (&'static str, &str) {
    let (mut text, mut prefix) = (text.trim(), "");
    while let Some((word, rest)) = text.split_once(' ')
        && let [letter @ (b'A' | b'E' | b'P' | b'L'), digits @ ..] = word.as_bytes()
        && !digits.is_empty()
        && digits.iter().all(u8::is_ascii_digit)
    {
        match (letter, digits) {
            (b'A', b"1") => prefix = "// ",
            (b'E', b"1") if prefix.is_empty() => prefix = "echo:",
            _ => {}
        }
        text = rest.trim_start();
    }
    let quoted = text.strip_prefix("S\"").and_then(|text| text.split('"').next());
    (prefix, quoted.unwrap_or(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_a_text_is_to_be_said_is_no_part_of_it() {
        for (line, text) in [
            ("E1 A1 hello you", ("// ", "hello you")),
            ("A1 action:pause", ("// ", "action:pause")),
            ("E1 P0 hello", ("echo:", "hello")),
            ("A0 hello", ("", "hello")),
            ("P0 S\"hello; you\"", ("", "hello; you")),
            ("Ready 10 %", ("", "Ready 10 %")),
            ("E1", ("", "E1")),
            ("", ("", "")),
        ] {
            assert_eq!(said_by_m118(line), text);
        }
    }
}
