//! MAX31855 thermocouple converter: a 32-bit read-only frame, most significant bit first.
//!
//! MAX31855 datasheet (19-5793 Rev 5), tables 2 to 5: bits 31 to 18 thermocouple in quarter degrees, bit 16
//! any fault, bits 15 to 4 the cold junction in sixteenths, bits 2, 1 and 0 which fault, bits 17 and 3 always
//! zero.

use units::Celsius;

/// SPI clock the chip takes at most (datasheet, "Serial-Interface Timing Characteristics").
pub const MAX_SPI_CLOCK_HZ: u32 = 5_000_000;

/// Why there is no temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing drives the data line, or it is stuck: all zeros, all ones, or a bit that must be zero is not.
    Absent,
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
    /// In words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Absent => "no MAX31855 answers: check its chip select, wiring and supply",
            Self::Open => "thermocouple open",
            Self::ShortToGround => "thermocouple shorted to ground",
            Self::ShortToSupply => "thermocouple shorted to the supply",
            Self::Unknown => "MAX31855 reports a fault without a cause",
        }
    }
}

/// One good frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Thermocouple, quarter degrees Celsius, -8192 to 8191.
    pub quarters: i16,
    /// Chip (cold junction), sixteenths of a degree, -2048 to 2047.
    pub cold_junction_sixteenths: i16,
}

impl Reading {
    /// Takes a frame apart.
    ///
    /// # Errors
    /// What the chip reports, or that no chip reports.
    pub const fn decode(frame: u32) -> Result<Self, Fault> {
        const MUST_BE_ZERO: u32 = 1 << 17 | 1 << 3;
        // A true all-zero frame would need both junctions at 0.00 C; a dead line is likelier, and off is the
        // safe side.
        if frame == 0 || frame & MUST_BE_ZERO != 0 {
            return Err(Fault::Absent);
        }
        if frame >> 16 & 1 == 1 {
            return Err(match frame & 0b111 {
                0b001 => Fault::Open,
                0b010 => Fault::ShortToGround,
                0b100 => Fault::ShortToSupply,
                _ => Fault::Unknown,
            });
        }
        let high = (frame >> 16) as u16;
        let low = frame as u16;
        Ok(Self { quarters: high.cast_signed() >> 2, cold_junction_sixteenths: low.cast_signed() >> 4 })
    }

    /// Thermocouple temperature.
    #[must_use]
    pub fn celsius(self) -> Celsius {
        Celsius(f32::from(self.quarters) * 0.25)
    }

    /// Chip temperature.
    #[must_use]
    pub fn cold_junction(self) -> Celsius {
        Celsius(f32::from(self.cold_junction_sixteenths) / 16.0)
    }
}

/// How many good readings are averaged, and how many faults in a row it takes to have no temperature.
const WINDOW: u8 = 4;

/// The average of the last good readings. Single disturbed frames are passed over; four in a row are not.
#[derive(Clone, Copy, Debug, Default)]
pub struct Average {
    quarters: [i16; WINDOW as usize],
    filled: u8,
    next: u8,
    faults: u8,
}

impl Average {
    /// Takes the next frame; gives the temperature, or the fault that has lasted.
    ///
    /// # Errors
    /// The last fault, when four frames in a row were faulty or no good one has come yet.
    pub fn push(&mut self, frame: Result<Reading, Fault>) -> Result<Celsius, Fault> {
        match frame {
            Ok(reading) => {
                if let Some(place) = self.quarters.get_mut(usize::from(self.next)) {
                    *place = reading.quarters;
                }
                self.next = (self.next + 1) % WINDOW;
                self.filled = (self.filled + 1).min(WINDOW);
                self.faults = 0;
            }
            Err(fault) => {
                self.faults = (self.faults + 1).min(WINDOW);
                if self.faults == WINDOW {
                    // Readings from before the fault say nothing about after it.
                    self.filled = 0;
                    self.next = 0;
                }
                if self.filled == 0 {
                    return Err(fault);
                }
            }
        }
        let sum: i32 = self.quarters.iter().take(usize::from(self.filled)).map(|q| i32::from(*q)).sum();
        Ok(Celsius(sum as f32 * 0.25 / f32::from(self.filled)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_datasheet_s_example_codes_are_read() {
        // Table 4 and 5: thermocouple and cold junction codes.
        for (code, celsius) in
            [(0b01_1001_0000_0000, 1_600.0), (0b00_0000_0110_0100, 25.0), (0b11_1111_1111_1111, -0.25)]
        {
            let reading = Reading::decode(code << 18 | 0x190 << 4).unwrap();
            assert_eq!((reading.celsius().0, reading.cold_junction().0), (celsius, 25.0));
        }
        let cold = Reading::decode(100 << 18 | 0b1111_1111_1111 << 4).unwrap();
        assert_eq!(cold.cold_junction().0, -0.0625);
    }

    #[test]
    fn each_cause_has_its_name() {
        let fault = |cause: u32| Reading::decode(100 << 18 | 1 << 16 | cause).unwrap_err();
        assert_eq!(
            [1, 2, 4, 0, 3].map(fault),
            [Fault::Open, Fault::ShortToGround, Fault::ShortToSupply, Fault::Unknown, Fault::Unknown]
        );
        assert_eq!([0, u32::MAX].map(|dead| Reading::decode(dead).unwrap_err()), [Fault::Absent; 2]);
    }

    proptest! {
        #[test]
        fn a_temperature_survives_the_frame(quarters in -1_000_i16..6_400, sixteenths in -640_i16..2_000) {
            prop_assume!(quarters != 0 || sixteenths != 0);
            let frame = u32::from((quarters << 2).cast_unsigned()) << 16 | u32::from((sixteenths << 4).cast_unsigned());
            prop_assert_eq!(Reading::decode(frame), Ok(Reading { quarters, cold_junction_sixteenths: sixteenths }));
        }

        #[test]
        fn the_average_lies_among_the_last_four(values in prop::collection::vec(-100_i16..4_000, 1..20)) {
            let mut average = Average::default();
            for (index, quarters) in values.iter().enumerate() {
                let celsius = average.push(Ok(Reading { quarters: *quarters, cold_junction_sixteenths: 0 })).unwrap();
                let last = &values[index.saturating_sub(3)..=index];
                let (low, high) = (*last.iter().min().unwrap(), *last.iter().max().unwrap());
                prop_assert!((f32::from(low)..=f32::from(high)).contains(&(celsius.0 * 4.0)));
            }
        }
    }

    #[test]
    fn three_bad_frames_are_passed_over_and_the_fourth_is_a_fault() {
        let mut average = Average::default();
        let good = Ok(Reading { quarters: 800, cold_junction_sixteenths: 400 });
        assert_eq!(average.push(Err(Fault::Open)), Err(Fault::Open));
        assert_eq!(average.push(good), Ok(Celsius(200.0)));
        for _ in 0..3 {
            assert_eq!(average.push(Err(Fault::Open)), Ok(Celsius(200.0)));
        }
        assert_eq!(average.push(Err(Fault::Open)), Err(Fault::Open));
        assert_eq!(average.push(Err(Fault::Open)), Err(Fault::Open));
        assert_eq!(average.push(good), Ok(Celsius(200.0)));
    }
}
