use super::*;

const MS: u64 = 1_000_000;
/// CHOPCONF with TOFF 5.
const ON: u32 = 0x9_81C5;

/// A chip with its bridges on and this DRVCONF.
fn driving(chip: Chip, drvconf: u32) -> Tmc26x {
    let mut chip = Tmc26x::new(chip);
    chip.set_enn(false);
    chip.write(0x0_0004);
    chip.write(0xE_0000 | drvconf);
    chip.write(ON);
    chip
}

/// Data sheets, "Microstep Table": DIR low counts up.
#[test]
fn the_microstep_counter_goes_up_while_dir_is_low() {
    for chip in [Chip::Tmc2590, Chip::Tmc2660] {
        let mut chip = driving(chip, 0);
        assert_eq!(chip.step_edge(MS, true, false), Some(16));
        assert_eq!(chip.status(MS) >> 10, 16);
        assert_eq!(chip.step_edge(2 * MS, true, true), Some(-16));
        assert_eq!(chip.status(2 * MS) >> 10, 0);
    }
}

/// TMC2590 data sheet section 12.1: the low side is watched only with EN_S2VS.
#[test]
fn a_short_to_the_supply_is_seen_by_a_tmc2590_with_its_detector_on() {
    const RDSEL_3: u32 = 0x30;
    for (chip, drvconf, seen) in
        [(Chip::Tmc2590, RDSEL_3 | 1, true), (Chip::Tmc2590, RDSEL_3, false), (Chip::Tmc2660, RDSEL_3 | 1, false)]
    {
        let mut chip = driving(chip, drvconf);
        chip.condition.short_to_supply[1] = true;
        let status = chip.status(MS);
        assert_eq!((status >> 4 & 1 == 1, status >> 17 & 1 == 1, chip.drives()), (seen, seen, !seen));
        assert_eq!(status >> 16 & 1, 0, "it is no short to ground");
    }
}

#[test]
fn a_short_stays_latched_until_the_bridges_were_off() {
    let mut chip = driving(Chip::Tmc2590, 0x31);
    chip.condition.short_to_ground[0] = true;
    assert_eq!(chip.status(MS) >> 14 & 0b11, 0b01);
    chip.condition.short_to_ground[0] = false;
    assert!(chip.status(MS) >> 3 & 1 == 1 && !chip.drives());
    chip.write(ON & !0xF);
    chip.write(ON);
    assert!(chip.status(MS) >> 3 & 1 == 0 && chip.drives());
}

/// "Detector Levels": shut down at 150 C; a TMC2590 is released at 120 C.
#[test]
fn a_chip_that_was_too_hot_comes_back_when_it_has_cooled() {
    for (kind, released_c) in [(Chip::Tmc2590, 119), (Chip::Tmc2660, 99)] {
        let mut chip = driving(kind, 0);
        for (celsius, drives) in [(149, true), (150, false), (released_c + 1, false), (released_c, true)] {
            chip.condition.temperature_c = celsius;
            chip.status(MS);
            assert_eq!(chip.drives(), drives, "{kind:?} at {celsius} C");
        }
    }
}

#[test]
fn passive_fast_decay_lets_a_tmc2590_keep_its_registers_at_five_volts() {
    for (drvconf, kept) in [(1 << 1, true), (0, false)] {
        let mut chip = driving(Chip::Tmc2590, drvconf);
        chip.set_supply(5.0);
        chip.set_supply(24.0);
        assert_eq!(chip.off_time() == 5, kept);
    }
}

/// SMARTEN: SEMIN 2, SEMAX 1, SEUP 2 a reading, SEDN every one, down to a half.
#[test]
fn coolstep_lowers_the_current_where_the_load_is_small_and_raises_it_again() {
    let mut chip = driving(Chip::Tmc2660, 2 << 4);
    chip.write(0xC_0000 | 20);
    chip.measure(900);
    assert_eq!(chip.scale_in_force(), 20, "it is off");
    chip.write(0xA_0000 | 3 << 13 | 1 << 8 | 1 << 5 | 2);
    for scale in (10..20).rev() {
        chip.measure(128);
        assert_eq!(chip.scale_in_force(), scale);
    }
    chip.measure(128);
    assert_eq!((chip.scale_in_force(), chip.status(MS) >> 10 & 0x1F), (10, 10), "a half is the least");
    chip.measure(100);
    assert_eq!(chip.scale_in_force(), 10, "neither low nor high");
    chip.measure(63);
    assert_eq!(chip.scale_in_force(), 12);
    chip.write(0xC_0000 | 20);
    assert_eq!(chip.scale_in_force(), 20);
}
