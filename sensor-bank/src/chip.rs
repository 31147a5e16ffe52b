//! Temperature sensor chips behind a common interface.

use config::{SensorConfig, SensorKind};
use drivers::max31855::{self, Max31855};
use drivers::max31856::{self, Max31856};
use drivers::max31865::{self, Mains, Max31865, Wires};
use drivers::platinum::Platinum;
use embedded_hal::spi::{MODE_0, MODE_3, Mode, SpiDevice};
use units::{Celsius, Micros};

/// Reason for a missing temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    /// Message that says what to check.
    pub(crate) words: &'static str,
    /// The chip has forgotten its settings.
    pub(crate) needs_set_up: bool,
}

macro_rules! fault_of {
    ($($chip:ident),*) => {$(
        impl From<$chip::Fault> for Fault {
            fn from(fault: $chip::Fault) -> Self {
                Self { words: fault.message(), needs_set_up: fault == $chip::Fault::Reset }
            }
        }
    )*};
}

fault_of!(max31856, max31865);

impl From<max31855::Fault> for Fault {
    fn from(fault: max31855::Fault) -> Self {
        Self { words: fault.message(), needs_set_up: false }
    }
}

/// Requirements of a kind of chip on its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chips {
    /// Clock polarity and phase of the bus.
    pub mode: Mode,
    /// Highest clock of the bus, Hz.
    pub most_hz: u32,
}

impl Chips {
    /// Clock of Smoothieware, a fifth of the chips' limit, as their wires are long.
    const MOST_HZ: u32 = 1_000_000;

    /// Returns the requirements of a kind of sensor; `None` if no chip reads it.
    #[must_use]
    pub const fn of(kind: SensorKind) -> Option<Self> {
        let mode = match kind {
            SensorKind::Max31855 => MODE_0,
            // Mode 1 would do as well; mode 3 is that of the motor drivers, which may share the bus.
            SensorKind::Max31856 | SensorKind::Max31865 => MODE_3,
            _ => return None,
        };
        Some(Self { mode, most_hz: Self::MOST_HZ })
    }
}

const _: () = assert!(Chips::MOST_HZ <= max31855::MAX_SPI_CLOCK_HZ);
const _: () = assert!(Chips::MOST_HZ <= max31856::MAX_SPI_CLOCK_HZ && Chips::MOST_HZ <= max31865::MAX_SPI_CLOCK_HZ);

/// A converter chip on its bus, with its settings.
#[derive(Debug)]
pub(crate) enum Chip<SPI> {
    Max31855(Max31855<SPI>),
    Max31856(Max31856<SPI>, max31856::Settings),
    Max31865(Max31865<SPI>, max31865::Settings),
}

impl<SPI: SpiDevice> Chip<SPI> {
    pub(crate) fn of(config: &SensorConfig, spi: SPI) -> Option<Self> {
        let sensor = &config.spi;
        let mains = if sensor.mains_60_hz { Mains::Hz60 } else { Mains::Hz50 };
        Some(match config.kind {
            SensorKind::Max31855 => Self::Max31855(Max31855::new(spi, sensor.averaging)),
            SensorKind::Max31856 => {
                let settings =
                    max31856::Settings { thermocouple: sensor.thermocouple, mains, averaging: sensor.averaging };
                Self::Max31856(Max31856::new(spi, settings), settings)
            }
            SensorKind::Max31865 => {
                let wires = match sensor.rtd_wires {
                    3 => Wires::Three,
                    4 => Wires::Four,
                    _ => Wires::Two,
                };
                let platinum = Platinum { r0: sensor.rtd_nominal };
                let settings = max31865::Settings { platinum, reference: sensor.rtd_reference, wires, mains };
                Self::Max31865(Max31865::new(spi, settings), settings)
            }
            _ => return None,
        })
    }

    pub(crate) fn set_up(&mut self) -> Result<(), Fault> {
        match self {
            Self::Max31855(_) => Ok(()),
            Self::Max31856(chip, _) => chip.set_up().map_err(Fault::from),
            Self::Max31865(chip, _) => chip.set_up().map_err(Fault::from),
        }
    }

    /// Whether the chip can test the sensor's wires.
    pub(crate) const fn has_test(&self) -> bool {
        matches!(self, Self::Max31865(..))
    }

    /// Starts a test of the sensor's wires and returns the time that the chip then stands. `None` if the chip
    /// has no such test.
    pub(crate) fn begin_test(&mut self) -> Result<Option<Micros>, Fault> {
        match self {
            Self::Max31855(_) | Self::Max31856(..) => Ok(None),
            Self::Max31865(chip, _) => chip.begin_test().map(|()| Some(max31865::TEST)).map_err(Fault::from),
        }
    }

    /// Reads the result of the test. The chip converts again, and has its next reading after its first
    /// conversion.
    pub(crate) fn end_test(&mut self) -> Result<(), Fault> {
        match self {
            Self::Max31855(_) | Self::Max31856(..) => Ok(()),
            Self::Max31865(chip, _) => chip.end_test().map_err(Fault::from),
        }
    }

    pub(crate) fn read(&mut self) -> Result<Celsius, Fault> {
        match self {
            Self::Max31855(chip) => chip.read().map_err(Fault::from),
            Self::Max31856(chip, _) => chip.read().map_err(Fault::from),
            Self::Max31865(chip, _) => chip.read().map_err(Fault::from),
        }
    }

    /// Returns the time from one conversion to the next.
    pub(crate) const fn conversion(&self) -> Micros {
        match self {
            Self::Max31855(_) => max31855::CONVERSION,
            Self::Max31856(_, settings) => settings.conversion(),
            Self::Max31865(_, settings) => settings.conversion(),
        }
    }

    /// Returns the time from the set-up, or from power-up if there is nothing to set, to the first
    /// conversion.
    pub(crate) const fn first_conversion(&self) -> Micros {
        match self {
            Self::Max31855(_) => max31855::FIRST_CONVERSION,
            Self::Max31856(_, settings) => settings.first_conversion(),
            Self::Max31865(_, settings) => settings.first_conversion(),
        }
    }
}
