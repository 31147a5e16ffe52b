//! What probing a bed starts from.

use config::{Leveling, LevelingConfig};

/// Set by the configuration, M557 and M565.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bed {
    /// Three points to probe, X and Y, mm.
    pub points: [[f64; 2]; 3],
    /// Where the probe is, seen from the tool, mm.
    pub probe_offsets: [f64; 3],
}

impl Bed {
    /// As configured.
    #[must_use]
    pub const fn new(leveling: &LevelingConfig) -> Self {
        let probe_offsets = match leveling.strategy {
            Some(Leveling::CartesianGrid) => leveling.grid.offsets,
            Some(Leveling::DeltaGrid) => leveling.delta.offsets,
            _ => leveling.plane_offsets,
        };
        Self { points: leveling.points, probe_offsets }
    }
}
