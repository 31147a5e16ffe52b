//! G28: find the endstops, fast and then slowly, and say exactly where the machine is.
//!
//! The position of a switch is that of the motors at the tick its input fired, which the latch keeps; the
//! braking after it costs nothing. A cycle for some axes: approach together at the fast rate, going on with
//! the others when one has hit; back off; approach again slowly; count from the second hit; move onto it. At
//! the end an axis whose switch is a limit too moves off it.
//!
//! Behind a switch there is little way. If braking would take more than that, the machine stops at once
//! instead: steps that a fast motor may lose in the first approach do not matter, for the second measures.

mod approach;
mod hits;
mod motor_space;
mod overtravel;
mod safe_z;
mod samples;
mod slaves;
mod stall;
mod switches;

use core::cell::Cell;

use base::failure::{Failure, FailureKind};
use base::safety::Event;
use base::tuning::Tuning;
use config::MachineConfig;
use motion::{Limits, Mode};
use units::{Axis, AxisSet, MmPerSecond, PerAxis};

use crate::arms;
use crate::endstop_phase::PhaseHands;

pub use hits::wait_trigger;
use motor_space::MotorSpace;
pub use motor_space::come_to_rest;
use samples::Samples;
pub use stall::steady;
use switches::{homeable, operated, slowest, switch_of, towards};

const XY: AxisSet = AxisSet::of(Axis::X).with(Axis::Y);

/// Homes these axes, or all that can be homed when none is named.
///
/// # Errors
/// A refusal when none of the axes can be homed, an alarm when a switch is not found where it should be.
pub fn home<'c>(hands: &mut impl PhaseHands<'c>, named: AxisSet) -> Result<(), Failure> {
    let homing = &hands.config().homing;
    let (tolerance, retries) = (homing.tolerance.0, homing.retries);
    let samples = Samples { count: homing.samples, tolerance, retries, tells_all: false, off: Cell::default() };
    home_with(hands, named, &samples)
}

/// Homes everything before a bed is measured. If lines of the configuration home, or a template stands for
/// G28, homing is not known to be safe without them, and they may hold any code: then the machine must
/// already have been homed by them.
///
/// # Errors
/// As [`home`]; a refusal when they have not been run.
pub fn home_before_probing<'c>(hands: &mut impl PhaseHands<'c>) -> Result<(), Failure> {
    let homing = &hands.config().homing;
    if homing.gcode.is_empty() && homing.z_gcode.is_empty() && !hands.homes_by_template() {
        return home(hands, AxisSet::NONE);
    }
    if hands.all_homed() {
        return Ok(());
    }
    Err(Failure::refused(&"home the machine with G28 first: home_gcode or [homing_override] may hold any code"))
}

/// Homes an axis with `count` slow approaches to its switch, and reports their agreement. Returns the
/// distance from its place at which the switch was found, mm.
///
/// # Errors
/// As [`home`].
pub fn measure<'c>(hands: &mut impl PhaseHands<'c>, axis: Axis, count: u8) -> Result<f64, Failure> {
    let samples = Samples { count, tolerance: f64::INFINITY, retries: 0, tells_all: true, off: Cell::default() };
    home_with(hands, AxisSet::of(axis), &samples)?;
    Ok(samples.off.get()[axis])
}

fn home_with<'c>(hands: &mut impl PhaseHands<'c>, named: AxisSet, samples: &Samples) -> Result<(), Failure> {
    let config = hands.config();
    let chosen = chosen(config, named);
    if chosen.is_empty() {
        return Err(Failure::refused(&"nothing to home: no endstop with a homing_direction for that"));
    }
    hands.standstill()?;
    hands.enable_motors()?;
    hands.apply(Event::HomingBegins);
    let mut homed = find_switches(hands, chosen, samples);
    if !homed.is_err_and(|failure| failure.is_alarm()) {
        // A hold may have come with the very last step, and homing would not end during it.
        homed = homed.and(hands.wait_while_held());
    }
    hands.apply(Event::HomingEnds);
    if hands.is_ended() {
        // Between two approaches no position is known for sure.
        hands.axes().forget_homed(chosen);
    }
    hands.end_suspension_without_place();
    if let Err(Failure { kind: FailureKind::Alarm, .. }) = homed {
        hands.axes().forget_all_homed();
        let word = if config.general.grbl_mode { "ALARM: Homing fail" } else { "ERROR: Homing cycle failed" };
        hands.announce(format_args!("{word}\n"));
    }
    homed?;
    move_to_origin(hands, chosen)?;
    leave_limits(hands, chosen)
}

