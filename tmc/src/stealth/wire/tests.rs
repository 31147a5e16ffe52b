//! Tests of the registers on a wire with models of chips, from chapter 4 of the datasheet.

use super::super::{StealthChip, StealthDriver, StealthSettings, register};
use super::*;
use proptest::prelude::*;
use std::cell::RefCell;
use std::convert::Infallible;
use units::{Amps, Ohms};

/// The polynomial as in the datasheet's figure: bits of the sum shifted and fed back one by one.
fn slow_sum(bytes: &[u8]) -> u8 {
    let mut sum = 0_u8;
    for byte in bytes {
        for place in 0..8 {
            let fed_back = sum >> 7 ^ byte >> place & 1;
            sum <<= 1;
            if fed_back == 1 {
                sum ^= 0b0000_0111;
            }
        }
    }
    sum
}

/// Checks datagrams recorded on real wires.
#[test]
fn check_sums_are_those_of_real_chips() {
    for datagram in [
        &[0x05, 0x00, 0xEC, 0x10, 0x00, 0x00, 0x53, 0x9C][..],
        &[0x55, 0x00, 0x06, 0xE8],
        &[0x05, 0xFF, 0x06, 0x21, 0x00, 0x02, 0x41, 0x9D],
    ] {
        let (sum, bytes) = datagram.split_last().expect("a datagram");
        assert_eq!(check_sum(bytes), *sum);
    }
}

/// Chips on one wire.
#[derive(Default)]
struct Wire {
    chips: Vec<(u8, [u32; 128])>,
    echoes: bool,
    /// Disturbed bits of the next exchanges: of the requests, and of the answers.
    noise: Vec<(usize, usize)>,
    exchanges: u32,
}

impl Wire {
    fn of(chip: StealthChip, addresses: &[u8]) -> RefCell<Self> {
        let registers = || {
            let mut words = [0; 128];
            (words[1], words[6]) = (1, chip.version() << 24);
            words
        };
        let chips = addresses.iter().map(|address| (*address, registers())).collect();
        RefCell::new(Self { chips, echoes: true, ..Self::default() })
    }

    fn hear(&mut self, bytes: &[u8]) -> Option<[u8; 8]> {
        let (sum, rest) = bytes.split_last()?;
        if slow_sum(rest) != *sum || rest[0] & 0xF != 5 {
            return None;
        }
        let (_, words) = self.chips.iter_mut().find(|(address, _)| *address == rest[1])?;
        let place = usize::from(rest[2] & 0x7F);
        if let [_, _, _, data @ ..] = rest
            && let Ok(data) = <[u8; 4]>::try_from(data)
        {
            let data = u32::from_be_bytes(data);
            words[place] = if place == 1 { words[1] & !data } else { data };
            words[2] = (words[2] + 1) & 0xFF;
            return None;
        }
        let [a, b, c, d] = words[place].to_be_bytes();
        let mut answer = [0x05, 0xFF, rest[2], a, b, c, d, 0];
        answer[7] = slow_sum(&answer[..7]);
        Some(answer)
    }
}

struct Line<'a>(&'a RefCell<Wire>);

impl SingleWire for Line<'_> {
    type Error = Infallible;

    fn exchange(&mut self, datagram: &[u8], answer: &mut [u8]) -> Result<(), WireFault<Infallible>> {
        let mut wire = self.0.borrow_mut();
        wire.exchanges += 1;
        if !wire.echoes {
            return Err(WireFault::NoEcho);
        }
        let mut heard = datagram.to_vec();
        let noise = wire.noise.pop();
        if let Some((bit, _)) = noise {
            let length = heard.len();
            heard[bit / 8 % length] ^= 1 << (bit % 8);
        }
        let said = wire.hear(&heard);
        if heard != datagram {
            return Err(WireFault::Disturbed);
        }
        if answer.is_empty() {
            return Ok(());
        }
        let mut said = said.ok_or(WireFault::NoAnswer)?;
        if let Some((_, bit)) = noise {
            said[bit / 8 % 8] ^= 1 << (bit % 8);
        }
        answer.copy_from_slice(&said);
        Ok(())
    }
}

