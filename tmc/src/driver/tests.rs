//! Tests of the driver against an independent model of the chip's SPI port.

use super::*;
use crate::status::{Reading, Temperature};
use crate::{BlankTime, HysteresisDecrement};
use core::convert::Infallible;
use embedded_hal::spi::{ErrorType, Operation};
use proptest::prelude::*;

/// Model of the chip by the datasheet: a 20-bit shift register, latched when chip select rises.
#[derive(Debug)]
struct FakeChip {
    words: [u32; 8],
    flags: u32,
    powered: bool,
    line_when_dead: u8,
    /// Number of a frame whose answer is disturbed, and the mask of its wrong bits.
    disturbed: Option<(u32, u32)>,
    /// Current scale as lowered by coolStep.
    scale: Option<u32>,
    /// Every CHOPCONF, SGCSCONF and DRVCONF state in order, as (on, peak current in units of 1/32 V at 1
    /// Ohm).
    history: Vec<(bool, f32)>,
}

impl Default for FakeChip {
    fn default() -> Self {
        Self {
            words: [0; 8],
            flags: 0,
            powered: true,
            line_when_dead: 0,
            disturbed: None,
            scale: None,
            history: Vec::new(),
        }
    }
}

impl FakeChip {
    fn answer(&self) -> u32 {
        let select = self.words[7] >> 4 & 3;
        let reading = match select {
            3 => 0b11 << 8,
            2 => (0x140 | self.scale.unwrap_or(self.words[6] & 31)) << 10,
            _ => 0x155 << 10,
        };
        reading | self.flags
    }

    fn current(&self) -> f32 {
        let full_scale = if self.words[7] >> 6 & 1 == 1 { 0.173 } else { 0.325 };
        ((self.words[6] & 31) as f32 + 1.0) * full_scale
    }
}

impl ErrorType for FakeChip {
    type Error = Infallible;
}

impl SpiDevice for FakeChip {
    fn transaction(&mut self, work: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let [Operation::TransferInPlace(frame)] = work else { panic!("one frame per chip select") };
        let [a, b, c] = **frame else { panic!("24 bits") };
        if !self.powered {
            frame.fill(self.line_when_dead);
            return Ok(());
        }
        let sent = u32::from_be_bytes([0, a, b, c]);
        let wrong = match &mut self.disturbed {
            Some((0, bits)) => core::mem::take(bits),
            Some((frames, _)) => {
                *frames -= 1;
                0
            }
            None => 0,
        };
        let back = (self.answer() ^ wrong) << 4 | sent >> 20;
        frame.copy_from_slice(&back.to_be_bytes()[1..]);
        let word = sent & WORD_MASK;
        // DRVCTRL is addressed by two bits only.
        let address = if word >> 18 == 0 { 0 } else { word >> 17 };
        self.words[address as usize] = word;
        self.history.push((self.words[4] & 15 != 0, self.current()));
        Ok(())
    }
}

fn driver(chip: Chip) -> Driver<FakeChip> {
    Driver::new(FakeChip::default(), chip, Ohms(0.05)).unwrap()
}

#[test]
fn starting_loads_a_smoothieboard_s_settings_with_the_bridges_off() {
    let mut driver = driver(Chip::Tmc2590);
    let status = driver.start().unwrap();
    assert!(matches!(status.reading, Reading::Diagnostics(all) if all.temperature == Temperature::Below100));
    let chip = driver.release();
    assert_eq!(chip.words[0], 0x0_0003, "32 microsteps");
    assert_eq!(chip.words[4], 0x9_81C0, "off time 0, blank 54, start 5, end 0");
    assert_eq!(chip.words[6] & !31, 0xD_0A00, "stallGuard threshold 10, filtered");
    assert_eq!(chip.words[7] & !64, 0xE_F031, "medium slopes, the low side's short detector on");
    assert!(chip.history.iter().all(|(on, _)| !on));
}

