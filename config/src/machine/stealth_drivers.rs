//! Drivers outside the board that are set up by us: `[tmc2130]`, `[tmc5160]`, `[tmc2240]` over SPI,
//! `[tmc2208]`, `[tmc2209]`, `[tmc2226]` over a UART.

use super::{CoolStepConfig, DriverKind, MachineConfig};
use crate::check::GOOD_FULL_STEPS_PER_S;
use crate::pin::Pin;
use units::{Actuator, Amps, Micros, MmPerSecond, Ohms, PerActuator};

/// One driver.
#[derive(Clone, Copy, Debug, Default)]
pub struct StealthConfig {
    /// The file has an entry for it.
    pub present: bool,
    /// Chip select, active low.
    pub spi_cs_pin: Option<Pin>,
    /// Address on a UART, 0 to 3.
    pub uart_address: u8,
    /// Sense resistor, or the reference resistor of a TMC2240; none: not written.
    pub resistor: Option<Ohms>,
    /// Ceiling of any requested current.
    pub max_current: Amps,
    /// Interpolate to 256 microsteps.
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
    /// What counts as a stall: `SGT`, or `SGTHRS` of a TMC2209 and TMC2226.
    pub stall_threshold: i16,
    /// `SFILT`.
    pub stall_filter: bool,
    /// Its stalls are watched for while it moves.
    pub stall_watch: bool,
    /// The input that DIAG leads to.
    pub stall_pin: Option<Pin>,
    /// From this speed on its load says anything.
    pub stall_least_speed: MmPerSecond,
    /// Current by load.
    pub cool_step: CoolStepConfig,
}

/// What all drivers of one kind share, and each of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct StealthFamily {
    /// The bus: SPI1, or 1 for SPI4, the on-board chips' own; on a UART USART3, or 1 for UART4.
    pub channel: u8,
    /// Idle time before the standstill current.
    pub standstill_time: Micros,
    /// By motor.
    pub axes: PerActuator<StealthConfig>,
}

impl DriverKind {
    /// Most peak current that such a chip may be asked for, whatever its resistor; none: its MOSFETs are
    /// outside.
    #[must_use]
    pub const fn most_current(self) -> Option<Amps> {
        match self {
            Self::Tmc2130 => Some(Amps(2.5)),
            Self::Tmc2208 | Self::Tmc2209 | Self::Tmc2226 => Some(Amps(2.8)),
            Self::Tmc2240 => Some(Amps(3.0)),
            _ => None,
        }
    }

    /// Peak current that a driver of this kind outside can measure with its resistor; none for others.
    #[must_use]
    pub fn measurable(self, resistor: Ohms) -> Option<Amps> {
        match self {
            // Behind 20 mOhm inside the chip.
            Self::Tmc2130 => Some(Amps(0.32 / (resistor.get() + 0.02))),
            Self::Tmc2208 | Self::Tmc2209 | Self::Tmc2226 => Some(Amps(0.325 / (resistor.get() + 0.02))),
            Self::Tmc5160 => Some(Amps(0.325 / resistor.get())),
            // 36 A kOhm in its highest range.
            Self::Tmc2240 => Some(Amps(36_000.0 / resistor.get())),
            _ => None,
        }
    }
}

impl MachineConfig {
    /// The settings that all drivers of a kind outside share; none for other kinds.
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

    /// The same, to be changed.
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

    /// What counts as a stall of a motor while its axis homes, from the least to the most; none where its
    /// driver measures no load that we know of.
    #[must_use]
    pub const fn stall_thresholds(&self, actuator: Actuator) -> Option<[i16; 2]> {
        match self.actuators.0[actuator as usize].driver {
            DriverKind::Tmc2208 | DriverKind::External => None,
            DriverKind::Tmc2209 | DriverKind::Tmc2226 => Some([0, 255]),
            _ => Some([-64, 63]),
        }
    }

    /// The speed from which on a motor's load says anything.
    #[must_use]
    pub fn load_speed(&self, actuator: Actuator) -> MmPerSecond {
        let outside = || self.stealth_driver(actuator).map(|driver| driver.stall_least_speed);
        let written = self.driver(actuator).map(|driver| driver.stall_least_speed).or_else(outside);
        written.unwrap_or_else(|| self.turn_a_second(actuator))
    }

    /// A turn a second of a motor of 200 full steps, below which load is measured badly.
    pub(crate) fn turn_a_second(&self, actuator: Actuator) -> MmPerSecond {
        let motor = &self.actuators[actuator];
        MmPerSecond(GOOD_FULL_STEPS_PER_S * f64::from(motor.microsteps.max(1)) / motor.steps_per_mm.max(1e-6))
    }

    /// A motor's load is measured over four full steps.
    #[must_use]
    pub fn measures_filtered(&self, actuator: Actuator) -> bool {
        match (self.driver(actuator), self.stealth_driver(actuator)) {
            (Some(driver), _) => driver.stall_filter.unwrap_or(true),
            (None, outside) => outside.is_some_and(|driver| driver.stall_filter),
        }
    }

    /// The auxiliary UART that a driver's chip is on.
    #[must_use]
    pub fn driver_uart(&self, actuator: Actuator) -> Option<u8> {
        let kind = self.actuators[actuator].driver;
        Some(self.stealth_family(kind).filter(|_| kind.is_on_uart())?.channel)
    }

    /// The settings of a motor's driver, when it is one of these.
    #[must_use]
    pub fn stealth_driver(&self, actuator: Actuator) -> Option<&StealthConfig> {
        Some(&self.stealth_family(self.actuators[actuator].driver)?.axes[actuator])
    }

    /// The most a motor's driver may be asked for; none where nobody can set its current.
    #[must_use]
    pub fn max_current(&self, actuator: Actuator) -> Option<Amps> {
        let on_board = self.driver(actuator).filter(|driver| driver.present).map(|driver| driver.max_current);
        let outside = || self.stealth_driver(actuator).filter(|driver| driver.present).map(|driver| driver.max_current);
        on_board.or_else(outside).filter(|most| most.get() > 0.0)
    }

    /// The current of a motor at rest and the time after which it applies, if there is one.
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
