//! Speed, acceleration, step and pressure advance settings at run time: M92, M203, M204, M205, M220, M900.

use gcode::{Block, Code};
use motion::{ConfigError, Limits, MotionConfig};
use units::{Actuator, Axis, Mm, MmPerSecond, MmPerSecond2};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;

/// Bounds of the speed factor, percent.
const FACTOR_PERCENT: core::ops::RangeInclusive<f64> = 10.0..=1_000.0;
/// An overall speed limit up to this, mm/s, means none.
const NO_LIMIT: f64 = 0.1;

fn motors() -> impl Iterator<Item = (Axis, Actuator)> {
    Axis::ALL.into_iter().zip(Actuator::ALL)
}

impl<P: Ports> Controller<P> {
    /// M203, M203.1, M204, M205, M220.
    pub(crate) fn limits_code(&mut self, code: Code, block: &Block<'_>) -> Outcome {
        if code.number == 220 {
            return self.speed_factor(block);
        }
        let Some(mut limits) = self.ports.motion(|motion| motion.config().map(|config| config.limits)) else {
            return Err(Failure::refused("motion is not configured"));
        };
        if block.is_bare() && code.number == 203 {
            self.report_speeds(&limits, code.subcode == 1);
            return Ok(Answer::Ok);
        }
        match (code.number, code.subcode) {
            (203, 0) if block.has('V') => {
                return Err(Failure::refused("M203 V: a limit of the flow is not supported yet"));
            }
            (203, 0) => self.set_speeds(&mut limits, block)?,
            (203, _) => {
                for (axis, motor) in motors() {
                    let rate = &mut limits.actuator_rate[motor];
                    *rate = block.get(axis.letter()).map_or(*rate, MmPerSecond);
                }
            }
            (204, _) => self.set_accelerations(&mut limits, block)?,
            _ => set_corners(&mut limits, block),
        }
        self.ports.motion(|motion| motion.set_limits(limits)).map_err(refuse)?;
        Ok(Answer::Ok)
    }

    /// P is the overall limit, beside E the number of an extruder.
    fn set_speeds(&mut self, limits: &mut Limits, block: &Block<'_>) -> Result<(), Failure> {
        for (axis, limit) in Axis::PRIMARY.into_iter().zip(&mut limits.axis_speed) {
            if let Some(speed) = block.get(axis.letter()) {
                *limit = (speed > 0.0).then_some(MmPerSecond(speed));
            }
        }
        if let Some(speed) = block.get('P').filter(|_| !block.has('E')) {
            limits.max_speed = (speed > NO_LIMIT).then_some(MmPerSecond(speed));
        }
        if let Some(speed) = block.get('S').filter(|_| self.config.motion.compliant_seek_rate) {
            self.modal.seek_rate = MmPerSecond(speed);
        }
        if let Some((motor, speed)) = self.extruder_word(block)? {
            limits.actuator_rate[motor] = MmPerSecond(speed);
        }
        Ok(())
    }

    fn set_accelerations(&self, limits: &mut Limits, block: &Block<'_>) -> Result<(), Failure> {
        if let Some(acceleration) = block.get('S') {
            limits.acceleration = MmPerSecond2(if acceleration < 1.0 { 1.0 } else { acceleration });
        }
        let own = |acceleration: f64| (acceleration > 0.0).then_some(MmPerSecond2(acceleration));
        for (axis, motor) in motors() {
            if let Some(acceleration) = block.get(axis.letter()) {
                limits.actuator_acceleration[motor] = own(acceleration);
            }
        }
        if let Some((motor, acceleration)) = self.extruder_word(block)? {
            limits.actuator_acceleration[motor] = own(acceleration);
        }
        Ok(())
    }

    /// The value of E, and the motor it is for: of the extruder in use, or of tool P.
    fn extruder_word(&self, block: &Block<'_>) -> Result<Option<(Actuator, f64)>, Failure> {
        let Some(value) = block.get('E') else { return Ok(None) };
        let axis = self.tools.selected(block.get('P'))?.axis;
        Ok(Actuator::from_index(axis as usize).map(|motor| (motor, value)))
    }

    fn report_speeds(&mut self, limits: &Limits, of_motors: bool) {
        if of_motors {
            let turned = |axis: Axis| self.tools.uses(axis);
            for (axis, motor) in motors().filter(|(axis, m)| self.config.actuators[*m].present && !turned(*axis)) {
                self.consoles
                    .write(self.target, format_args!(" {}:{:.6} ", axis.letter(), limits.actuator_rate[motor].0));
            }
        } else {
            for (axis, limit) in Axis::PRIMARY.into_iter().zip(limits.axis_speed) {
                self.say(format_args!(" {}:{:.6} ", axis.letter(), limit.map_or(0.0, |limit| limit.0)));
            }
            let (seek, most) = (self.modal.seek_rate.0, limits.max_speed.map_or(0.0, |limit| limit.0));
            self.say(format_args!(" S:{seek:.6} P:{most:.6} "));
            if let Some(motor) = self.tools.active().and_then(|tool| Actuator::from_index(tool.axis as usize)) {
                let rate = limits.actuator_rate[motor].0;
                self.say(format_args!("E:{rate:.6} "));
            }
        }
        self.say(format_args!("\n"));
    }

