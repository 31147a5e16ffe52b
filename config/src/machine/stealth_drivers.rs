//! External drivers that Velvet configures: `[tmc2130]`, `[tmc5160]`, `[tmc2240]` over SPI, `[tmc2208]`,
//! `[tmc2209]`, `[tmc2226]` over a UART.

use super::{CoolStepConfig, DriverKind, MachineConfig};
use crate::check::GOOD_FULL_STEPS_PER_S;
use crate::pin::Pin;
use units::{Actuator, Amps, Micros, MmPerSecond, Ohms, PerActuator};

/// Settings of one external driver.
#[derive(Clone, Copy, Debug, Default)]
pub struct StealthConfig {
    /// Whether the file has an entry for the driver.
    pub present: bool,
    /// Chip select, active low.
    pub spi_cs_pin: Option<Pin>,
    /// Address on a UART, 0 to 3.
    pub uart_address: u8,
    /// Sense resistor, or the reference resistor of a TMC2240; none: not written.
    pub resistor: Option<Ohms>,
    /// Ceiling of any requested current.
    pub max_current: Amps,
    /// Whether steps are interpolated to 256 microsteps.
    pub step_interpolation: bool,
    /// Current when standing still; none: no reduction.
    pub standstill_current: Option<Amps>,
    /// stealthChop up to this speed; none: never.
    pub stealth_threshold: Option<MmPerSecond>,
    /// spreadCycle's off time, 1 to 15.
    pub off_time: u8,
    /// spreadCycle's blanking time in clocks: 16, 24, 36 or 54; 16, 24, 32 or 40 on a UART.
    pub blank_time: u8,
    /// spreadCycle's hysteresis at the start, 1 to 8.
    pub hysteresis_start: u8,
    /// spreadCycle's hysteresis at the end, -3 to 12.
    pub hysteresis_end: i8,
    /// Stall threshold: `SGT`, or `SGTHRS` of a TMC2209 and TMC2226.
    pub stall_threshold: i16,
    /// StallGuard filter, the bit `SFILT`.
    pub stall_filter: bool,
    /// Whether stalls are monitored while the motor moves.
    pub stall_watch: bool,
    /// Input that is wired to the driver's DIAG output.
    pub stall_pin: Option<Pin>,
    /// Least speed at which the measured load is meaningful.
    pub stall_least_speed: MmPerSecond,
    /// Settings of the load-dependent current.
    pub cool_step: CoolStepConfig,
}

/// Settings that all drivers of one kind share, and those of each driver.
#[derive(Clone, Copy, Debug, Default)]
pub struct StealthFamily {
    /// The bus: SPI1, or 1 for SPI4, the on-board chips' own; on a UART USART3, or 1 for UART4.
    pub channel: u8,
    /// Idle time before the standstill current.
    pub standstill_time: Micros,
    /// Settings of each driver, by motor.
    pub axes: PerActuator<StealthConfig>,
}

impl DriverKind {
    /// Returns the greatest peak current of such a chip, whatever its resistor; none: its MOSFETs are outside
    /// the chip.
    #[must_use]
    pub const fn most_current(self) -> Option<Amps> {
        match self {
            Self::Tmc2130 => Some(Amps(2.5)),
            Self::Tmc2208 | Self::Tmc2209 | Self::Tmc2226 => Some(Amps(2.8)),
            Self::Tmc2240 => Some(Amps(3.0)),
            _ => None,
        }
    }

    /// Returns the peak current that an external driver of this kind can measure with its resistor; none for
    /// others.
    #[must_use]
    pub fn measurable(self, resistor: Ohms) -> Option<Amps> {
        match self {
            // The chip adds 20 mOhm in series with the resistor.
            Self::Tmc2130 => Some(Amps(0.32 / (resistor.get() + 0.02))),
            Self::Tmc2208 | Self::Tmc2209 | Self::Tmc2226 => Some(Amps(0.325 / (resistor.get() + 0.02))),
            Self::Tmc5160 => Some(Amps(0.325 / resistor.get())),
            // The constant is 36 A kOhm in the chip's highest range.
            Self::Tmc2240 => Some(Amps(36_000.0 / resistor.get())),
            _ => None,
        }
    }
}

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
