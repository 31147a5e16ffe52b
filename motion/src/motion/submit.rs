//! Submission of moves: from a requested move to a block in the queue.

use units::{Actuator, Axis, AxisSet, PerActuator, PerAxis};

use super::{
    Exit, Last, Motion, State,
    corner::{MOST_CUT, Rounding},
};
use crate::{
    compensation::{Compensation, Over},
    config::MotionConfig,
    greatest,
    knots::{MAX_STEPS, is_countable},
    least,
    moves::{Corner, Move, Refusal},
    path::{Curve, Path},
    planner::{Envelope, SMALLEST, corner_sq, curve_envelope, is_tangent, jump_sq},
    square_root,
    timeline::Mark,
};

impl Motion {
    /// Appends a move to the look-ahead queue.
    ///
    /// A move too short to count (every axis below 0.1 um) is accepted and left to be made up for by the next
    /// one.
    ///
    /// # Errors
    /// [`Refusal::Full`] when it should be asked again later; otherwise why the move can never be made.
    pub fn submit(&mut self, request: &Move) -> Result<(), Refusal> {
        let result = self.accept(request, self.config.as_ref().map_or(0, |config| config.queue_size));
        // A jerk-limited plan depends on the plan before it, so planning runs after each block, no matter
        // when the planner task has its turn.
        self.planner.plan_jerk();
        result
    }

    /// Makes a mark behind what has been submitted so far: the feed's reports tell when the motors have come
    /// there. An effect that hangs on a mark stops nothing, and changes no speed.
    ///
    /// # Errors
    /// [`Refusal::Full`] when too many marks wait, and [`Refusal::Stopping`]: ask again later.
    pub fn mark(&mut self) -> Result<Mark, Refusal> {
        if matches!(self.state, State::Stopping | State::Aborting) {
            return Err(Refusal::Stopping);
        }
        // What hangs on the mark belongs there, so the block before it ends there.
        self.end_growth();
        self.timeline.mark(self.planner.pushed()).ok_or(Refusal::Full)
    }

    /// Accepts a move as [`Self::submit`] does, into a queue of this size.
    pub(super) fn accept(&mut self, request: &Move, queue_size: usize) -> Result<(), Refusal> {
        let config = self.config.as_ref().ok_or(Refusal::NotConfigured)?;
        if matches!(self.state, State::Stopping | State::Aborting) {
            return Err(Refusal::Stopping);
        }
        let is_curved = !request.curve.is_line();
        let may_curve = is_curved || matches!(request.corner, Corner::Rounded(_));
        let grows = self.goes_straight_on(request);
        if grows {
            self.has_room_for_level(request)?;
        } else if self.planner.len() >= queue_size || (may_curve && self.curves.is_full()) {
            return Err(Refusal::Full);
        }
        // Last: while the queue is full this is asked again and again.
        check_request(config, &self.compensation, self.countable, request)?;
        let from = if grows { &self.laser.growth.origin } else { &self.planned };
        let mut delta = request.target;
        for axis in Axis::ALL {
            delta[axis] -= from[axis];
        }
        let length = request.curve.length();
        if is_curved && length >= SMALLEST {
            return self.accept_curve(request, &delta, length);
        }
        no_orphan(self.orphans, &delta)?;
        let over = self.compensation.over_line(from, &request.target);
        let Some(mut envelope) = envelope(config, from, &delta, &request.target, &over)? else {
            return Ok(());
        };
        envelope.limit_straight_jerk(&config.limits);
        if grows {
            self.extend(&envelope, &delta, request);
            return Ok(());
        }
        // A curve of no length is a line.
        let as_line;
        let straight = if is_curved {
            as_line = Move { curve: Curve::Line, ..*request };
            &as_line
        } else {
            request
        };
        let length = envelope.length;
        let unit = PerAxis(delta.0.map(|part| part / length));
        let rounding = self.rounding(&envelope, &unit, request);
        self.wants_two = rounding.is_some() && self.planner.len() + 2 > queue_size;
        if self.wants_two {
            return Err(Refusal::Full);
        }
        if let Some(rounding) = rounding {
            envelope.length -= rounding.cut;
            self.round(&rounding, straight);
        }
        let origin = self.growth_origin(rounding.map(|rounding| rounding.to));
        self.push(&envelope, Exit::straight(envelope.primary), straight);
        if let (Some(last), Some(_), Corner::Rounded(_)) = (&mut self.last, envelope.primary, request.corner) {
            last.line = Some((unit, length));
            self.planner.set_reserve(MOST_CUT * length);
        }
        self.begin_growth(straight, origin, &unit);
        Ok(())
    }

