//! Tests of the MAX31865 with a model of the chip.

use super::*;
use embedded_hal::spi::{ErrorKind, ErrorType};
use proptest::prelude::*;

const PT100: Settings =
    Settings { platinum: Platinum::PT100, reference: Ohms(430.0), wires: Wires::Two, mains: Mains::Hz50 };

/// Model of the chip by its datasheet: eight registers with an auto-incremented address, faults by the
/// thresholds.
struct Chip {
    registers: [u8; 8],
    ratio: u16,
    is_there: bool,
    also: u8,
    /// Result of a test of the wires, and whether the test ends.
    finds: u8,
    ends: bool,
}

impl Chip {
    /// Creates a chip after power-on (table 1).
    fn new(ratio: u16) -> Self {
        Self { registers: [0, 0, 0, 0xFF, 0xFF, 0, 0, 0], ratio, is_there: true, also: 0, finds: 0, ends: true }
    }

    fn convert(&mut self) {
        if self.registers[0] & 0b1100 == 0b0100 && self.ends {
            assert_eq!(self.registers[0] & 0b1110_1110, 0b1000_0100, "100X010X");
            self.registers[0] &= !0b1100;
            self.registers[7] |= self.finds;
        }
        if self.registers[0] & 0b0100_0000 == 0 {
            return;
        }
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

/// Bus whose data line is at ground.
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
    for (status, fault) in [(2, Fault::Voltage), (6, Fault::Shorted), (7, Fault::Open)] {
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

/// Tests the bits of tables 10 to 12, and the likeliest cause.
#[test]
fn a_test_of_the_wires_finds_them_one_by_one_and_the_chip_converts_again() {
    for (finds, fault) in [
        (1 << 5, Fault::NoCurrent),
        (1 << 4 | 1 << 3, Fault::MinusGrounded),
        (1 << 3, Fault::Grounded),
        (1 << 2 | 1 << 5, Fault::Voltage),
    ] {
        let mut chip = Chip::new(8_192);
        let mut driver = set_up(&mut chip, Settings { wires: Wires::Three, ..PT100 });
        driver.spi.finds = finds;
        assert!(driver.read().is_ok(), "conversions do not show it");
        driver.begin_test().unwrap();
        assert_eq!(driver.end_test(), Err(fault));
        assert!(driver.read().is_ok(), "it converts, and the fault is cleared");
        driver.spi.finds = 0;
        driver.begin_test().unwrap();
        assert_eq!(driver.end_test(), Ok(()));
    }
}

#[test]
fn a_test_that_does_not_end_or_was_forgotten_is_no_pass() {
    let mut chip = Chip::new(8_192);
    let mut driver = set_up(&mut chip, PT100);
    driver.spi.ends = false;
    driver.begin_test().unwrap();
    assert_eq!(driver.end_test(), Err(Fault::Garbled));
    driver.spi.ends = true;
    driver.begin_test().unwrap();
    driver.spi.registers = Chip::new(0).registers;
    assert_eq!(driver.end_test(), Err(Fault::Reset));
    driver.spi.is_there = false;
    assert_eq!(driver.end_test(), Err(Fault::Absent));
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
