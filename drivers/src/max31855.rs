//! MAX31855 thermocouple converter: a 32-bit read-only frame, most significant bit first.
//!
//! MAX31855 datasheet (19-5793 Rev 5), tables 2 to 5: bits 31 to 18 thermocouple in quarter degrees, bit 16
//! any fault, bits 15 to 4 the cold junction in sixteenths, bits 2, 1 and 0 which fault, bits 17 and 3 always
//! zero. The frame is read with the clock resting low and sampled at its rising edge, mode 0 (figure 1). The
//! chip converts in the background, and takes a new result over only while it is not selected ("Serial
//! Interface").

use embedded_hal::spi::SpiDevice;
use units::{Celsius, Micros};

/// Highest SPI clock of the chip (datasheet, "Serial-Interface Timing Characteristics").
pub const MAX_SPI_CLOCK_HZ: u32 = 5_000_000;
/// Longest time of a conversion (datasheet, "Thermal Characteristics": tCONV, 70 ms, at most 100 ms).
pub const CONVERSION: Micros = Micros::from_millis(100);
/// Time from power-up to the first conversion (datasheet, "Thermal Characteristics": tCONV_PU).
pub const FIRST_CONVERSION: Micros = Micros::from_millis(200);

/// Possible thermocouple values, quarter degrees: -270 to 1800 C (datasheet, "General Description").
const POSSIBLE: core::ops::RangeInclusive<i16> = -270 * 4..=1_800 * 4;
/// Operating range of the chip itself, sixteenths of a degree: -40 to 125 C ("Recommended Operating
/// Conditions").
const CHIP_WORKS: core::ops::RangeInclusive<i16> = -40 * 16..=125 * 16;

/// Reason for a missing temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The bus failed, or nothing drives the data line: all ones.
    Absent,
    /// The data line stays low: all zeros.
    Low,
    /// A bit that must be zero is not, or a temperature is impossible.
    Garbled,
    /// Thermocouple not connected (OC).
    Open,
    /// Thermocouple shorted to ground (SCG).
    ShortToGround,
    /// Thermocouple shorted to the supply (SCV).
    ShortToSupply,
    /// The fault bit is set and no cause is given.
    Unknown,
}

impl Fault {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Absent => "no MAX31855 answers: check spi_select_pin, its wires and its supply",
            Self::Low => "the MAX31855's data line stays low: check its supply and the wire to MISO",
            Self::Garbled => "that is no MAX31855's answer: check sensor, and the wires of the bus",
            Self::Open => "thermocouple open: check its plug and wires",
            Self::ShortToGround => "thermocouple shorted to ground: check its insulation",
            Self::ShortToSupply => "thermocouple shorted to the supply: check its wires",
            Self::Unknown => "the MAX31855 reports a fault without a cause: check its wires",
        }
    }
}

/// Frame without a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Thermocouple, quarter degrees Celsius, -8192 to 8191.
    pub quarters: i16,
    /// Chip (cold junction), sixteenths of a degree, -2048 to 2047.
    pub cold_junction_sixteenths: i16,
}

impl Reading {
    /// Decodes a frame.
    ///
    /// # Errors
    /// What the chip reports, or that no chip reports.
    pub fn decode(frame: u32) -> Result<Self, Fault> {
        const MUST_BE_ZERO: u32 = 1 << 17 | 1 << 3;
        // A true all-zero frame would need both junctions at 0.00 C; a dead line is likelier, and off is the
        // safe side.
        match frame {
            0 => return Err(Fault::Low),
            u32::MAX => return Err(Fault::Absent),
            _ if frame & MUST_BE_ZERO != 0 => return Err(Fault::Garbled),
            _ => {}
        }
        let high = (frame >> 16) as u16;
        let low = frame as u16;
        let read = Self { quarters: high.cast_signed() >> 2, cold_junction_sixteenths: low.cast_signed() >> 4 };
        if !CHIP_WORKS.contains(&read.cold_junction_sixteenths) {
            return Err(Fault::Garbled);
        }
        if frame >> 16 & 1 == 1 {
            return Err(match frame & 0b111 {
                0b001 => Fault::Open,
                0b010 => Fault::ShortToGround,
                0b100 => Fault::ShortToSupply,
                _ => Fault::Unknown,
            });
        }
        if POSSIBLE.contains(&read.quarters) { Ok(read) } else { Err(Fault::Garbled) }
    }

    /// Returns the thermocouple temperature.
    #[must_use]
    pub fn celsius(self) -> Celsius {
        Celsius(f32::from(self.quarters) * 0.25)
    }
}

/// Most readings that are averaged.
const MOST: usize = 16;

/// The average of the last good readings.
#[derive(Clone, Copy, Debug)]
struct Average {
    quarters: [i16; MOST],
    window: usize,
    filled: usize,
    next: usize,
}

impl Average {
    /// Creates an average of so many readings, 1 to [`MOST`].
    fn of(window: u8) -> Self {
        Self { quarters: [0; MOST], window: usize::from(window).clamp(1, MOST), filled: 0, next: 0 }
    }

    fn push(&mut self, quarters: i16) -> Celsius {
        if let Some(place) = self.quarters.get_mut(self.next) {
            *place = quarters;
        }
        self.next = (self.next + 1) % self.window;
        self.filled = (self.filled + 1).min(self.window);
        let sum: i32 = self.quarters.iter().take(self.filled).map(|quarters| i32::from(*quarters)).sum();
        Celsius(sum as f32 * 0.25 / self.filled as f32)
    }

