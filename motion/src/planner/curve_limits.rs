//! The speed and acceleration that a curve allows.
//!
//! Going along a curve of curvature k at speed v takes an acceleration of `k v^2` towards the centre, at
//! right angles to that along the path, so with a limit of A `a^2 + (k v^2)^2 <= A^2` must hold. The speed
//! gets as much of A as it asks for, from half to nine tenths; the rest, by Pythagoras 0.87 to 0.44 of A, is
//! left to gain and lose speed with. Both are fixed for the whole block, so that planning stays in closed
//! form.
//!
//! For linear kinematics a motor that turns m mm for a millimetre in the plane of the curve and d mm for the
//! rise sees at most `(m + d) A`. The demand of an arc on axes and motors is a sine of the angle, so its
//! greatest value is known in closed form; splines, and machines that bend lines, are looked at in a bounded
//! number of places, and what may hide between two of these is allowed for.

use units::{Actuator, MmPerSecond2, PerActuator, PerAxis};

use super::{Envelope, curve_jerk::Asks, peak::Peak};
use crate::{
    compensation::Over,
    config::{Limits, MotionConfig},
    greatest,
    kinematics::{Kinematics, Strain},
    least,
    moves::Refusal,
    path::{Arc, Curve, Path, Vector, dot, primary, size, unit},
    square_root,
};

/// Shares of the acceleration that the way round the bend may take: at least, at most.
const BEND_SHARES: (f64, f64) = (0.5, 0.9);
/// Intervals of a curve that are looked at; more where it comes close to an edge of the space.
const INTERVALS: u32 = 16;
const MOST_INTERVALS: u32 = 256;
/// Distance of the two slopes whose difference is the bend, as a share of the clearance.
const BEND_STEP: f64 = 1e-4;
/// Size up to which the second of two motors' parts is rounding.
const NOTHING: f64 = 1e-9;

/// Greatest demand of a curve, for each mm/s of speed along it.
struct Demand {
    axes: Vector,
    motors: PerActuator<f64>,
    /// Inverse of the least radius, 1/mm.
    curvature: f64,
}

/// The limits of a move along a curve; the speed asked for decides how much acceleration is kept for the
/// bend.
pub(crate) fn curve_envelope(
    config: &MotionConfig,
    path: &Path,
    length: f64,
    requested: f64,
    over: &Over,
) -> Result<Envelope, Refusal> {
    let (kinematics, limits) = (&config.kinematics, &config.limits);
    let machine = &Skewed { kinematics, over };
    let (mut demand, mut strain) = match (kinematics.is_linear(), &path.curve) {
        (true, Curve::Arc(arc)) => (of_arc(machine, path, arc), None),
        (true, _) => (sampled(machine, path, length, INTERVALS).0, None),
        (false, _) => {
            let (demand, strain) = strained(machine, path, length)?;
            (demand, Some(strain))
        }
    };
    lift(machine, path, length, &mut demand, &mut strain);
    let excess = excess(path);
    let mut envelope = Envelope {
        length,
        speed_limit: limits.max_speed.map_or(f64::INFINITY, |most| most.get() / excess),
        acceleration: limits.acceleration.get() / excess,
        primary: Some(unit(path, 0.0)),
        bend: path.curve.bend(0.0),
        jerk: 0.0,
        clearance: 1.0 / demand.curvature,
    };
    envelope.limit_cartesian(&demand.axes, limits);
    let ways = PerActuator(demand.motors.0.map(|slope| slope * length));
    for actuator in Actuator::ALL {
        envelope.limit_rate(actuator, &ways, limits);
    }
    if kinematics.is_linear() {
        if let Some(strain) = &strain {
            limit_by_lift(&mut envelope, strain, limits);
        }
        limit_by_motors(&mut envelope, machine, path, length, (limits, strain.as_ref()));
    }
    let jerks = Asks::new(path, length, excess, limits);
    if let Some(asks) = &jerks {
        asks.limit_speed(&mut envelope, requested);
    }
    limit_by_bend(&mut envelope, demand.curvature, requested);
    if let Some(strain) = strain {
        let clearance = least(envelope.clearance, strain.clearance);
        if !kinematics.is_linear() {
            envelope.limit_strain(&strain, limits);
            for actuator in PATH_MOTORS {
                envelope.limit_acceleration(actuator, &ways, limits);
            }
        }
        envelope.clearance = clearance;
    }
    if let Some(asks) = jerks {
        let jerk = asks.limit_jerk(&mut envelope);
        envelope.limit_jerk(jerk, &asks.shares(), limits);
    }
    Ok(envelope)
}

