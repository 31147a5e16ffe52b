//! Tests of the drivers against models of the chips in memory, at the level of datagrams.

use super::register::{self, Register};
use super::*;
use crate::register::Field;
use crate::{CurrentFit, Error, Microsteps};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use proptest::prelude::*;
use std::cell::RefCell;
use std::convert::Infallible;
use units::{Amps, Ohms};

/// Model of the registers behind a bus: answers the question of the datagram before.
struct Memory {
    chip: StealthChip,
    words: [u32; 128],
    asked: usize,
    status: u8,
    /// Byte that the line gives instead of the chip's answer, if set.
    line: Option<u8>,
    heard: Vec<[u8; 5]>,
}

impl Memory {
    fn new(chip: StealthChip) -> RefCell<Self> {
        let mut words = [0; 128];
        words[0x01] = 1;
        words[0x04] = chip.version() << 24 | 0x10;
        RefCell::new(Self { chip, words, asked: 0, status: 0, line: None, heard: Vec::new() })
    }
}

struct Bus<'a>(&'a RefCell<Memory>);

impl ErrorType for Bus<'_> {
    type Error = Infallible;
}

impl SpiDevice for Bus<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut chip = self.0.borrow_mut();
        for operation in operations {
            let Operation::TransferInPlace(bytes) = operation else { panic!("another operation") };
            let datagram: [u8; 5] = (&**bytes).try_into().expect("40 bits");
            chip.heard.push(datagram);
            if let Some(line) = chip.line {
                bytes.fill(line);
                continue;
            }
            let value = chip.words[chip.asked].to_be_bytes();
            bytes[0] = chip.status;
            bytes[1..].copy_from_slice(&value);
            let [address, data @ ..] = datagram;
            let (place, data) = (usize::from(address & 0x7F), u32::from_be_bytes(data));
            let reads_to_clear = chip.chip == StealthChip::Tmc2130;
            match (address & 0x80 != 0, place) {
                (true, 0x01) if !reads_to_clear => chip.words[1] &= !data,
                (true, 0x01 | 0x04) => {}
                (true, place) => chip.words[place] = data,
                (false, _) => {}
            }
            // Reading the register cleared it.
            if reads_to_clear && chip.asked == 1 {
                chip.words[1] = 0;
            }
            chip.asked = place;
        }
        Ok(())
    }
}

fn driver(memory: &RefCell<Memory>, settings: StealthSettings) -> StealthDriver<SpiRegisters<Bus<'_>>> {
    let chip = memory.borrow().chip;
    StealthDriver::new(SpiRegisters(Bus(memory)), chip, settings).expect("settings of these chips")
}

fn word(memory: &RefCell<Memory>, register: Register) -> u32 {
    memory.borrow().words[usize::from(register.address)]
}

const SENSE: Ohms = Ohms(0.075);
const ON_SPI: [StealthChip; 3] = [StealthChip::Tmc2130, StealthChip::Tmc5160, StealthChip::Tmc2240];

fn resistor(chip: StealthChip) -> Ohms {
    match chip {
        StealthChip::Tmc2130 => Ohms(0.11),
        StealthChip::Tmc5160 => SENSE,
        StealthChip::Tmc2240 => Ohms(12_000.0),
        StealthChip::Tmc2208 | StealthChip::Tmc2209 => unreachable!("they are on a UART"),
    }
}

#[test]
fn a_tmc5160_is_sent_what_its_datasheet_says() {
    let memory = Memory::new(StealthChip::Tmc5160);
    let mut driver = driver(&memory, StealthSettings::new(SENSE));
    // 256 * 2 A * 0.075 Ohm / 0.325 V = 118.2
    driver.store_current(Amps(2.0));
    assert!(memory.borrow().heard.is_empty());
    driver.start().unwrap();
    driver.enable().unwrap();
    let heard = memory.borrow().heard.clone();
    let writes: Vec<_> = heard.iter().filter(|datagram| datagram[0] & 0x80 != 0).collect();
    // The write has MRES 4 for 16 microsteps, TPFD 4, and the example's 000100C3.
    assert_eq!(writes.last(), Some(&&[0xEC, 0x04, 0x41, 0x00, 0xC3]));
    for expected in [
        [0xEC, 0x04, 0x41, 0x00, 0xC0],
        [0x80, 0, 0, 0, 0x08],
        [0x8B, 0, 0, 0, 118],
        [0x90, 0, 6, 31, 31],
        [0x93, 0, 0, 0, 0],
        [0xF0, 0xC4, 0x0C, 0x00, 0x1E],
        [0x81, 0, 0, 0, 0x1F],
    ] {
        assert!(writes.contains(&&expected), "{expected:02x?} is not in {writes:02x?}");
    }
}