#[test]
fn a_tmc2660_starts_with_the_gentlest_slopes() {
    let mut driver = driver(Chip::Tmc2660);
    driver.start().unwrap();
    assert_eq!(driver.release().words[7] & !64, 0xE_0010);
}

#[test]
fn a_search_ends_with_what_was_set_before_also_where_the_chip_was_gone_meanwhile() {
    for is_gone in [false, true] {
        let mut driver = driver(Chip::Tmc2590);
        driver.start().unwrap();
        driver.set_current(Amps(1.2)).unwrap();
        let cool_step =
            CoolStep { lower_threshold: 2, threshold_width: 1, increment: 0, decrement: 0, quarter_current: false };
        driver.set_cool_step(Some(cool_step)).unwrap();
        driver.enable().unwrap();
        let (words, current) = (driver.spi.words, driver.current());
        driver.end_search().unwrap();
        assert_eq!(driver.spi.words, words, "there was none");
        driver.begin_search(StallGuard { threshold: -3, filter: false }, Some(Amps(0.6))).unwrap();
        assert_eq!(
            (driver.spi.words[5] & 15, driver.spi.words[6] >> 8 & 0x1FF),
            (0, 0x7D),
            "coolStep off, threshold -3"
        );
        assert!(driver.current().0 < 0.7);
        driver.spi.powered = !is_gone;
        assert_eq!(driver.end_search().is_err(), is_gone);
        driver.spi.powered = true;
        if is_gone {
            driver.enable().unwrap();
        }
        assert_eq!((driver.spi.words, driver.current()), (words, current));
    }
}

/// Positions of the bits in the register tables: `SLPH` 15 and 14, `SLPL` 13 and 12, `SLP2` 11.
#[test]
fn gate_drive_reaches_both_slopes_and_nothing_else() {
    const SLOPES: u32 = 0x0_F800;
    for (chip, words) in [
        (Chip::Tmc2590, &[0x0000, 0x5000, 0xA000, 0xF000, 0x0800, 0x5800, 0xA800, 0xF800][..]),
        (Chip::Tmc2660, &[0x0000, 0x5000, 0xA000, 0xF000]),
    ] {
        let mut driver = driver(chip);
        driver.start().unwrap();
        let rest = driver.spi.words[7] & !SLOPES;
        for (strength, slopes) in words.iter().enumerate() {
            driver.set_gate_drive(strength as u8).unwrap();
            assert_eq!(driver.spi.words[7], rest | slopes, "{} at {strength}", chip.name());
        }
        let before = driver.spi.words[7];
        assert!(matches!(driver.set_gate_drive(words.len() as u8), Err(Error::Setting(_))));
        assert_eq!(driver.spi.words[7], before);
    }
}

#[test]
fn the_low_side_s_detector_is_on_where_there_is_one() {
    let mut driver = driver(Chip::Tmc2590);
    driver.start().unwrap();
    let on = driver.spi.words[7];
    driver.set_short_to_supply_detection(false).unwrap();
    assert_eq!((on & 1, driver.spi.words[7]), (1, on & !1));
    let mut other = self::driver(Chip::Tmc2660);
    assert!(matches!(other.set_short_to_supply_detection(true), Err(Error::Setting(_))));
    assert_eq!(other.set_short_to_supply_detection(false).map(|()| other.registers().drvconf.en_s2vs()), Ok(0));
}

#[test]
fn a_tmc2660_never_sees_the_fields_it_has_not() {
    let mut driver = driver(Chip::Tmc2660);
    driver.start().unwrap();
    driver.write_raw(0xE_F80F).unwrap();
    assert_eq!(
        driver.read(ReadSelect::Diagnostics).unwrap_err(),
        Error::Setting(SettingError { setting: "reading", must_be: "one that a TMC2660 has" })
    );
    assert_eq!(driver.release().words[7] & 0x0_080F, 0);
}

