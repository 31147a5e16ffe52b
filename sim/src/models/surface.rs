//! The surface that a probe can touch: a bed that is neither level nor even, and solid blocks on it.

/// Height of a bed over its coordinates: a plane that is bent and twisted, with waves and a step on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bed {
    /// Height at X0 Y0, millimetres.
    pub height_mm: f64,
    /// Rise per millimetre along X and Y.
    pub slope: [f64; 2],
    /// Height of the waves over the plane, millimetres; zero for a flat bed.
    pub wave_mm: f64,
    /// Length of the waves along X and Y, millimetres.
    pub wave_length_mm: f64,
    /// Place at which bend and twist add nothing.
    pub middle: [f64; 2],
    /// Fall by bending 100 mm from the middle along X and along Y, growing with the square, millimetres.
    pub bend_mm: [f64; 2],
    /// Rise by twist 100 mm from the middle along both, growing with the product, millimetres.
    pub twist_mm: f64,
    /// Beginning of the step along X, and its height from there on, millimetres.
    pub step_mm: [f64; 2],
}

impl Bed {
    /// Makes a level bed at this height.
    #[must_use]
    pub const fn level(height_mm: f64) -> Self {
        Self {
            height_mm,
            slope: [0.0; 2],
            wave_mm: 0.0,
            wave_length_mm: 1.0,
            middle: [0.0; 2],
            bend_mm: [0.0; 2],
            twist_mm: 0.0,
            step_mm: [f64::INFINITY, 0.0],
        }
    }

    /// Makes a bed that leans.
    #[must_use]
    pub const fn tilted(height_mm: f64, slope: [f64; 2]) -> Self {
        Self { slope, ..Self::level(height_mm) }
    }

    /// Returns the same bed with waves.
    #[must_use]
    pub const fn wavy(self, wave_mm: f64, wave_length_mm: f64) -> Self {
        Self { wave_mm, wave_length_mm, ..self }
    }

    /// Returns the same bed, bent and twisted around a middle.
    #[must_use]
    pub const fn bent(self, middle: [f64; 2], bend_mm: [f64; 2], twist_mm: f64) -> Self {
        Self { middle, bend_mm, twist_mm, ..self }
    }

    /// Returns the same bed with a step.
    #[must_use]
    pub const fn stepped(self, from_x: f64, by_mm: f64) -> Self {
        Self { step_mm: [from_x, by_mm], ..self }
    }

    /// Returns the height of the bed at a place, millimetres.
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let (u, v) = ((x - self.middle[0]) / 100.0, (y - self.middle[1]) / 100.0);
        let bent = self.twist_mm * u * v - self.bend_mm[0] * u * u - self.bend_mm[1] * v * v;
        let step = if x >= self.step_mm[0] { self.step_mm[1] } else { 0.0 };
        let plane = self.height_mm + self.slope[0] * x + self.slope[1] * y + bent + step;
        if self.wave_mm == 0.0 {
            return plane;
        }
        let turn = std::f64::consts::TAU / self.wave_length_mm;
        plane + self.wave_mm * (turn * x).sin() * (turn * y).cos()
    }
}

/// A solid block: a touch plate, a work piece. From and to along X, Y and Z, millimetres.
pub type Block = [[f64; 2]; 3];

/// Everything the probe can touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Bed; none if the probe looks for blocks alone.
    pub bed: Option<Bed>,
    /// Whether the bed is above, for a probe that searches upwards.
    pub overhead: bool,
    /// Solid blocks on the bed.
    pub blocks: Vec<Block>,
    /// Position of the probe's tip relative to the tool, millimetres.
    pub tip_mm: [f64; 3],
    /// Standard deviation of the height at which the contact closes, from touch to touch, millimetres.
    pub noise_mm: f64,
}

/// Height at which the contact of a probe closes, which differs from touch to touch: normally distributed,
/// the same in every run.
#[derive(Clone, Copy, Debug)]
pub struct TouchNoise {
    state: u64,
    now_mm: f64,
}

impl Default for TouchNoise {
    fn default() -> Self {
        Self { state: 0x9E37_79B9_7F4A_7C15, now_mm: 0.0 }
    }
}

impl TouchNoise {
    /// Returns the excess height of the touch to come, millimetres.
    #[must_use]
    pub const fn now_mm(&self) -> f64 {
        self.now_mm
    }

