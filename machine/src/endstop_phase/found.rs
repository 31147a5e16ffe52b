//! What is found at a switch.

/// How far motors had come since power up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Way {
    /// In places of the cycle.
    places: f64,
    /// How many places their steps are, together: where that has changed, ways cannot be compared.
    size: i64,
}

impl Way {
    /// The same way with that of one more motor, whose steps are so many places.
    pub(super) fn with(self, places: f64, size: i64) -> Self {
        Self { places: self.places + places, size: self.size + size }
    }

    /// The same way and some places more.
    pub(super) fn and(self, places: f64) -> Self {
        Self { places: self.places + places, ..self }
    }

    /// How many places it is since the other one.
    pub(super) fn since(self, before: Self) -> Option<f64> {
        (self.size == before.size).then_some(self.places - before.places)
    }
}

/// A phase at a switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    /// The phase of the axis: that of its motor, or what those of its motors come to. 0 to below 1024.
    pub phase: f64,
    /// Where the axis was, mm.
    pub hit: f64,
    /// The way that the motors had made.
    pub made: Way,
    /// How far the axis goes for one place of the cycle, mm.
    pub mm: f64,
    /// The drivers say it: it is the same after the next power up.
    pub is_absolute: bool,
}

/// Why there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unread {
    /// This motor's driver does not answer.
    Silent(units::Actuator),
    /// The motors of the axis do not add up to a phase of it.
    Uneven,
}