#[test]
fn a_dead_line_is_absent_and_a_strange_answer_is_wrong() {
    for line in [0x00, 0xFF] {
        let mut driver = driver(Chip::Tmc2590);
        (driver.spi.powered, driver.spi.line_when_dead) = (false, line);
        assert_eq!(driver.start(), Err(Error::Absent));
    }
    let mut driver = driver(Chip::Tmc2590);
    (driver.spi.powered, driver.spi.line_when_dead) = (false, 0xA5);
    assert!(matches!(driver.start(), Err(Error::WrongAnswer(0xA5_A5A5))));
}

/// Returns a started driver whose chip was reset.
fn reset(chip: Chip, current: f32) -> (Driver<FakeChip>, [u32; 8]) {
    let mut driver = driver(chip);
    driver.start().unwrap();
    driver.set_current(Amps(current)).unwrap();
    driver.enable().unwrap();
    assert!(driver.status().is_ok());
    let before = core::mem::take(&mut driver.spi.words);
    (driver, before)
}

#[test]
fn a_chip_that_lost_its_settings_is_seen_until_started_again() {
    for chip in [Chip::Tmc2590, Chip::Tmc2660] {
        let (mut driver, before) = reset(chip, 3.0);
        for _ in 0..3 {
            assert_eq!(driver.status(), Err(Error::Reset), "{}", chip.name());
        }
        assert_eq!(driver.enable(), Err(Error::Reset));
        driver.start().unwrap();
        assert_eq!(driver.spi.words, before);
        assert!(driver.status().is_ok());
    }
}

/// Every write reveals the reset, whether it selects a reading again or gives the chip a current.
#[test]
fn no_setting_hides_that_a_chip_lost_the_others() {
    type Write = fn(&mut Driver<FakeChip>);
    let writes: [(&str, Write); 6] = [
        ("a current", |driver| assert_eq!(driver.set_current(Amps(1.0)), Err(Error::Reset))),
        ("a higher current", |driver| assert_eq!(driver.set_current(Amps(3.1)), Err(Error::Reset))),
        ("a threshold", |driver| {
            let done = driver.set_stall_guard(StallGuard { threshold: 3, filter: false });
            assert_eq!(done, Err(Error::Reset));
        }),
        ("a search", |driver| {
            let begun = driver.begin_search(StallGuard { threshold: 3, filter: false }, Some(Amps(0.9)));
            assert_eq!(begun, Err(Error::Reset));
        }),
        // Neither of these selects a reading that hides the reset, and a TMC2660 accepts both.
        ("gate drive", |driver| _ = driver.set_gate_drive(2)),
        ("a reading", |driver| _ = driver.read(ReadSelect::Microstep)),
    ];
    for chip in [Chip::Tmc2590, Chip::Tmc2660] {
        for (what, write) in writes {
            let (mut driver, _) = reset(chip, 3.0);
            write(&mut driver);
            assert_eq!(driver.status(), Err(Error::Reset), "{} after {what}", chip.name());
            driver.start().unwrap();
            assert!(driver.status().is_ok());
        }
    }
}

/// Disturbs one bit at a time, also in a TMC2660 whose scale has one bit set.
#[test]
fn a_disturbed_bit_is_no_reset() {
    for (chip, current) in [(Chip::Tmc2590, 3.0), (Chip::Tmc2660, 3.0), (Chip::Tmc2660, 1.75)] {
        let mut driver = driver(chip);
        driver.start().unwrap();
        driver.set_current(Amps(current)).unwrap();
        for bit in 0..20 {
            for frame in 0..2 {
                driver.spi.disturbed = Some((frame, 1 << bit));
                let status = driver.status();
                assert!(!matches!(status, Err(Error::Reset)), "{} bit {bit} of frame {frame}", chip.name());
                driver.spi.disturbed = None;
                assert!(driver.status().is_ok());
            }
        }
    }
}

