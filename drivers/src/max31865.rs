//! MAX31865 converter for platinum sensors: registers over SPI, mode 1 or 3, most significant bit first.
//!
//! MAX31865 datasheet (19-6478 Rev 3): table 1 addresses, table 2 configuration, table 3 the test of the
//! wires, tables 4 and 5 the ratio of sensor to reference resistor, table 7 fault status, tables 10 to 12 the
//! meaning of faults.
//!
//! An open or shorted sensor shows with every conversion. A single wire that is open or at ground may not:
//! then readings are the voltage kept by the input's capacitor, or look right. The chip's fault detection
//! cycle finds it, but the converter has to stand meanwhile: [`Max31865::begin_test`], a millisecond later
//! [`Max31865::end_test`], and [`Settings::first_conversion`] later there are readings again. The delays of
//! the automatic cycle are for filters of up to 100 us ("Fault Detection Cycle"); the data sheet's capacitors
//! at the sensor (10 nF for 1 kOhm, 100 nF for 100 Ohm) make 10 us.

use embedded_hal::spi::{Operation, SpiDevice};
use units::{Celsius, Micros, Ohms};

use crate::platinum::Platinum;

/// Highest SPI clock of the chip (datasheet, "AC Electrical Characteristics").
pub const MAX_SPI_CLOCK_HZ: u32 = 5_000_000;

/// Addresses of the registers (table 1), for writing plus 80h.
mod register {
    pub const CONFIGURATION: u8 = 0x00;
    pub const HIGH_THRESHOLD: u8 = 0x03;
    pub const WRITE: u8 = 0x80;
}

/// The configuration register's bits (table 2).
mod configuration {
    pub const BIAS: u8 = 1 << 7;
    pub const AUTOMATIC: u8 = 1 << 6;
    pub const THREE_WIRE: u8 = 1 << 4;
    /// Fault detection with automatic delays; the bit reads as set while it runs (table 3).
    pub const DETECT: u8 = 0b01 << 2;
    pub const DETECTING: u8 = 0b11 << 2;
    pub const CLEAR_FAULTS: u8 = 1 << 1;
    pub const NOTCH_50_HZ: u8 = 1 << 0;
    /// Bits that read back as they were written.
    pub const KEPT: u8 = BIAS | AUTOMATIC | THREE_WIRE | NOTCH_50_HZ;
}

/// Number of the sensor's wires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wires {
    /// Two leads, whose resistance counts as sensor.
    #[default]
    Two,
    /// Three leads of equal resistance, which is subtracted.
    Three,
    /// Four leads, of which the sensing two carry no current.
    Four,
}

/// Mains frequency that the chip's filter suppresses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Mains {
    #[default]
    Hz50,
    Hz60,
}

/// Longest time of a wire test (datasheet, "Electrical Characteristics": automatic fault detection cycle
/// time, 550 us, 600 us at most).
pub const TEST: Micros = Micros(600);

/// Settings of a chip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Resistance curve of the sensor.
    pub platinum: Platinum,
    /// The reference resistor on the chip's board: 430 Ohm for a PT100, 4300 Ohm for a PT1000 on most.
    pub reference: Ohms,
    /// Number of the sensor's wires.
    pub wires: Wires,
    /// Mains frequency of the filter.
    pub mains: Mains,
}

impl Settings {
    /// Returns the byte for the configuration register: bias on and converting continuously.
    #[must_use]
    pub const fn configuration(&self) -> u8 {
        use configuration::{AUTOMATIC, BIAS, NOTCH_50_HZ, THREE_WIRE};
        let wires = if matches!(self.wires, Wires::Three) { THREE_WIRE } else { 0 };
        let notch = if matches!(self.mains, Mains::Hz50) { NOTCH_50_HZ } else { 0 };
        BIAS | AUTOMATIC | wires | notch
    }

    /// Returns the longest time from one conversion to the next (datasheet, "Electrical Characteristics",
    /// tCONV: continuous conversion, 20 ms and at most 21 ms with the 50 Hz notch, 16.7 ms and at most 17.6
    /// ms with that of 60 Hz).
    #[must_use]
    pub const fn conversion(&self) -> Micros {
        Micros(if matches!(self.mains, Mains::Hz50) { 21_000 } else { 17_600 })
    }

