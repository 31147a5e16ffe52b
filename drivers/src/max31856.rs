//! MAX31856 thermocouple converter: registers over SPI, mode 1 or 3, most significant bit first.
//!
//! MAX31856 datasheet (19-7534 Rev 0), "Register Map": 00h configuration 0 (CR0), 01h configuration 1 (CR1),
//! 02h fault mask, 0Ch to 0Eh linearised thermocouple temperature of 19 bits with 2^-7 C, 0Fh fault status
//! (SR).

use embedded_hal::spi::{Operation, SpiDevice};
pub use units::Thermocouple;
use units::{Celsius, Micros};

use crate::max31865::Mains;

/// Highest SPI clock of the chip (datasheet, "Serial Interface": fSCL).
pub const MAX_SPI_CLOCK_HZ: u32 = 5_000_000;

mod register {
    pub const CR0: u8 = 0x00;
    pub const TEMPERATURE: u8 = 0x0C;
    pub const WRITE: u8 = 0x80;
}

/// Bits of the register CR0.
mod cr0 {
    /// Conversions follow each other continuously.
    pub const AUTOMATIC: u8 = 1 << 7;
    /// Looks for an open thermocouple every 16 conversions, with leads below 5 kOhm (OCFAULT 01).
    pub const FIND_OPEN: u8 = 1 << 4;
    pub const NOTCH_50_HZ: u8 = 1 << 0;
}

/// Bits of the register SR.
mod sr {
    pub const TC_RANGE: u8 = 1 << 6;
    pub const CJ_RANGE: u8 = 1 << 7;
    pub const VOLTAGE: u8 = 1 << 1;
    pub const OPEN: u8 = 1 << 0;
}

/// Settings of a chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// Type of the thermocouple.
    pub thermocouple: Thermocouple,
    /// Mains frequency of the filter, to be changed only while the chip does not convert.
    pub mains: Mains,
    /// Samples that make one reading: 1, 2, 4, 8 or 16; a number in between means the next lower.
    pub averaging: u8,
}

impl Settings {
    /// Returns the bytes for CR0 and CR1.
    #[must_use]
    pub const fn configuration(&self) -> [u8; 2] {
        let notch = if matches!(self.mains, Mains::Hz50) { cr0::NOTCH_50_HZ } else { 0 };
        [cr0::AUTOMATIC | cr0::FIND_OPEN | notch, self.average_exponent() << 4 | self.thermocouple as u8]
    }

    /// Returns the exponent of two for AVGSEL.
    const fn average_exponent(&self) -> u8 {
        match self.averaging {
            0 | 1 => 0,
            2..=3 => 1,
            4..=7 => 2,
            8..=15 => 3,
            _ => 4,
        }
    }

    /// Returns the longest time from one conversion to the next (datasheet, "Electrical Characteristics":
    /// tCONV, conversions 2 to n, 98 ms and at most 110 ms with the 50 Hz notch, 82 ms and at most 90 ms with
    /// that of 60 Hz; CR1, AVGSEL: what each sample more takes). The one in sixteen that looks for an open
    /// thermocouple is up to 15 ms longer.
    #[must_use]
    pub const fn conversion(&self) -> Micros {
        let [one, more] = if matches!(self.mains, Mains::Hz50) { [110_000, 20_000] } else { [90_000, 16_670] };
        Micros(one + more * ((1 << self.average_exponent()) - 1))
    }

    /// Returns the longest time from [`Max31856::set_up`] to the first conversion (the same places: 169 ms
    /// and at most 185 ms, 143 ms and at most 155 ms), with the look for an open thermocouple (CR0, OCFAULT
    /// 01 with the cold junction on: 13.3 ms, at most 15 ms).
    #[must_use]
    pub const fn first_conversion(&self) -> Micros {
        let [one, more] = if matches!(self.mains, Mains::Hz50) { [185_000, 40_000] } else { [155_000, 33_330] };
        Micros(15_000 + one + more * ((1 << self.average_exponent()) - 1))
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
    /// Thermocouple not connected (OPEN).
    Open,
    /// An input is above the supply or below ground (OVUV).
    Voltage,
    /// Colder or hotter than the thermocouple's type can be (TC Range).
    Range,
    /// The chip itself is colder than -55 C or hotter than 125 C (CJ Range).
    ColdJunction,
}

impl Fault {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Absent => "no MAX31856 answers: check spi_select_pin, its wires and its supply",
            Self::Low => "the MAX31856's data line stays low: check its supply and the wire to MISO",
            Self::Garbled => "the MAX31856 keeps no settings: check sensor, and the wires of the bus",
            Self::Reset => "the MAX31856 has lost its settings: check its supply",
            Self::Open => "thermocouple open: check its plug and wires",
            Self::Voltage => "a wire of the sensor touches a voltage: check insulation",
            Self::Range => "beyond what the thermocouple can be: check type and polarity",
            Self::ColdJunction => "the MAX31856 itself is too hot or too cold to measure",
        }
    }

    /// Returns the fault in SR, the likeliest cause first; `None` if no bit is set. The thresholds (bits 5 to
    /// 2) are not used.
    #[must_use]
    pub const fn of_status(status: u8) -> Option<Self> {
        if status & sr::VOLTAGE != 0 {
            Some(Self::Voltage)
        } else if status & sr::OPEN != 0 {
            Some(Self::Open)
        } else if status & sr::TC_RANGE != 0 {
            Some(Self::Range)
        } else if status & sr::CJ_RANGE != 0 {
            Some(Self::ColdJunction)
        } else {
            None
        }
    }
}

