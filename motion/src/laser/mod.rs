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

mod state;
mod store;

pub(crate) use state::Laser;
pub use store::PowerStore;

/// Most points of a [`PowerCurve`].
pub const MOST_CURVE_POINTS: usize = 32;

/// Optical power of a laser over its duty. Used backwards: a level gives that share of the optical power.
/// The duty of its points is counted from 0 at [`LaserConfig::least`] to 1 at [`LaserConfig::most`].
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

/// Longest delay of either edge: 20 ms, in ticks.
const MOST_DELAY: i32 = 4_000_000;

impl LaserConfig {
    /// Whether a laser can be like this: duties from 0 to 1 and in order, a curve that rises, delays of 20 ms
    /// at most.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let is_share = |value: f32| (0.0..=1.0).contains(&value);
        let delays = [self.on_delay, self.off_delay].iter().all(|delay| (-MOST_DELAY..=MOST_DELAY).contains(delay));
        delays && is_share(self.least) && is_share(self.most) && self.least <= self.most && self.curve.is_valid()
    }
}

impl PowerCurve {
    /// The points in use; `None` when there are more than fit.
    fn in_use(&self) -> Option<&[(f32, f32)]> {
        self.points.get(..self.count)
    }

    fn is_valid(&self) -> bool {
        let Some(points) = self.in_use() else { return false };
        let is_share = |value: f32| (0.0..=1.0).contains(&value);
        let is_rising = points.iter().zip(points.iter().skip(1)).all(|(a, b)| a.0 < b.0 && a.1 < b.1);
        points.iter().all(|(duty, power)| is_share(*duty) && is_share(*power)) && is_rising
    }
}
