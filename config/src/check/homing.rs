//! Checks of endstops and the probe.

use super::findings::Checks;
use crate::machine::{ActuatorConfig, ArmSolution, EndstopConfig, HomingDirection};
use crate::suggest::at_most;
use units::{Actuator, Axis, Mm};

const ENDSTOPS: &str = "endstops";
/// A probe that is pressed further than this past its contact may be out of its travel, mm.
const DEEPEST_PRESS: f64 = 0.5;
/// Overtravel of a carriage beyond its switch that is acceptable, mm; the levers of common switches give way
/// by 0.3.
const RUN_ON: f64 = 0.25;
/// Two switches on pins of one number (PD0 and PI0) share the chip's edge detector; one of them is then read
/// at each run of the step feed, seconds apart.
const SWITCH_PERIOD: f64 = 0.5e-3;
/// Lead of the written steps, seconds.
const WRITTEN_AHEAD: f64 = 1.5e-3;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, stop) in config.endstops.iter().enumerate().filter(|(_, stop)| stop.enable) {
        switch(checks, place, stop);
        for (other_place, other) in config.endstops.iter().enumerate().filter(|(_, stop)| stop.enable) {
            if other_place < place && other.axis == stop.axis {
                pair(checks, place, stop, other);
            }
        }
    }
    safe_z(checks);
    if config.probe.enable {
        probe(checks);
    }
    if config.safety_door.enable && config.safety_door.pin.is_none() {
        checks.error(("safety door", 0, "pin"), format_args!("the safety door needs a pin"), format_args!("write one"));
    }
    if config.kill_button.enable && config.kill_button.pin.is_none() {
        checks.error(("kill button", 0, "pin"), format_args!("the kill button needs a pin"), format_args!("write one"));
    }
}

/// Checks that X and Y are known at the position for homing Z.
fn safe_z(checks: &mut Checks<'_, '_>) {
    let homing = &checks.config.homing;
    let keys = ["common.safe_z_x", "common.safe_z_y"];
    let Some(key) = keys.into_iter().zip(homing.safe_z).find_map(|(key, place)| place.map(|_| key)) else { return };
    let key = key.trim_start_matches("common.");
    if homing.delta || homing.rotary_delta || homing.scara {
        let reason = format_args!("towers and arms home together");
        return checks.error((ENDSTOPS, 0, key), reason, format_args!("delete it"));
    }
    let place = |axis| homing.order.iter().position(|homed| *homed == axis);
    let z_is_late = match place(Axis::Z) {
        Some(z) => [Axis::X, Axis::Y].into_iter().all(|axis| place(axis).is_none_or(|place| place < z)),
        None => !homing.z_first,
    };
    if !z_is_late {
        let reason = format_args!("Z homes before X and Y, and cannot go there");
        checks.error((ENDSTOPS, 0, key), reason, format_args!("delete it, or have Z home last"));
    }
}

fn probe(checks: &mut Checks<'_, '_>) {
    const SECTION: &str = "zprobe";
    let config = checks.config;
    let probe = &config.probe;
    if probe.pin.is_none() {
        let reason = format_args!("the probe needs a pin");
        checks.error((SECTION, 0, "probe_pin"), reason, format_args!("write one; the board's probe connector is PB10"));
    }
    if probe.slow_rate > probe.fast_rate {
        let reason = format_args!("the search is faster than the travel between the points");
        checks.warn((SECTION, 0, "slow_feedrate"), reason, format_args!("write less than fast_feedrate"));
    }
    let [deploy, stow] = &config.probe_scripts;
    if deploy.is_empty() != stow.is_empty() {
        let (missing, given) =
            if deploy.is_empty() { ("deploy_gcode", "stow_gcode") } else { ("stow_gcode", "deploy_gcode") };
        let reason = format_args!("{given} moves the probe, and nothing moves it back");
        checks.error((SECTION, 0, given), reason, format_args!("write {missing} too"));
    }
    if probe.deployed_pin.is_some() && probe.stowed_reads_triggered {
        let reason = format_args!("both deployed_pin and this tell whether the probe is out");
        checks.error((SECTION, 0, "stowed_reads_triggered"), reason, format_args!("keep one of them"));
    }
    let probes_points = config.leveling.strategy.is_some() || config.delta_calibration.enable;
    if probes_points && probe.height == Mm(0.0) {
        let reason = format_args!("the probe would stay in touch on its way from point to point");
        checks.error((SECTION, 0, "probe_height"), reason, format_args!("write how far to lift it, in mm"));
    }
    if config.delta_calibration.enable && config.motion.arm_solution != ArmSolution::LinearDelta {
        let reason = format_args!("only a linear delta can be calibrated");
        checks.error((SECTION, 0, "calibration"), reason, format_args!("leave it out"));
    }
    let motor = &config.actuators[Actuator::Gamma];
    // The motor takes no more than its own limit, so that is the speed it would have to brake from.
    let speed = if probe.slow_rate < motor.max_rate { probe.slow_rate.get() } else { motor.max_rate.get() };
    let acceleration = motor.acceleration.unwrap_or(config.motion.default_acceleration).get();
    let past = speed * speed / (2.0 * acceleration);
    if motor.present && past > DEEPEST_PRESS {
        let reason = format_args!("the probe is pressed {past:.2} mm past its contact while the machine brakes");
        checks.warn((SECTION, 0, "slow_feedrate"), reason, format_args!("write less, or make sure it can give way"));
    }
}

