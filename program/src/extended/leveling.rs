//! Klipper's commands for leveling a bed and probing it.

use gcode::Extended;

use super::row::{CodeLine, ExtendedFault, ExtendedInfo, Names, codes, number, put, put_number};

pub(super) const COMMANDS: &[ExtendedInfo] = &[
    codes(
        "BED_MESH_CALIBRATE",
        "ADAPTIVE ADAPTIVE_MARGIN MESH_MIN MESH_MAX PROBE_COUNT PROFILE",
        "measure the bed and level by it, as G31; with PROFILE save it, as M374",
        calibrate,
    ),
    codes("BED_MESH_CLEAR", "", "no leveling, as M370", |_, _, line| put(line, "M370")),
    codes("BED_MESH_MAP", "", "show the bed as a map, as M375.2", |_, _, line| put(line, "M375.2")),
    codes("BED_MESH_OFFSET", "X Y ZFADE", "look the mesh up beside the tool, as M420.1", offset),
    codes("BED_MESH_OUTPUT", "", "show the bed as a map, as M375.2", |_, _, line| put(line, "M375.2")),
    codes(
        "BED_MESH_PROFILE",
        "LOAD SAVE REMOVE",
        "meshes on the card by name: M375, M374, M374.1; without words list them, M374.2",
        profile,
    ),
    codes("PROBE_ACCURACY", "SAMPLES PROBE_SPEED", "how well the probe repeats itself, as M48", probe_accuracy),
    codes("SCREWS_TILT_CALCULATE", "", "turns of each bed screw, as G35", |_, _, line| put(line, "G35")),
    codes("QUAD_GANTRY_LEVEL", "RETRIES RETRY_TOLERANCE", "align the Z motors, as G34", align_z),
    codes("Z_TILT_ADJUST", "RETRIES RETRY_TOLERANCE", "align the Z motors, as G34", align_z),
];

fn is_on(command: &Extended<'_>, key: &str) -> bool {
    command.get(key).is_some_and(|value| value != "0")
}

fn calibrate(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    put(line, "G31")?;
    match (pair(command, "MESH_MIN")?, pair(command, "MESH_MAX")?) {
        (Some([left, near]), Some([right, far])) => {
            let words = [(" X", left), (" Y", near), (" A", right - left), (" B", far - near)];
            words.into_iter().try_for_each(|(word, value)| put_number(line, word, value))?;
        }
        (None, None) => {}
        (None, _) => return Err(ExtendedFault::MustSupply("MESH_MIN")),
        (_, None) => return Err(ExtendedFault::MustSupply("MESH_MAX")),
    }
    if let Some([across, along]) = pair(command, "PROBE_COUNT")? {
        put_number(line, " I", across)?;
        put_number(line, " J", along)?;
    }
    if is_on(command, "ADAPTIVE") {
        match number(command, "ADAPTIVE_MARGIN")? {
            Some(margin) => put_number(line, " D", margin)?,
            None => put(line, " D")?,
        }
    }
    command.get("PROFILE").map_or(Ok(()), |name| named(line, " M374", name))
}

fn profile(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let asked = [("LOAD", "M375"), ("SAVE", "M374"), ("REMOVE", "M374.1")];
    let found = asked.into_iter().find_map(|(key, code)| command.get(key).map(|name| (code, name)));
    match found {
        Some((code, name)) => named(line, code, name),
        None => put(line, "M374.2"),
    }
}

fn offset(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    if number(command, "ZFADE")?.is_some_and(|mm| mm != 0.0) {
        return Err(ExtendedFault::Missing("ZFADE=, where fading begins: it is M376"));
    }
    put(line, "M420.1")?;
    number(command, "X")?.map_or(Ok(()), |mm| put_number(line, " X", mm))?;
    number(command, "Y")?.map_or(Ok(()), |mm| put_number(line, " Y", mm))
}

/// Writes a code for the mesh with this name.
fn named(line: &mut CodeLine, code: &str, name: &str) -> Result<(), ExtendedFault> {
    ["", code, " P\"", name, "\""].into_iter().try_for_each(|part| put(line, part))
}

/// Parses two numbers with a comma between, or a single number for both.
fn pair(command: &Extended<'_>, key: &'static str) -> Result<Option<[f64; 2]>, ExtendedFault> {
    let Some(text) = command.get(key) else { return Ok(None) };
    let (one, other) = text.split_once(',').unwrap_or((text, text));
    let read = |text: &str| gcode::read_f64(text.trim()).filter(|number| number.is_finite());
    read(one).zip(read(other)).map(|(one, other)| Some([one, other])).ok_or(ExtendedFault::NotANumber(key))
}