    /// Forgets the readings, as those from before a fault do not count after it.
    const fn forget(&mut self) {
        (self.filled, self.next) = (0, 0);
    }
}

/// Chip on its bus, without settings.
#[derive(Debug)]
pub struct Max31855<SPI> {
    spi: SPI,
    average: Average,
}

impl<SPI: SpiDevice> Max31855<SPI> {
    /// Creates a driver without contact to the chip. The last `averaging` readings make one, 1 to 16.
    pub fn new(spi: SPI, averaging: u8) -> Self {
        Self { spi, average: Average::of(averaging) }
    }

    /// Returns the average of the latest conversions, by a transfer of four bytes.
    ///
    /// # Errors
    /// What the chip reports, or that no chip answers.
    pub fn read(&mut self) -> Result<Celsius, Fault> {
        let mut frame = [0; 4];
        let read = self.spi.read(&mut frame).map_err(|_| Fault::Absent);
        match read.and_then(|()| Reading::decode(u32::from_be_bytes(frame))) {
            Ok(reading) => Ok(self.average.push(reading.quarters)),
            Err(fault) => {
                self.average.forget();
                Err(fault)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::spi::{ErrorKind, ErrorType, Operation};
    use proptest::prelude::*;

    #[test]
    fn the_datasheet_s_example_codes_are_read() {
        // Table 4 and 5: thermocouple and cold junction codes.
        for (code, celsius) in
            [(0b01_1001_0000_0000, 1_600.0), (0b00_0000_0110_0100, 25.0), (0b11_1111_1111_1111, -0.25)]
        {
            let reading = Reading::decode(code << 18 | 0x190 << 4).unwrap();
            assert_eq!((reading.celsius().0, reading.cold_junction_sixteenths), (celsius, 25 * 16));
        }
        let cold = Reading::decode(100 << 18 | 0b1111_1111_1111 << 4).unwrap();
        assert_eq!(cold.cold_junction_sixteenths, -1);
    }

    #[test]
    fn each_cause_has_its_name() {
        let fault = |cause: u32| Reading::decode(100 << 18 | 1 << 16 | cause).unwrap_err();
        assert_eq!(
            [1, 2, 4, 0, 3].map(fault),
            [Fault::Open, Fault::ShortToGround, Fault::ShortToSupply, Fault::Unknown, Fault::Unknown]
        );
        assert_eq!([0, u32::MAX].map(|dead| Reading::decode(dead).unwrap_err()), [Fault::Low, Fault::Absent]);
        // The frames have bits that must be zero, a chip at 126 C, or a thermocouple at 1801 C.
        for garbled in [100 << 18 | 1 << 17, 100 << 18 | 1 << 3, 100 << 18 | 0x7E0 << 4, 7_204 << 18 | 0x190 << 4] {
            assert_eq!(Reading::decode(garbled), Err(Fault::Garbled), "{garbled:#010x}");
        }
    }

    proptest! {
        #[test]
        fn a_temperature_survives_the_frame(quarters in -1_000_i16..6_400, sixteenths in -640_i16..2_000) {
            prop_assume!(quarters != 0 || sixteenths != 0);
            let frame = u32::from((quarters << 2).cast_unsigned()) << 16 | u32::from((sixteenths << 4).cast_unsigned());
            prop_assert_eq!(Reading::decode(frame), Ok(Reading { quarters, cold_junction_sixteenths: sixteenths }));
        }

        #[test]
        fn the_average_lies_among_the_last_ones(
            values in prop::collection::vec(-100_i16..4_000, 1..40),
            window in 1_u8..=16,
        ) {
            let mut average = Average::of(window);
            for (index, quarters) in values.iter().enumerate() {
                let celsius = average.push(*quarters);
                let last = &values[(index + 1).saturating_sub(usize::from(window))..=index];
                let (low, high) = (*last.iter().min().unwrap(), *last.iter().max().unwrap());
                prop_assert!((f32::from(low)..=f32::from(high)).contains(&(celsius.0 * 4.0)));
            }
        }
    }

    /// Chip that answers with this frame.
    struct Chip(u32);

    impl ErrorType for &mut Chip {
        type Error = ErrorKind;
    }

    impl SpiDevice for &mut Chip {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
            match operations {
                [Operation::Read(into)] if into.len() == 4 => into.copy_from_slice(&self.0.to_be_bytes()),
                _ => return Err(ErrorKind::Other),
            }
            Ok(())
        }
    }

    #[test]
    fn a_fault_is_told_at_once_and_what_was_read_before_is_forgotten() {
        let mut chip = Chip(400 << 18 | 0x190 << 4);
        let mut driver = Max31855::new(&mut chip, 4);
        assert_eq!(driver.read(), Ok(Celsius(100.0)));
        driver.spi.0 = 800 << 18 | 0x190 << 4;
        assert_eq!(driver.read(), Ok(Celsius(150.0)));
        driver.spi.0 |= 1 << 16 | 1;
        assert_eq!(driver.read(), Err(Fault::Open));
        driver.spi.0 = 800 << 18 | 0x190 << 4;
        assert_eq!(driver.read(), Ok(Celsius(200.0)));
    }
}
