//! Klipper's commands of probes, calibration and skew.

use gcode::Extended;

use super::row::{CodeLine, ExtendedFault, ExtendedInfo, Names, codes, number, put, put_number};

pub(super) const COMMANDS: &[ExtendedInfo] = &[
    codes("ABORT", "", "end a paper test, and change nothing, as M851.4", |_, _, line| put(line, "M851.4")),
    codes("ACCEPT", "", "in a paper test, the paper drags, as M851.3", |_, _, line| put(line, "M851.3")),
    codes("ADJUSTED", "", "the screw was turned until the paper drags, as M851.5", |_, _, line| put(line, "M851.5")),
    codes(
        "AXIS_TWIST_COMPENSATION_CALIBRATE",
        "",
        "what the probe reads too high along an axis, as M851.1 P4",
        |_, _, line| put(line, "M851.1 P4"),
    ),
    codes("BED_SCREWS_ADJUST", "", "level the bed by its screws and paper, as M851.1 P3", |_, _, line| {
        put(line, "M851.1 P3")
    }),
    codes("CALC_MEASURED_SKEW", "AC BD AD", "the skew of a measured square, as M852.1", |command, _, line| {
        put(line, "M852.1")?;
        [("AC", " A"), ("BD", " B"), ("AD", " D")].into_iter().try_for_each(|(key, letter)| {
            put_number(line, letter, number(command, key)?.ok_or(ExtendedFault::MustSupply(key))?)
        })
    }),
    codes(
        "DELTA_ANALYZE",
        "CENTER_DISTS CENTER_PILLAR_WIDTHS OUTER_DISTS OUTER_PILLAR_WIDTHS SCALE CALIBRATE",
        "calibrate a delta by Klipper's part, as M665.4 and M665.2",
        delta_analyze,
    ),
    codes("DELTA_CALIBRATE", "", "calibrate trims, radius and angles of a delta, as G32 S6", |_, _, line| {
        put(line, "G32 S6")
    }),
    codes(
        "ENDSTOP_PHASE_CALIBRATE",
        "AXIS STEPPER",
        "calibrate the phase of a motor at its switch, as M875.1; without words say it, M875",
        endstop_phase,
    ),
    codes("GET_CURRENT_SKEW", "", "say the skew factors, as M852", |_, _, line| put(line, "M852")),
    codes("MANUAL_PROBE", "", "the height at which paper drags, as M851.1 P2", |_, _, line| put(line, "M851.1 P2")),
    codes("PROBE_CALIBRATE", "", "how high the tool is as the probe touches, as M851.1 P0", |_, _, line| {
        put(line, "M851.1 P0")
    }),
    codes("SET_SKEW", "XY XZ YZ CLEAR", "skew by measured squares, AC,BD,AD each, as M852", set_skew),
    codes("SKEW_PROFILE", "LOAD SAVE REMOVE", "skew factors on the card by name: M852.3, M852.2, M852.4", skew_profile),
    codes(
        "SET_Z_THERMAL_ADJUST",
        "ENABLE TEMP_COEFF REF_TEMP",
        "Z by the frame's temperature, as M290.1",
        |command, _, line| {
            put(line, "M290.1")?;
            [("ENABLE", " S"), ("TEMP_COEFF", " K"), ("REF_TEMP", " R")].into_iter().try_for_each(|(key, letter)| {
                number(command, key)?.map_or(Ok(()), |value| put_number(line, letter, value))
            })
        },
    ),
    codes("TESTZ", "Z", "move the tool in a paper test, as M851.2", test_z),
    codes("Z_ENDSTOP_CALIBRATE", "", "where Z homes, by paper, as M851.1 P1", |_, _, line| put(line, "M851.1 P1")),
];

