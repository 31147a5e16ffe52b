//! Coordinate systems that are turned about their origin, in the plane of X and Y (G10 L2 R, as in LinuxCNC).

/// How far each coordinate system is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotations<const N: usize> {
    degrees: [f64; N],
    /// One of them is: nearly every program asks no more than that.
    any: bool,
}

impl<const N: usize> Rotations<N> {
    /// None is turned.
    pub(crate) const NONE: Self = Self { degrees: [0.0; N], any: false };

    /// Whether any is turned.
    #[inline]
    #[must_use]
    pub const fn any(&self) -> bool {
        self.any
    }

    /// How far one is turned, degrees counter-clockwise.
    #[must_use]
    pub fn of(&self, system: usize) -> f64 {
        self.degrees.get(system).copied().unwrap_or(0.0)
    }

    /// Turns one to so many degrees.
    pub(crate) fn set(&mut self, system: usize, degrees: f64) {
        if let Some(place) = self.degrees.get_mut(system) {
            *place = degrees;
        }
        self.any = self.degrees.iter().any(|degrees| *degrees != 0.0);
    }

    /// The turn of one; none where it is not turned.
    pub(crate) fn turn(&self, system: usize) -> Option<Turn> {
        let degrees = self.of(system);
        (degrees != 0.0).then(|| Turn::by(degrees))
    }
}

/// A turn about the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    sin: f64,
    cos: f64,
}

impl Turn {
    fn by(degrees: f64) -> Self {
        let quarters = libm::fmod(degrees / 90.0, 4.0);
        // Of a quarter the sine and cosine are numbers, that of its radians are nearly so.
        let (sin, cos) = match (libm::floor(quarters) == quarters, (quarters + 4.0) as u8 % 4) {
            (true, 0) => (0.0, 1.0),
            (true, 1) => (1.0, 0.0),
            (true, 2) => (0.0, -1.0),
            (true, _) => (-1.0, 0.0),
            (false, _) => libm::sincos(degrees.to_radians()),
        };
        Self { sin, cos }
    }

    /// X and Y of the turned system, as they lie in the machine's.
    pub(crate) fn forward(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x * self.cos - y * self.sin, x * self.sin + y * self.cos]
    }

    /// The other way.
    pub(crate) fn back(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x * self.cos + y * self.sin, y * self.cos - x * self.sin]
    }
}
