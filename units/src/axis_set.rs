//! A set of axes.

use core::fmt::{self, Write};

use crate::Axis;

/// Set of some of the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxisSet(u8);

impl AxisSet {
    /// Set without any axis.
    pub const NONE: Self = Self(0);
    /// Set of X, Y and Z.
    pub const PRIMARY: Self = Self(0b111);
    /// Set of X, Y, Z, A, B and C.
    pub const ALL: Self = Self(0b11_1111);

    /// Returns the set of a single axis.
    #[must_use]
    pub const fn of(axis: Axis) -> Self {
        Self(1 << axis as u8)
    }

    /// Collects the axes of an iterator.
    pub fn collect(axes: impl IntoIterator<Item = Axis>) -> Self {
        axes.into_iter().fold(Self::NONE, Self::with)
    }

    /// Returns the union of both sets.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the intersection of both sets.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Returns the axes of this set that are not in the other.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Returns this set with an axis added.
    #[must_use]
    pub const fn with(self, axis: Axis) -> Self {
        self.or(Self::of(axis))
    }

    /// Returns whether an axis is in the set.
    #[must_use]
    pub const fn has(self, axis: Axis) -> bool {
        self.0 & 1 << axis as u8 != 0
    }

    /// Returns whether all axes of another set are in this set.
    #[must_use]
    pub const fn has_all(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Returns whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the set's axes in order.
    pub fn axes(self) -> impl Iterator<Item = Axis> {
        Axis::ALL.into_iter().filter(move |axis| self.has(*axis))
    }
}

/// Writes the axes' letters in order: `XYZ`.
impl fmt::Display for AxisSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.axes().try_for_each(|axis| f.write_char(axis.letter()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_behave_as_sets() {
        let xz = AxisSet::collect([Axis::Z, Axis::X]);
        assert_eq!(std::format!("{xz}"), "XZ");
        assert!(xz.has(Axis::X) && !xz.has(Axis::Y) && AxisSet::PRIMARY.has_all(xz));
        assert_eq!(xz.without(AxisSet::of(Axis::X)), AxisSet::of(Axis::Z));
        assert_eq!(xz.with(Axis::Y), AxisSet::PRIMARY);
        assert!(xz.and(AxisSet::of(Axis::Y)).is_empty() && AxisSet::NONE.is_empty());
        assert_eq!(AxisSet::ALL.axes().count(), 6);
    }
}
