//! Arcs of a G-code program as chords.

use gcode::Block;

/// Chords are no further than this from the arc, mm.
const CHORD_ERROR_MM: f64 = 0.001;

/// Corners of an arc between its ends. RS-274: G2 clockwise seen from the positive third axis.
pub fn between(
    block: &Block<'_>,
    scale: f64,
    plane: [usize; 3],
    from: [f64; 3],
    to: [f64; 3],
    clockwise: bool,
) -> Vec<[f64; 3]> {
    let [a, b, along] = plane;
    let offsets = ['I', 'J', 'K'].map(|letter| block.get(letter).map(|word| word * scale));
    let center = match block.get('R') {
        Some(radius) => radius_center([from[a], from[b]], [to[a], to[b]], radius * scale, clockwise),
        None => Some([from[a] + offsets[a].unwrap_or(0.0), from[b] + offsets[b].unwrap_or(0.0)]),
    };
    let Some([ca, cb]) = center else { return Vec::new() };
    let radius = (from[a] - ca).hypot(from[b] - cb);
    let start = (from[b] - cb).atan2(from[a] - ca);
    let mut sweep = (to[b] - cb).atan2(to[a] - ca) - start;
    let turn = std::f64::consts::TAU;
    if clockwise && sweep >= -1e-9 {
        sweep -= turn;
    } else if !clockwise && sweep <= 1e-9 {
        sweep += turn;
    }
    let step = 2.0 * (1.0 - CHORD_ERROR_MM / radius.max(2.0 * CHORD_ERROR_MM)).acos();
    let pieces = (sweep.abs() / step).ceil().clamp(1.0, 10_000.0) as usize;
    let place = |piece: usize| {
        let share = piece as f64 / pieces as f64;
        let angle = start + share * sweep;
        let mut at = from;
        at[a] = ca + radius * angle.cos();
        at[b] = cb + radius * angle.sin();
        at[along] = from[along] + share * (to[along] - from[along]);
        at
    };
    (1..pieces).map(place).collect()
}

/// Center of the arc of this radius; a negative one means the long way round.
fn radius_center(from: [f64; 2], to: [f64; 2], radius: f64, clockwise: bool) -> Option<[f64; 2]> {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let chord = dx.hypot(dy);
    let height = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
    if chord == 0.0 {
        return None;
    }
    let side = if clockwise == (radius > 0.0) { -1.0 } else { 1.0 };
    Some([(from[0] + to[0]) / 2.0 - side * height * dy / chord, (from[1] + to[1]) / 2.0 + side * height * dx / chord])
}

#[cfg(test)]
mod tests {
    use super::super::program::Program;
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &str) -> Program {
        Program::parse(text.as_bytes(), [Some(0.0); 3])
    }

    proptest! {
        #[test]
        fn every_corner_of_an_arc_is_on_it(radius in 1.0_f64..50.0, angle in 0.1_f64..6.0, clockwise: bool) {
            let turn = if clockwise { -angle } else { angle };
            let (x, y) = (radius * turn.cos(), radius * turn.sin());
            let code = if clockwise { 2 } else { 3 };
            let program = parse(&format!("G1 X{radius}\nG{code} X{x:.9} Y{y:.9} I{:.9} J0\n", -radius));
            let mut length = 0.0;
            for pair in program.path()[1..].windows(2) {
                length += (pair[1].at[0] - pair[0].at[0]).hypot(pair[1].at[1] - pair[0].at[1]);
                prop_assert!((pair[1].at[0].hypot(pair[1].at[1]) - radius).abs() < 1e-6);
            }
            prop_assert!((length / (radius * angle) - 1.0).abs() < 2e-3, "{} of {}", length, radius * angle);
        }

        #[test]
        fn a_radius_word_and_a_center_word_make_the_same_arc(radius in 1.0_f64..50.0, angle in 0.2_f64..6.0, clockwise: bool) {
            prop_assume!((angle - std::f64::consts::PI).abs() > 0.1);
            let turn = if clockwise { -angle } else { angle };
            let (x, y) = (radius * turn.cos(), radius * turn.sin());
            let signed = if angle > std::f64::consts::PI { -radius } else { radius };
            let center = radius_center([radius, 0.0], [x, y], signed, clockwise).unwrap();
            prop_assert!(center[0].abs() < 1e-6 && center[1].abs() < 1e-6, "{:?}", center);
        }
    }
}
