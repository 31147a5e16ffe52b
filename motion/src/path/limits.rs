//! The speed and acceleration that a curve allows.
//!
//! Going along a curve of curvature k at speed v takes an acceleration of `k v^2` towards the centre, at right angles to that
//! along the path, so with a limit of A `a^2 + (k v^2)^2 <= A^2` must hold. The speed gets as much of A as it asks for, from half to
//! nine tenths; the rest, by Pythagoras 0.87 to 0.44 of A, is left to gain and lose speed with. Both are fixed for the whole block, so
//! that planning stays in closed form.
//!
//! For linear kinematics a motor that turns m mm for a millimetre in the plane of the curve and d mm for the rise sees at most
//! `(m + d) A`. What an arc asks of axes and motors is a sine of the angle, so its greatest value is known in closed form; splines, and
//! machines that bend lines, are looked at in a bounded number of places, and what may hide between two of these is allowed for.

use units::{Actuator, MmPerSecond2, PerActuator, PerAxis};

use super::{Arc, Curve, Path, Vector, dot, primary, size};
use crate::{
    config::{Limits, MotionConfig},
    greatest,
    kinematics::{Kinematics, Strain},
    least,
    moves::Refusal,
    planner::Envelope,
};

/// Shares of the acceleration that the way round the bend may take: at least, at most.
const BEND_SHARES: (f64, f64) = (0.5, 0.9);
/// Intervals of a curve that are looked at; more where it comes close to an edge of the space.
const INTERVALS: u32 = 16;
const MOST_INTERVALS: u32 = 256;
/// Distance of the two slopes whose difference is the bend, as a share of the clearance.
const BEND_STEP: f64 = 1e-4;
/// Of two motors' parts the second this small is rounding.
const NOTHING: f64 = 1e-9;

/// What a curve asks for, at most, for each mm/s of speed along it.
struct Demand {
    axes: Vector,
    motors: PerActuator<f64>,
    /// One by the least radius, 1/mm.
    curvature: f64,
}

/// The limits of a move along a curve; the speed asked for decides how much acceleration is kept for the bend.
pub(crate) fn envelope(config: &MotionConfig, path: &Path, length: f64, requested: f64) -> Result<Envelope, Refusal> {
    let (kinematics, limits) = (&config.kinematics, &config.limits);
    let (demand, strain) = match (kinematics.is_linear(), &path.curve) {
        (true, Curve::Arc(arc)) => (of_arc(kinematics, path, arc), None),
        (true, _) => (sampled(kinematics, path, length, INTERVALS).0, None),
        (false, _) => {
            let (demand, strain) = strained(kinematics, path, length)?;
            (demand, Some(strain))
        }
    };
    let mut envelope = Envelope {
        length,
        speed_limit: f64::INFINITY,
        acceleration: limits.acceleration.get(),
        primary: Some(unit(path, 0.0)),
        clearance: 1.0 / demand.curvature,
    };
    let excess = excess(path);
    envelope.acceleration /= excess;
    envelope.speed_limit = limits.max_speed.map_or(f64::INFINITY, |most| most.get() / excess);
    envelope.limit_cartesian(&demand.axes, limits);
    let ways = PerActuator(demand.motors.0.map(|slope| slope * length));
    for actuator in Actuator::ALL {
        envelope.limit_rate(actuator, &ways, limits);
    }
    if kinematics.is_linear() {
        limit_by_motors(&mut envelope, kinematics, path, length, limits);
    }
    limit_by_bend(&mut envelope, demand.curvature, requested);
    if let Some(strain) = strain {
        let clearance = least(envelope.clearance, strain.clearance);
        envelope.limit_strain(&strain, limits);
        envelope.clearance = clearance;
        for actuator in PATH_MOTORS {
            envelope.limit_acceleration(actuator, &ways, limits);
        }
    }
    Ok(envelope)
}

/// Extruders and other auxiliary motors never slow the acceleration of a combined move.
const PATH_MOTORS: [Actuator; 3] = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma];

/// Unit direction of X, Y and Z.
pub(crate) fn unit(path: &Path, s: f64) -> Vector {
    let tangent = primary(&path.tangent(s));
    let length = size(tangent);
    tangent.map(|part| part / length)
}

/// How much longer than one the tangent may be: where the end is a little off its circle, the way there is added.
fn excess(path: &Path) -> f64 {
    let Curve::Arc(arc) = &path.curve else { return 1.0 };
    let ([ax, ay, az], [bx, by, bz]) = (arc.arm(), arc.ahead());
    let across = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
    let direction = primary(&path.direction);
    let rise = dot(direction, across) / size(across);
    let aside = libm::sqrt(greatest(dot(direction, direction) - rise * rise, 0.0));
    let round = arc.rate() * size(arc.arm()) + aside;
    greatest(libm::sqrt(round * round + rise * rise), 1.0)
}

