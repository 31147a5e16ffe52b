//! Motor current: on before a move, off on request, its strength, and what the drivers say.

use core::fmt::Write;

use gcode::Block;
use units::{Actuator, Amps, Axis, Micros};

use crate::boot::internal_motors;
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::{DriverFault, MotorDrivers, Ports};
use crate::state::State;

/// The motor that a letter names: X Y Z A B C are alpha to zeta.
fn motor_of(letter: char) -> Option<Actuator> {
    Axis::from_letter(letter).and_then(|axis| Actuator::from_index(axis as usize))
}

impl<P: Ports> Controller<P> {
    /// Gives every motor its current, unless it has it. Refused without motor supply.
    pub(crate) fn enable_motors(&mut self) -> Result<(), Failure> {
        let wanted = self.config.actuators().fold(0, |bits, (motor, _)| bits | motor.bit());
        if self.motors_on == wanted {
            return self.restore_current();
        }
        if internal_motors(&self.config) != 0 && !self.ports.supervisor(|supervisor| supervisor.motor_supply_on()) {
            return Err(Failure::alarm("motor supply is off (vmotor below 6 V): switch it on, then M999"));
        }
        self.ports.set_motor_power(true);
        for motor in Actuator::ALL.into_iter().filter(|motor| wanted & motor.bit() != 0) {
            match self.ports.drivers(|drivers| drivers.set_enabled(motor, true)) {
                Ok(()) | Err(DriverFault::External) => self.motors_on |= motor.bit(),
                Err(DriverFault::Silent | DriverFault::BadAnswer) => {
                    let text =
                        format_args!("motor driver {} does not answer, check its supply and wiring", motor.name());
                    return Err(Failure::Alarm(message(text)));
                }
            }
        }
        self.restore_current()
    }

    /// Standing still for `standstill_time` brings motors to their standstill current.
    pub(crate) fn watch_standstill(&mut self, now: Micros) {
        if self.state != State::Idle {
            self.standing_since = now;
            return;
        }
        let standing = self.motors_on & !self.resting_motors;
        for motor in Actuator::ALL.into_iter().filter(|motor| standing & motor.bit() != 0) {
            let Some(current) = self.config.driver(motor).and_then(|driver| driver.standstill_current) else {
                continue;
            };
            let family = self.config.driver_family(self.config.actuators[motor].driver);
            let time = family.map_or(Micros(0), |family| family.standstill_time);
            if now.since(self.standing_since) >= time
                && self.ports.drivers(|drivers| drivers.set_current(motor, current)).is_ok()
            {
                self.resting_motors |= motor.bit();
            }
        }
    }

    /// Full current again for motors that were resting.
    fn restore_current(&mut self) -> Result<(), Failure> {
        let resting = self.resting_motors;
        for motor in Actuator::ALL.into_iter().filter(|motor| resting & motor.bit() != 0) {
            self.resting_motors &= !motor.bit();
            let Some(current) = self.config.actuators[motor].current else { continue };
            if self.ports.drivers(|drivers| drivers.set_current(motor, current)).is_err() {
                let text = format_args!("motor driver {} does not answer, check its supply and wiring", motor.name());
                return Err(Failure::Alarm(message(text)));
            }
        }
        self.standing_since = self.ports.now();
        Ok(())
    }

    /// Takes the current off all motors. Errors are left to the supervisor: a driver that does not answer cannot be
    /// switched off over its bus; the global enable line does it.
    pub(crate) fn motors_off(&mut self) {
        for (motor, _) in self.config.actuators() {
            let _ = self.ports.drivers(|drivers| drivers.set_enabled(motor, false));
        }
        self.motors_on = 0;
    }

