//! Homing motor by motor, with the kinematics switched off.
//!
//! Towers and arms home separately, and until all are homed the kinematics mean nothing. So homing switches
//! them off: each of X, Y and Z is then the position of its own motor, mm or degrees. The motors' places at
//! their switches follow from the homing position of the tool (linear delta, SCARA) or are configured
//! themselves (rotary delta).

use base::failure::Failure;
use base::ports::Wake;
use base::tuning::Tuning;
use config::MachineConfig;
use motion::{Kinematics, MotionConfig};
use units::{Axis, Micros, MmPerSecond, PerActuator, PerAxis};

use super::switch_places;
use crate::arms;
use crate::endstop_phase::PhaseHands;

/// Time in which any motion comes to rest: a halt brakes for a second at most, and tries to cut for another.
const SETTLING_TIME: Micros = Micros::from_seconds(3);

/// Settings in force before X, Y and Z became motors.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotorSpace {
    kinematics: Kinematics,
    axis_speed: [Option<MmPerSecond>; 3],
    max_speed: Option<MmPerSecond>,
    switches: PerAxis<f64>,
}

impl MotorSpace {
    /// Makes X, Y and Z the motors' own positions. Only while idle. The returned space must be left with
    /// [`Self::leave`].
    pub(super) fn enter<'c>(hands: &mut impl PhaseHands<'c>) -> Result<Self, Failure> {
        let config = hands.motion_config()?;
        let machine = hands.config();
        let space = Self {
            kinematics: config.kinematics,
            axis_speed: config.limits.axis_speed,
            max_speed: config.limits.max_speed,
            switches: motor_places(machine, hands.tuning(), &config.kinematics),
        };
        let motors = config.kinematics.actuators(&hands.position());
        let mut plain = MotionConfig { kinematics: Kinematics::Cartesian, ..config };
        // The tool's limits do not apply to a motor; the motors' own hold.
        plain.limits.axis_speed = [None; 3];
        plain.limits.max_speed = None;
        hands.motion(|motion| motion.configure(plain)).map_err(|error| hands.texts().refusal(error))?;
        if let Err(failure) = hands.set_position(PerAxis(motors.0)) {
            // The configuration was in force a moment ago, so it is accepted again.
            let _ = hands.motion(|motion| motion.configure(config));
            return Err(failure);
        }
        Ok(space)
    }

    /// Returns the position of each motor when its switch closes, mm or degrees.
    pub(super) const fn switches(&self) -> PerAxis<f64> {
        self.switches
    }

    /// Makes X, Y and Z the tool's again, at the place that the motors' positions mean. Waits for standstill,
    /// halt or not.
    pub(super) fn leave<'c>(self, hands: &mut impl PhaseHands<'c>) -> Result<(), Failure> {
        come_to_rest(hands);
        let mut config = hands.motion_config()?;
        config.kinematics = self.kinematics;
        config.limits.axis_speed = self.axis_speed;
        config.limits.max_speed = self.max_speed;
        let motors = hands.position();
        if let Err(error) = hands.motion(|motion| motion.configure(config)) {
            hands.axes().forget_all_homed();
            return Err(hands.texts().alarm(format_args!("the kinematics are still off: reset the machine ({error})")));
        }
        hands.set_position(self.kinematics.point(&PerActuator(motors.0)))
    }
}

/// Waits for standstill after a failure, halt or not; no longer than any halt takes.
pub fn come_to_rest<'c>(hands: &mut impl PhaseHands<'c>) {
    let since = hands.now();
    while !hands.motion(|motion| motion.is_idle()) && hands.now().since(since) < SETTLING_TIME {
        hands.wait(Wake::Any).whatever_happens();
    }
}

/// Returns the positions of the motors at their switches. A trim is the part of the way that a switch sits
/// too low.
fn motor_places(config: &MachineConfig, tuning: &Tuning, kinematics: &Kinematics) -> PerAxis<f64> {
    let mut place = switch_places(config, tuning);
    if config.homing.rotary_delta {
        return place;
    }
    if config.homing.delta {
        let home = arms::delta_home(config, tuning);
        Axis::PRIMARY.into_iter().for_each(|axis| place[axis] = home[axis]);
    }
    let mut motors = PerAxis(kinematics.actuators(&place).0);
    for (axis, trim) in Axis::PRIMARY.into_iter().zip(tuning.trim()) {
        motors[axis] -= trim;
    }
    motors
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::kinematics::{LinearDelta, LinearDeltaGeometry};
    use units::Mm;

    fn tower(axis: Axis, letter: &str) -> config::EndstopConfig {
        config::EndstopConfig {
            name: letter.try_into().unwrap(),
            axis: Some(axis),
            homing_direction: config::HomingDirection::ToMax,
            homing_position: Mm(250.0),
            ..config::EndstopConfig::default()
        }
    }

    #[test]
    fn a_trim_lowers_one_tower_and_the_middle_is_at_the_homing_height() {
        let mut config = MachineConfig::default();
        config.homing.delta = true;
        for (axis, letter) in Axis::PRIMARY.into_iter().zip(["x", "y", "z"]) {
            config.endstops.push(tower(axis, letter)).unwrap();
        }
        let delta = Kinematics::LinearDelta(LinearDelta::new(LinearDeltaGeometry {
            arm_length: 250.0,
            arm_offset: [0.0; 3],
            arm_radius: 124.0,
            tower_offset: [0.0; 3],
            tower_angle: [0.0; 3],
        }));
        let mut tuning = Tuning::new(&config);
        let motors = motor_places(&config, &tuning, &delta);
        let tool = delta.point(&PerActuator(motors.0));
        assert!(tool[Axis::X].abs() < 1e-9 && (tool[Axis::Z] - 250.0).abs() < 1e-9, "{tool:?}");
        tuning.set_trim([0.0, 0.5, 0.0]);
        tuning.set_home_offset(Axis::Z, 1.0);
        let trimmed = motor_places(&config, &tuning, &delta);
        let raised = [1.0, 0.5, 1.0];
        for (axis, by) in Axis::PRIMARY.into_iter().zip(raised) {
            assert!((trimmed[axis] - motors[axis] - by).abs() < 1e-9, "{axis:?}: {trimmed:?}");
        }
    }
}