#[test]
fn each_register_has_an_address_of_its_own_and_its_fields_do_not_overlap() {
    for (place, one) in register::ALL.iter().enumerate() {
        assert!(one.address < 0x80);
        assert!(register::ALL[..place].iter().all(|other| other.address != one.address && other.name != one.name));
    }
    for fields in field_lists() {
        let mut taken = 0;
        for field in fields {
            assert_eq!(taken & field.mask(), 0, "{}", field.name);
            taken |= field.mask();
        }
    }
}

fn field_lists() -> [&'static [Field]; 8] {
    [
        register::gconf::FIELDS,
        register::gstat::FIELDS,
        register::ioin::FIELDS,
        register::drv_conf::FIELDS,
        register::ihold_irun::FIELDS,
        register::chopconf::FIELDS,
        register::coolconf::FIELDS,
        register::drv_status::FIELDS,
    ]
}

#[test]
fn a_dead_line_another_chip_and_one_that_does_not_listen_are_told_apart() {
    for chip in ON_SPI {
        let memory = Memory::new(chip);
        let mut driver = driver(&memory, StealthSettings::new(resistor(chip)));
        for line in [0x00, 0xFF] {
            memory.borrow_mut().line = Some(line);
            assert_eq!(driver.start(), Err(Error::Absent));
            assert_eq!(driver.status(), Err(Error::Absent));
            assert_eq!(driver.enable(), Err(Error::Absent));
            assert_eq!(driver.set_current(Amps(1.0)), Err(Error::Absent));
        }
        memory.borrow_mut().line = None;
        assert_eq!(driver.start(), Ok(()));
        memory.borrow_mut().words[4] = 0x2100_0000;
        assert!(matches!(driver.start(), Err(Error::WrongAnswer(0x2100_0000))));
    }
}

#[test]
fn a_reset_is_seen_until_the_chip_is_set_up_again() {
    for chip in ON_SPI {
        let memory = Memory::new(chip);
        let mut driver = driver(&memory, StealthSettings::new(resistor(chip)));
        driver.set_current(Amps(0.5)).unwrap();
        driver.start().unwrap();
        assert!(!driver.status().unwrap().reset, "{}", chip.name());
        {
            let mut memory = memory.borrow_mut();
            memory.words[1] = 1;
            memory.words[0x6C] = 0;
        }
        for _ in 0..3 {
            assert!(driver.status().unwrap().reset, "{}", chip.name());
        }
        driver.start().unwrap();
        assert!(!driver.status().unwrap().reset, "{}", chip.name());
    }
}

#[test]
fn each_flag_of_the_status_is_its_own_bit() {
    let of = |bit: u32| StealthStatus::decode(StealthChip::Tmc5160, 1 << bit, 0);
    assert!(of(31).standstill && of(30).open_load[1] && of(29).open_load[0]);
    assert!(of(28).short[1] && of(27).short[0] && of(26).over_temperature_warning && of(25).over_temperature);
    assert!(of(12).supply_short[0] && of(13).supply_short[1] && of(14).stealth);
    assert_eq!((of(9).stall_guard, of(20).current_scale), (512, 16));
    let old = StealthStatus::decode(StealthChip::Tmc2130, 0x7000, 0b101);
    assert_eq!(old, StealthStatus { reset: true, charge_pump_low: true, ..StealthStatus::default() });
}

/// Worked out by hand: 0.32 V / 0.13 Ohm / 1.414, 0.18 V / 0.13 Ohm / 1.414, 0.325 V / 0.075 Ohm / 1.414; and
/// the three ranges of a TMC2240 with 12 kOhm, about 1 A, 2 A and 3 A peak.
#[test]
fn full_scale_is_what_the_equations_say() {
    let rms = |chip: StealthChip, low, range| chip.full_scale(resistor(chip), low, range).0 / 2_f32.sqrt();
    for (is, says) in [
        (rms(StealthChip::Tmc2130, false, 0), 1.74),
        (rms(StealthChip::Tmc2130, true, 0), 0.98),
        (rms(StealthChip::Tmc5160, false, 0), 3.06),
        (StealthChip::Tmc2240.full_scale(Ohms(12_000.0), false, 0).0, 1.0),
        (StealthChip::Tmc2240.full_scale(Ohms(12_000.0), false, 1).0, 2.0),
        (StealthChip::Tmc2240.full_scale(Ohms(12_000.0), false, 2).0, 3.0),
    ] {
        assert!((is - says).abs() < 0.025, "{is} A, not {says} A");
    }
}