    /// Draws another height for the next touch, after the contact has opened.
    pub fn next(&mut self, deviation_mm: f64) {
        // Twelve even numbers from 0 to 1 have a sum whose deviation is 1; xorshift makes them (Marsaglia
        // 2003).
        let mut even = || {
            self.state ^= self.state << 13;
            self.state ^= self.state >> 7;
            self.state ^= self.state << 17;
            (self.state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let normal: f64 = (0..12).map(|_| even()).sum::<f64>() - 6.0;
        self.now_mm = normal * deviation_mm;
    }
}

impl Default for Surface {
    /// Returns a level bed at zero under a probe whose tip is the tool's.
    fn default() -> Self {
        Self { bed: Some(Bed::level(0.0)), overhead: false, blocks: Vec::new(), tip_mm: [0.0; 3], noise_mm: 0.0 }
    }
}

impl Surface {
    /// Returns the distance of the tip from the nearest touchable thing, with the tool here, millimetres:
    /// zero or less when it touches. Away from bed and blocks the value is only known to be above zero.
    #[must_use]
    pub fn gap(&self, tool_mm: [f64; 3]) -> f64 {
        let tip: [f64; 3] = std::array::from_fn(|axis| tool_mm[axis] + self.tip_mm[axis]);
        let over_bed = self.bed.map_or(f64::INFINITY, |bed| {
            let above = tip[2] - bed.height(tip[0], tip[1]);
            if self.overhead { -above } else { above }
        });
        let outside = |block: &Block| {
            (0..3).map(|axis| (block[axis][0] - tip[axis]).max(tip[axis] - block[axis][1])).fold(f64::MIN, f64::max)
        };
        self.blocks.iter().map(outside).fold(over_bed, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tip_touches_the_bed_under_it_and_not_under_the_tool() {
        let bed = Bed::tilted(1.0, [0.01, -0.02]);
        let surface = Surface { bed: Some(bed), tip_mm: [30.0, -10.0, -2.0], ..Surface::default() };
        // The surface under the tip at 130, 40 has the height 1 + 1.3 - 0.8.
        for (z, touches) in [(3.51, false), (3.499, true), (0.0, true)] {
            assert_eq!(surface.gap([100.0, 50.0, z]) <= 0.0, touches, "{z}");
        }
    }

    #[test]
    fn touches_scatter_by_their_deviation() {
        let mut noise = TouchNoise::default();
        let seen: Vec<f64> = (0..2_000)
            .map(|_| {
                noise.next(0.02);
                noise.now_mm()
            })
            .collect();
        let mean = seen.iter().sum::<f64>() / 2_000.0;
        let deviation = (seen.iter().map(|mm| (mm - mean).powi(2)).sum::<f64>() / 2_000.0).sqrt();
        assert!(mean.abs() < 0.002 && (deviation - 0.02).abs() < 0.002, "{mean} {deviation}");
    }

    #[test]
    fn waves_come_and_go_with_their_length() {
        let bed = Bed::level(0.5).wavy(0.2, 80.0);
        assert!((bed.height(20.0, 0.0) - 0.7).abs() < 1e-12);
        assert!((bed.height(60.0, 80.0) - 0.3).abs() < 1e-12);
        assert!((bed.height(40.0, 13.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn beds_are_bent_twisted_and_stepped() {
        let bed = Bed::level(1.0).bent([50.0, 60.0], [0.2, 0.1], 0.4).stepped(140.0, 0.5);
        for ([x, y], height) in [
            ([50.0, 60.0], 1.0),
            ([-50.0, 60.0], 0.8),
            ([50.0, 160.0], 0.9),
            ([150.0, 160.0], 1.6),
            ([139.9, 60.0], 0.838_359_8),
        ] {
            assert!((bed.height(x, y) - height).abs() < 1e-6, "{}", bed.height(x, y));
        }
    }

    #[test]
    fn a_block_is_touched_from_every_side() {
        let surface = Surface { bed: None, blocks: vec![[[10.0, 20.0], [0.0, 5.0], [0.0, 8.0]]], ..Surface::default() };
        for (point, touches) in [
            ([9.99, 2.0, 4.0], false),
            ([10.0, 2.0, 4.0], true),
            ([15.0, 5.01, 4.0], false),
            ([15.0, 5.0, 4.0], true),
            ([15.0, 2.0, 8.0], true),
            ([15.0, 2.0, 8.01], false),
            ([25.0, 2.0, -100.0], false),
        ] {
            assert_eq!(surface.gap(point) <= 0.0, touches, "{point:?}");
        }
    }

    #[test]
    fn a_probe_that_searches_upwards_touches_what_is_above_it() {
        let surface = Surface { bed: Some(Bed::level(50.0)), overhead: true, ..Surface::default() };
        assert!(surface.gap([0.0, 0.0, 49.9]) > 0.0 && surface.gap([0.0, 0.0, 50.0]) <= 0.0);
    }
}