/// Extruders and other auxiliary motors never slow the acceleration of a combined move.
const PATH_MOTORS: [Actuator; 3] = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma];

/// Returns the factor by which the tangent may be longer than one: where the end is a little off its circle,
/// the way there is added.
fn excess(path: &Path) -> f64 {
    let Curve::Arc(arc) = &path.curve else { return 1.0 };
    let ([ax, ay, az], [bx, by, bz]) = (arc.arm(), arc.ahead());
    let across = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
    let direction = primary(&path.direction);
    let rise = dot(direction, across) / size(across);
    let sideways = square_root(greatest(dot(direction, direction) - rise * rise, 0.0));
    let round = arc.rate() * size(arc.arm()) + sideways;
    greatest(square_root(round * round + rise * rise), 1.0)
}

fn along_axes([x, y, z]: Vector) -> PerAxis<f64> {
    PerAxis([x, y, z, 0.0, 0.0, 0.0])
}

/// The machine behind its skew.
struct Skewed<'a> {
    kinematics: &'a Kinematics,
    over: &'a Over,
}

impl Skewed<'_> {
    fn velocities(&self, point: &PerAxis<f64>, direction: &PerAxis<f64>) -> PerActuator<f64> {
        self.kinematics.velocities(&self.over.skewed(point), &self.over.skewed(direction))
    }

    fn clearance(&self, point: &PerAxis<f64>) -> f64 {
        self.kinematics.clearance(&self.over.skewed(point))
    }

    fn reaches(&self, point: &PerAxis<f64>) -> bool {
        self.kinematics.reaches_lifted(&self.over.skewed(point), self.over.lift.as_ref())
    }
}

/// Adds what levelling asks for to what the curve asks for.
fn lift(machine: &Skewed<'_>, path: &Path, length: f64, demand: &mut Demand, strain: &mut Option<Strain>) {
    let Some(lift) = &machine.over.lift else { return };
    let none = PerActuator([0.0; units::MAX_ACTUATORS]);
    let places = [0.0, 0.5, 1.0].map(|share| machine.over.skewed(&path.point(share * length)));
    let mut raised = Strain { slope: none, bend: none, clearance: f64::INFINITY };
    // On linear kinematics the way round the bend is no bend of the motors' but a part of the acceleration.
    let round = if machine.kinematics.is_linear() { 0.0 } else { lift.slope() * demand.curvature };
    let with = |strain: &mut Strain| {
        strain.lift(machine.kinematics, machine.over, lift, (lift.slope(), lift.bend() + round), &places);
    };
    with(&mut raised);
    demand.axes[2] = libm::fabs(demand.axes[2]) + lift.slope();
    for actuator in Actuator::ALL {
        demand.motors[actuator] = libm::fabs(demand.motors[actuator]) + raised.slope[actuator];
    }
    match strain {
        Some(strain) => with(strain),
        None => *strain = Some(raised),
    }
}

/// The bend of the surface may take half of what a motor can do.
fn limit_by_lift(envelope: &mut Envelope, lifted: &Strain, limits: &Limits) {
    for actuator in PATH_MOTORS {
        let own = limits.actuator_acceleration[actuator].map(MmPerSecond2::get);
        if let (Some(own), true) = (own, lifted.bend[actuator] > 0.0) {
            envelope.speed_limit = least(envelope.speed_limit, square_root(0.5 * own / lifted.bend[actuator]));
        }
    }
}