#[test]
fn the_range_of_a_tmc2240_rises_and_stays() {
    let memory = Memory::new(StealthChip::Tmc2240);
    let mut driver = driver(&memory, StealthSettings::new(Ohms(12_000.0)));
    for (amps, range) in [(0.5, 0), (1.5, 1), (0.5, 1), (2.9, 2), (0.2, 2)] {
        let set = driver.set_current(Amps(amps)).unwrap();
        assert_eq!((set.range, word(&memory, register::DRV_CONF)), (range, u32::from(range)), "{amps} A");
        assert!((set.actual.0 - amps).abs() < 0.02, "{amps} A becomes {}", set.actual);
    }
}

#[test]
fn a_speed_becomes_the_time_of_a_step() {
    // 12 MHz, 500 full steps a second, 256 microsteps: 93.75 clocks.
    assert_eq!(step_time(StealthChip::Tmc5160, 500.0), 94);
    assert_eq!(step_time(StealthChip::Tmc5160, 0.0), 0xF_FFFF);
}

/// SGT and SFILT of COOLCONF, TCOOLTHRS, and spreadCycle, which stallGuard2 needs; and back.
#[test]
fn a_search_measures_load_with_spread_cycle_and_ends_with_what_was_set_before() {
    for chip in ON_SPI {
        let memory = Memory::new(chip);
        let cool_step = crate::CoolStep {
            lower_threshold: 3,
            threshold_width: 4,
            increment: 2,
            decrement: 1,
            quarter_current: true,
        };
        let settings = StealthSettings {
            stealth_threshold: Some(94),
            stall_threshold: -5,
            stall_filter: true,
            load_from: Some(300),
            cool_step: Some(cool_step),
            ..StealthSettings::new(resistor(chip))
        };
        let mut driver = driver(&memory, settings);
        driver.store_current(Amps(0.9));
        driver.start().unwrap();
        driver.enable().unwrap();
        assert_eq!(word(&memory, register::COOLCONF), 1 << 24 | 0x7B << 16 | 1 << 15 | 1 << 13 | 4 << 8 | 2 << 5 | 3);
        assert_eq!(word(&memory, register::TCOOLTHRS), 300);
        let (words, current) = (memory.borrow().words, *driver.current());
        driver.begin_search(3, Some(Amps(0.5))).unwrap();
        assert_eq!((word(&memory, register::COOLCONF), word(&memory, register::TCOOLTHRS)), (3 << 16, 0xF_FFFF));
        assert_eq!(word(&memory, register::GCONF) & 0b1_1000_0100, 0b1_1000_0000, "spreadCycle, both outputs");
        assert_eq!(word(&memory, register::CHOPCONF) & 15, 3, "it keeps its current");
        assert!((driver.current().actual.0 - 0.5).abs() < 0.03);
        driver.begin_search(4, Some(Amps(0.4))).unwrap();
        memory.borrow_mut().words[0x6F] = 345;
        assert_eq!(driver.reserve(), Ok(345));
        memory.borrow_mut().words[0x6F] = words[0x6F];
        driver.end_search().unwrap();
        assert_eq!((memory.borrow().words, *driver.current()), (words, current), "{}", chip.name());
        assert!(matches!(driver.begin_search(64, None), Err(Error::Setting(_))));
        // A chip absent at the end of the search gets the current when it is enabled.
        driver.begin_search(4, Some(Amps(0.4))).unwrap();
        memory.borrow_mut().line = Some(0xFF);
        assert_eq!(driver.end_search(), Err(Error::Absent));
        memory.borrow_mut().line = None;
        driver.enable().unwrap();
        let mut after = memory.borrow().words;
        after[1] = words[1];
        assert_eq!((after, *driver.current()), (words, current));
    }
}

/// Returns the peak current of the words on the wire, by the datasheets' equations.
fn flowing(memory: &RefCell<Memory>, chip: StealthChip, resistor: Ohms) -> f32 {
    let cs = (word(memory, register::IHOLD_IRUN) >> 8 & 31) as f32;
    let scaler = match word(memory, register::GLOBALSCALER) {
        0 => 1.0,
        scaler => scaler as f32 / 256.0,
    };
    let full = match chip {
        StealthChip::Tmc2130 if word(memory, register::CHOPCONF) & 1 << 17 != 0 => 0.18 / (resistor.0 + 0.02),
        StealthChip::Tmc2130 => 0.32 / (resistor.0 + 0.02),
        StealthChip::Tmc5160 => 0.325 / resistor.0,
        StealthChip::Tmc2208 | StealthChip::Tmc2209 => unreachable!("they are on a UART"),
        StealthChip::Tmc2240 => [11_750.0, 24_000.0, 36_000.0][word(memory, register::DRV_CONF) as usize] / resistor.0,
    };
    (cs + 1.0) / 32.0 * scaler * full
}

