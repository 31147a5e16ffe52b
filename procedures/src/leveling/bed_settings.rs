//! M557 and M565: points and offset of probing a bed; and the lines of leveling that M500 saves.

use core::fmt::{self, Write};

use base::bed::{Bed, MOST_TWIST_POINTS, Twist};
use base::failure::{Answer, Failure, Outcome};
use base::ports::MotionPort;
use base::sessions::Reply;
use config::{Leveling, MachineConfig};
use motion::compensation::Bed as Shape;
use program::Words;

use super::words::configured;

/// M557: sets a point to probe, P0 to P2 with X and Y; without words shows all.
///
/// # Errors
/// When there is no such point.
pub fn probe_point(bed: &mut Bed, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
    if let Some(number) = words.get('P') {
        let index = [0.0, 1.0, 2.0].iter().position(|known| *known == number);
        let point = index.and_then(|index| bed.points.get_mut(index));
        let [x, y] = point.ok_or_else(|| Failure::refused(&"M557: P is 0, 1 or 2"))?;
        *x = words.get('X').unwrap_or(*x);
        *y = words.get('Y').unwrap_or(*y);
    }
    for (index, [x, y]) in bed.points.into_iter().enumerate() {
        reply.say(format_args!("P{index} X:{x:.4} Y:{y:.4}\n"));
    }
    Ok(Answer::Ok)
}

/// M565: sets the position of the probe relative to the tool.
pub fn probe_offset(bed: &mut Bed, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
    for (letter, offset) in ['X', 'Y', 'Z'].into_iter().zip(&mut bed.probe_offsets) {
        *offset = words.get(letter).unwrap_or(*offset);
    }
    let [x, y, z] = bed.probe_offsets;
    reply.say(format_args!("Probe offsets: X:{x:.4} Y:{y:.4} Z:{z:.4}\n"));
    Ok(Answer::Ok)
}

/// M851: sets the position of the probe in Marlin's terms, whose Z is the height at which the contact closes,
/// relative to the tip of the tool.
pub fn marlin_probe_offset(bed: &mut Bed, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
    let [x, y, z] = &mut bed.probe_offsets;
    *x = words.as_length('X').unwrap_or(*x);
    *y = words.as_length('Y').unwrap_or(*y);
    *z = words.as_length('Z').map_or(*z, |below| -below);
    // A zero is reported without a sign.
    let [x, y, z] = [*x, *y, 0.0 - *z];
    reply.say(format_args!("M851 X{x:.4} Y{y:.4} Z{z:.4}\n"));
    Ok(Answer::Ok)
}

/// Writes the lines of leveling that M500 saves.
///
/// # Errors
/// When the lines do not fit.
pub fn write_leveling(
    text: &mut impl Write,
    motion: &mut impl MotionPort,
    config: &MachineConfig,
    bed: &Bed,
) -> fmt::Result {
    let (skew, shape) = motion.motion(|motion| (motion.compensation().skew(), motion.compensation().bed()));
    let leveling = &config.leveling;
    if skew != configured(leveling) {
        writeln!(text, ";Skew factors XY XZ YZ:\nM852 I{:.8} J{:.8} K{:.8}", skew.xy, skew.xz, skew.yz)?;
    }
    if bed.twist != Twist::new(config) {
        write_twist(text, bed)?;
    }
    let Some(strategy) = leveling.strategy else {
        let changed = bed.probe_offsets != config.probe_offsets();
        return if config.probe.enable && changed { write_offsets(text, bed) } else { Ok(()) };
    };
    if strategy == Leveling::ThreePoint {
        writeln!(text, ";Probe points:")?;
        for (index, [x, y]) in bed.points.into_iter().enumerate() {
            writeln!(text, "M557 P{index} X{x:.5} Y{y:.5}")?;
        }
    }
    write_offsets(text, bed)?;
    if let Some(height) = bed.fade_height {
        writeln!(text, ";The mesh has faded at this height:\nM376 H{height:.5}")?;
    }
    if let Some(target) = bed.fade_target {
        writeln!(text, ";What is left of the mesh there:\nM376 T{target:.5}")?;
    }
    let saves_grid = match strategy {
        Leveling::CartesianGrid => leveling.grid.save,
        Leveling::DeltaGrid => leveling.delta.save,
        Leveling::ThreePoint => false,
    };
    match shape {
        Shape::Plane(plane) if leveling.save_plane => {
            writeln!(text, ";Plane A X + B Y + C Z + D = 0:")?;
            writeln!(text, "M561 A{:.9} B{:.9} C1 D{:.9}", -plane.x, -plane.y, -plane.z)
        }
        Shape::Grid if saves_grid && bed.mesh_name.is_empty() => writeln!(text, ";Load the saved grid:\nM375"),
        Shape::Grid if saves_grid => writeln!(text, ";Load the saved mesh:\nM375 P\"{}\"", bed.mesh_name.as_str()),
        _ => Ok(()),
    }
}

/// M851.6: sets a place along an axis and the excess of the probe's reading there; R forgets all of them,
/// without words they are reported.
pub fn axis_twist(bed: &mut Bed, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
    if words.has('R') {
        bed.twist = Twist::along(bed.twist.along_y);
    }
    let place = words.as_length('X').or(words.as_length('Y'));
    if let Some(place) = place {
        let high =
            words.as_length('Z').ok_or_else(|| Failure::refused(&"M851.6 needs Z, what the probe reads too high"))?;
        let points = bed.twist.points();
        if points.last().is_some_and(|[last, _]| *last >= place) || points.len() == MOST_TWIST_POINTS {
            return Err(Failure::refused(&"M851.6: places rise, eight at most; M851.6 R forgets them"));
        }
        if bed.twist.points().is_empty() {
            bed.twist.along_y = words.has('Y');
        }
        bed.twist.push([place, high]);
    }
    let letter = if bed.twist.along_y { 'Y' } else { 'X' };
    for [place, high] in bed.twist.points() {
        reply.say(format_args!("{letter}{place:.2}: the probe reads {high:+.4} mm\n"));
    }
    Ok(Answer::Ok)
}

fn write_twist(text: &mut impl Write, bed: &Bed) -> fmt::Result {
    writeln!(text, ";Axis twist:\nM851.6 R")?;
    let letter = if bed.twist.along_y { 'Y' } else { 'X' };
    bed.twist.points().iter().try_for_each(|[place, high]| writeln!(text, "M851.6 {letter}{place:.4} Z{high:.5}"))
}

fn write_offsets(text: &mut impl Write, bed: &Bed) -> fmt::Result {
    let [x, y, z] = bed.probe_offsets;
    writeln!(text, ";Probe offsets:\nM565 X{x:.5} Y{y:.5} Z{z:.5}")
}