const SENSE: Ohms = Ohms(0.11);

fn driver(wire: &RefCell<Wire>, chip: StealthChip, address: u8) -> StealthDriver<WireRegisters<Line<'_>>> {
    StealthDriver::new(WireRegisters::new(Line(wire), address), chip, StealthSettings::new(SENSE)).expect("settings")
}

/// GCONF: en_spreadcycle, pdn_disable, mstep_reg_select, multistep_filt. IRUN: 32 * 0.9 A * 0.13 Ohm / 0.18 V
/// - 1 = 19.8, with vsense, bit 17 of CHOPCONF. MRES 4 for 16 microsteps.
#[test]
fn a_tmc2209_is_set_as_its_datasheet_says_and_each_chip_by_its_address() {
    let wire = Wire::of(StealthChip::Tmc2209, &[0, 3]);
    let mut driver = driver(&wire, StealthChip::Tmc2209, 3);
    driver.store_current(Amps(0.9));
    driver.start().unwrap();
    driver.enable().unwrap();
    let words = wire.borrow().chips[1].1;
    for (address, word) in [
        (0x00, 0x1C4),
        (0x01, 0),
        (0x03, 0x200),
        (0x10, 0x0006_1414),
        (0x11, 10),
        (0x13, 0),
        (0x14, 0),
        (0x40, 0),
        (0x42, 0),
        (0x6C, 0x0403_00C3),
        (0x70, 0xC10D_0024),
    ] {
        assert_eq!(words[address], word, "{address:02x}: {:x}", words[address]);
    }
    assert_eq!(words[0x15], 0, "it has no THIGH");
    assert_eq!(wire.borrow().chips[0].1[3], 0, "the other one is not touched");
}

#[test]
fn a_chip_that_does_not_answer_a_wire_that_is_none_and_another_chip_are_told_apart() {
    let wire = Wire::of(StealthChip::Tmc2209, &[0]);
    assert_eq!(driver(&wire, StealthChip::Tmc2209, 1).start(), Err(Error::Absent));
    assert_eq!(driver(&wire, StealthChip::Tmc2208, 0).start(), Err(Error::WrongAnswer(0x2100_0000)));
    wire.borrow_mut().echoes = false;
    assert_eq!(driver(&wire, StealthChip::Tmc2209, 0).start(), Err(Error::NoEcho));
    assert!(wire.borrow().exchanges <= 9, "it gives up soon");
}

#[test]
fn a_reset_is_seen_until_the_chip_is_set_up_again_and_its_counter_is_found_again() {
    let wire = Wire::of(StealthChip::Tmc2208, &[0]);
    let mut driver = driver(&wire, StealthChip::Tmc2208, 0);
    driver.start().unwrap();
    assert!(!driver.status().unwrap().reset);
    wire.borrow_mut().chips[0].1 = Wire::of(StealthChip::Tmc2208, &[0]).borrow().chips[0].1;
    for _ in 0..3 {
        assert!(driver.status().unwrap().reset);
    }
    driver.start().unwrap();
    assert!(!driver.status().unwrap().reset);
}

/// TMC2209 datasheet Rev. 1.03, table of chapter 8: sense resistors in mOhm, RMS amperes at full scale.
#[test]
fn full_scale_is_that_of_the_datasheet_s_table() {
    for (milliohms, amps) in
        [(1_000.0, 0.23), (500.0, 0.44), (330.0, 0.66), (220.0, 0.96), (150.0, 1.35), (120.0, 1.64), (100.0, 1.92)]
    {
        let peak = StealthChip::Tmc2209.full_scale(Ohms(milliohms / 1e3), false, 0).0;
        assert!(
            (peak / 2_f32.sqrt() - amps).abs() < 0.0061,
            "{milliohms} mOhm: {} A, not {amps} A",
            peak / 2_f32.sqrt()
        );
    }
}

