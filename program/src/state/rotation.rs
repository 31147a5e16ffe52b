//! Coordinate systems that are rotated about their origin, in the plane of X and Y (G10 L2 R, as in
//! LinuxCNC).

/// Rotation of each coordinate system, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotations<const N: usize> {
    degrees: [f64; N],
    /// Whether any system is rotated; kept because nearly every program needs no more than this flag.
    any: bool,
}

impl<const N: usize> Rotations<N> {
    /// No system is rotated.
    pub(crate) const NONE: Self = Self { degrees: [0.0; N], any: false };

    /// Whether any system is rotated.
    #[inline]
    #[must_use]
    pub const fn any(&self) -> bool {
        self.any
    }

    /// Returns the rotation of a system, degrees counter-clockwise.
    #[must_use]
    pub fn of(&self, system: usize) -> f64 {
        self.degrees.get(system).copied().unwrap_or(0.0)
    }

    /// Sets the rotation of a system, degrees.
    pub(crate) fn set(&mut self, system: usize, degrees: f64) {
        if let Some(place) = self.degrees.get_mut(system) {
            *place = degrees;
        }
        self.any = self.degrees.iter().any(|degrees| *degrees != 0.0);
    }

    /// Returns the rotation of a system as a matrix; `None` without rotation.
    pub(crate) fn turn(&self, system: usize) -> Option<Turn> {
        let degrees = self.of(system);
        (degrees != 0.0).then(|| Turn::by(degrees))
    }
}

/// Rotation about the origin, as sine and cosine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    sin: f64,
    cos: f64,
}

impl Turn {
    fn by(degrees: f64) -> Self {
        let quarters = libm::fmod(degrees / 90.0, 4.0);
        // Quarter turns have exact sines and cosines, but computing them from radians is inexact.
        let (sin, cos) = match (libm::floor(quarters) == quarters, (quarters + 4.0) as u8 % 4) {
            (true, 0) => (0.0, 1.0),
            (true, 1) => (1.0, 0.0),
            (true, 2) => (0.0, -1.0),
            (true, _) => (-1.0, 0.0),
            (false, _) => libm::sincos(degrees.to_radians()),
        };
        Self { sin, cos }
    }

    /// Rotates X and Y of the system to the machine's axes.
    pub(crate) fn forward(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x * self.cos - y * self.sin, x * self.sin + y * self.cos]
    }

    /// Rotates X and Y of the machine to the system's axes.
    pub(crate) fn back(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x * self.cos + y * self.sin, y * self.cos - x * self.sin]
    }
}
