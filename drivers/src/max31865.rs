//! MAX31865 converter for platinum sensors: registers over SPI, mode 1 or 3, most significant bit first.
//!
//! MAX31865 datasheet (19-6478 Rev 3): table 1 addresses, table 2 configuration, tables 4 and 5 the ratio of
//! sensor to reference resistor, table 7 fault status, tables 10 to 12 what a fault means.

use embedded_hal::spi::{Operation, SpiDevice};
use units::{Celsius, Micros, Ohms};

use crate::platinum::Platinum;

/// SPI clock the chip takes at most (datasheet, "AC Electrical Characteristics").
pub const MAX_SPI_CLOCK_HZ: u32 = 5_000_000;

/// Registers (table 1); written at 80h more.
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
    pub const CLEAR_FAULTS: u8 = 1 << 1;
    pub const NOTCH_50_HZ: u8 = 1 << 0;
    /// Those that read back as they were written.
    pub const KEPT: u8 = BIAS | AUTOMATIC | THREE_WIRE | NOTCH_50_HZ;
}

/// Wires of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wires {
    /// Its leads count as sensor.
    #[default]
    Two,
    /// Leads of equal resistance are taken out.
    Three,
    /// Leads carry no current.
    Four,
}

/// The mains that the chip's filter suppresses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Mains {
    #[default]
    Hz50,
    Hz60,
}

/// How a chip is set up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The sensor.
    pub platinum: Platinum,
    /// The reference resistor on the chip's board: 430 Ohm for a PT100, 4300 Ohm for a PT1000 on most.
    pub reference: Ohms,
    /// Its wires.
    pub wires: Wires,
    /// The filter.
    pub mains: Mains,
}

impl Settings {
    /// What the configuration register is to hold: bias on and converting continuously.
    #[must_use]
    pub const fn configuration(&self) -> u8 {
        use configuration::{AUTOMATIC, BIAS, NOTCH_50_HZ, THREE_WIRE};
        let wires = if matches!(self.wires, Wires::Three) { THREE_WIRE } else { 0 };
        let notch = if matches!(self.mains, Mains::Hz50) { NOTCH_50_HZ } else { 0 };
        BIAS | AUTOMATIC | wires | notch
    }

    /// From one conversion to the next at most (datasheet, "Electrical Characteristics": continuous
    /// conversion).
    #[must_use]
    pub const fn conversion(&self) -> Micros {
        Micros(if matches!(self.mains, Mains::Hz50) { 21_000 } else { 17_600 })
    }

    /// From [`Max31865::set_up`] to the first conversion at most (the same place, single conversion), and
    /// what the input's capacitors take once the bias is on: 10.5 time constants ("Conversion Mode"), 10 ms
    /// for 100 nF at some kiloohms.
    #[must_use]
    pub const fn first_conversion(&self) -> Micros {
        Micros(if matches!(self.mains, Mains::Hz50) { 66_000 + 10_000 } else { 55_000 + 10_000 })
    }

    /// Fault thresholds, high and low, as they stand in their registers: a sensor beyond 850 C or below -200
    /// C is open or shorted.
    #[must_use]
    pub fn thresholds(&self) -> [u16; 2] {
        [850.0, -200.0].map(|celsius| {
            let ratio = f64::from(self.platinum.ohms(Celsius(celsius)).0) / f64::from(self.reference.0);
            ((ratio * 32_768.0) as u16).min(0x7FFF) << 1
        })
    }
}

/// Why there is no temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The bus failed, or nothing drives the data line: all ones.
    Absent,
    /// The data line stays low: all zeros.
    Low,
    /// The chip does not keep what it is told.
    Garbled,
    /// The chip lost its settings: its supply failed. They have to be written again.
    Reset,
    /// More resistance than platinum has (D7), or REFIN- above 0.85 VBIAS (D5): tables 10 to 12.
    Open,
    /// Less resistance than platinum has (D6).
    Shorted,
    /// REFIN- (D4) or RTDIN- (D3) below 0.85 VBIAS with FORCE- open.
    LowSide,
    /// A protected input is above the supply or below ground (D2).
    Voltage,
    /// The fault bit is set and no cause is given.
    Unknown,
}