    /// Returns the longest time from [`Max31865::set_up`] or the end of a test to the first conversion (the
    /// same place, single conversion: 62.5 ms and at most 66 ms, 52 ms and at most 55 ms), and the charging
    /// time of the input's capacitors once the bias is on: 10.5 time constants and 1 ms ("1-Shot"), within 10
    /// ms for 100 nF at some kiloohms.
    #[must_use]
    pub const fn first_conversion(&self) -> Micros {
        Micros(if matches!(self.mains, Mains::Hz50) { 66_000 + 10_000 } else { 55_000 + 10_000 })
    }

    /// Returns the byte for the configuration register during a wire test: bias on, the converter off
    /// (100X010X, "Fault Detection Cycle").
    #[must_use]
    const fn testing(&self) -> u8 {
        self.configuration() & !configuration::AUTOMATIC | configuration::DETECT
    }

    /// Returns the fault thresholds, high and low, for their registers: a sensor beyond 850 C or below -200 C
    /// is open or shorted.
    #[must_use]
    pub fn thresholds(&self) -> [u16; 2] {
        [850.0, -200.0].map(|celsius| {
            let ratio = f64::from(self.platinum.ohms(Celsius(celsius)).0) / f64::from(self.reference.0);
            ((ratio * 32_768.0) as u16).min(0x7FFF) << 1
        })
    }
}

/// Reason for a missing temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The bus failed, or nothing drives the data line: all ones.
    Absent,
    /// The data line stays low: all zeros.
    Low,
    /// The chip does not keep the settings written.
    Garbled,
    /// The chip lost its settings: its supply failed. The settings have to be written again.
    Reset,
    /// The resistance is above that of platinum (D7).
    Open,
    /// The resistance is below that of platinum (D6).
    Shorted,
    /// REFIN- above 0.85 VBIAS (D5): no current flows through the sensor.
    NoCurrent,
    /// REFIN- below 0.85 VBIAS with FORCE- open (D4): a wire of the minus side leads to ground.
    MinusGrounded,
    /// RTDIN- below 0.85 VBIAS with FORCE- open (D3): some wire leads to ground.
    Grounded,
    /// A protected input is above the supply or below ground (D2).
    Voltage,
    /// The fault bit is set and no cause is given.
    Unknown,
}

impl Fault {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Absent => "no MAX31865 answers: check spi_select_pin, its wires and its supply",
            Self::Low => "the MAX31865's data line stays low: check its supply and the wire to MISO",
            Self::Garbled => "the MAX31865 keeps no settings: check sensor, and the wires of the bus",
            Self::Reset => "the MAX31865 has lost its settings: check its supply",
            Self::Open => "platinum sensor open: check its plug, its wires and rtd_wires",
            Self::Shorted => "platinum sensor shorted: check its wires and rtd_nominal",
            Self::NoCurrent => "platinum sensor open: check its plug, its FORCE wires and rtd_wires",
            Self::MinusGrounded => "platinum sensor: RTDIN- or FORCE- touches ground: check their insulation",
            Self::Grounded => "platinum sensor: a wire of it touches ground: check their insulation",
            Self::Voltage => "a wire of the sensor touches a voltage: check its insulation",
            Self::Unknown => "the MAX31865 reports a fault without a cause: check its wires",
        }
    }

    /// Returns the fault in the fault status register (table 7), the likeliest cause first.
    #[must_use]
    pub fn of_status(status: u8) -> Self {
        let is = |bit: u8| status >> bit & 1 == 1;
        if is(2) {
            Self::Voltage
        } else if is(7) {
            Self::Open
        } else if is(5) {
            Self::NoCurrent
        } else if is(4) {
            Self::MinusGrounded
        } else if is(3) {
            // RTDIN+ at ground, which shorts the sensor too.
            Self::Grounded
        } else if is(6) {
            Self::Shorted
        } else {
            Self::Unknown
        }
    }
}

/// Chip on its bus with its settings.
#[derive(Debug)]
pub struct Max31865<SPI> {
    spi: SPI,
    settings: Settings,
}

impl<SPI: SpiDevice> Max31865<SPI> {
    /// Creates a driver without contact to the chip.
    pub const fn new(spi: SPI, settings: Settings) -> Self {
        Self { spi, settings }
    }