    /// Accepts a curve of this length between places that are so far apart.
    #[inline(always)]
    fn accept_curve(&mut self, request: &Move, delta: &PerAxis<f64>, length: f64) -> Result<(), Refusal> {
        let config = self.config.as_ref().ok_or(Refusal::NotConfigured)?;
        countable_length(config, length)?;
        let path = Path::new(self.planned, &request.target, length, request.curve);
        no_orphan(self.orphans, &ways_of_curve(&path, delta))?;
        let over = self.compensation.over_path(&path, length);
        let envelope = curve_envelope(config, &path, length, request.feed_rate.get(), &over)?;
        let exit = Exit::of(&path, length);
        self.push(&envelope, exit, request);
        self.curves.push(request.curve);
        Ok(())
    }

    /// Puts the arc into the queue, and shortens the line before it.
    fn round(&mut self, rounding: &Rounding, request: &Move) {
        let Some(last) = self.last else { return };
        self.planner.shorten_last(rounding.cut, &rounding.from);
        let curve = Curve::Arc(rounding.arc);
        let feed_rate = if last.requested < request.feed_rate.get() {
            units::MmPerSecond(last.requested)
        } else {
            request.feed_rate
        };
        let along = Move { target: rounding.to, feed_rate, curve, ..*request };
        let path = Path::new(rounding.from, &rounding.to, rounding.arc.length(), curve);
        let target = self.planned;
        self.push(&rounding.envelope, Exit::of(&path, rounding.arc.length()), &along);
        self.curves.push(curve);
        self.planned = target;
    }

    /// Appends the block of a move that ends like this.
    fn push(&mut self, envelope: &Envelope, exit: Exit, request: &Move) {
        let Some(MotionConfig { limits, .. }) = &self.config else { return };
        let mut block = envelope.block(request);
        self.planner.keep_cruise_ratio(limits.cruise_ratio);
        let cruise = block.cruise(&self.overrides);
        // The last block may have been executed already: then this one starts from rest.
        let last = if self.planner.is_empty() && self.run.is_none() { None } else { self.last.as_ref() };
        block.corner_sq = match last {
            Some(last) if request.corner != Corner::Stop => {
                let acceleration = least(last.acceleration, block.acceleration);
                let gain_sq = least(last.acceleration * last.length, block.acceleration * block.length);
                let corner = corner_sq(last.exit.direction, envelope.primary, acceleration, gain_sq, limits);
                least(corner, jump_sq(last.exit.bend, envelope.bend, limits))
            }
            _ => limits.minimum_speed.get() * limits.minimum_speed.get(),
        };
        block.is_tangent = last.is_some_and(|last| is_tangent(last.exit.direction, envelope.primary));
        let cruise_before = last.map_or(cruise, |last| last.cruise(&self.overrides));
        let rest = least(limits.minimum_speed.get(), cruise);
        self.laser.begin_block(self.planner.pushed());
        // The queue was found to have room.
        self.last = Some(Last::new(&block, exit));
        let _pushed = self.planner.push(block, cruise_before, rest, &self.overrides);
        self.planned = request.target;
    }
}

/// Returns the axes that a curve moves, with a lower bound of each axis' movement.
fn ways_of_curve(path: &Path, delta: &PerAxis<f64>) -> PerAxis<f64> {
    let mut ways = *delta;
    let length = path.curve.length();
    for share in [0.25, 0.5, 0.75] {
        let offset = path.curve.offset(share * length);
        for (axis, part) in Axis::PRIMARY.into_iter().zip(offset) {
            ways[axis] = greatest(libm::fabs(ways[axis]), libm::fabs(part));
        }
    }
    ways
}

