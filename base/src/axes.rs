//! State of axes and motors: homed, with current, or at standstill current.

use config::{DriverKind, MachineConfig};
use units::{Actuator, Axis, AxisSet, Micros};

use crate::failure::{Failure, Texts};
use crate::ports::{DriverFault, DriversPort, MotionPort, MotorDrivers};
use crate::supervisor::SupervisorPort;
use crate::tuning::Tuning;

/// Returns the motors with a driver that is set up and asked, on the board or outside, one bit each.
#[must_use]
pub fn internal_motors(config: &MachineConfig) -> u8 {
    motors_with(config, DriverKind::is_spoken_with)
}

/// Returns the motors with a driver on the board, one bit each.
#[must_use]
pub fn on_board_motors(config: &MachineConfig) -> u8 {
    motors_with(config, DriverKind::is_on_board)
}

fn motors_with(config: &MachineConfig, is_such: fn(DriverKind) -> bool) -> u8 {
    let such = config.actuators().filter(|(_, actuator)| is_such(actuator.driver));
    such.fold(0, |bits, (motor, _)| bits | motor.bit())
}

fn unusable(texts: &Texts, motor: Actuator, fault: DriverFault) -> Failure {
    let why = match fault {
        DriverFault::Reset => "was without power, check its supply, and home",
        _ => "does not answer, check its supply and wiring",
    };
    texts.alarm(format_args!("motor driver {} {why}", motor.name()))
}

/// State of the axes and motors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Axes {
    homed: AxisSet,
    /// Motors that the machine has, one bit each.
    present: u8,
    /// Motors with current, one bit each.
    on: u8,
    /// Motors at their standstill current, one bit each.
    resting: u8,
    /// Time of the last motion.
    standing_since: Micros,
    /// Axes that were homed when a place was kept, and those that have not read as then since.
    homed_then: AxisSet,
    strayed: AxisSet,
    /// The motors of Z have been aligned, and none has been without current since.
    are_aligned: bool,
}