fn switch(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig) {
    if stop.pin.is_none() {
        checks.error((ENDSTOPS, place, "pin"), format_args!("the endstop needs a pin"), format_args!("write one"));
    }
    let Some(axis) = stop.axis else {
        let reason = format_args!("the endstop does not say which axis it is for");
        return checks.error((ENDSTOPS, place, "axis"), reason, format_args!("write axis = X, Y, Z, A, B or C"));
    };
    let motor = Actuator::from_index(axis as usize).map(|actuator| &checks.config.actuators[actuator]);
    let Some(motor) = motor.filter(|motor| motor.present) else {
        let reason = format_args!("axis {} has no motor", axis.letter());
        return checks.error((ENDSTOPS, place, "axis"), reason, format_args!("name an axis that has one"));
    };
    if stop.homing_direction == HomingDirection::None {
        return;
    }
    // The towers of a delta home upwards, whatever their connectors are called.
    if !checks.config.homing.delta {
        direction_against_name(checks, place, stop);
    }
    direction_against_position(checks, place, stop);
    if stop.fast_rate > motor.max_rate {
        let reason = format_args!("{} mm/s is faster than the motor's max_rate", stop.fast_rate.get());
        checks.warn(
            (ENDSTOPS, place, "fast_rate"),
            reason,
            format_args!("write {} or less", at_most(motor.max_rate.get())),
        );
    }
    if stop.slow_rate > stop.fast_rate {
        let reason = format_args!("the second approach is faster than the first");
        checks.warn((ENDSTOPS, place, "slow_rate"), reason, format_args!("write less than fast_rate"));
    }
    if !stop.stall.homing {
        run_on(checks, place, stop, motor);
    }
}

/// Checks the overtravel of the carriage beyond the switch. The fast approach may stop at once, and does
/// where braking would take longer; the slow one measures, so its motor should not have to.
fn run_on(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig, motor: &ActuatorConfig) {
    if stop.fast_rate.get() * SWITCH_PERIOD > RUN_ON {
        let fastest = RUN_ON / SWITCH_PERIOD;
        let reason = format_args!("{:.0} mm/s may run past the switch by more than it gives way", stop.fast_rate.get());
        checks.error((ENDSTOPS, place, "fast_rate"), reason, format_args!("write {} mm/s or less", at_most(fastest)));
    }
    let acceleration = motor.acceleration.unwrap_or(checks.config.motion.default_acceleration).get();
    let slow = stop.slow_rate.get();
    let distance = slow * WRITTEN_AHEAD + slow * slow / (2.0 * acceleration);
    if distance > RUN_ON && stop.slow_rate <= stop.fast_rate {
        let reason = format_args!(
            "braking from {slow} mm/s takes {distance:.2} mm past the switch: the motor is stopped at once and may lose steps"
        );
        let fix = format_args!("write a lower slow_rate");
        checks.warn((ENDSTOPS, place, "slow_rate"), reason, fix);
    }
}

/// A switch called `minx` that is homed to upwards would drive the carriage into the other end.
fn direction_against_name(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig) {
    let has = |word: &[u8; 3]| stop.name.as_bytes().windows(3).any(|part| part == word);
    let wrong = match stop.homing_direction {
        HomingDirection::ToMax => has(b"min"),
        HomingDirection::ToMin => has(b"max"),
        HomingDirection::None => false,
    };
    if wrong {
        let reason = format_args!("the name '{}' and the direction contradict each other", stop.name);
        let fix = format_args!("check which end of the axis the switch is at");
        checks.warn((ENDSTOPS, place, "homing_direction"), reason, fix);
    }
}

/// A min switch at the far end of the coordinates, or a max switch at the near one: everything reachable lies
/// on the wrong side of it.
fn direction_against_position(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig) {
    let (far, end) = match stop.homing_direction {
        HomingDirection::ToMin => (stop.homing_position, "min"),
        HomingDirection::ToMax => (Mm(-stop.homing_position.get()), "max"),
        HomingDirection::None => return,
    };
    // Half the travel beyond zero is no shifted origin any more.
    if far.get() * 2.0 > stop.max_travel.get() {
        let letter = stop.axis.map_or('?', units::Axis::letter);
        let reason = format_args!("the {end} end of {letter} is said to be at {}", stop.homing_position);
        let fix = format_args!("check homing_direction: after homing the axis could only move further out");
        checks.warn((ENDSTOPS, place, "homing_position"), reason, fix);
    }
}

/// Checks two switches of one axis against each other.
fn pair(checks: &mut Checks<'_, '_>, place: usize, stop: &EndstopConfig, other: &EndstopConfig) {
    let Some(axis) = stop.axis else { return };
    if stop.homing_direction == HomingDirection::None || other.homing_direction == HomingDirection::None {
        return;
    }
    let letter = axis.letter();
    let reason = format_args!("{letter} homes to '{}' already", other.name);
    let fix = format_args!("write none for one of them; as a limit it works all the same");
    checks.error((ENDSTOPS, place, "homing_direction"), reason, fix);
    let (low, high) = match (stop.homing_direction, other.homing_direction) {
        (HomingDirection::ToMin, HomingDirection::ToMax) => (stop, other),
        (HomingDirection::ToMax, HomingDirection::ToMin) => (other, stop),
        _ => return,
    };
    if low.homing_position >= high.homing_position {
        let reason = format_args!(
            "{letter} is {} at the min end and {} at the max end",
            low.homing_position, high.homing_position
        );
        checks.error((ENDSTOPS, place, "homing_position"), reason, format_args!("the max end must be further"));
    }
}