proptest! {
    #[test]
    fn a_field_holds_what_is_put_and_disturbs_no_other(start: u32, value: u32) {
        for field in field_lists().into_iter().flatten() {
            let value = value & field.max();
            let word = field.put(start, value);
            prop_assert_eq!(field.get(word), value);
            prop_assert_eq!(word & !field.mask(), start & !field.mask());
        }
    }

    #[test]
    fn every_word_that_is_written_is_read_back(address in 0x60_u8..0x6A, value: u32) {
        let memory = Memory::new(StealthChip::Tmc5160);
        let mut bus = SpiRegisters(Bus(&memory));
        bus.write(address, value).unwrap();
        prop_assert_eq!(bus.read([address, 0x04]).unwrap(), [value, 0x3000_0010]);
    }

    #[test]
    fn the_current_on_the_wire_is_within_a_scale_step_of_what_was_asked(
        first in 0.0_f32..6.0,
        amps in 0.0_f32..6.0,
        place in 0_usize..3,
    ) {
        let chip = ON_SPI[place];
        let memory = Memory::new(chip);
        let mut driver = driver(&memory, StealthSettings::new(resistor(chip)));
        driver.set_current(Amps(first)).unwrap();
        let set = driver.set_current(Amps(amps)).unwrap();
        let flows = flowing(&memory, chip, resistor(chip));
        prop_assert!((flows - set.actual.0).abs() < 1e-4);
        let full = chip.full_scale(resistor(chip), set.low_range, set.range).0;
        let step = if chip.has_global_scaler() { full / 256.0 } else { full / 32.0 };
        if set.fit == CurrentFit::Limited {
            prop_assert!(flows <= amps && (flows - chip.most(resistor(chip)).0).abs() < 1e-4);
        } else {
            prop_assert!((flows - amps).abs() <= step * 0.51 || amps < step, "{flows} A for {amps} A");
        }
    }

    #[test]
    fn nothing_on_the_way_is_more_than_the_larger_of_two_currents(
        first in 0.05_f32..4.0,
        second in 0.05_f32..4.0,
        place in 0_usize..3,
    ) {
        let chip = ON_SPI[place];
        let memory = Memory::new(chip);
        let mut driver = driver(&memory, StealthSettings::new(resistor(chip)));
        driver.set_current(Amps(first)).unwrap();
        driver.start().unwrap();
        let before = flowing(&memory, chip, resistor(chip));
        memory.borrow_mut().heard.clear();
        let copy = memory.borrow().words;
        driver.set_current(Amps(second)).unwrap();
        let after = flowing(&memory, chip, resistor(chip));
        let heard = memory.borrow().heard.clone();
        memory.borrow_mut().words = copy;
        for [address, data @ ..] in heard.into_iter().filter(|datagram| datagram[0] & 0x80 != 0) {
            memory.borrow_mut().words[usize::from(address & 0x7F)] = u32::from_be_bytes(data);
            let between = flowing(&memory, chip, resistor(chip));
            prop_assert!(between <= before.max(after) + 1e-4, "{between} A between {before} A and {after} A");
        }
    }

    #[test]
    fn settings_arrive_in_their_fields(
        count in 0_u32..9,
        interpolation: bool,
        threshold in proptest::option::of(0_u32..1 << 20),
        off_time in 1_u8..16,
        start in 1_u8..9,
        end in -3_i8..7,
        place in 0_usize..3,
    ) {
        let chip = ON_SPI[place];
        let memory = Memory::new(chip);
        let settings = StealthSettings {
            microsteps: Microsteps::from_count(1 << count).unwrap(),
            interpolation,
            stealth_threshold: threshold,
            off_time,
            hysteresis_start: start,
            hysteresis_end: end,
            ..StealthSettings::new(resistor(chip))
        };
        let mut driver = driver(&memory, settings);
        driver.start().unwrap();
        driver.enable().unwrap();
        use register::chopconf as c;
        let chopconf = word(&memory, register::CHOPCONF);
        prop_assert_eq!(256 >> c::MRES.get(chopconf), 1 << count);
        prop_assert_eq!((c::TOFF.get(chopconf), c::INTPOL.get(chopconf)), (u32::from(off_time), u32::from(interpolation)));
        prop_assert_eq!((c::HSTRT.get(chopconf) as i8 + 1, c::HEND.get(chopconf) as i8 - 3), (start as i8, end));
        prop_assert_eq!((c::TBL.get(chopconf), c::DEDGE.get(chopconf)), (2, 0));
        prop_assert_eq!(word(&memory, register::TPWMTHRS), threshold.unwrap_or(0));
        prop_assert_eq!(word(&memory, register::GCONF) >> 2 & 1, u32::from(threshold.is_some()));
        driver.disable().unwrap();
        prop_assert_eq!(word(&memory, register::CHOPCONF), chopconf & !0xF);
    }
}
