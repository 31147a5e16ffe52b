//! Temperature sensors behind converter chips: when each is read, what its settings are, what it says.
//!
//! A crate of its own because `machine` never sees a chip and `drivers` never sees a configuration; the board
//! and the native runner bring their own bus. Who polls the bank is the one owner of the buses for as long.
#![no_std]

mod chip;

use heapless::Vec;
use machine::ports::{DatedReading, MAX_HEATERS, SensorReading};
use units::Micros;

use chip::Chip;
pub use chip::Chips;

/// No chip is read more often: none has more than ten new readings a second for everybody (a MAX31855 takes
/// 100 ms), and eight of them leave the bus free most of the time.
const LEAST_PERIOD: Micros = Micros::from_millis(100);
/// After a fault the chip is asked again so soon. A frame that noise has spoilt is forgiven by heat safety,
/// which stops at four bad looks 50 ms apart; a fault that lasts is not.
const ASK_AGAIN: Micros = Micros::from_millis(50);
/// A reading counts for so many of its own periods.
const LASTS_PERIODS: u64 = 4;

/// A chip and when it is to be read.
#[derive(Debug)]
struct Sensor<SPI> {
    /// The place of its temperature control in the configuration.
    controller: usize,
    chip: Chip<SPI>,
    is_set_up: bool,
    period: Micros,
    due: Micros,
}

impl<SPI: embedded_hal::spi::SpiDevice> Sensor<SPI> {
    fn dated(&self, reading: SensorReading, now: Micros, next: Micros) -> DatedReading {
        let lasts = Micros(self.period.0.max(next.0) * LASTS_PERIODS);
        DatedReading { reading, taken: now, lasts }
    }

    /// Sets the chip up, or reads it. None when there is nothing to say yet.
    fn run(&mut self, now: Micros) -> Option<DatedReading> {
        let read = if self.is_set_up { self.chip.read() } else { self.set_up(now)? };
        let next = match read {
            Ok(_) => self.period,
            Err(fault) if fault.needs_set_up => {
                // Told as what it is. What it reads until its first conversion is over is nobody's
                // temperature.
                self.is_set_up = self.chip.set_up().is_ok();
                if self.is_set_up { self.chip.first_conversion() } else { ASK_AGAIN }
            }
            Err(_) => ASK_AGAIN,
        };
        self.due = now.plus(next);
        let reading = match read {
            Ok(celsius) => SensorReading::MilliDegrees((celsius.0 * 1e3) as i32),
            Err(fault) => SensorReading::Fault(fault.words),
        };
        Some(self.dated(reading, now, next))
    }

    /// None when it is set up, and converts.
    fn set_up(&mut self, now: Micros) -> Option<Result<units::Celsius, chip::Fault>> {
        match self.chip.set_up() {
            Ok(()) => {
                self.is_set_up = true;
                self.due = now.plus(self.chip.first_conversion());
                None
            }
            Err(fault) => Some(Err(fault)),
        }
    }
}

/// The chips of all sensors.
#[derive(Debug)]
pub struct SensorBank<SPI> {
    sensors: Vec<Sensor<SPI>, MAX_HEATERS>,
}

impl<SPI> Default for SensorBank<SPI> {
    fn default() -> Self {
        Self { sensors: Vec::new() }
    }
}

impl<SPI: embedded_hal::spi::SpiDevice> SensorBank<SPI> {
    /// Adds the sensor of the temperature control at this place of the configuration. Nothing is said to its
    /// chip before the first [`Self::poll`]. False when its kind has no chip, or there is no room.
    pub fn add(&mut self, controller: usize, config: &config::SensorConfig, spi: SPI) -> bool {
        let Some(chip) = Chip::of(config, spi) else { return false };
        let wanted = Micros(1_000_000 / u64::from(config.readings_per_second.max(1)));
        let period = Micros(wanted.0.max(chip.conversion().0).max(LEAST_PERIOD.0));
        self.sensors.push(Sensor { controller, chip, is_set_up: false, period, due: Micros(0) }).is_ok()
    }

    /// Whether there is nothing to poll.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sensors.is_empty()
    }

    /// Reads the chip that has been due for longest, if one is: at most one, so that a call is short. Call
    /// at 100 Hz. What was read, and by the place of its temperature control whose it is.
    pub fn poll(&mut self, now: Micros) -> Option<(usize, DatedReading)> {
        let sensor = self.sensors.iter_mut().filter(|sensor| sensor.due <= now).min_by_key(|sensor| sensor.due)?;
        Some((sensor.controller, sensor.run(now)?))
    }
}

#[cfg(test)]
mod tests;