/// Selects an axis by its letter or by Klipper's name of its stepper; the towers of a delta are a, b, c.
fn endstop_phase(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    const STEPPERS: [(&str, &str); 6] = [
        ("stepper_x", "X"),
        ("stepper_y", "Y"),
        ("stepper_z", "Z"),
        ("stepper_a", "X"),
        ("stepper_b", "Y"),
        ("stepper_c", "Z"),
    ];
    const AXES: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];
    let Some(name) = command.get("AXIS").or_else(|| command.get("STEPPER")).map(str::trim) else {
        return put(line, "M875");
    };
    let stepper = STEPPERS.into_iter().find(|(stepper, _)| stepper.eq_ignore_ascii_case(name)).map(|(_, axis)| axis);
    let axis = stepper.or_else(|| AXES.into_iter().find(|axis| axis.eq_ignore_ascii_case(name)));
    let axis = axis.ok_or(ExtendedFault::Missing("AXIS is the letter of an axis, X Y Z A B or C"))?;
    put(line, "M875.1 ")?;
    put(line, axis)
}

fn skew_profile(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let asked = [("LOAD", "M852.3"), ("SAVE", "M852.2"), ("REMOVE", "M852.4")];
    let found = asked.into_iter().find_map(|(key, code)| command.get(key).map(|name| (code, name)));
    let (code, name) = found.ok_or(ExtendedFault::MustSupply("LOAD"))?;
    [code, " P\"", name.trim(), "\""].into_iter().try_for_each(|part| put(line, part))
}

/// Accepts the lists one by one, as Klipper does; CALIBRATE uses the lists received so far.
fn delta_analyze(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let lists = [
        ("CENTER_DISTS", " M665.4 P0", 6),
        ("OUTER_DISTS", " M665.4 P1", 6),
        ("CENTER_PILLAR_WIDTHS", " M665.4 P2", 3),
        ("OUTER_PILLAR_WIDTHS", " M665.4 P3", 6),
    ];
    for (key, code, count) in lists {
        let Some(text) = command.get(key) else { continue };
        if text.split(',').count() != count {
            return Err(ExtendedFault::List(key, count));
        }
        put(line, code)?;
        for (part, letter) in text.split(',').zip([" A", " B", " C", " D", " E", " F"]) {
            let mm = gcode::read_f64(part.trim()).filter(|mm| mm.is_finite());
            put_number(line, letter, mm.ok_or(ExtendedFault::NotANumber(key))?)?;
        }
    }
    number(command, "SCALE")?.map_or(Ok(()), |scale| put_number(line, " M665.4 S", scale))?;
    match command.get("CALIBRATE").map(str::trim) {
        Some("extended") => put(line, " M665.4 M665.2"),
        Some(_) => Err(ExtendedFault::Missing("CALIBRATE is extended, or left out; heights alone are DELTA_CALIBRATE")),
        None if line.is_empty() => Err(ExtendedFault::MustSupply("CENTER_DISTS")),
        None => Ok(()),
    }
}

fn test_z(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let share = match command.get("Z").ok_or(ExtendedFault::MustSupply("Z"))?.trim() {
        "+" => " S1",
        "++" => " S2",
        "-" => " S-1",
        "--" => " S-2",
        _ => {
            let by = number(command, "Z")?.ok_or(ExtendedFault::MustSupply("Z"))?;
            put(line, "M851.2")?;
            return put_number(line, " Z", by);
        }
    };
    put(line, "M851.2")?;
    put(line, share)
}

fn set_skew(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    if command.get("CLEAR").is_some_and(|value| value.trim() != "0") {
        return put(line, "M852 I0 J0 K0");
    }
    let mut any = false;
    for (key, code) in [("XY", "M852 P0"), ("XZ", "M852 P1"), ("YZ", "M852 P2")] {
        let Some(text) = command.get(key) else { continue };
        let mut lengths = text.split(',').map(|length| gcode::read_f64(length.trim()));
        let (Some(Some(ac)), Some(Some(bd)), Some(Some(ad)), None) =
            (lengths.next(), lengths.next(), lengths.next(), lengths.next())
        else {
            return Err(ExtendedFault::ThreeLengths(key));
        };
        put(line, if any { " " } else { "" })?;
        put(line, code)?;
        [(" A", ac), (" B", bd), (" D", ad)].into_iter().try_for_each(|(letter, mm)| put_number(line, letter, mm))?;
        any = true;
    }
    if any { Ok(()) } else { Err(ExtendedFault::MustSupply("XY")) }
}
