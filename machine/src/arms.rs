//! Machines with towers and arms: homing motor by motor, M665 and M666.
//!
//! Towers and arms home one by one, and until they have the kinematics mean nothing. So homing switches them off: each of X, Y
//! and Z is then the position of its own motor, mm or degrees. The motors' places at their switches follow from the homing
//! position of the tool (linear delta, SCARA) or are configured themselves (rotary delta).

use gcode::Block;
use motion::{Kinematics, MotionConfig};
use units::{Axis, Micros, MmPerSecond, PerActuator, PerAxis};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;
use crate::wait::yield_once;

/// What homing put aside while X, Y and Z are motors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotorSpace {
    kinematics: Kinematics,
    axis_speed: [Option<MmPerSecond>; 3],
    max_speed: Option<MmPerSecond>,
    /// Where each motor is when its switch fires, mm or degrees.
    pub home: PerAxis<f64>,
}

/// After a halt the step feed reports where the motors stand within a millisecond or two; much more is a fault.
const SETTLING_TIME: Micros = Micros::from_millis(100);

fn refuse(error: motion::ConfigError) -> Failure {
    Failure::Refused(message(format_args!("{error}")))
}

impl<P: Ports> Controller<P> {
    /// X, Y and Z home together, motor by motor.
    pub(crate) const fn homes_by_motor(&self) -> bool {
        let homing = &self.config.homing;
        homing.delta || homing.rotary_delta || homing.scara
    }

    pub(crate) fn motion_config(&mut self) -> Result<MotionConfig, Failure> {
        let config = self.ports.motion(|motion| motion.config().copied());
        config.ok_or_else(|| Failure::refused("motion is not configured"))
    }

    /// From now on X, Y and Z are the motors' own positions. Only while idle.
    pub(crate) fn enter_motor_space(&mut self) -> Result<(), Failure> {
        let config = self.motion_config()?;
        let space = MotorSpace {
            kinematics: config.kinematics,
            axis_speed: config.limits.axis_speed,
            max_speed: config.limits.max_speed,
            home: self.motor_homes(&config.kinematics),
        };
        let motors = config.kinematics.actuators(&self.position);
        let mut plain = MotionConfig { kinematics: Kinematics::Cartesian, ..config };
        // Limits of the tool are none of a motor; its own hold.
        plain.limits.axis_speed = [None; 3];
        plain.limits.max_speed = None;
        self.ports.motion(|motion| motion.configure(plain)).map_err(refuse)?;
        self.motor_space = Some(space);
        self.set_machine_position(PerAxis(motors.0))
    }

    /// X, Y and Z are the tool's again, at the place that the motors' positions mean.
    pub(crate) async fn leave_motor_space(&mut self) -> Result<(), Failure> {
        let Some(space) = self.motor_space.take() else { return Ok(()) };
        self.come_to_rest().await;
        let mut config = self.motion_config()?;
        config.kinematics = space.kinematics;
        config.limits.axis_speed = space.axis_speed;
        config.limits.max_speed = space.max_speed;
        let motors = self.ports.motion(|motion| motion.commanded_position());
        self.ports.motion(|motion| motion.configure(config)).map_err(refuse)?;
        self.set_machine_position(space.kinematics.point(&PerActuator(motors.0)))
    }

    /// Waits for standstill after something went wrong, halt or not.
    pub(crate) async fn come_to_rest(&mut self) {
        let since = self.ports.now();
        while !self.ports.motion(|motion| motion.is_idle()) && self.ports.now().since(since) < SETTLING_TIME {
            self.serve();
            yield_once().await;
        }
    }

    /// Where the tool of a linear delta is with every carriage at its switch, were there no trims.
    pub(crate) fn delta_home(&self) -> PerAxis<f64> {
        let stop = self.config.homing_endstop(Axis::Z).map_or(0.0, |stop| stop.homing_position.0);
        // With all carriages at the top the tool is in the middle.
        let mut place = PerAxis([0.0; units::MAX_AXES]);
        place[Axis::Z] = stop + self.home_offset[Axis::Z];
        place
    }

    /// Where the motors are at their switches. A trim is the part of the way that a switch sits too low.
    fn motor_homes(&self, kinematics: &Kinematics) -> PerAxis<f64> {
        let stop = |axis: Axis| self.config.homing_endstop(axis).map_or(0.0, |stop| stop.homing_position.0);
        let mut place = PerAxis([0.0; units::MAX_AXES]);
        for axis in Axis::ALL {
            place[axis] = stop(axis) + self.home_offset[axis];
        }
        let homing = &self.config.homing;
        if homing.rotary_delta {
            return place;
        }
        if homing.delta {
            let home = self.delta_home();
            Axis::PRIMARY.into_iter().for_each(|axis| place[axis] = home[axis]);
        }
        let mut motors = PerAxis(kinematics.actuators(&place).0);
        for (axis, trim) in Axis::PRIMARY.into_iter().zip(homing.trim) {
            motors[axis] -= trim.0;
        }
        motors
    }

