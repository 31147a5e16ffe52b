//! Phases and travels that are read when a switch closes.

/// Travel of an axis' motors since power up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Way {
    /// Travel in places of the cycle.
    places: f64,
    /// Sum of the motors' step sizes, in places: travels with different sums cannot be compared.
    size: i64,
}

impl Way {
    /// Returns the travel with that of a further motor, whose steps are `size` places.
    pub(super) fn with(self, places: f64, size: i64) -> Self {
        Self { places: self.places + places, size: self.size + size }
    }

    /// Returns the travel and some places more.
    pub(super) fn and(self, places: f64) -> Self {
        Self { places: self.places + places, ..self }
    }

    /// Returns the places since another travel, or `None` if the step size has changed between.
    pub(super) fn since(self, before: Self) -> Option<f64> {
        (self.size == before.size).then_some(self.places - before.places)
    }
}

/// A phase at a switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    /// The phase of the axis: that of its motor, or what those of its motors come to. 0 to below 1024.
    pub phase: f64,
    /// Position of the axis, mm.
    pub hit: f64,
    /// Travel of the motors at the switch.
    pub made: Way,
    /// Travel of the axis for a place of the cycle, mm.
    pub mm: f64,
    /// Whether the drivers report the phase: then it is the same after the next power up.
    pub is_absolute: bool,
}

/// Reason why a phase cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unread {
    /// The driver of this motor does not answer.
    Silent(units::Actuator),
    /// The phases of the axis' motors do not add up to a phase of the axis.
    Uneven,
}
