//! Tests with chips whose answers depend on the order and the time of the questions.

extern crate std;

use core::cell::{Cell, RefCell};
use std::rc::Rc;
use std::vec::Vec as List;

use config::{SensorConfig, SensorKind, SpiSensorConfig};
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};

use super::*;

/// Model of a MAX31855 with this frame, or of a MAX31865 that keeps its registers, with a count of its
/// requests.
#[derive(Clone, Default)]
struct Line {
    frame: Rc<Cell<u32>>,
    registers: Rc<RefCell<[u8; 8]>>,
    asked: Rc<Cell<u32>>,
    /// Fault bits that a test of the wires finds.
    finds: Rc<Cell<u8>>,
    /// Whether nothing drives the data line.
    is_dead: Rc<Cell<bool>>,
}

impl ErrorType for Line {
    type Error = ErrorKind;
}

impl SpiDevice for Line {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        self.asked.set(self.asked.get() + 1);
        match operations {
            [.., Operation::Read(into)] if self.is_dead.get() => into.fill(0xFF),
            [Operation::Read(into)] => into.copy_from_slice(&self.frame.get().to_be_bytes()),
            [Operation::Write(bytes)] => {
                let at = usize::from(bytes[0] & 0x7F);
                let mut registers = self.registers.borrow_mut();
                registers[at..at + bytes.len() - 1].copy_from_slice(&bytes[1..]);
                if registers[0] & 2 != 0 {
                    registers[7] = 0;
                }
                if registers[0] & 0b1100 == 0b0100 {
                    registers[7] |= self.finds.get();
                }
                registers[0] &= !0b1110;
            }
            [Operation::Write(_), Operation::Read(into)] => into.copy_from_slice(&*self.registers.borrow()),
            _ => return Err(ErrorKind::Other),
        }
        Ok(())
    }
}

const GOOD: u32 = 400 << 18 | 0x190 << 4;
const OPEN: u32 = GOOD | 1 << 16 | 1;

fn config(kind: SensorKind, readings_per_second: u16) -> SensorConfig {
    let spi = SpiSensorConfig {
        averaging: 1,
        rtd_nominal: units::Ohms(100.0),
        rtd_reference: units::Ohms(430.0),
        ..SpiSensorConfig::default()
    };
    SensorConfig { kind, spi, readings_per_second, ..SensorConfig::default() }
}

fn bank(kind: SensorKind, readings_per_second: u16) -> (SensorBank<Line>, Line) {
    let (mut bank, line) = (SensorBank::default(), Line::default());
    line.frame.set(GOOD);
    assert!(bank.add(3, &config(kind, readings_per_second), line.clone()));
    (bank, line)
}

/// Returns the readings, polled at every hundredth of a second from `from_ms` on, with their times.
fn readings(bank: &mut SensorBank<Line>, from_ms: u64, to_ms: u64) -> List<(u64, DatedReading)> {
    let run = |ms| bank.poll(Micros::from_millis(ms)).map(|(controller, reading)| (controller, ms, reading));
    let read = (from_ms..to_ms).step_by(10).filter_map(run);
    read.map(|(controller, ms, reading)| {
        assert_eq!(controller, 3);
        (ms, reading)
    })
    .collect()
}

fn degrees(thousandths: i32) -> SensorReading {
    SensorReading::MilliDegrees(thousandths)
}

#[test]
fn a_chip_is_read_as_often_as_is_asked_for_and_it_converts() {
    for (per_second, period_ms) in [(20, 100), (100, 100), (5, 200), (1, 1_000)] {
        let (mut bank, _) = bank(SensorKind::Max31855, per_second);
        let read = readings(&mut bank, 1_000, 5_000);
        assert!(read.windows(2).all(|pair| pair[1].0 - pair[0].0 == period_ms), "{per_second}: {read:?}");
        assert!(read.iter().all(|(_, dated)| dated.reading == degrees(100_000)));
        let (last_ms, last) = *read.last().unwrap();
        let at = |ms| last.at(Micros::from_millis(last_ms + ms));
        assert_eq!([at(4 * period_ms), at(4 * period_ms + 1)], [degrees(100_000), SensorReading::Missing]);
    }
}

#[test]
fn a_fault_is_told_at_once_and_asked_for_again_soon() {
    let (mut bank, line) = bank(SensorKind::Max31855, 10);
    readings(&mut bank, 0, 1_000);
    line.frame.set(OPEN);
    let read = readings(&mut bank, 1_000, 1_400);
    let words = drivers::max31855::Fault::Open.message();
    assert!(read.iter().all(|(_, dated)| dated.reading == SensorReading::Fault(words)));
    assert!(read.windows(2).all(|pair| pair[1].0 - pair[0].0 == 50), "{read:?}");
    line.frame.set(GOOD);
    assert_eq!(readings(&mut bank, 1_400, 1_500)[0].1.reading, degrees(100_000));
}