/// The limits of a straight move; `None` when nothing moves enough to count.
#[inline(always)]
fn envelope(
    config: &MotionConfig,
    from: &PerAxis<f64>,
    delta: &PerAxis<f64>,
    target: &PerAxis<f64>,
    over: &Over,
) -> Result<Option<Envelope>, Refusal> {
    let [x, y, z, ..] = delta.0;
    let length = square_root(x * x + y * y + z * z);
    let is_short = length < SMALLEST;
    if (is_short || config.kinematics.is_linear()) && *over == Over::NONE {
        return Ok(Envelope::new(delta, &ways_between(config, from, target), &config.limits));
    }
    let (start, way) = (over.skewed(from), over.skewed(delta));
    if !is_short && !config.kinematics.check_line(&start, &way, length, over) {
        return Err(Refusal::Unreachable);
    }
    let strain = if is_short { None } else { config.kinematics.strain(&start, &way, length, over) };
    let Some(strain) = strain else {
        return Ok(Envelope::new(delta, &ways_between(config, &start, &over.skewed(target)), &config.limits));
    };
    // The worst slope all along bounds the rest.
    let ways = PerActuator(strain.slope.0.map(|slope| slope * length));
    let mut envelope = Envelope::new(delta, &ways, &config.limits);
    if let Some(envelope) = &mut envelope {
        if let Some(lift) = &over.lift {
            envelope.limit_cartesian(&lift.on_top_of(&[x / length, y / length, z / length]), &config.limits);
        }
        envelope.limit_strain(&strain, &config.limits);
    }
    Ok(envelope)
}

/// The difference of two positions: for linear kinematics the same as the motors' way, without its rounding.
fn ways_between(config: &MotionConfig, from: &PerAxis<f64>, to: &PerAxis<f64>) -> PerActuator<f64> {
    let mut motors = config.kinematics.actuators(to);
    let before = config.kinematics.actuators(from);
    for actuator in Actuator::ALL {
        motors[actuator] -= before[actuator];
    }
    motors
}

/// Refuses numbers that mean nothing. `countable`: the distance from the origin, mm, within which the motors'
/// steps can surely be counted.
#[inline(always)]
fn check_request(
    config: &MotionConfig,
    compensation: &Compensation,
    countable: f64,
    request: &Move,
) -> Result<(), Refusal> {
    if !request.feed_rate.get().is_finite() {
        return Err(Refusal::NotFinite);
    }
    let tolerance = if let Corner::Rounded(tolerance) = request.corner { tolerance } else { 0.0 };
    if !(request.curve.is_sound() && tolerance.is_finite() && tolerance >= 0.0) {
        return Err(Refusal::NotFinite);
    }
    if request.feed_rate.get() <= 0.0 {
        return Err(Refusal::NoFeedRate);
    }
    let place = compensation.motors(&request.target);
    let is_near = place.0.iter().all(|part| libm::fabs(*part) < countable);
    if is_near || is_countable(config, &place) { Ok(()) } else { Err(Refusal::NotFinite) }
}

/// The steps of a curve's whole length can be counted. So can they then at each of its places, and the way
/// that braking takes is not lost in the rounding of a place on it.
fn countable_length(config: &MotionConfig, length: f64) -> Result<(), Refusal> {
    let steps = Actuator::ALL.into_iter().map(|actuator| length * config.steps_per_mm(actuator));
    if steps.fold(0.0, greatest) < MAX_STEPS { Ok(()) } else { Err(Refusal::NotFinite) }
}

/// Refuses a move of axes that have no motor.
fn no_orphan(orphans: AxisSet, delta: &PerAxis<f64>) -> Result<(), Refusal> {
    let moved = orphans.axes().find(|axis| libm::fabs(delta[*axis]) >= SMALLEST);
    moved.map_or(Ok(()), |axis| Err(Refusal::NoActuator(axis)))
}