fn along_axes([x, y, z]: Vector) -> PerAxis<f64> {
    PerAxis([x, y, z, 0.0, 0.0, 0.0])
}

/// A motor turns m mm for a millimetre in the plane, d for the rise: `(m + d)` times the acceleration of the path at most. One that only
/// makes the rise does not feel the bend.
fn limit_by_motors(envelope: &mut Envelope, kinematics: &Kinematics, path: &Path, length: f64, limits: &Limits) {
    let origin = &path.origin;
    let rise = kinematics.velocities(origin, &along_axes(primary(&path.direction)));
    let mut in_plane = PerActuator([0.0; units::MAX_ACTUATORS]);
    for side in plane(path, length) {
        let turned = kinematics.velocities(origin, &along_axes(side));
        for actuator in PATH_MOTORS {
            in_plane[actuator] += turned[actuator] * turned[actuator];
        }
    }
    for actuator in PATH_MOTORS {
        let Some(own) = limits.actuator_acceleration[actuator].map(MmPerSecond2::get) else { continue };
        let share = libm::sqrt(in_plane[actuator]) + libm::fabs(rise[actuator]);
        if share > NOTHING {
            envelope.acceleration = least(envelope.acceleration, own / share);
        }
    }
}

/// Unit vectors at right angles to each other that the curve lies in.
fn plane(path: &Path, length: f64) -> [Vector; 3] {
    let side = |along: Vector| {
        let size = size(along);
        along.map(|part| part / size)
    };
    match &path.curve {
        Curve::Arc(arc) => [side(arc.arm()), side(arc.ahead()), [0.0; 3]],
        // Any axis that takes part.
        _ => {
            let moves = |axis: usize| {
                let places = [0.25, 0.5, 0.75, 1.0].map(|share| path.curve.offset(share * length));
                places.iter().any(|place| place.get(axis).is_some_and(|part| libm::fabs(*part) > NOTHING))
            };
            let one = |axis: usize| f64::from(u8::from(moves(axis)));
            [[one(0), 0.0, 0.0], [0.0, one(1), 0.0], [0.0, 0.0, one(2)]]
        }
    }
}

/// Divides the acceleration between the bend and the speed along the path.
fn limit_by_bend(envelope: &mut Envelope, curvature: f64, requested: f64) {
    let most = envelope.acceleration;
    let wanted = least(requested, envelope.speed_limit);
    let share = curvature * wanted * wanted / most;
    let (lowest, highest) = BEND_SHARES;
    let share = least(greatest(share, lowest), highest);
    envelope.speed_limit = least(envelope.speed_limit, libm::sqrt(share * most / curvature));
    let taken = curvature * envelope.speed_limit * envelope.speed_limit / most;
    envelope.acceleration = most * libm::sqrt(greatest(1.0 - taken * taken, 0.0));
}

/// Greatest size of `base + c cos p + s sin p` for p from 0 to `angle`.
fn greatest_swing(base: f64, c: f64, s: f64, angle: f64) -> f64 {
    const TURN: f64 = 2.0 * core::f64::consts::PI;
    let swing = libm::sqrt(c * c + s * s);
    let top = libm::atan2(s, c);
    let passes = |at: f64| {
        let first = at - TURN * libm::floor(at / TURN);
        first <= angle
    };
    let (sin, cos) = libm::sincos(angle);
    let mut most = greatest(libm::fabs(base + c), libm::fabs(base + c * cos + s * sin));
    for (at, value) in [(top, base + swing), (top + 0.5 * TURN, base - swing)] {
        if passes(at) {
            most = greatest(most, libm::fabs(value));
        }
    }
    most
}

fn of_arc(kinematics: &Kinematics, path: &Path, arc: &Arc) -> Demand {
    let rate = arc.rate();
    // The slope is `direction + rate (ahead cos p - arm sin p)`.
    let (cosine, sine) = (arc.ahead().map(|part| rate * part), arc.arm().map(|part| -rate * part));
    let mut axes = primary(&path.direction);
    for ((axis, c), s) in axes.iter_mut().zip(cosine).zip(sine) {
        *axis = greatest_swing(*axis, c, s, arc.angle());
    }
    let origin = &path.origin;
    let base = kinematics.velocities(origin, &path.direction);
    let (c, s) = (kinematics.velocities(origin, &along_axes(cosine)), kinematics.velocities(origin, &along_axes(sine)));
    let mut motors = base;
    for actuator in Actuator::ALL {
        motors[actuator] = greatest_swing(base[actuator], c[actuator], s[actuator], arc.angle());
    }
    Demand { axes, motors, curvature: rate * rate * size(arc.arm()) }
}

/// Greatest size of a smooth function known at equal distances: between two places a parabola rises above both by an eighth of
/// the second difference at most.
#[derive(Clone, Copy, Default)]
struct Peak {
    most: f64,
    hidden: f64,
    before: [f64; 2],
    seen: u32,
}