    /// Tells the chip its settings. The first reading comes [`Settings::first_conversion`] later.
    ///
    /// # Errors
    /// When it does not read back what was written.
    pub fn set_up(&mut self) -> Result<(), Fault> {
        let [high, low] = self.settings.thresholds().map(u16::to_be_bytes);
        let thresholds = [register::HIGH_THRESHOLD | register::WRITE, high[0], high[1], low[0], low[1]];
        self.spi.write(&thresholds).map_err(|_| Fault::Absent)?;
        // The faults of an earlier conversion are cleared, or they would stand before every reading.
        self.write_configuration(self.settings.configuration() | configuration::CLEAR_FAULTS)?;
        let [configuration, _, _, kept @ .., _] = self.registers()?;
        let is_kept = configuration & configuration::KEPT == self.settings.configuration();
        if is_kept && kept == [high[0], high[1], low[0], low[1]] { Ok(()) } else { Err(Fault::Garbled) }
    }

    /// Has the chip test the wires, for [`TEST`]. Conversions stop until [`Self::end_test`].
    ///
    /// # Errors
    /// When the bus fails.
    pub fn begin_test(&mut self) -> Result<(), Fault> {
        self.write_configuration(self.settings.testing())
    }

    /// Returns the result of the test; the chip converts again, and has its next reading
    /// [`Settings::first_conversion`] later.
    ///
    /// # Errors
    /// What is wrong with the wires; that the chip has forgotten its settings, and has to be set up; that it
    /// does not end its test; or that it does not answer.
    pub fn end_test(&mut self) -> Result<(), Fault> {
        let [configuration, .., status] = self.registers()?;
        let begun = self.settings.testing() & configuration::KEPT;
        // The chip is to convert with any result; the faults found would stand before every reading.
        self.write_configuration(self.settings.configuration() | configuration::CLEAR_FAULTS)?;
        match configuration {
            _ if configuration & configuration::KEPT != begun => Err(Fault::Reset),
            _ if configuration & configuration::DETECTING != 0 => Err(Fault::Garbled),
            _ if status >> 2 != 0 => Err(Fault::of_status(status)),
            _ => Ok(()),
        }
    }

    fn write_configuration(&mut self, value: u8) -> Result<(), Fault> {
        let frame = [register::CONFIGURATION | register::WRITE, value];
        self.spi.write(&frame).map_err(|_| Fault::Absent)
    }

    /// Reads all registers. After power-on the high threshold alone has ones (table 1), so nothing but zeros
    /// or ones come from a dead line.
    fn registers(&mut self) -> Result<[u8; 8], Fault> {
        let mut all = [0; 8];
        let mut operations = [Operation::Write(&[register::CONFIGURATION]), Operation::Read(&mut all)];
        self.spi.transaction(&mut operations).map_err(|_| Fault::Absent)?;
        match all {
            _ if all == [0; 8] => Err(Fault::Low),
            _ if all == [u8::MAX; 8] => Err(Fault::Absent),
            _ => Ok(all),
        }
    }

    /// Returns the latest conversion, by a transfer of nine bytes, and one of two more after a fault.
    ///
    /// # Errors
    /// What the chip reports; that it has forgotten its settings, and has to be set up; or that no chip
    /// answers. A fault is cleared, so that the next conversion tells whether it lasts.
    pub fn read(&mut self) -> Result<Celsius, Fault> {
        let [configuration, rtd_high, rtd_low, .., status] = self.registers()?;
        if configuration & configuration::KEPT != self.settings.configuration() {
            return Err(Fault::Reset);
        }
        let rtd = u16::from_be_bytes([rtd_high, rtd_low]);
        if rtd & 1 == 1 {
            self.write_configuration(self.settings.configuration() | configuration::CLEAR_FAULTS)?;
            return Err(Fault::of_status(status));
        }
        celsius(&self.settings, rtd >> 1)
    }
}

/// Returns the temperature of a ratio in the 15 bits of tables 4 and 5.
///
/// # Errors
/// A resistance that platinum does not have.
pub fn celsius(settings: &Settings, ratio: u16) -> Result<Celsius, Fault> {
    let ohms = Ohms((f64::from(ratio) / 32_768.0 * f64::from(settings.reference.0)) as f32);
    let beyond = if ohms > settings.platinum.r0 { Fault::Open } else { Fault::Shorted };
    settings.platinum.celsius(ohms).ok_or(beyond)
}

#[cfg(test)]
mod tests;