/// coolStep may lower a scale of 1 to 0, the same as after a reset.
#[test]
fn a_scale_that_may_be_0_tells_nothing() {
    let mut driver = driver(Chip::Tmc2660);
    driver.start().unwrap();
    for (current, cool_step) in [(0.01, false), (0.2, true)] {
        let by_load =
            CoolStep { lower_threshold: 2, threshold_width: 1, increment: 0, decrement: 0, quarter_current: true };
        driver.set_cool_step(cool_step.then_some(by_load)).unwrap();
        driver.set_current(Amps(current)).unwrap();
        driver.spi.scale = Some(0);
        assert!(driver.status().is_ok(), "{current} A");
        driver.spi.scale = None;
    }
}

#[test]
fn disabling_keeps_the_chopper_for_the_next_enable() {
    let mut driver = driver(Chip::Tmc2590);
    driver.start().unwrap();
    let chopper = Chopper::SpreadCycle {
        off_time: 3,
        blank_time: BlankTime::Clocks36,
        hysteresis_start: 2,
        hysteresis_end: 1,
        decrement: HysteresisDecrement::Clocks64,
        random_off_time: false,
    };
    driver.set_chopper(chopper).unwrap();
    assert_eq!(driver.spi.words[4] & 15, 0, "setting a chopper must not start the motor");
    driver.enable().unwrap();
    let on = driver.spi.words[4];
    assert_eq!(on & 15, 3);
    driver.disable().unwrap();
    assert_eq!(driver.spi.words[4], on & !15);
    driver.enable().unwrap();
    assert_eq!((driver.spi.words[4], driver.is_enabled()), (on, true));
}

#[test]
fn every_reading_can_be_had_and_the_usual_one_comes_back() {
    let mut driver = driver(Chip::Tmc2590);
    driver.start().unwrap();
    assert_eq!(driver.read(ReadSelect::Microstep).unwrap().reading, Reading::Microstep(0x155));
    assert_eq!(driver.read(ReadSelect::StallGuard).unwrap().reading, Reading::StallGuard(0x155));
    assert!(matches!(driver.status().unwrap().reading, Reading::Diagnostics(_)));
}

#[test]
fn standing_uses_the_standstill_current_and_moving_the_running_one() {
    let mut driver = driver(Chip::Tmc2590);
    driver.start().unwrap();
    driver.set_current(Amps(4.0)).unwrap();
    let running = driver.spi.current();
    driver.set_standing(true).unwrap();
    assert_eq!(driver.spi.current(), running, "no standstill current is set");
    driver.set_standstill_current(Some(Amps(1.0))).unwrap();
    assert!(driver.spi.current() < running * 0.3);
    driver.set_standing(false).unwrap();
    assert_eq!(driver.spi.current(), running);
}

#[test]
fn a_raw_word_cannot_switch_a_motor_on_or_blind_the_driver() {
    let mut driver = driver(Chip::Tmc2590);
    driver.start().unwrap();
    driver.write_raw(0x9_0005).unwrap();
    assert_eq!(driver.spi.words[4], 0x9_0000);
    assert!(matches!(driver.write_raw(0x9_0000), Err(Error::Setting(_))));
    assert!(matches!(driver.write_raw(0x4_0000), Err(Error::Setting(_))));
    driver.write_raw(0xE_0080).unwrap();
    assert_eq!(driver.spi.words[7], 0xE_0030, "STEP/DIR mode and the selected reading stay");
    driver.write_raw(0xC_0013).unwrap();
    assert!((driver.current().0 - 20.0 / 32.0 * 0.325 / 0.05).abs() < 1e-6);
}