impl Fault {
    /// In words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Absent => "no MAX31865 answers: check spi_select_pin, its wires and its supply",
            Self::Low => "the MAX31865's data line stays low: check its supply and the wire to MISO",
            Self::Garbled => "the MAX31865 keeps no settings: check sensor, and the wires of the bus",
            Self::Reset => "the MAX31865 has lost its settings: check its supply",
            Self::Open => "platinum sensor open: check its plug, its wires and rtd_wires",
            Self::Shorted => "platinum sensor shorted: check its wires and rtd_nominal",
            Self::LowSide => "platinum sensor: FORCE- or RTDIN- open or at ground: check its wires",
            Self::Voltage => "a wire of the sensor touches a voltage: check its insulation",
            Self::Unknown => "the MAX31865 reports a fault without a cause: check its wires",
        }
    }

    /// What the fault status register says (table 7), the likeliest cause first.
    #[must_use]
    pub fn of_status(status: u8) -> Self {
        let is = |bit: u8| status >> bit & 1 == 1;
        if is(2) {
            Self::Voltage
        } else if is(7) || is(5) {
            Self::Open
        } else if is(6) {
            Self::Shorted
        } else if is(4) || is(3) {
            Self::LowSide
        } else {
            Self::Unknown
        }
    }
}

/// A chip on its bus.
#[derive(Debug)]
pub struct Max31865<SPI> {
    spi: SPI,
    settings: Settings,
}

impl<SPI: SpiDevice> Max31865<SPI> {
    /// Nothing is said to the chip yet.
    pub const fn new(spi: SPI, settings: Settings) -> Self {
        Self { spi, settings }
    }

    /// Tells the chip its settings. Its first reading comes [`Settings::first_conversion`] later.
    ///
    /// # Errors
    /// When it does not read back what was written.
    pub fn set_up(&mut self) -> Result<(), Fault> {
        let [high, low] = self.settings.thresholds().map(u16::to_be_bytes);
        let thresholds = [register::HIGH_THRESHOLD | register::WRITE, high[0], high[1], low[0], low[1]];
        self.spi.write(&thresholds).map_err(|_| Fault::Absent)?;
        // What an earlier fault has left would stand before every reading.
        self.write_configuration(self.settings.configuration() | configuration::CLEAR_FAULTS)?;
        let [configuration, _, _, kept @ .., _] = self.registers()?;
        let is_kept = configuration & configuration::KEPT == self.settings.configuration();
        if is_kept && kept == [high[0], high[1], low[0], low[1]] { Ok(()) } else { Err(Fault::Garbled) }
    }

    fn write_configuration(&mut self, value: u8) -> Result<(), Fault> {
        let frame = [register::CONFIGURATION | register::WRITE, value];
        self.spi.write(&frame).map_err(|_| Fault::Absent)
    }

    /// All registers. After power-on the high threshold alone has ones (table 1), so nothing but zeros or
    /// ones are a line's.
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

    /// The latest conversion: a transfer of nine bytes, and one of two more after a fault.
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

/// The temperature of a ratio in the 15 bits of tables 4 and 5.
///
/// # Errors
/// A resistance that platinum does not have.
pub fn celsius(settings: &Settings, ratio: u16) -> Result<Celsius, Fault> {
    let ohms = Ohms((f64::from(ratio) / 32_768.0 * f64::from(settings.reference.0)) as f32);
    let beyond = if ohms > settings.platinum.r0 { Fault::Open } else { Fault::Shorted };
    settings.platinum.celsius(ohms).ok_or(beyond)
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::spi::{ErrorKind, ErrorType};
    use proptest::prelude::*;

    const PT100: Settings =
        Settings { platinum: Platinum::PT100, reference: Ohms(430.0), wires: Wires::Two, mains: Mains::Hz50 };

    /// The chip by its datasheet: eight registers at an address that counts on, faults by the thresholds.
    struct Chip {
        registers: [u8; 8],
        ratio: u16,
        is_there: bool,
        also: u8,
    }

    impl Chip {
        /// As it is after power-on (table 1).
        fn new(ratio: u16) -> Self {
            Self { registers: [0, 0, 0, 0xFF, 0xFF, 0, 0, 0], ratio, is_there: true, also: 0 }
        }

        fn convert(&mut self) {
            let threshold = |at: usize| u16::from_be_bytes([self.registers[at], self.registers[at + 1]]) >> 1;
            let high = u8::from(self.ratio >= threshold(3)) << 7;
            let low = u8::from(self.ratio <= threshold(5)) << 6;
            self.registers[7] |= high | low | self.also;
            let rtd = self.ratio << 1 | u16::from(self.registers[7] != 0);
            [self.registers[1], self.registers[2]] = rtd.to_be_bytes();
        }
    }

    impl ErrorType for &mut Chip {
        type Error = ErrorKind;
    }

    impl SpiDevice for &mut Chip {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
            let (mut at, mut first, mut writes) = (0, true, false);
            for operation in operations {
                match operation {
                    Operation::Write(bytes) => {
                        for byte in bytes.iter() {
                            if core::mem::take(&mut first) {
                                (at, writes) = (usize::from(byte & 0x7F), byte & 0x80 != 0);
                            } else if writes && (at == 0 || (3..7).contains(&at)) {
                                self.registers[at] = *byte;
                                at += 1;
                            }
                        }
                    }
                    Operation::Read(into) => {
                        self.convert();
                        for byte in into.iter_mut() {
                            *byte = if self.is_there { self.registers[at % 8] } else { 0xFF };
                            at += 1;
                        }
                    }
                    _ => return Err(ErrorKind::Other),
                }
            }
            if self.registers[0] & 2 != 0 {
                self.registers[0] &= !2;
                self.registers[7] = 0;
            }
            Ok(())
        }
    }

