//! What a session was told of what seldom changes, so that it is told again when it has, and seldom else.

/// Of a session: how many reports are left until something is told anyway, and what was told last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Told {
    pub offsets_in: u8,
    pub overrides_in: u8,
    pub offsets: [f64; 3],
    pub overrides: Overrides,
    /// What grblHAL tells; `None`: nothing yet.
    pub extra: Option<Extra>,
    /// The next report has everything.
    pub wants_all: bool,
}

/// What grblHAL tells when it has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Extra {
    /// The coordinate system in force, counted from 0.
    pub system: usize,
    /// The tool.
    pub tool: u32,
    /// Bits: axes that are homed, X first.
    pub homed: u8,
}

/// Percents of feed, rapids and spindle; what is on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Overrides {
    pub percents: [f64; 3],
    /// Bits: spindle forwards, backwards, flood, mist.
    pub accessories: u8,
}