fn align_z(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    put(line, "G34")?;
    number(command, "RETRIES")?.map_or(Ok(()), |value| put_number(line, " I", value))?;
    number(command, "RETRY_TOLERANCE")?.map_or(Ok(()), |value| put_number(line, " T", value))
}

fn probe_accuracy(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    put(line, "M48")?;
    number(command, "SAMPLES")?.map_or(Ok(()), |value| put_number(line, " P", value))?;
    number(command, "PROBE_SPEED")?.map_or(Ok(()), |per_second| put_number(line, " F", 60.0 * per_second))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extended::{Asked, NamedSwitch, translate};
    use gcode::Code;
    use std::string::{String, ToString};

    struct Nothing;

    impl Names for Nothing {
        fn switch(&self, _: &str) -> Option<NamedSwitch> {
            None
        }

        fn heater(&self, _: &str) -> Option<(Code, u8)> {
            None
        }

        fn strip(&self, _: &str) -> Option<u8> {
            None
        }

        fn has_strips(&self) -> bool {
            false
        }

        fn heater_at(&self, _: usize) -> Option<(Code, u8)> {
            None
        }

        fn motor(&self, _: &str) -> Option<char> {
            None
        }
    }

    fn becomes(line: &str) -> String {
        let mut codes = CodeLine::new();
        match translate(&Extended::new(line), &Nothing, &mut codes) {
            Ok(Asked::Codes) => codes.trim().into(),
            other => other.expect_err("codes or a fault").to_string(),
        }
    }

    #[test]
    fn commands_become_codes() {
        for (line, codes) in [
            ("BED_MESH_CALIBRATE", "G31"),
            ("BED_MESH_CALIBRATE ADAPTIVE=1", "G31 D"),
            ("BED_MESH_CALIBRATE ADAPTIVE=0 ADAPTIVE_MARGIN=5", "G31"),
            ("BED_MESH_CALIBRATE ADAPTIVE=1 ADAPTIVE_MARGIN=7.5 PROFILE=part", "G31 D7.5 M374 P\"part\""),
            ("BED_MESH_CALIBRATE MESH_MIN=10,20 MESH_MAX=110,90 PROBE_COUNT=5,4", "G31 X10 Y20 A100 B70 I5 J4"),
            ("BED_MESH_CALIBRATE PROBE_COUNT=5", "G31 I5 J5"),
            ("BED_MESH_PROFILE LOAD=default", "M375 P\"default\""),
            ("BED_MESH_PROFILE SAVE=pei", "M374 P\"pei\""),
            ("BED_MESH_PROFILE REMOVE=pei", "M374.1 P\"pei\""),
            ("BED_MESH_PROFILE", "M374.2"),
            ("BED_MESH_CLEAR", "M370"),
            ("BED_MESH_OUTPUT PGP=1", "M375.2"),
            ("BED_MESH_OFFSET X=20 Y=-3.5", "M420.1 X20 Y-3.5"),
            ("EXCLUDE_OBJECT_DEFINE NAME=a CENTER=1,2 POLYGON=[[1,2],[3,4.5]]", "M486 O1,2,3,4.5 a"),
            ("EXCLUDE_OBJECT_DEFINE NAME=a POLYGON=[[1,2],[3,4", "M486 Da"),
            ("Z_TILT_ADJUST RETRIES=3 RETRY_TOLERANCE=0.01", "G34 I3 T0.01"),
            ("PROBE_ACCURACY SAMPLES=5 PROBE_SPEED=5", "M48 P5 F300"),
        ] {
            assert_eq!(becomes(line), codes, "{line}");
        }
        for (line, why) in [
            ("BED_MESH_CALIBRATE MESH_MIN=10,20", "MESH_MAX"),
            ("BED_MESH_CALIBRATE MESH_MAX=10,20", "MESH_MIN"),
            ("BED_MESH_CALIBRATE PROBE_COUNT=a,5", "PROBE_COUNT"),
            ("BED_MESH_OFFSET ZFADE=1", "M376"),
        ] {
            assert!(becomes(line).contains(why), "{line}: {}", becomes(line));
        }
    }
}