    /// M665: parameters of the arms, Z of the homing position, S and U for cutting lines.
    pub(crate) async fn arm_code(&mut self, block: &Block<'_>) -> Outcome {
        self.wait_idle().await?;
        let config = self.motion_config()?;
        let mut parameters = config.kinematics.parameters();
        for (letter, _) in config.kinematics.parameters().iter() {
            if let Some(value) = block.get(letter) {
                parameters.set(letter, value);
            }
        }
        if parameters != config.kinematics.parameters() {
            self.change_arms(config, config.kinematics.with_parameters(&parameters))?;
        }
        self.set_home_height(block);
        self.set_line_cutting(block);
        for (letter, value) in parameters.iter() {
            self.say(format_args!("{letter}: {value:8.4} "));
        }
        self.say(format_args!("\n"));
        Ok(Answer::Ok)
    }

    /// The motors stay where they are; what that means for the tool is worked out anew.
    pub(crate) fn change_arms(&mut self, config: MotionConfig, kinematics: Kinematics) -> Result<(), Failure> {
        let place = self.position;
        let motors = self.ports.motion(|motion| config.kinematics.actuators(&motion.compensation().motors(&place)));
        self.ports.motion(|motion| motion.configure(MotionConfig { kinematics, ..config })).map_err(refuse)?;
        let place = self.ports.motion(|motion| motion.compensation().program(&kinematics.point(&motors)));
        self.set_machine_position(place)
    }

    fn set_home_height(&mut self, block: &Block<'_>) {
        let by_tool = self.config.homing.delta || self.config.homing.scara;
        let Some(height) = block.get('Z').filter(|_| by_tool) else { return };
        let is_home = |stop: &&mut config::EndstopConfig| {
            stop.axis == Some(Axis::Z) && stop.homing_direction != config::HomingDirection::None
        };
        if let Some(stop) = self.config.endstops.iter_mut().find(is_home) {
            stop.homing_position = units::Mm(height);
        }
    }

    fn set_line_cutting(&mut self, block: &Block<'_>) {
        let motion = &mut self.config.motion;
        if let Some(rate) = block.get('S') {
            motion.segments_per_second = (rate > 1.0).then_some(rate);
        }
        if let Some(length) = block.get('U') {
            motion.segments_per_second = None;
            motion.mm_per_line_segment = (length >= 1e-4).then_some(units::Mm(length));
        }
    }

    /// M666: trims of the towers or arms, from the next homing on.
    pub(crate) fn trim_code(&mut self, block: &Block<'_>) -> Outcome {
        for (axis, trim) in Axis::PRIMARY.into_iter().zip(&mut self.config.homing.trim) {
            if let Some(mm) = block.get(axis.letter()) {
                *trim = units::Mm(mm);
            }
        }
        let [x, y, z] = self.config.homing.trim.map(|trim| trim.0);
        self.say(format_args!("X: {x:5.4} Y: {y:5.4} Z: {z:5.4}\n"));
        Ok(Answer::Ok)
    }

    /// The lines M500 saves of this.
    pub(crate) fn write_arms(&mut self, text: &mut impl core::fmt::Write) -> core::fmt::Result {
        let Ok(config) = self.motion_config() else { return Ok(()) };
        if config.kinematics.parameters().iter().next().is_some() {
            write!(text, ";Arm solution:\nM665")?;
            for (letter, value) in config.kinematics.parameters().iter() {
                write!(text, " {letter}{value:.5}")?;
            }
            writeln!(text)?;
        }
        if self.homes_by_motor() {
            let [x, y, z] = self.config.homing.trim.map(|trim| trim.0);
            writeln!(text, ";Trim:\nM666 X{x:.5} Y{y:.5} Z{z:.5}")?;
        }
        let by_tool = self.config.homing.delta || self.config.homing.scara;
        if let Some(stop) = self.config.homing_endstop(Axis::Z).filter(|_| by_tool) {
            writeln!(text, ";Homing height:\nM665 Z{:.5}", stop.homing_position.0)?;
        }
        Ok(())
    }

    /// A move out of reach halts, unless the configuration says otherwise.
    pub(crate) const fn halts_out_of_reach(&self) -> bool {
        let arms = &self.config.motion.arms;
        match self.config.motion.arm_solution {
            config::ArmSolution::LinearDelta => arms.linear_delta.halt_on_error,
            config::ArmSolution::RotaryDelta => arms.rotary_delta.halt_on_error,
            _ => true,
        }
    }
}