impl Axes {
    /// Starts with no motor having current, and no axis homed.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        Self { present: config.actuators().fold(0, |bits, (motor, _)| bits | motor.bit()), ..Self::default() }
    }

    /// Axes that are homed.
    #[must_use]
    pub const fn homed(&self) -> AxisSet {
        self.homed
    }

    /// Marks axes as homed. An axis that was homed when a place was kept reads as it did then again; an axis
    /// that was not homed has no reading to come back to.
    pub fn mark_homed(&mut self, axes: AxisSet) {
        self.homed = self.homed.or(axes);
        self.strayed = self.strayed.without(axes.and(self.homed_then)).or(axes.without(self.homed_then));
    }

    /// Marks axes as not homed.
    pub fn forget_homed(&mut self, axes: AxisSet) {
        self.homed = self.homed.without(axes);
        self.stray(axes);
    }

    /// Notes that the motors of Z have been aligned.
    pub const fn mark_aligned(&mut self) {
        self.are_aligned = true;
    }

    /// Whether the motors of Z have been aligned, and none has been without current or lost its place since.
    #[must_use]
    pub const fn are_aligned(&self) -> bool {
        self.are_aligned
    }

    /// Notes that a place is kept, to come back to; the axes `to_home` are to be homed before.
    pub fn keep_place(&mut self, to_home: AxisSet) {
        (self.homed_then, self.strayed) = (self.homed.or(to_home), to_home);
    }

    /// Notes that the readings of these axes mean another place than before.
    pub fn stray(&mut self, axes: AxisSet) {
        self.strayed = self.strayed.or(axes);
    }

    /// Returns the axes of X, Y and Z that do not read as when a place was kept, and those of them that
    /// homing brings back.
    #[must_use]
    pub fn strayed(&self) -> [AxisSet; 2] {
        let strayed = self.strayed.and(AxisSet::PRIMARY);
        [strayed, strayed.and(self.homed_then)]
    }

    /// Notes that a motor is not where its steps say: the axes that it moves count as not homed. Belts and
    /// towers go where several motors are, so a motor of X, Y or Z takes all three.
    pub fn lose_place(&mut self, motor: Actuator) {
        let own = Axis::ALL.get(motor as usize).map_or(AxisSet::NONE, |axis| AxisSet::of(*axis));
        let is_primary = !own.and(AxisSet::PRIMARY).is_empty();
        self.are_aligned = false;
        self.forget_homed(if is_primary { AxisSet::PRIMARY } else { own });
    }

    /// Marks all axes as not homed.
    pub fn forget_all_homed(&mut self) {
        self.forget_homed(AxisSet::ALL);
    }

    /// Notes that the motor supply is gone: no motor holds anything.
    pub fn lose_supply(&mut self) {
        self.forget_all_homed();
        (self.on, self.are_aligned) = (0, false);
    }

    /// Notes that the driver of a motor has been set up again, and is off.
    pub fn lose_current(&mut self, motor: Actuator) {
        self.on &= !motor.bit();
        self.resting &= !motor.bit();
        self.are_aligned = false;
    }

    /// Gives every motor its current, unless it has it.
    ///
    /// # Errors
    /// Without motor supply, or when a driver does not answer.
    pub fn enable(
        &mut self,
        texts: &Texts,
        ports: &mut (impl DriversPort + SupervisorPort),
        config: &MachineConfig,
        tuning: &Tuning,
        now: Micros,
    ) -> Result<(), Failure> {
        if self.on != self.present {
            if on_board_motors(config) != 0 && !ports.supervisor(|supervisor| supervisor.motor_supply_on()) {
                return Err(Failure::alarm(&"motor supply is off (vmotor below 6 V): switch it on, then M999"));
            }
            ports.set_motor_power(true);
            for motor in Actuator::of_bits(self.present) {
                match ports.drivers(|drivers| drivers.set_enabled(motor, true)) {
                    Ok(()) | Err(DriverFault::External) => self.on |= motor.bit(),
                    Err(fault) => return Err(unusable(texts, motor, fault)),
                }
            }
        }
        for motor in Actuator::of_bits(self.resting) {
            self.resting &= !motor.bit();
            let Some(current) = tuning.currents[motor] else { continue };
            if let Err(fault) = ports.drivers(|drivers| drivers.set_current(motor, current)) {
                return Err(unusable(texts, motor, fault));
            }
        }
        self.standing_since = now;
        Ok(())
    }

    /// Whether every motor has its full current, so that [`Self::enable`] has nothing to do.
    #[must_use]
    pub const fn are_enabled(&self) -> bool {
        self.resting == 0 && self.on == self.present
    }

    /// Whether a motor has current.
    #[must_use]
    pub const fn has_any_on(&self) -> bool {
        self.on != 0
    }

    /// Gives motors their standstill current once they have stood for `standstill_time`.
    pub fn watch_standstill(
        &mut self,
        ports: &mut impl DriversPort,
        config: &MachineConfig,
        is_idle: bool,
        now: Micros,
    ) {
        if !is_idle {
            self.standing_since = now;
            return;
        }
        for motor in Actuator::of_bits(self.on & !self.resting) {
            let Some((current, time)) = config.standstill(motor) else { continue };
            if now.since(self.standing_since) >= time
                && ports.drivers(|drivers| drivers.set_current(motor, current)).is_ok()
            {
                self.resting |= motor.bit();
            }
        }
    }

    /// Takes the current off these axes' own motors, and marks every axis that they move as not homed: in a
    /// CoreXY both X and Y go where one belt goes. Errors are left to the supervisor: a driver that does not
    /// answer cannot be switched off over its bus; the global enable line does it.
    pub fn disable(&mut self, ports: &mut (impl DriversPort + MotionPort), axes: AxisSet) {
        let mut lost = axes;
        for axis in axes.axes() {
            let Some(motor) = Actuator::from_index(axis as usize) else { continue };
            let _ = ports.drivers(|drivers| drivers.set_enabled(motor, false));
            self.on &= !motor.bit();
            let moved = ports.motion(|motion| motion.config().map(|config| config.kinematics.axes_of(motor)));
            lost = lost.or(moved.unwrap_or(AxisSet::ALL));
        }
        // Motors that copy Z's have the letters of other axes.
        self.are_aligned &= lost.without(AxisSet::of(Axis::X).with(Axis::Y)).is_empty();
        self.forget_homed(lost);
    }

    /// Takes the current off all motors; homed axes stay homed, for the motors were standing.
    pub fn disable_all(&mut self, ports: &mut impl DriversPort, config: &MachineConfig) {
        for (motor, _) in config.actuators() {
            // Errors are left to the supervisor, as in `disable`.
            let _ = ports.drivers(|drivers| drivers.set_enabled(motor, false));
        }
        (self.on, self.are_aligned) = (0, false);
    }

    /// Notes that a motor got a new current, and so is not at its standstill current.
    pub fn has_new_current(&mut self, motor: Actuator) {
        self.resting &= !motor.bit();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{BenchHands, THREE_MOTORS};
    use crate::hands::Hands;

    const X: AxisSet = AxisSet::of(Axis::X);

    /// A machine of three motors, one with a driver on the board.
    fn machine() -> BenchHands<()> {
        BenchHands::new(THREE_MOTORS)
    }

    #[test]
    fn motors_on_the_board_are_those_with_a_chip() {
        let bench = machine();
        assert_eq!(on_board_motors(bench.config()), Actuator::Alpha.bit());
        assert_eq!(internal_motors(bench.config()), Actuator::Alpha.bit());
    }

    #[test]
    fn motors_get_their_current_once_and_lose_it_axis_by_axis() {
        let mut bench = machine();
        assert!(!bench.motors.has_any_on() && !bench.motors.are_enabled());
        bench.enable_motors().unwrap();
        assert!(bench.world.motor_power && bench.motors.has_any_on() && bench.motors.are_enabled());
        assert_eq!(bench.world.bank.enabled, 0b111);
        bench.motors.mark_homed(AxisSet::PRIMARY);
        bench.motors.disable(&mut bench.world, X);
        assert_eq!((bench.world.bank.enabled, bench.motors.homed()), (0b110, AxisSet::PRIMARY.without(X)));
        assert!(bench.motors.has_any_on() && !bench.motors.are_enabled());
        let config = bench.config();
        bench.motors.disable_all(&mut bench.world, config);
        assert_eq!((bench.world.bank.enabled, bench.motors.has_any_on()), (0, false));
        assert_eq!(bench.motors.homed(), AxisSet::PRIMARY.without(X), "they were standing");
    }

    #[test]
    fn a_driver_that_does_not_answer_and_a_supply_that_is_off_are_alarms() {
        let mut bench = machine();
        bench.world.bank.fault = Some(DriverFault::Silent);
        let failure = bench.enable_motors().unwrap_err();
        assert!(failure.is_alarm() && bench.text_of(failure).contains("motor driver alpha does not answer"));
        bench.world.bank.fault = Some(DriverFault::External);
        bench.enable_motors().unwrap();
        let mut bench = machine();
        bench.world.watch.motor_supply_is_lost();
        let failure = bench.enable_motors().unwrap_err();
        assert!(failure.is_alarm() && bench.text_of(failure).contains("motor supply is off"));
        assert_eq!(bench.world.bank.enabled, 0);
    }

    #[test]
    fn a_motor_that_lost_its_place_takes_the_axes_with_it_that_it_may_move() {
        let mut axes = Axes::default();
        let all = AxisSet::PRIMARY.with(Axis::A);
        axes.mark_homed(all);
        axes.lose_place(Actuator::Delta);
        assert_eq!(axes.homed(), AxisSet::PRIMARY);
        axes.mark_homed(all);
        axes.lose_place(Actuator::Beta);
        assert_eq!(axes.homed(), AxisSet::of(Axis::A));
    }

    #[test]
    fn an_axis_reads_as_when_its_place_was_kept_once_it_is_homed_again() {
        let mut axes = Axes::default();
        axes.mark_homed(X);
        axes.keep_place(AxisSet::NONE);
        assert_eq!(axes.strayed(), [AxisSet::NONE; 2]);
        axes.forget_all_homed();
        assert_eq!(axes.strayed(), [AxisSet::PRIMARY, X], "Y and Z have no reading to come back to");
        axes.mark_homed(AxisSet::PRIMARY);
        assert_eq!(axes.strayed(), [AxisSet::PRIMARY.without(X), AxisSet::NONE]);
    }
}