/// A motor turns m mm for a millimetre in the plane, d for the rise: `(m + d)` times the acceleration of the
/// path at most. A motor that only makes the rise does not feel the bend.
fn limit_by_motors(
    envelope: &mut Envelope,
    machine: &Skewed<'_>,
    path: &Path,
    length: f64,
    (limits, lifted): (&Limits, Option<&Strain>),
) {
    let origin = &path.origin;
    let rise = machine.velocities(origin, &along_axes(primary(&path.direction)));
    let mut in_plane = PerActuator([0.0; units::MAX_ACTUATORS]);
    for side in plane(path, length) {
        let turned = machine.velocities(origin, &along_axes(side));
        for actuator in PATH_MOTORS {
            in_plane[actuator] += turned[actuator] * turned[actuator];
        }
    }
    for actuator in PATH_MOTORS {
        let Some(own) = limits.actuator_acceleration[actuator].map(MmPerSecond2::get) else { continue };
        let speed_sq = envelope.speed_limit * envelope.speed_limit;
        let (slope, bend) = lifted.map_or((0.0, 0.0), |lifted| (lifted.slope[actuator], lifted.bend[actuator]));
        let own = if bend > 0.0 { own - bend * speed_sq } else { own };
        let share = square_root(in_plane[actuator]) + libm::fabs(rise[actuator]) + slope;
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
    envelope.speed_limit = least(envelope.speed_limit, square_root(share * most / curvature));
    let taken = curvature * envelope.speed_limit * envelope.speed_limit / most;
    envelope.acceleration = most * square_root(greatest(1.0 - taken * taken, 0.0));
}

/// Greatest size of `base + c cos p + s sin p` for p from 0 to `angle`.
fn greatest_swing(base: f64, c: f64, s: f64, angle: f64) -> f64 {
    const TURN: f64 = 2.0 * core::f64::consts::PI;
    let swing = square_root(c * c + s * s);
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

fn of_arc(machine: &Skewed<'_>, path: &Path, arc: &Arc) -> Demand {
    let rate = arc.rate();
    // The slope is `direction + rate (ahead cos p - arm sin p)`.
    let (cosine, sine) = (arc.ahead().map(|part| rate * part), arc.arm().map(|part| -rate * part));
    let mut axes = primary(&path.direction);
    for ((axis, c), s) in axes.iter_mut().zip(cosine).zip(sine) {
        *axis = greatest_swing(*axis, c, s, arc.angle());
    }
    let origin = &path.origin;
    let base = machine.velocities(origin, &path.direction);
    let (c, s) = (machine.velocities(origin, &along_axes(cosine)), machine.velocities(origin, &along_axes(sine)));
    let mut motors = base;
    for actuator in Actuator::ALL {
        motors[actuator] = greatest_swing(base[actuator], c[actuator], s[actuator], arc.angle());
    }
    Demand { axes, motors, curvature: rate * rate * size(arc.arm()) }
}

/// Returns the demand from places at equal distances, the strain with the least clearance seen, and the
/// clearance that may be hidden between two places.
fn sampled(machine: &Skewed<'_>, path: &Path, length: f64, intervals: u32) -> (Demand, Strain, f64) {
    let kinematics = machine.kinematics;
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
        let slope = machine.velocities(&point, &tangent);
        let free = machine.clearance(&point);
        clearance = least(clearance, free);
        edge.take(free);
        let step = BEND_STEP * least(least(greatest(free, NOTHING), 100.0), 1.0 / curvature);
        let near = |s: f64| machine.velocities(&path.point(s), &path.tangent(s));
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

/// Returns demand and strain for machines that bend lines. Near an edge slopes grow at most as one by the
/// distance to it, bends as its square: by that factor the demand between two places may be worse than at
/// them.
fn strained(machine: &Skewed<'_>, path: &Path, length: f64) -> Result<(Demand, Strain), Refusal> {
    let turns = match &path.curve {
        Curve::Arc(arc) => arc.angle() / core::f64::consts::PI,
        _ => 0.0,
    };
    let wanted = greatest(f64::from(INTERVALS), f64::from(INTERVALS) * turns);
    let least_free = |intervals: u32| {
        let mut free = f64::INFINITY;
        for index in 0..=intervals {
            let point = path.point(length * f64::from(index) / f64::from(intervals));
            if !machine.reaches(&point) {
                return Err(Refusal::Unreachable);
            }
            free = least(free, machine.clearance(&point));
        }
        Ok(free)
    };
    let bounded = |wanted: f64| if wanted < f64::from(MOST_INTERVALS) { wanted as u32 } else { MOST_INTERVALS };
    let first = bounded(libm::ceil(wanted));
    let needed = bounded(libm::ceil(8.0 * length / least_free(first)?));
    let intervals = if needed > first { needed } else { first };
    least_free(intervals)?;
    let (mut demand, mut strain, hidden) = sampled(machine, path, length, intervals);
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

    #[test]
    fn the_bend_gets_as_much_of_the_acceleration_as_the_speed_asks_for() {
        let share_of = |requested: f64| {
            let mut envelope = Envelope {
                length: 10.0,
                speed_limit: 1_000.0,
                acceleration: 1_000.0,
                primary: None,
                bend: [0.0; 3],
                jerk: 0.0,
                clearance: f64::INFINITY,
            };
            limit_by_bend(&mut envelope, 0.1, requested);
            let across = 0.1 * envelope.speed_limit * envelope.speed_limit;
            let whole = square_root(across * across + envelope.acceleration * envelope.acceleration);
            assert!((whole - 1_000.0).abs() < 1e-9, "both together are the limit");
            across / 1_000.0
        };
        for (requested, share) in [(1.0, 0.5), (70.0, 0.5), (80.0, 0.64), (90.0, 0.81), (500.0, 0.9)] {
            assert!((share_of(requested) - share).abs() < 1e-9, "{} at {requested} mm/s", share_of(requested));
        }
    }
}
