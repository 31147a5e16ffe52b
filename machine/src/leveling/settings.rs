//! M557 and M565: what probing a bed starts from; and what M500 saves of leveling.

use core::fmt::{self, Write};

use config::{Leveling, MachineConfig};
use motion::compensation::Bed as Shape;
use program::Words;

use super::skew::configured;
use crate::bed::Bed;
use crate::failure::{Answer, Failure, Outcome};
use crate::ports::MotionPort;
use crate::sessions::Reply;

/// M557: P0 to P2 with X and Y is a point to probe; without words shows all.
///
/// # Errors
/// When there is no such point.
pub(crate) fn probe_point(bed: &mut Bed, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
    if let Some(number) = words.get('P') {
        let index = [0.0, 1.0, 2.0].iter().position(|known| *known == number);
        let point = index.and_then(|index| bed.points.get_mut(index));
        let [x, y] = point.ok_or_else(|| Failure::refused("M557: P is 0, 1 or 2"))?;
        *x = words.get('X').unwrap_or(*x);
        *y = words.get('Y').unwrap_or(*y);
    }
    for (index, [x, y]) in bed.points.into_iter().enumerate() {
        reply.say(format_args!("P{index} X:{x:.4} Y:{y:.4}\n"));
    }
    Ok(Answer::Ok)
}

/// M565: where the probe is, seen from the tool.
pub(crate) fn probe_offset(bed: &mut Bed, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
    for (letter, offset) in ['X', 'Y', 'Z'].into_iter().zip(&mut bed.probe_offsets) {
        *offset = words.get(letter).unwrap_or(*offset);
    }
    let [x, y, z] = bed.probe_offsets;
    reply.say(format_args!("Probe offsets: X:{x:.4} Y:{y:.4} Z:{z:.4}\n"));
    Ok(Answer::Ok)
}

/// The lines M500 saves of this.
///
/// # Errors
/// When they do not fit.
pub(crate) fn write_leveling(
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
    let Some(strategy) = leveling.strategy else { return Ok(()) };
    if strategy == Leveling::ThreePoint {
        writeln!(text, ";Probe points:")?;
        for (index, [x, y]) in bed.points.into_iter().enumerate() {
            writeln!(text, "M557 P{index} X{x:.5} Y{y:.5}")?;
        }
    }
    let [x, y, z] = bed.probe_offsets;
    writeln!(text, ";Probe offsets:\nM565 X{x:.5} Y{y:.5} Z{z:.5}")?;
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
        Shape::Grid if saves_grid => writeln!(text, ";Load the saved grid:\nM375"),
        _ => Ok(()),
    }
}
