//! Readings of sensors, and bits of outputs. Numbers, not names: the board binds each to a pin once, at boot.

use units::Micros;

/// Greatest number of temperature controllers.
pub const MAX_HEATERS: usize = config::MAX_TEMPERATURES;
/// Greatest number of switches.
pub const MAX_SWITCHES: usize = config::MAX_SWITCHES;

const _: () = assert!(MAX_HEATERS <= 8 && MAX_SWITCHES <= 16, "outputs must fit the level word");

/// Returns the bit of a heater output, by its place in the configuration's list of temperature controllers.
#[must_use]
pub const fn heater_bit(index: usize) -> u32 {
    1 << index
}

/// Returns the bit of a switch output (digital or sigma-delta), by its place in the configuration's list of
/// switches.
#[must_use]
pub const fn switch_bit(index: usize) -> u32 {
    1 << (8 + index)
}

/// Levels of the outputs at a modulation tick of the heat task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutputLevels {
    /// Logical level of each output, see [`heater_bit`] and [`switch_bit`]. Inversion is the pin's affair.
    pub on: u32,
    /// Global enable of the MOSFET stage and its supply. Off while halted.
    pub fets_enabled: bool,
}

/// Raw reading of a temperature sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorReading {
    /// No reading yet, or the sensor does not answer.
    #[default]
    Missing,
    /// Averaged thermistor input, 16 bits full scale.
    Counts(u16),
    /// A sensor that reports degrees, in thousandths of one.
    MilliDegrees(i32),
    /// Fault of a sensor's chip that gives no temperature, in words that say what to check.
    Fault(&'static str),
}

/// Reading with the time at which it was taken, elsewhere than in the heat task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DatedReading {
    /// Raw reading of the sensor.
    pub reading: SensorReading,
    /// Time of the reading.
    pub taken: Micros,
    /// Time for which the reading counts.
    pub lasts: Micros,
}

impl DatedReading {
    /// Returns the reading, as long as it counts: then it is missing, so that nothing heats by what once was.
    #[must_use]
    pub fn at(&self, now: Micros) -> SensorReading {
        if now.since(self.taken) <= self.lasts { self.reading } else { SensorReading::Missing }
    }
}

/// Latest reading of each temperature controller, in the configuration's order.
pub type SensorReadings = [SensorReading; MAX_HEATERS];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_that_lasts_no_longer_is_missing() {
        let reading = SensorReading::MilliDegrees(25_000);
        let dated = DatedReading { reading, taken: Micros(1_000), lasts: Micros(400) };
        assert_eq!([1_000, 1_400].map(|now| dated.at(Micros(now))), [reading; 2]);
        assert_eq!(dated.at(Micros(1_401)), SensorReading::Missing);
    }

    #[test]
    fn every_output_has_a_bit_of_its_own() {
        let heaters = (0..MAX_HEATERS).map(heater_bit);
        let bits = heaters.chain((0..MAX_SWITCHES).map(switch_bit)).fold(0_u32, |bits, bit| {
            assert_eq!((bits & bit, bit.count_ones()), (0, 1), "{bit:#x}");
            bits | bit
        });
        assert_eq!(bits.count_ones() as usize, MAX_HEATERS + MAX_SWITCHES);
    }
}
