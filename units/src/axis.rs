//! Axes are the coordinates that a program commands (X Y Z and the auxiliary A B C); actuators are the motors
//! (alpha to zeta).

use core::ops::{Index, IndexMut};

/// Number of axes that a program can name: X Y Z A B C.
pub const MAX_AXES: usize = 6;
/// Number of motors that the board can drive: four on-board drivers and two external ones.
pub const MAX_ACTUATORS: usize = 6;

/// A coordinate of the machine. X Y Z are Cartesian millimetres; A B C are auxiliary (filament, rotary).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "the letters are the meaning")]
pub enum Axis {
    #[default]
    X,
    Y,
    Z,
    A,
    B,
    C,
}

impl Axis {
    /// All axes in order.
    pub const ALL: [Self; MAX_AXES] = [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C];
    /// The axes whose common length is the path length.
    pub const PRIMARY: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Returns the letter that a program uses.
    #[must_use]
    pub const fn letter(self) -> char {
        match self {
            Self::X => 'X',
            Self::Y => 'Y',
            Self::Z => 'Z',
            Self::A => 'A',
            Self::B => 'B',
            Self::C => 'C',
        }
    }

    /// Returns the axis that a letter names, in either case.
    #[must_use]
    pub const fn from_letter(letter: char) -> Option<Self> {
        Some(match letter.to_ascii_uppercase() {
            'X' => Self::X,
            'Y' => Self::Y,
            'Z' => Self::Z,
            'A' => Self::A,
            'B' => Self::B,
            'C' => Self::C,
            _ => return None,
        })
    }

    /// Returns whether the axis is X, Y or Z.
    #[must_use]
    pub const fn is_primary(self) -> bool {
        matches!(self, Self::X | Self::Y | Self::Z)
    }
}

/// A motor, by the name Smoothieware configurations give it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Actuator {
    Alpha,
    Beta,
    Gamma,
    Delta,
    Epsilon,
    Zeta,
}

impl Actuator {
    /// All actuators in order.
    pub const ALL: [Self; MAX_ACTUATORS] =
        [Self::Alpha, Self::Beta, Self::Gamma, Self::Delta, Self::Epsilon, Self::Zeta];

    /// Returns the motors of a set of bits, see [`Self::bit`].
    pub fn of_bits(bits: u8) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |motor| bits & motor.bit() != 0)
    }

    /// Returns the name in configuration files, lower case.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Alpha => "alpha",
            Self::Beta => "beta",
            Self::Gamma => "gamma",
            Self::Delta => "delta",
            Self::Epsilon => "epsilon",
            Self::Zeta => "zeta",
        }
    }

    /// Returns the actuator of this name, as configuration files spell it.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|actuator| actuator.name() == name)
    }

    /// Returns the actuator at this index, alpha being 0.
    #[must_use]
    pub const fn from_index(index: usize) -> Option<Self> {
        if index < MAX_ACTUATORS { Some(Self::ALL[index]) } else { None }
    }

    /// Returns the bit of this actuator in a set of actuators.
    #[must_use]
    pub const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// A value for each axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerAxis<T>(pub [T; MAX_AXES]);

/// A value for each actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerActuator<T>(pub [T; MAX_ACTUATORS]);

impl<T> Index<Axis> for PerAxis<T> {
    type Output = T;
    fn index(&self, axis: Axis) -> &T {
        &self.0[axis as usize]
    }
}

impl<T> IndexMut<Axis> for PerAxis<T> {
    fn index_mut(&mut self, axis: Axis) -> &mut T {
        &mut self.0[axis as usize]
    }
}

impl<T> Index<Actuator> for PerActuator<T> {
    type Output = T;
    fn index(&self, actuator: Actuator) -> &T {
        &self.0[actuator as usize]
    }
}

impl<T> IndexMut<Actuator> for PerActuator<T> {
    fn index_mut(&mut self, actuator: Actuator) -> &mut T {
        &mut self.0[actuator as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_and_name_finds_its_way_back() {
        for axis in Axis::ALL {
            assert_eq!(Axis::from_letter(axis.letter()), Some(axis));
            assert_eq!(Axis::from_letter(axis.letter().to_ascii_lowercase()), Some(axis));
        }
        for (index, actuator) in Actuator::ALL.into_iter().enumerate() {
            assert_eq!(Actuator::from_name(actuator.name()), Some(actuator));
            assert_eq!(Actuator::from_index(index), Some(actuator));
            assert_eq!(actuator.bit(), 1 << index);
        }
        assert_eq!(Axis::from_letter('E'), None);
        assert_eq!(Actuator::from_name("Alpha"), None);
        assert_eq!(Actuator::from_index(MAX_ACTUATORS), None);
    }
}
