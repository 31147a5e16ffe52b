//! Questions about the motors' drivers, on the board or outside.

use super::{DriverKind, MachineConfig, StealthConfig, StealthFamily};
use units::{Actuator, Amps, Micros, MmPerSecond};

/// Below one turn a second of a motor of 200 full steps the measurement gets unstable with many motors
/// (TMC2130 datasheet rev. 1.09, 14.4; stallGuard2 is the same in all).
pub(crate) const GOOD_FULL_STEPS_PER_S: f64 = 200.0;

impl MachineConfig {
    /// Returns the settings that all external drivers of a kind share; none for other kinds.
    #[must_use]
    pub const fn stealth_family(&self, kind: DriverKind) -> Option<&StealthFamily> {
        match kind {
            DriverKind::Tmc2130 => Some(&self.tmc2130),
            DriverKind::Tmc5160 => Some(&self.tmc5160),
            DriverKind::Tmc2240 => Some(&self.tmc2240),
            DriverKind::Tmc2208 => Some(&self.tmc2208),
            DriverKind::Tmc2209 => Some(&self.tmc2209),
            DriverKind::Tmc2226 => Some(&self.tmc2226),
            DriverKind::Tmc2590 | DriverKind::Tmc2660 | DriverKind::External => None,
        }
    }

    /// Returns the shared settings of a kind, mutably.
    pub(crate) const fn stealth_family_mut(&mut self, kind: DriverKind) -> Option<&mut StealthFamily> {
        match kind {
            DriverKind::Tmc2130 => Some(&mut self.tmc2130),
            DriverKind::Tmc5160 => Some(&mut self.tmc5160),
            DriverKind::Tmc2240 => Some(&mut self.tmc2240),
            DriverKind::Tmc2208 => Some(&mut self.tmc2208),
            DriverKind::Tmc2209 => Some(&mut self.tmc2209),
            DriverKind::Tmc2226 => Some(&mut self.tmc2226),
            DriverKind::Tmc2590 | DriverKind::Tmc2660 | DriverKind::External => None,
        }
    }

    /// Returns the range of the stall threshold for homing, least to greatest; none where the driver measures
    /// no load that Velvet reads.
    #[must_use]
    pub const fn stall_thresholds(&self, actuator: Actuator) -> Option<[i16; 2]> {
        match self.actuators.0[actuator as usize].driver {
            DriverKind::Tmc2208 | DriverKind::External => None,
            DriverKind::Tmc2209 | DriverKind::Tmc2226 => Some([0, 255]),
            _ => Some([-64, 63]),
        }
    }

    /// Returns the least speed at which a motor's measured load is meaningful.
    #[must_use]
    pub fn load_speed(&self, actuator: Actuator) -> MmPerSecond {
        let outside = || self.stealth_driver(actuator).map(|driver| driver.stall_least_speed);
        let written = self.driver(actuator).map(|driver| driver.stall_least_speed).or_else(outside);
        written.unwrap_or_else(|| self.turn_a_second(actuator))
    }

    /// Returns the speed at one turn a second of a motor of 200 full steps, below which load is measured
    /// badly.
    pub(crate) fn turn_a_second(&self, actuator: Actuator) -> MmPerSecond {
        let motor = &self.actuators[actuator];
        MmPerSecond(GOOD_FULL_STEPS_PER_S * f64::from(motor.microsteps.max(1)) / motor.steps_per_mm.max(1e-6))
    }

    /// Returns whether a motor's load is measured over four full steps.
    #[must_use]
    pub fn measures_filtered(&self, actuator: Actuator) -> bool {
        match (self.driver(actuator), self.stealth_driver(actuator)) {
            (Some(driver), _) => driver.stall_filter.unwrap_or(true),
            (None, outside) => outside.is_some_and(|driver| driver.stall_filter),
        }
    }

    /// Returns the auxiliary UART that a driver's chip is on.
    #[must_use]
    pub fn driver_uart(&self, actuator: Actuator) -> Option<u8> {
        let kind = self.actuators[actuator].driver;
        Some(self.stealth_family(kind).filter(|_| kind.is_on_uart())?.channel)
    }

    /// Returns the settings of a motor's driver, when the driver is an external one.
    #[must_use]
    pub fn stealth_driver(&self, actuator: Actuator) -> Option<&StealthConfig> {
        Some(&self.stealth_family(self.actuators[actuator].driver)?.axes[actuator])
    }

    /// Returns the greatest current of a motor's driver; none where nobody can set the current.
    #[must_use]
    pub fn max_current(&self, actuator: Actuator) -> Option<Amps> {
        let on_board = self.driver(actuator).filter(|driver| driver.present).map(|driver| driver.max_current);
        let outside = || self.stealth_driver(actuator).filter(|driver| driver.present).map(|driver| driver.max_current);
        on_board.or_else(outside).filter(|most| most.get() > 0.0)
    }

    /// Returns the current of a motor at rest and the time after which it applies, if there is one.
    #[must_use]
    pub fn standstill(&self, actuator: Actuator) -> Option<(Amps, Micros)> {
        let kind = self.actuators[actuator].driver;
        if let Some(family) = self.driver_family(kind) {
            return Some((family.axes[actuator].standstill_current?, family.standstill_time));
        }
        let family = self.stealth_family(kind)?;
        Some((family.axes[actuator].standstill_current?, family.standstill_time))
    }
}