/// Returns the machine's position after homing these axes from here, if every switch is where it should be,
/// mm.
pub fn ends_at(config: &MachineConfig, tuning: &Tuning, named: AxisSet, from: &PerAxis<f64>) -> PerAxis<f64> {
    let (chosen, places) = (chosen(config, named), switch_places(config, tuning));
    let mut place = *from;
    for axis in chosen.axes() {
        place[axis] = places[axis];
        if let Some((_, stop)) = switch_of(config, axis).filter(|(_, stop)| stop.limit_enable || stop.stall.homing) {
            place[axis] -= towards(stop) * stop.retract.0;
        }
    }
    if config.homing.ends_over_origin(chosen) {
        (place[Axis::X], place[Axis::Y]) = (0.0, 0.0);
        if config.homing.delta {
            place[Axis::Z] = places[Axis::Z] - switch_of(config, Axis::Z).map_or(0.0, |(_, stop)| stop.retract.0);
        }
    }
    place
}

/// Returns the direction of an axis to its switch, 1 or -1, and the speed of its last approach.
pub fn homing_switch(config: &MachineConfig, axis: Axis) -> Option<(f64, MmPerSecond)> {
    switch_of(config, axis).map(|(_, stop)| (towards(stop), stop.slow_rate))
}

/// Returns whether an axis may brake when its switch closes at this speed; else it must stop at once.
pub fn stops_in_time(rate: MmPerSecond, limits: &Limits, axis: Axis) -> bool {
    overtravel::brakes_in_time(rate, limits, core::iter::once(axis))
}

/// Returns the axes to home of those named, or all that can. Towers and arms home together.
pub fn chosen(config: &MachineConfig, named: AxisSet) -> AxisSet {
    let able = homeable(config);
    let chosen = if named.is_empty() { able } else { named.and(able) };
    if are_motors(config, chosen) { chosen.or(able.and(AxisSet::PRIMARY)) } else { chosen }
}

/// Returns whether towers or arms are among these axes.
fn are_motors(config: &MachineConfig, set: AxisSet) -> bool {
    arms::homes_by_motor(config) && !set.and(AxisSet::PRIMARY).is_empty()
}

/// Returns the positions of axes when their switches close, mm.
fn switch_places(config: &MachineConfig, tuning: &Tuning) -> PerAxis<f64> {
    PerAxis(Axis::ALL.map(|axis| tuning.homing_position(config, axis) + tuning.home_offset()[axis]))
}

/// Homes with the latch, the filters and the compensation out of the way, and always puts them back.
fn find_switches<'c>(hands: &mut impl PhaseHands<'c>, chosen: AxisSet, samples: &Samples) -> Result<(), Failure> {
    hands.suspend_limits();
    // Filters would delay the stop at a switch.
    hands.motion(|motion| motion.bypass_filters(true));
    // A switch is at a position of the motors, so the compensation is suspended.
    let was_suspended = hands.motion(|motion| motion.compensation().is_suspended());
    let suspended = hands.motion(|motion| motion.suspend_compensation(true));
    let homed = match suspended {
        Ok(()) => home_in_space(hands, chosen, samples),
        Err(busy) => Err(hands.texts().refused(format_args!("{busy}"))),
    };
    hands.motion(|motion| motion.bypass_filters(false));
    if !was_suspended {
        // A stop or a halt may still be coming to its end.
        come_to_rest(hands);
        let restored = hands.motion(|motion| motion.suspend_compensation(false));
        return homed.and(restored.map_err(|busy| hands.texts().alarm(format_args!("{busy}"))));
    }
    homed
}

/// Homes axes, or motors if the kinematics mean nothing before.
fn home_in_space<'c>(hands: &mut impl PhaseHands<'c>, chosen: AxisSet, samples: &Samples) -> Result<(), Failure> {
    let config = hands.config();
    if !are_motors(config, chosen) {
        let places = switch_places(config, hands.tuning());
        let homed = home_in_order(hands, chosen, &places, samples);
        hands.latch().disarm();
        return homed;
    }
    let space = MotorSpace::enter(hands)?;
    let homed = home_motors(hands, chosen, &space.switches(), samples);
    hands.latch().disarm();
    let left = space.leave(hands);
    homed.and(left)
}

