//! Bits of inputs and outputs. Numbers, not names: the board binds each to a pin once, at boot.

use units::Micros;

/// Greatest number of temperature controllers.
pub const MAX_HEATERS: usize = config::MAX_TEMPERATURES;
/// Greatest number of switches.
pub const MAX_SWITCHES: usize = config::MAX_SWITCHES;

const _: () = assert!(MAX_HEATERS <= 8 && MAX_SWITCHES <= 16, "outputs must fit the level word");
const _: () = assert!(config::MAX_ENDSTOPS <= 12, "endstops must fit below the switches in the input word");

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

/// Input that the machine knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Endstop, by its place in the configuration's list.
    Endstop(u8),
    /// The probe's contact closes.
    Probe,
    /// The probe's contact opens. For the trigger latch alone, whose inputs fire when they become active.
    ProbeOpen,
    /// The kill button is pressed.
    Kill,
    /// Input switch, by its place in the configuration's list of switches.
    Switch(u8),
    /// There is no filament, or it is too thick.
    Filament,
    /// The wheel that filament turns.
    FilamentWheel,
    /// The probe is deployed.
    ProbeDeployed,
    /// A button of the button box, by its place in the configuration's list.
    Button(u8),
    /// The safety door is open.
    Door,
    /// The on-board driver of the motor with this number reports a stall.
    Stall(u8),
}

impl Input {
    /// Returns the input's place in [`InputLevels`]; for inputs that stop motion, below 32, also the number
    /// at the trigger latch.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Endstop(index) => index & 0xF,
            Self::Switch(index) => 12 + (index & 0xF),
            Self::Probe => 28,
            Self::Kill => 29,
            Self::ProbeOpen => 30,
            Self::Filament => 32,
            Self::FilamentWheel => 33,
            Self::ProbeDeployed => 34,
            Self::Button(index) => 40 + (index & 0xF),
            Self::Door => 35,
            Self::Stall(motor) => 56 + (motor & 7),
        }
    }

    /// Returns the input's bit in the trigger latch's masks; 0 for one that never stops motion.
    #[must_use]
    pub const fn bit(self) -> u32 {
        match 1_u32.checked_shl(self.number() as u32) {
            Some(bit) => bit,
            None => 0,
        }
    }
}

/// Level of every input, one bit each; set is triggered or pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputLevels(u64);

impl InputLevels {
    /// Returns the same levels with this input triggered as well.
    #[must_use]
    pub const fn with(self, input: Input) -> Self {
        self.with_number(input.number())
    }

    /// Returns the same levels with the input of this number triggered as well.
    #[must_use]
    pub const fn with_number(self, number: u8) -> Self {
        Self(self.0 | 1 << (number & 63))
    }

    /// Returns the levels of the inputs that can stop motion, as in the trigger latch's masks.
    #[must_use]
    pub const fn mask(self) -> u32 {
        self.0 as u32
    }

    /// Returns whether an input is triggered.
    #[must_use]
    pub const fn is_active(self, input: Input) -> bool {
        self.0 & 1 << input.number() != 0
    }
}

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
}