/// SGTHRS, TCOOLTHRS and the chopper that stallGuard4 needs; and back.
#[test]
fn a_search_measures_load_with_stealth_chop_and_ends_with_what_was_set_before() {
    let wire = Wire::of(StealthChip::Tmc2209, &[0]);
    let mut driver = driver(&wire, StealthChip::Tmc2209, 0);
    driver.store_current(Amps(0.9));
    driver.start().unwrap();
    let (words, current) = (wire.borrow().chips[0].1, *driver.current());
    driver.begin_search(60, Some(Amps(0.5))).unwrap();
    let searching = wire.borrow().chips[0].1;
    assert_eq!((searching[0], searching[0x13], searching[0x14], searching[0x40]), (0x1C0, 0, 0xF_FFFF, 60));
    assert!((driver.current().actual.0 - 0.5).abs() < 0.03);
    for (reading, reserve) in [(0, 0), (120, 0), (121, 2), (510, 780)] {
        wire.borrow_mut().chips[0].1[0x41] = reading;
        assert_eq!(driver.reserve(), Ok(reserve), "{reading}");
    }
    driver.end_search().unwrap();
    let mut after = wire.borrow().chips[0].1;
    (after[2], after[0x41]) = (words[2], words[0x41]);
    assert_eq!((after, *driver.current()), (words, current));
    assert!(matches!(driver.begin_search(256, None), Err(Error::Setting(_))));
    let mut none = super::tests::driver(&wire, StealthChip::Tmc2208, 0);
    assert!(matches!(none.begin_search(0, None), Err(Error::Setting(_))));
    assert!(matches!(none.reserve(), Err(Error::Setting(_))));
}

proptest! {
    #[test]
    fn check_sums_are_the_polynomial_s(bytes in proptest::collection::vec(0_u8.., 0..8)) {
        prop_assert_eq!(check_sum(&bytes), slow_sum(&bytes));
    }

    /// After any two disturbed exchanges in a row, a write has arrived or is reported as lost.
    #[test]
    fn a_write_that_is_said_to_have_arrived_has(
        noise in proptest::collection::vec((0_usize..64, 0_usize..64), 0..3),
        value: u32,
    ) {
        let wire = Wire::of(StealthChip::Tmc2209, &[0]);
        let mut bus = WireRegisters::new(Line(&wire), 0);
        bus.write(0x70, 1).unwrap();
        wire.borrow_mut().noise = noise;
        if bus.write(0x6C, value).is_ok() {
            prop_assert_eq!(wire.borrow().chips[0].1[0x6C], value);
        }
        wire.borrow_mut().noise.clear();
        prop_assert_eq!(bus.write(0x6C, !value), Ok(()));
        prop_assert_eq!(bus.read([0x6C, 0x70]), Ok([!value, 1]));
    }

    #[test]
    fn each_flag_of_the_status_is_its_own_bit(bit in 0_u32..32) {
        let status = super::super::StealthStatus::decode(StealthChip::Tmc2209, 1 << bit, 0);
        let flags = [
            (0, status.over_temperature_warning), (1, status.over_temperature), (2, status.short[0]),
            (3, status.short[1]), (4, status.supply_short[0]), (5, status.supply_short[1]),
            (6, status.open_load[0]), (7, status.open_load[1]), (30, status.stealth), (31, status.standstill),
        ];
        for (of, is_set) in flags {
            prop_assert_eq!(is_set, of == bit, "bit {} and the flag of {}", bit, of);
        }
        prop_assert_eq!(status.current_scale != 0, (16..21).contains(&bit));
    }
}

#[test]
fn registers_are_where_no_others_are_and_their_fields_do_not_overlap() {
    let shared =
        register::ALL.iter().filter(|one| !["IOIN", "COOLCONF", "DRV_CONF", "GLOBALSCALER"].contains(&one.name));
    let all: Vec<_> = register::wire::ALL.iter().chain(shared).collect();
    for (place, one) in all.iter().enumerate() {
        assert!(all[..place].iter().all(|other| other.address != one.address), "{}", one.name);
    }
    for fields in [register::wire::gconf::FIELDS, register::wire::drv_status::FIELDS] {
        let mut taken = 0;
        for field in fields {
            assert_eq!(taken & field.mask(), 0, "{}", field.name);
            taken |= field.mask();
        }
    }
}
