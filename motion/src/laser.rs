//! Power of a laser along the path: what a move asks for, and what the laser is like.

/// Power of a laser during a move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Power {
    /// Share of full power at the requested speed, in 1/65535.
    pub level: u16,
    /// Power follows the actual speed along the path over the requested one (M4), rather than being constant
    /// (M3).
    pub by_speed: bool,
}

impl Power {
    /// No power.
    pub const OFF: Self = Self { level: 0, by_speed: false };
    /// Level of full power.
    pub const FULL: u16 = u16::MAX;
}

/// Most points of a [`PowerCurve`].
pub const MOST_CURVE_POINTS: usize = 32;

/// Optical power of a laser over its duty. Used backwards: a level gives that share of the optical power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PowerCurve {
    /// Points as `(duty, power)`, both from 0 to 1, ascending in both.
    pub points: [(f32, f32); MOST_CURVE_POINTS],
    /// Number of points in use; none for a laser whose power is proportional to the duty.
    pub count: usize,
}

/// Properties of a laser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserConfig {
    /// Ticks by which the output goes up later than the power of the path does; negative: earlier.
    pub on_delay: i32,
    /// Ticks by which the output goes down later than the power of the path does; negative: earlier.
    pub off_delay: i32,
    /// Duty of the least power above zero, 0 to 1. Levels between zero and full lie evenly between it and
    /// `most`.
    pub least: f32,
    /// Duty of full power, 0 to 1.
    pub most: f32,
    /// What the laser makes of a duty.
    pub curve: PowerCurve,
}
