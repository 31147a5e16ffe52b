//! What a probe can touch: a bed that is neither level nor even, and solid blocks on it.

/// Height of a bed over its coordinates: a plane with waves on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bed {
    /// Height at X0 Y0, millimetres.
    pub height_mm: f64,
    /// Rise per millimetre along X and Y.
    pub slope: [f64; 2],
    /// Height of the waves over the plane, millimetres; zero for a flat bed.
    pub wave_mm: f64,
    /// Their length along X and Y, millimetres.
    pub wave_length_mm: f64,
}

impl Bed {
    /// A level bed at this height.
    #[must_use]
    pub const fn level(height_mm: f64) -> Self {
        Self { height_mm, slope: [0.0; 2], wave_mm: 0.0, wave_length_mm: 1.0 }
    }

    /// A bed that leans.
    #[must_use]
    pub const fn tilted(height_mm: f64, slope: [f64; 2]) -> Self {
        Self { slope, ..Self::level(height_mm) }
    }

    /// The same with waves.
    #[must_use]
    pub const fn wavy(self, wave_mm: f64, wave_length_mm: f64) -> Self {
        Self { wave_mm, wave_length_mm, ..self }
    }

    /// Its height here, millimetres.
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let plane = self.height_mm + self.slope[0] * x + self.slope[1] * y;
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
    /// The bed; none where the probe looks for blocks alone.
    pub bed: Option<Bed>,
    /// The bed is above, for a probe that searches upwards.
    pub overhead: bool,
    /// Blocks.
    pub blocks: Vec<Block>,
    /// Where the probe's tip is, seen from the tool, millimetres.
    pub tip_mm: [f64; 3],
}

impl Default for Surface {
    /// A level bed at zero under a probe whose tip is the tool's.
    fn default() -> Self {
        Self { bed: Some(Bed::level(0.0)), overhead: false, blocks: Vec::new(), tip_mm: [0.0; 3] }
    }
}

impl Surface {
    /// How far the tip is from the nearest thing it can touch, with the tool here, millimetres: zero or less
    /// when it touches. Away from bed and blocks this is not the distance along any way, only above zero.
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
        // Under the tip at 130, 40: 1 + 1.3 - 0.8.
        for (z, touches) in [(3.51, false), (3.499, true), (0.0, true)] {
            assert_eq!(surface.gap([100.0, 50.0, z]) <= 0.0, touches, "{z}");
        }
    }

    #[test]
    fn waves_come_and_go_with_their_length() {
        let bed = Bed::level(0.5).wavy(0.2, 80.0);
        assert!((bed.height(20.0, 0.0) - 0.7).abs() < 1e-12);
        assert!((bed.height(60.0, 80.0) - 0.3).abs() < 1e-12);
        assert!((bed.height(40.0, 13.0) - 0.5).abs() < 1e-12);
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