/// Decodes the thermocouple's temperature in 0Ch to 0Eh: 19 bits with sign, the last 2^-7 C.
#[must_use]
pub const fn celsius([high, middle, low]: [u8; 3]) -> Celsius {
    let code = i32::from_be_bytes([high, middle, low, 0]) >> 13;
    Celsius(code as f32 / 128.0)
}

/// Chip on its bus with its settings.
#[derive(Debug)]
pub struct Max31856<SPI> {
    spi: SPI,
    settings: Settings,
}

impl<SPI: SpiDevice> Max31856<SPI> {
    /// Creates a driver without contact to the chip.
    pub const fn new(spi: SPI, settings: Settings) -> Self {
        Self { spi, settings }
    }

    /// Tells the chip its settings. The first reading comes [`Settings::first_conversion`] later.
    ///
    /// # Errors
    /// When it does not read back what was written.
    pub fn set_up(&mut self) -> Result<(), Fault> {
        let [first, second] = self.settings.configuration();
        // The filter must be chosen while the chip does not convert.
        for bytes in [[first & !cr0::AUTOMATIC, second], [first, second]] {
            let frame = [register::CR0 | register::WRITE, bytes[0], bytes[1]];
            self.spi.write(&frame).map_err(|_| Fault::Absent)?;
        }
        if self.configuration()? == [first, second] { Ok(()) } else { Err(Fault::Garbled) }
    }

    /// Reads CR0 and CR1. After power-on the values are 00h and 03h ("Register Map"), so two alike bytes of
    /// zeros or ones come from a dead line.
    fn configuration(&mut self) -> Result<[u8; 2], Fault> {
        let mut kept = [0; 2];
        self.read_from(register::CR0, &mut kept)?;
        match kept {
            [0, 0] => Err(Fault::Low),
            [u8::MAX, u8::MAX] => Err(Fault::Absent),
            _ => Ok(kept),
        }
    }

    fn read_from(&mut self, register: u8, into: &mut [u8]) -> Result<(), Fault> {
        let mut operations = [Operation::Write(core::slice::from_ref(&register)), Operation::Read(into)];
        self.spi.transaction(&mut operations).map_err(|_| Fault::Absent)
    }