    /// A data line at ground.
    struct Dead;

    impl ErrorType for Dead {
        type Error = ErrorKind;
    }

    impl SpiDevice for Dead {
        fn transaction(&mut self, _: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
            Ok(())
        }
    }

    fn set_up(chip: &mut Chip, settings: Settings) -> Max31865<&mut Chip> {
        let mut driver = Max31865::new(chip, settings);
        driver.set_up().unwrap();
        driver
    }

    #[test]
    fn the_configuration_is_that_of_table_2() {
        let of = |wires, mains| Settings { wires, mains, ..PT100 }.configuration();
        assert_eq!(of(Wires::Two, Mains::Hz50), 0b1100_0001);
        assert_eq!(of(Wires::Three, Mains::Hz60), 0b1101_0000);
        assert_eq!(of(Wires::Four, Mains::Hz60), 0b1100_0000);
    }

    #[test]
    fn the_datasheet_s_example_ratios_are_read() {
        // Table 9, a PT100 with 400 Ohm: codes and temperatures.
        let settings = Settings { reference: Ohms(400.0), ..PT100 };
        for (code, celsius) in
            [(2_394, -175.0), (6_579, -50.0), (8_192, 0.0), (11_346, 100.0), (14_406, 200.0), (15_901, 250.0)]
        {
            let read = super::celsius(&settings, code).unwrap().0;
            assert!((read - celsius).abs() < 0.03, "{read} for {celsius}");
        }
    }

    #[test]
    fn every_fault_has_its_words_and_is_cleared() {
        for (status, fault) in [(4, Fault::LowSide), (3, Fault::LowSide), (2, Fault::Voltage), (5, Fault::Open)] {
            let mut chip = Chip::new(8_192);
            let mut driver = set_up(&mut chip, PT100);
            assert!(driver.read().is_ok());
            driver.spi.also = 1 << status;
            assert_eq!(driver.read(), Err(fault));
            driver.spi.also = 0;
            assert!(driver.read().is_ok(), "cleared");
        }
        assert_eq!(Fault::of_status(0), Fault::Unknown);
    }

    #[test]
    fn open_and_shorted_sensors_are_beyond_the_thresholds() {
        for (ratio, fault) in [(32_767, Fault::Open), (0, Fault::Shorted)] {
            let mut chip = Chip::new(ratio);
            let mut driver = set_up(&mut chip, PT100);
            assert_eq!(driver.read(), Err(fault));
        }
    }

    #[test]
    fn a_chip_that_forgets_and_a_line_that_is_dead_are_told_apart() {
        let mut chip = Chip::new(8_192);
        let mut driver = set_up(&mut chip, PT100);
        driver.spi.registers = Chip::new(0).registers;
        assert_eq!(driver.read(), Err(Fault::Reset));
        driver.set_up().unwrap();
        assert!(driver.read().is_ok());
        driver.spi.is_there = false;
        assert_eq!(driver.read(), Err(Fault::Absent));
        assert_eq!(driver.set_up(), Err(Fault::Absent));
        assert_eq!(Max31865::new(Dead, PT100).read(), Err(Fault::Low));
    }

    proptest! {
        #[test]
        fn a_temperature_survives_ratio_and_chip(celsius in -190.0_f32..840.0, thousand: bool) {
            let (platinum, reference) =
                if thousand { (Platinum::PT1000, Ohms(4_300.0)) } else { (Platinum::PT100, Ohms(430.0)) };
            let settings = Settings { platinum, reference, ..PT100 };
            let ratio = f64::from(platinum.ohms(Celsius(celsius)).0) / f64::from(reference.0);
            let mut chip = Chip::new((ratio * 32_768.0).round() as u16);
            let mut driver = set_up(&mut chip, settings);
            // Half a step of 13 milliohms where platinum is least steep.
            prop_assert!((driver.read().unwrap().0 - celsius).abs() < 0.03);
        }
    }
}
