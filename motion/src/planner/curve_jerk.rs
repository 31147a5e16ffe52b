//! The jerk that a curve allows.
//!
//! At speed v, with the acceleration a and the jerk j along the path, the third derivative of the place is `T
//! j + 3 T' v a + T'' v^3`: T is the unit tangent, T' the bend (one by the radius in size), T'' its change,
//! dashes being for a millimetre of path. So the bend has a jerk of its own, which no time law takes away:
//! `v^3 / r^2` on a circle. The rest of a limit J is shared between the acceleration and the jerk along the
//! path.
//!
//! Each limit (that of the path, and of each axis) asks for three numbers: the greatest T, T' and T'' that it
//! sees in the block. The speed is lowered until the bend's own jerk takes [`TWIST_SHARES`] of J, as the
//! speed asked for needs; then the acceleration until the second term leaves [`LEFT_FOR_JERK`] of the rest;
//! the jerk along the path gets what remains. On a circle T' and T'' are at right angles, so their terms add
//! up as a root of squares; on a spline as they are. All three are fixed for the whole block.

use super::{Envelope, peak::Peak};
use crate::{
    arithmetic::cube_root,
    config::Limits,
    greatest, least,
    path::{Arc, Curve, Path, Vector, primary, size},
    square_root,
};

/// Shares of the jerk that the bend's own may take: at least, at most. The speed goes with their cubic root.
const TWIST_SHARES: (f64, f64) = (0.25, 0.7);
/// Share of the rest that is kept for the jerk along the path.
const LEFT_FOR_JERK: f64 = 0.5;
/// Places of a spline that are looked at.
const INTERVALS: u32 = 16;

/// Demand of a curve on one limit: the greatest parts of T, T' and T''.
#[derive(Clone, Copy, Debug, Default)]
struct Ask {
    slope: f64,
    bend: f64,
    twist: f64,
    limit: f64,
}

/// Demands of a curve on every limit: that of the path, then those of X, Y and Z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asks {
    asks: [Ask; 4],
    /// T' and T'' are at right angles.
    square: bool,
}

impl Asks {
    /// Returns the demands of a path; `None` where nothing limits jerk.
    pub fn new(path: &Path, length: f64, excess: f64, limits: &Limits) -> Option<Self> {
        if !limits.has_jerk() {
            return None;
        }
        let (mut asks, square) = match &path.curve {
            Curve::Arc(arc) => (of_arc(path, arc, excess), true),
            _ => (sampled(path, length), false),
        };
        for (ask, limit) in asks.iter_mut().zip(limits.jerks()) {
            ask.limit = limit;
        }
        Some(Self { asks, square })
    }

    /// Greatest part of each axis in a millimetre of path.
    pub fn shares(&self) -> Vector {
        let [_, x, y, z] = self.asks;
        [x.slope, y.slope, z.slope]
    }

    /// Lowers the speed to what the bend's own jerk allows.
    pub fn limit_speed(&self, envelope: &mut Envelope, requested: f64) {
        let (lowest, highest) = TWIST_SHARES;
        for ask in self.asks.iter().filter(|ask| ask.twist > 0.0) {
            let wanted = least(requested, envelope.speed_limit);
            let share = ask.twist * wanted * wanted * wanted / ask.limit;
            let share = least(greatest(share, lowest), highest);
            envelope.speed_limit = least(envelope.speed_limit, cube_root(share * ask.limit / ask.twist));
        }
    }

    /// Lowers the acceleration, and says what jerk along the path is left.
    pub fn limit_jerk(&self, envelope: &mut Envelope) -> f64 {
        let speed = envelope.speed_limit;
        for ask in self.asks.iter().filter(|ask| ask.bend * speed > 0.0) {
            let own = ask.twist * speed * speed * speed;
            let most = own + (1.0 - LEFT_FOR_JERK) * (ask.limit - own);
            let left = if self.square { square_root(most * most - own * own) } else { most - own };
            envelope.acceleration = least(envelope.acceleration, left / (3.0 * ask.bend * speed));
        }
        let jerk = |ask: &Ask| {
            let own = ask.twist * speed * speed * speed;
            let second = 3.0 * ask.bend * speed * envelope.acceleration;
            let taken = if self.square { square_root(own * own + second * second) } else { own + second };
            if ask.slope > 0.0 { (ask.limit - taken) / ask.slope } else { f64::INFINITY }
        };
        self.asks.iter().map(jerk).fold(f64::INFINITY, least)
    }
}

/// Returns the demands of the whole circle, whatever part of it the arc is: so all parts of a circle have the
/// same limits, and ramps may run from one into the next.
fn of_arc(path: &Path, arc: &Arc, excess: f64) -> [Ask; 4] {
    let rate = arc.rate();
    let ask = |slope: f64, radius: f64| Ask {
        slope,
        bend: rate * rate * radius,
        twist: rate * rate * rate * radius,
        limit: 0.0,
    };
    let ([ax, ay, az], [bx, by, bz], [dx, dy, dz]) = (arc.arm(), arc.ahead(), primary(&path.direction));
    let axis = |direction: f64, a: f64, b: f64| {
        let radius = square_root(a * a + b * b);
        ask(libm::fabs(direction) + rate * radius, radius)
    };
    [ask(excess, size(arc.arm())), axis(dx, ax, bx), axis(dy, ay, by), axis(dz, az, bz)]
}

fn sampled(path: &Path, length: f64) -> [Ask; 4] {
    let mut peaks = [[Peak::default(); 3]; 4];
    for index in 0..=INTERVALS {
        let s = length * f64::from(index) / f64::from(INTERVALS);
        let (tangent, bend, twist) = (primary(&path.tangent(s)), path.curve.bend(s), path.curve.twist(s));
        let parts = tangent.into_iter().zip(bend).zip(twist);
        let axes = parts.map(|((slope, bend), twist)| [slope, bend, twist]);
        let whole = [size(tangent), size(bend), size(twist)];
        for (peaks, parts) in peaks.iter_mut().zip(core::iter::once(whole).chain(axes)) {
            peaks.iter_mut().zip(parts).for_each(|(peak, part)| peak.take(part));
        }
    }
    let mut asks = peaks.map(|[slope, bend, twist]| Ask {
        slope: slope.bound(),
        bend: bend.bound(),
        twist: twist.bound(),
        limit: 0.0,
    });
    // An axis that takes part takes all of it, so that the pieces of a curve have the same limits.
    for ask in &mut asks {
        ask.slope = if ask.slope > 0.3 { greatest(ask.slope, 1.0) } else { 1.2 * ask.slope };
    }
    asks
}