impl Peak {
    fn take(&mut self, value: f64) {
        let [older, old] = self.before;
        if self.seen >= 2 {
            self.hidden = greatest(self.hidden, libm::fabs(value - 2.0 * old + older));
        }
        self.most = greatest(self.most, libm::fabs(value));
        self.before = [old, value];
        self.seen += 1;
    }

    fn bound(&self) -> f64 {
        // And a fifth of that for what a parabola does not tell.
        self.most + 0.15 * self.hidden
    }
}

/// From places at equal distances. Also the strain, its clearance being the least one seen, and how much less may hide between two.
fn sampled(kinematics: &Kinematics, path: &Path, length: f64, intervals: u32) -> (Demand, Strain, f64) {
    let mut axes = [Peak::default(); 3];
    let mut slopes = PerActuator([Peak::default(); units::MAX_ACTUATORS]);
    let mut bends = slopes;
    let mut curvatures = Peak::default();
    let mut clearance = f64::INFINITY;
    let mut edge = Peak::default();
    for index in 0..=intervals {
        let s = length * f64::from(index) / f64::from(intervals);
        let (point, tangent) = (path.point(s), path.tangent(s));
        let curvature = path.curvature(s);
        axes.iter_mut().zip(primary(&tangent)).for_each(|(peak, part)| peak.take(part));
        curvatures.take(curvature);
        let slope = kinematics.velocities(&point, &tangent);
        let free = kinematics.clearance(&point);
        clearance = least(clearance, free);
        edge.take(free);
        let step = BEND_STEP * least(least(greatest(free, NOTHING), 100.0), 1.0 / curvature);
        let near = |s: f64| kinematics.velocities(&path.point(s), &path.tangent(s));
        let (before, after) = if kinematics.is_linear() { (slope, slope) } else { (near(s - step), near(s + step)) };
        for actuator in Actuator::ALL {
            slopes[actuator].take(slope[actuator]);
            bends[actuator].take((after[actuator] - before[actuator]) / (2.0 * step));
        }
    }
    let bounds = |peaks: PerActuator<Peak>| PerActuator(peaks.0.map(|peak| peak.bound()));
    let (slope, bend) = (bounds(slopes), bounds(bends));
    let demand = Demand { axes: axes.map(|peak| peak.bound()), motors: slope, curvature: curvatures.bound() };
    // A distance from a point may be that of a path straight through it; one from an edge is smooth.
    let from_points = matches!(kinematics, Kinematics::Polar | Kinematics::Winch(_));
    let hidden = if from_points { 0.5 * length / f64::from(intervals) } else { edge.bound() - edge.most };
    (demand, Strain { slope, bend, clearance }, hidden)
}

/// For machines that bend lines. Near an edge slopes grow at most as one by the distance to it, bends as its square: by that what lies
/// between two places may be worse than at them.
fn strained(kinematics: &Kinematics, path: &Path, length: f64) -> Result<(Demand, Strain), Refusal> {
    let turns = match &path.curve {
        Curve::Arc(arc) => arc.angle() / core::f64::consts::PI,
        _ => 0.0,
    };
    let wanted = greatest(f64::from(INTERVALS), f64::from(INTERVALS) * turns);
    let least_free = |intervals: u32| {
        let mut free = f64::INFINITY;
        for index in 0..=intervals {
            let point = path.point(length * f64::from(index) / f64::from(intervals));
            if !kinematics.reaches(&point) {
                return Err(Refusal::Unreachable);
            }
            free = least(free, kinematics.clearance(&point));
        }
        Ok(free)
    };
    let bounded = |wanted: f64| if wanted < f64::from(MOST_INTERVALS) { wanted as u32 } else { MOST_INTERVALS };
    let first = bounded(libm::ceil(wanted));
    let needed = bounded(libm::ceil(8.0 * length / least_free(first)?));
    let intervals = if needed > first { needed } else { first };
    least_free(intervals)?;
    let (mut demand, mut strain, hidden) = sampled(kinematics, path, length, intervals);
    let free = strain.clearance - hidden;
    if free <= 0.0 {
        return Err(Refusal::Unreachable);
    }
    let worse = strain.clearance / free;
    for actuator in PATH_MOTORS {
        demand.motors[actuator] *= worse;
        strain.slope[actuator] *= worse;
        strain.bend[actuator] *= worse * worse;
    }
    strain.clearance = free;
    Ok((demand, strain))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_swing_is_as_great_as_its_greatest_place(
            base in -2.0..2.0_f64, c in -2.0..2.0_f64, s in -2.0..2.0_f64, angle in 0.01..20.0_f64,
        ) {
            let places = (0..=20_000).map(|n| angle * f64::from(n) / 20_000.0);
            let most = places.map(|p| (base + c * p.cos() + s * p.sin()).abs()).fold(0.0, f64::max);
            let found = greatest_swing(base, c, s, angle);
            prop_assert!(found >= most - 1e-12 && found <= most + 1e-5, "{found} is not {most}");
        }
    }
}