    /// M17, M18, M84.
    pub(crate) async fn motor_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        if number == 17 {
            self.enable_motors()?;
            return Ok(Answer::Ok);
        }
        self.wait_idle().await?;
        let e_axis = self.tools.active().map(|tool| tool.axis).filter(|_| block.has('E'));
        let named = |axis: Axis| block.has(axis.letter()) || e_axis == Some(axis);
        let all = !Axis::ALL.into_iter().any(named);
        for axis in Axis::ALL.into_iter().filter(|axis| all || named(*axis)) {
            let Some(motor) = Actuator::from_index(axis as usize) else { continue };
            // See motors_off.
            let _ = self.ports.drivers(|drivers| drivers.set_enabled(motor, false));
            self.motors_on &= !motor.bit();
            self.homed &= !(1 << axis as u8);
        }
        Ok(Answer::Ok)
    }

    /// M906 in mA, M907 in A.
    pub(crate) async fn current_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        let unit = if number == 906 { 1e-3 } else { 1.0 };
        if let Some((letter, _)) = block.words().find(|(letter, _)| motor_of(*letter).is_none()) {
            return Err(Failure::Refused(message(format_args!("M{number}: {letter} is the letter of no motor"))));
        }
        if block.is_bare() {
            self.report_currents();
        }
        for (letter, value) in block.words() {
            let (Some(motor), Some(value)) = (motor_of(letter), value) else { continue };
            self.set_current(motor, Amps((value * unit) as f32))?;
        }
        Ok(Answer::Ok)
    }

    fn set_current(&mut self, motor: Actuator, wanted: Amps) -> Result<(), Failure> {
        let name = motor.name();
        let refuse = |reason: &str| Failure::Refused(message(format_args!("{name}: {reason}")));
        if wanted.0 < 0.0 || !wanted.0.is_finite() {
            return Err(refuse("the current must not be negative"));
        }
        let ceiling = self.config.driver(motor).map(|driver| driver.max_current);
        let Some(ceiling) = ceiling.filter(|_| self.config.actuators[motor].present) else {
            return Err(refuse("has no driver whose current can be set"));
        };
        let allowed = if wanted > ceiling { ceiling } else { wanted };
        if allowed < wanted {
            self.say(format_args!("WARNING: {name}: current cut to max_current {:.3} A\n", allowed.0));
        }
        match self.ports.drivers(|drivers| drivers.set_current(motor, allowed)) {
            Ok(_) => {
                self.config.actuators[motor].current = Some(allowed);
                self.resting_motors &= !motor.bit();
                Ok(())
            }
            Err(DriverFault::External) => Err(refuse("has no driver whose current can be set")),
            Err(DriverFault::Silent | DriverFault::BadAnswer) => Err(refuse("the driver does not answer")),
        }
    }

    fn report_currents(&mut self) {
        for (motor, actuator) in Actuator::ALL.into_iter().zip(self.config.actuators.0) {
            if let Some(amps) = actuator.current.filter(|_| actuator.present) {
                self.say(format_args!("{}: {:.5} Amps\n", motor.name(), amps.0));
            }
        }
    }

    /// M911: what each driver says, or the one that P names.
    pub(crate) async fn describe_drivers(&mut self, block: &Block<'_>) -> Outcome {
        let internal = internal_motors(&self.config);
        let motors = Actuator::ALL.into_iter().filter(|motor| internal & motor.bit() != 0);
        let is_named = |motor: Actuator| block.get('P').is_none_or(|p| p == f64::from(motor as u8));
        if let Some(p) = block.get('P').filter(|_| !motors.clone().any(is_named)) {
            let mut text = message(format_args!("M911: P{p} is the number of no driver; there are"));
            for (place, motor) in motors.enumerate() {
                let comma = if place == 0 { "" } else { "," };
                let letter = Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter());
                // What does not fit any more is left out.
                let _ = write!(text, "{comma} P{} {letter}", motor as u8);
            }
            return Err(Failure::Refused(text));
        }
        if !self.ports.supervisor(|supervisor| supervisor.motor_supply_on()) {
            self.say(format_args!("VMOT is off\n"));
        }
        for motor in motors.filter(|motor| is_named(*motor)) {
            let mut text = heapless::String::<1_024>::new();
            // A description that does not fit is cut.
            let _ = self.ports.drivers(|drivers| drivers.describe(motor, &mut text));
            self.say(format_args!("{}:\n{text}\n", motor.name()));
            self.drain().await;
        }
        Ok(Answer::Ok)
    }
}