    /// M220: scales all speeds.
    fn speed_factor(&mut self, block: &Block<'_>) -> Outcome {
        match block.get('S') {
            Some(percent) => {
                let factor = percent.clamp(*FACTOR_PERCENT.start(), *FACTOR_PERCENT.end()) / 100.0;
                self.ports.motion(|motion| motion.set_overrides(factor, factor));
            }
            None => {
                let percent = self.ports.motion(|motion| motion.overrides().feed) * 100.0;
                self.say(format_args!("Speed factor at {percent:6.2} %\n"));
            }
        }
        Ok(Answer::Ok)
    }

    /// M92: steps per mm. Waits for standstill, since the meaning of every step changes.
    pub(crate) async fn steps_per_mm_code(&mut self, block: &Block<'_>) -> Outcome {
        if !block.is_bare() {
            self.wait_idle().await?;
            let config = self.ports.motion(|motion| motion.config().copied());
            let mut config = config.ok_or_else(|| Failure::refused("motion is not configured"))?;
            self.set_steps(&mut config, block)?;
            self.ports.motion(|motion| motion.configure(config)).map_err(refuse)?;
        }
        let config = self.ports.motion(|motion| motion.config().copied());
        let steps = |motor: Actuator| config.and_then(|config| config.actuators[motor]).map(|motor| motor.steps_per_mm);
        for (axis, motor) in motors() {
            if let Some(steps) = steps(motor).filter(|_| !self.tools.uses(axis)) {
                self.say(format_args!("{}:{steps:.6} ", axis.letter()));
            }
        }
        let e_motor = self.tools.active().and_then(|tool| Actuator::from_index(tool.axis as usize));
        if let Some(steps) = e_motor.and_then(steps) {
            self.say(format_args!("E:{steps:.6} "));
        }
        self.say(format_args!("\n"));
        Ok(Answer::Ok)
    }

    /// M900 K: pressure advance of the tool in use, or of tool P, in seconds. Waits for standstill, since the filters change.
    pub(crate) async fn pressure_advance_code(&mut self, block: &Block<'_>) -> Outcome {
        let index = advance_of(self.tools.selected(block.get('P'))?.axis);
        if let Some(factor) = block.get('K') {
            self.wait_idle().await?;
            let config = self.ports.motion(|motion| motion.config().copied());
            let mut config = config.ok_or_else(|| Failure::refused("motion is not configured"))?;
            let Some(Some(advance)) = config.filters.advance.get_mut(index) else {
                return Err(Failure::refused("this extruder has no pressure advance"));
            };
            advance.factor = factor;
            self.ports.motion(|motion| motion.configure(config)).map_err(refuse)?;
            return Ok(Answer::Ok);
        }
        let advance =
            self.ports.motion(|motion| motion.config().and_then(|config| config.filters.advance.get(index).copied()));
        if let Some(Some(advance)) = advance {
            self.say(format_args!("K:{:.4} smooth time:{:.4}\n", advance.factor, advance.smooth_time));
        }
        Ok(Answer::Ok)
    }

    fn set_steps(&self, config: &mut MotionConfig, block: &Block<'_>) -> Result<(), Failure> {
        for (axis, motor) in motors() {
            let (Some(actuator), Some(steps)) = (&mut config.actuators[motor], block.get(axis.letter())) else {
                continue;
            };
            // Steps per inch, when the program counts in inches.
            let per_mm = if axis.is_primary() && self.modal.inches { steps / crate::modal::MM_PER_INCH } else { steps };
            actuator.steps_per_mm = per_mm;
        }
        if let Some((motor, steps)) = self.extruder_word(block)?
            && let Some(actuator) = &mut config.actuators[motor]
        {
            actuator.steps_per_mm = steps;
        }
        Ok(())
    }
}

/// Where an extruder's pressure advance is among the filters: tools turn A, B and C, in this order.
pub(crate) const fn advance_of(axis: Axis) -> usize {
    (axis as usize).saturating_sub(Axis::PRIMARY.len())
}

fn refuse(error: ConfigError) -> Failure {
    Failure::Refused(message(format_args!("{error}")))
}

fn set_corners(limits: &mut Limits, block: &Block<'_>) {
    if let Some(deviation) = block.get('X') {
        limits.junction_deviation = Mm(deviation);
        // It counts from now on.
        limits.square_corner_velocity = None;
    }
    if let Some(deviation) = block.get('Z') {
        limits.z_junction_deviation = (deviation >= 0.0).then_some(Mm(deviation));
    }
    if let Some(speed) = block.get('S') {
        limits.minimum_speed = MmPerSecond(speed);
    }
}
