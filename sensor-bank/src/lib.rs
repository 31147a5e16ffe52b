//! Temperature sensors behind converter chips: times of reading, settings, and results.
//!
//! A crate of its own because `machine` never sees a chip and `drivers` never sees a configuration; the board
//! and the native runner bring their own bus. During a poll, the caller is the only owner of the buses.
#![no_std]

mod chip;

use base::ports::{DatedReading, MAX_HEATERS, SensorReading};
use heapless::Vec;
use units::Micros;

use chip::Chip;
pub use chip::Chips;

/// Shortest period between two readings: no chip has more than ten new readings a second (a MAX31855 takes
/// 100 ms), and eight of them leave the bus free most of the time.
const LEAST_PERIOD: Micros = Micros::from_millis(100);
/// Time until the chip is read again after a fault. Heat safety forgives a frame spoilt by noise, as it stops
/// at four bad readings 50 ms apart; a lasting fault is not forgiven.
const ASK_AGAIN: Micros = Micros::from_millis(50);
/// Number of its periods for which a reading is valid.
const LASTS_PERIODS: u64 = 4;

/// Period of the wire test, for chips that can test their sensor's wires. A test costs a conversion and a few
/// milliseconds, so that no reading is left out.
const TEST_PERIOD: Micros = Micros::from_seconds(5);

/// Activity of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Waiting to be set up.
    New,
    /// Waiting for a test of the wires, which are not known to be sound.
    Untested,
    /// Testing the sensor's wires.
    Tests,
    /// Converting the temperature continuously.
    Converts,
}

/// Chip with the time of its next reading.
#[derive(Debug)]
struct Sensor<SPI> {
    /// Index of the temperature control in the configuration.
    controller: usize,
    chip: Chip<SPI>,
    stage: Stage,
    period: Micros,
    due: Micros,
    /// Times of the last reading and of the last test of the wires.
    read: Micros,
    tested: Micros,
}

impl<SPI: embedded_hal::spi::SpiDevice> Sensor<SPI> {
    /// Takes the next step: setting the chip up, testing the wires, or a reading. Returns `None` if there is
    /// no reading yet.
    fn run(&mut self, now: Micros) -> Option<DatedReading> {
        let done = match self.stage {
            Stage::New => self.set_up(now).map(|()| None),
            Stage::Untested => self.begin_test(now).map(|()| None),
            Stage::Tests => self.end_test(now).map(|()| None),
            Stage::Converts => self.read(now).map(Some),
        };
        match done {
            Ok(None) => None,
            Ok(Some(celsius)) => Some(self.dated(SensorReading::MilliDegrees((celsius.0 * 1e3) as i32), now)),
            Err(fault) => {
                // The fault is reported as such: readings up to the end of the first conversion would be no
                // temperatures.
                let is_set_up_anew = fault.needs_set_up && self.set_up(now).is_ok();
                if !is_set_up_anew {
                    self.due = now.plus(ASK_AGAIN);
                }
                Some(self.dated(SensorReading::Fault(fault.words), now))
            }
        }
    }

    /// Dates a reading, so that it is valid until the next one has failed to come a few times.
    fn dated(&self, reading: SensorReading, now: Micros) -> DatedReading {
        DatedReading { reading, taken: now, lasts: Micros(self.period.0 * LASTS_PERIODS) }
    }

    fn set_up(&mut self, now: Micros) -> Result<(), chip::Fault> {
        self.stage = Stage::New;
        self.chip.set_up()?;
        self.begin_test(now)
    }

    /// Begins a test; a chip without a test begins to convert.
    fn begin_test(&mut self, now: Micros) -> Result<(), chip::Fault> {
        self.stage = Stage::Untested;
        match self.chip.begin_test()? {
            Some(lasts) => {
                self.stage = Stage::Tests;
                self.due = now.plus(lasts);
            }
            None => self.convert(now),
        }
        Ok(())
    }

    fn end_test(&mut self, now: Micros) -> Result<(), chip::Fault> {
        // After a failed test the wires are tested again.
        self.stage = Stage::Untested;
        self.chip.end_test()?;
        self.tested = now;
        self.convert(now);
        Ok(())
    }

    /// Begins the stage of conversions.
    fn convert(&mut self, now: Micros) {
        self.stage = Stage::Converts;
        let (converted, next) = (now.plus(self.chip.first_conversion()), self.read.plus(self.period));
        self.due = if self.read == Micros(0) { converted } else { converted.max(next) };
    }

    fn read(&mut self, now: Micros) -> Result<units::Celsius, chip::Fault> {
        let celsius = self.chip.read()?;
        (self.read, self.due) = (now, now.plus(self.period));
        if self.chip.has_test() && now.since(self.tested) >= TEST_PERIOD {
            self.begin_test(now)?;
        }
        Ok(celsius)
    }
}

/// Chips of all temperature sensors.
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
    /// Adds the sensor of the temperature control at this place of the configuration. No message is sent to
    /// its chip before the first [`Self::poll`]. Returns false when its kind has no chip, or there is no
    /// room.
    pub fn add(&mut self, controller: usize, config: &config::SensorConfig, spi: SPI) -> bool {
        let Some(chip) = Chip::of(config, spi) else { return false };
        let wanted = Micros(1_000_000 / u64::from(config.readings_per_second.max(1)));
        let period = Micros(wanted.0.max(chip.conversion().0).max(LEAST_PERIOD.0));
        let (stage, never) = (Stage::New, Micros(0));
        self.sensors.push(Sensor { controller, chip, stage, period, due: never, read: never, tested: never }).is_ok()
    }

    /// Whether there is nothing to poll.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sensors.is_empty()
    }

    /// Reads the chip that has been due for longest, if any: at most one, so that a call is short. Call at
    /// 100 Hz. Returns the reading with the place of its temperature control.
    pub fn poll(&mut self, now: Micros) -> Option<(usize, DatedReading)> {
        let sensor = self.sensors.iter_mut().filter(|sensor| sensor.due <= now).min_by_key(|sensor| sensor.due)?;
        Some((sensor.controller, sensor.run(now)?))
    }
}

#[cfg(test)]
mod tests;