    /// Returns the latest conversion, by transfers of three and of five bytes. Faults follow the thermocouple
    /// by themselves (comparator mode), nothing has to be cleared.
    ///
    /// # Errors
    /// What the chip reports; that it has forgotten its settings, and has to be set up; or that no chip
    /// answers.
    pub fn read(&mut self) -> Result<Celsius, Fault> {
        if self.configuration()? != self.settings.configuration() {
            return Err(Fault::Reset);
        }
        let mut result = [0; 4];
        self.read_from(register::TEMPERATURE, &mut result)?;
        let [high, middle, low, status] = result;
        Fault::of_status(status).map_or_else(|| Ok(celsius([high, middle, low])), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::spi::{ErrorKind, ErrorType};
    use proptest::prelude::*;

    /// Model of the chip by its datasheet: sixteen registers with an auto-incremented address.
    struct Chip {
        registers: [u8; 16],
        is_there: bool,
    }

    impl Chip {
        /// Creates a chip after power-on ("Register Map", factory defaults).
        fn new() -> Self {
            let mut registers = [0; 16];
            (registers[1], registers[2]) = (0x03, 0xFF);
            Self { registers, is_there: true }
        }

        fn measures(&mut self, codes: i32, status: u8) {
            let [high, middle, low, _] = (codes << 13).to_be_bytes();
            self.registers[12..].copy_from_slice(&[high, middle, low, status]);
        }
    }

    impl ErrorType for &mut Chip {
        type Error = ErrorKind;
    }

    impl SpiDevice for &mut Chip {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
            let (mut at, mut first) = (0, true);
            for operation in operations {
                match operation {
                    Operation::Write(bytes) => {
                        for byte in bytes.iter() {
                            if core::mem::take(&mut first) {
                                at = usize::from(byte & 0x0F);
                            } else if at < 12 {
                                let stands = self.registers[0] & cr0::AUTOMATIC == 0;
                                let keeps = at != 0 || stands || self.registers[0] & 1 == byte & 1;
                                assert!(keeps, "the filter is changed while the chip converts");
                                self.registers[at] = *byte;
                                at += 1;
                            }
                        }
                    }
                    Operation::Read(into) => {
                        for byte in into.iter_mut() {
                            *byte = if self.is_there { self.registers[at % 16] } else { 0xFF };
                            at += 1;
                        }
                    }
                    _ => return Err(ErrorKind::Other),
                }
            }
            Ok(())
        }
    }

    fn driver(chip: &mut Chip, settings: Settings) -> Max31856<&mut Chip> {
        let mut driver = Max31856::new(chip, settings);
        driver.set_up().unwrap();
        driver
    }

    #[test]
    fn the_datasheet_s_example_codes_are_read() {
        // "Linearized Thermocouple Temperature Data": temperatures and codes.
        for (bytes, celsius) in [
            ([0x64, 0x00, 0x00], 1_600.0),
            ([0x3E, 0x80, 0x00], 1_000.0),
            ([0x06, 0x4F, 0x00], 100.937_5),
            ([0x01, 0x90, 0x00], 25.0),
            ([0x00, 0x01, 0x00], 0.062_5),
            ([0x00, 0x00, 0x00], 0.0),
            ([0xFF, 0xFF, 0x00], -0.062_5),
            ([0xF0, 0x60, 0x00], -250.0),
        ] {
            assert_eq!(super::celsius(bytes).0, celsius);
        }
    }

    #[test]
    fn every_type_and_mains_stands_in_its_bits() {
        use Thermocouple::{B, E, J, K, N, R, S, T};
        for (number, thermocouple) in [B, E, J, K, N, R, S, T].into_iter().enumerate() {
            let [first, second] = Settings { thermocouple, mains: Mains::Hz60, averaging: 4 }.configuration();
            assert_eq!((first, second), (0b1001_0000, 0b0010_0000 | number as u8));
            assert!(thermocouple.range()[0] < thermocouple.range()[1]);
        }
        assert_eq!(Settings::default().configuration(), [0b1001_0001, 0b0000_0011]);
        for (averaging, exponent) in [(1, 0), (2, 1), (4, 2), (8, 3), (16, 4)] {
            let settings = Settings { averaging, ..Settings::default() };
            assert_eq!(settings.configuration()[1] >> 4, exponent);
            assert!(settings.first_conversion() > settings.conversion());
        }
    }

    #[test]
    fn every_fault_has_its_bit_and_its_words() {
        let mut chip = Chip::new();
        let mut driver = driver(&mut chip, Settings::default());
        let mut words = Vec::new();
        for (status, fault) in [(1, Fault::Open), (2, Fault::Voltage), (64, Fault::Range), (128, Fault::ColdJunction)] {
            driver.spi.measures(3_200, status);
            assert_eq!(driver.read(), Err(fault));
            assert!(!words.contains(&fault.message()));
            words.push(fault.message());
        }
        driver.spi.measures(3_200, 0);
        assert_eq!(driver.read(), Ok(Celsius(25.0)));
    }

    #[test]
    fn a_chip_that_forgets_and_a_line_that_is_dead_are_told_apart() {
        let mut chip = Chip::new();
        let mut driver = driver(&mut chip, Settings::default());
        driver.spi.registers = Chip::new().registers;
        assert_eq!(driver.read(), Err(Fault::Reset));
        driver.set_up().unwrap();
        assert_eq!(driver.read(), Ok(Celsius(0.0)));
        driver.spi.is_there = false;
        assert_eq!(driver.read(), Err(Fault::Absent));
        assert_eq!(driver.set_up(), Err(Fault::Absent));
        driver.spi.is_there = true;
        driver.spi.registers = [0; 16];
        assert_eq!(driver.read(), Err(Fault::Low));
    }

    proptest! {
        #[test]
        fn a_temperature_survives_the_registers(code in -32_000_i32..232_960) {
            let mut chip = Chip::new();
            let mut driver = driver(&mut chip, Settings::default());
            driver.spi.measures(code, 0);
            prop_assert_eq!(driver.read(), Ok(Celsius(code as f32 / 128.0)));
        }
    }
}