fn home_motors<'c>(
    hands: &mut impl PhaseHands<'c>,
    chosen: AxisSet,
    places: &PerAxis<f64>,
    samples: &Samples,
) -> Result<(), Failure> {
    approach::cycle(hands, chosen.and(AxisSet::PRIMARY), places, samples)?;
    home_auxiliary(hands, chosen, places, samples)
}

fn home_in_order<'c>(
    hands: &mut impl PhaseHands<'c>,
    chosen: AxisSet,
    places: &PerAxis<f64>,
    samples: &Samples,
) -> Result<(), Failure> {
    let homing = &hands.config().homing;
    safe_z::lift(hands, chosen)?;
    if !homing.order.is_empty() {
        for axis in homing.order.iter().copied().filter(|axis| chosen.has(*axis)) {
            safe_z::before(hands, AxisSet::of(axis))?;
            approach::cycle(hands, AxisSet::of(axis), places, samples)?;
        }
        return Ok(());
    }
    let z = AxisSet::of(Axis::Z);
    let cycles = if homing.z_first { [z, XY] } else { [XY, z] };
    for cycle in cycles.map(|cycle| cycle.and(chosen)).into_iter().filter(|cycle| !cycle.is_empty()) {
        safe_z::before(hands, cycle)?;
        if homing.corexy || stall::is_used(hands.config(), cycle) {
            each_alone(hands, cycle, places, samples)?;
        } else {
            approach::cycle(hands, cycle, places, samples)?;
        }
    }
    home_auxiliary(hands, chosen, places, samples)
}

/// Homes A, B and C.
fn home_auxiliary<'c>(
    hands: &mut impl PhaseHands<'c>,
    chosen: AxisSet,
    places: &PerAxis<f64>,
    samples: &Samples,
) -> Result<(), Failure> {
    each_alone(hands, chosen.without(AxisSet::PRIMARY), places, samples)
}

fn each_alone<'c>(
    hands: &mut impl PhaseHands<'c>,
    set: AxisSet,
    places: &PerAxis<f64>,
    samples: &Samples,
) -> Result<(), Failure> {
    for axis in set.axes() {
        approach::cycle(hands, AxisSet::of(axis), places, samples)?;
    }
    Ok(())
}

fn move_to_origin<'c>(hands: &mut impl PhaseHands<'c>, chosen: AxisSet) -> Result<(), Failure> {
    let config = hands.config();
    if !config.homing.ends_over_origin(chosen) {
        return Ok(());
    }
    let rate = slowest(config, XY, |stop| stop.fast_rate);
    let mut target = hands.position();
    (target[Axis::X], target[Axis::Y]) = (0.0, 0.0);
    if config.homing.delta {
        // The tool goes down from the switches first of all, or a switch would be operated in the middle.
        target[Axis::Z] -= switch_of(config, Axis::Z).map_or(0.0, |(_, stop)| stop.retract.0);
    }
    hands.go_there(target, rate)
}

/// Moves axes off switches that are limits by `retract`: such a switch cannot guard while it is operated.
fn leave_limits<'c>(hands: &mut impl PhaseHands<'c>, chosen: AxisSet) -> Result<(), Failure> {
    let config = hands.config();
    let is_limit = |axis: &Axis| switch_of(config, *axis).is_some_and(|(_, stop)| stop.limit_enable);
    let on = operated(config, hands.inputs(), AxisSet::collect(chosen.axes().filter(is_limit)));
    if on.is_empty() {
        return Ok(());
    }
    let rate = slowest(config, on, |stop| stop.slow_rate);
    let here = hands.position();
    let mut target = here;
    for axis in on.axes() {
        let away = switch_of(config, axis).map_or(0.0, |(_, stop)| -towards(stop) * stop.retract.0);
        if are_motors(config, AxisSet::of(axis)) {
            // Going down leaves the switches of all towers.
            target[Axis::Z] = here[Axis::Z] + away;
        } else {
            target[axis] += away;
        }
    }
    hands.go(target, rate, Mode::Feed)?;
    hands.standstill()
}

#[cfg(test)]
mod tests;
