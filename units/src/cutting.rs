//! Fineness with which moves are cut, as the configuration has it and motion takes it.

/// Conditions and fineness of the cutting of straight moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineSettings {
    /// Greatest length of a piece, mm (`mm_per_line_segment`). `None`: not cut by length.
    pub segment_length: Option<f64>,
    /// Pieces per second of motion (`delta_segments_per_second`); takes precedence over the length. `None`:
    /// not by time.
    pub segments_per_second: Option<f64>,
}

impl LineSettings {
    /// Whether they cut anything.
    #[must_use]
    pub const fn cut(&self) -> bool {
        self.segment_length.is_some() || self.segments_per_second.is_some()
    }
}

/// Fineness of the chords of arcs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ArcSettings {
    /// Least chord length, mm (`mm_per_arc_segment`); zero: not given.
    pub segment_length: f64,
    /// Greatest distance between chord and arc, mm (`mm_max_arc_error`); zero: not given.
    pub max_error: f64,
}

impl ArcSettings {
    /// Whether arcs are cut at all.
    #[must_use]
    pub fn cut(&self) -> bool {
        self.segment_length > 0.0 || self.max_error > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_moves_are_cut_by_length_or_by_time() {
        assert!(!LineSettings::default().cut());
        assert!(LineSettings { segment_length: Some(1.0), segments_per_second: None }.cut());
        assert!(LineSettings { segment_length: None, segments_per_second: Some(100.0) }.cut());
    }

    #[test]
    fn arcs_are_cut_by_length_or_by_error() {
        assert!(!ArcSettings::default().cut());
        assert!(ArcSettings { segment_length: 0.5, max_error: 0.0 }.cut());
        assert!(ArcSettings { segment_length: 0.0, max_error: 0.01 }.cut());
    }
}