#[test]
fn a_register_dump_is_taken_whole_or_not_at_all() {
    let mut driver = driver(Chip::Tmc2590);
    let dump = [0x0_0204, 0x9_4550, 0xA_0000, 0xC_0A1F, 0xE_0001];
    driver.load_registers(dump).unwrap();
    assert!(driver.spi.history.is_empty(), "nothing is sent");
    driver.start().unwrap();
    assert_eq!(driver.spi.words[0], 0x0_0204);
    assert_eq!(driver.registers().chopconf.word(), 0x9_4555, "the off time stays");
    assert!((driver.current().0 - 6.5).abs() < 1e-6);
    let before = *driver.registers();
    for bad in [[0x0_0204, 0x0_0203, 0xA_0000, 0xC_0A1F, 0xE_0001], [0x4_0000, 0x9_4550, 0xA_0000, 0xC_0A1F, 0xE_0001]]
    {
        assert!(matches!(driver.load_registers(bad), Err(Error::Setting(_))));
        assert_eq!(*driver.registers(), before);
    }
}

#[test]
fn settings_made_before_the_chip_answers_are_sent_when_it_does() {
    let mut driver = driver(Chip::Tmc2590);
    driver.spi.powered = false;
    assert_eq!(driver.set_current(Amps(3.0)), Err(Error::Absent));
    assert_eq!(driver.set_passive_fast_decay(true), Err(Error::Absent));
    driver.spi.powered = true;
    driver.start().unwrap();
    assert!((driver.current().0 - driver.spi.current() / 32.0 / 0.05).abs() < 1e-6);
    assert_eq!(driver.spi.words[7] & 0b10, 0b10);
}

#[test]
fn settings_may_come_before_the_first_start() {
    let mut driver = driver(Chip::Tmc2590);
    driver.set_current(Amps(3.0)).unwrap();
    driver.set_standstill_current(Some(Amps(0.6))).unwrap();
    let input = StepInput { microsteps: Microsteps::M16, double_edge: true, interpolation: true };
    driver.set_step_input(input).unwrap();
    driver.start().unwrap();
    assert_eq!(driver.spi.words[0], 0x0_0304);
}

#[test]
fn a_sense_resistor_of_nothing_is_refused() {
    for bad in [0.0, -0.1, f32::NAN, f32::INFINITY] {
        assert!(matches!(Driver::new(FakeChip::default(), Chip::Tmc2590, Ohms(bad)), Err(Error::Setting(_))));
    }
}

#[test]
fn microsteps_find_their_way_back() {
    for count in 0..=300_u16 {
        let expected = (count <= 256 && count.is_power_of_two()).then_some(count);
        assert_eq!(Microsteps::from_count(count).map(Microsteps::count), expected);
    }
}

proptest! {
    #[test]
    fn between_two_currents_there_is_never_a_larger_one(first in 0.0_f32..7.0, second in 0.0_f32..7.0) {
        let mut driver = driver(Chip::Tmc2590);
        driver.start().unwrap();
        driver.set_current(Amps(first)).unwrap();
        let before = driver.spi.current();
        driver.spi.history.clear();
        driver.set_current(Amps(second)).unwrap();
        let after = driver.spi.current();
        for (_, between) in &driver.spi.history {
            prop_assert!(*between <= before.max(after), "{} between {} and {}", between, before, after);
        }
        prop_assert!((driver.current().0 - after / 32.0 / 0.05).abs() < 1e-5);
    }

    #[test]
    fn flags_reach_the_status_whatever_the_settings(flags in 0_u32..256, threshold: i8) {
        let mut driver = driver(Chip::Tmc2590);
        driver.spi.flags = flags;
        driver.start().unwrap();
        match driver.set_stall_guard(StallGuard { threshold, filter: true }) {
            Ok(()) => prop_assert_eq!(((driver.spi.words[6] >> 8 & 0x7F) << 1) as u8 as i8 >> 1, threshold),
            Err(error) => prop_assert!(matches!(error, Error::Setting(_)) && !(-64..=63).contains(&threshold)),
        }
        prop_assert_eq!(driver.status().unwrap().raw & 0xFF, flags);
    }
}
