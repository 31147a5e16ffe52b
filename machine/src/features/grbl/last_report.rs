//! Values that a session's reports had last, so that fields that seldom change are reported when they have
//! changed, and seldom else.

/// Memory of a session's reports: the number of reports until a field is due anyway, and its last value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Told {
    pub offsets_in: u8,
    pub overrides_in: u8,
    pub offsets: [f64; 3],
    pub overrides: Overrides,
    /// Last fields of grblHAL; `None`: nothing yet.
    pub extra: Option<Extra>,
    /// Whether the next report has everything.
    pub wants_all: bool,
}

/// Fields that grblHAL reports when they have changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Extra {
    /// Coordinate system in force, counted from 0.
    pub system: usize,
    /// Number of the tool.
    pub tool: u32,
    /// Homed axes as bits, X first.
    pub homed: u8,
}

/// Overrides of feed, rapids and spindle, percent, and what is switched on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Overrides {
    pub percents: [f64; 3],
    /// Accessories as bits: spindle forwards, backwards, flood, mist.
    pub accessories: u8,
}