#[test]
fn a_chip_that_was_reset_is_set_up_told_and_left_to_convert() {
    let (mut bank, line) = bank(SensorKind::Max31865, 10);
    assert!(bank.poll(Micros(0)).is_none(), "set up, and nothing to read");
    let ratio = (100.0 / 430.0 * 32_768.0) as u16;
    line.registers.borrow_mut()[1..3].copy_from_slice(&(ratio << 1).to_be_bytes());
    let read = readings(&mut bank, 10, 500);
    assert_eq!(read[0].0, 90, "the test of the wires, and the first conversion, which takes 76 ms");
    assert!(matches!(read[0].1.reading, SensorReading::MilliDegrees(-60..60)), "{read:?}");
    *line.registers.borrow_mut() = [0, 0, 0, 0xFF, 0xFF, 0, 0, 0];
    let read = readings(&mut bank, 500, 800);
    let words = drivers::max31865::Fault::Reset.message();
    assert_eq!(read[0].1.reading, SensorReading::Fault(words));
    assert_eq!(line.registers.borrow()[0], 0b1100_0001, "told again");
    assert_eq!(read[1].0 - read[0].0, 90);
}

#[test]
fn a_chip_that_comes_later_is_set_up_when_it_answers() {
    let (mut bank, line) = bank(SensorKind::Max31865, 10);
    line.is_dead.set(true);
    let read = readings(&mut bank, 0, 200);
    let words = drivers::max31865::Fault::Absent.message();
    assert!(read.len() == 4 && read.iter().all(|(_, dated)| dated.reading == SensorReading::Fault(words)), "{read:?}");
    line.is_dead.set(false);
    assert!(bank.poll(Micros::from_millis(200)).is_none() && line.registers.borrow()[0] == 0b1000_0001, "it tests");
    assert!(bank.poll(Micros::from_millis(210)).is_none() && line.registers.borrow()[0] == 0b1100_0001, "it converts");
}

/// The wires are tested every five seconds without delaying a reading; a bad wire is reported until it is
/// sound.
#[test]
fn the_wires_of_platinum_are_tested_again_and_again() {
    let (mut bank, line) = bank(SensorKind::Max31865, 10);
    let ratio = (100.0 / 430.0 * 32_768.0) as u16;
    let read = readings(&mut bank, 0, 200);
    assert!(!read.is_empty());
    line.registers.borrow_mut()[1..3].copy_from_slice(&(ratio << 1).to_be_bytes());
    let read = readings(&mut bank, 200, 12_000);
    assert!(read.windows(2).all(|pair| pair[1].0 - pair[0].0 == 100), "{read:?}");
    line.finds.set(1 << 5);
    let read = readings(&mut bank, 12_000, 18_000);
    let words = drivers::max31865::Fault::NoCurrent.message();
    let found = read.iter().position(|(_, dated)| dated.reading == SensorReading::Fault(words)).expect("it is found");
    assert!(read[found].0 < 17_200, "within the five seconds: {} ms", read[found].0);
    let told = &read[found..];
    assert!(told.iter().all(|(_, dated)| dated.reading == SensorReading::Fault(words)), "until it is mended");
    assert!(told.windows(2).all(|pair| pair[1].0 - pair[0].0 == 60), "{told:?}");
    line.finds.set(0);
    let read = readings(&mut bank, 18_000, 18_300);
    assert!(matches!(read.last(), Some((_, dated)) if matches!(dated.reading, SensorReading::MilliDegrees(-60..60))));
}

#[test]
fn the_one_that_waits_longest_is_next() {
    let mut bank = SensorBank::default();
    let lines: List<Line> = (0..8).map(|_| Line::default()).collect();
    for (place, line) in lines.iter().enumerate() {
        line.frame.set(GOOD);
        assert!(bank.add(place, &config(SensorKind::Max31855, 100), line.clone()));
    }
    for run in 0..1_000 {
        bank.poll(Micros::from_millis(run * 10));
    }
    // Ten seconds at 10 Hz, of which the first set-up takes 0.2 s.
    assert!(lines.iter().all(|line| (90..=100).contains(&line.asked.get())), "{:?}", lines[0].asked);
    assert!(!bank.add(8, &config(SensorKind::Max31855, 1), Line::default()), "no room");
    assert!(!SensorBank::default().add(0, &config(SensorKind::Thermistor, 1), Line::default()));
}
