//! Settings of the motor drivers, as the chips have taken them.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

/// Bits of DRVCTRL (TMC2590 datasheet section 7.5): microsteps, double edge, interpolation.
const MRES: u32 = 0xF;
const DEDGE: u32 = 1 << 8;
const INTPOL: u32 = 1 << 9;
/// Hysteresis and decay bits of CHOPCONF, without the off time, which is zero while a motor is off.
const CHOPPER: u32 = 0x1_FFF0;
/// Passive fast decay, DRVCONF bit 1.
const EN_PFD: u32 = 1 << 1;

fn with(settings: &str) -> Bench {
    let mut bench =
        Plan::new(CARTESIAN).with("alpha.spi_cs_pin = PJ13", &format!("alpha.spi_cs_pin = PJ13\n{settings}")).start();
    bench.hear(1.0);
    bench
}

fn registers(bench: &Bench) -> [u32; 5] {
    bench.world(|world| world.driver(Alpha as usize).registers())
}

#[test]
fn raw_registers_reach_the_chip_and_named_settings_stand_above_them() {
    // 256 microsteps, single edge; another chopper; coolStep; a stallGuard threshold of 3 and a current scale
    // of 31; DRVCONF with the weakest gate drive.
    let bench = with("alpha.reg = 00000, 901B4, A8202, C031F, E0010\nalpha.passive_fast_decay = false");
    let [drvctrl, chopconf, smarten, sgcsconf, drvconf] = registers(&bench);
    assert_eq!(chopconf & CHOPPER, 0x1_01B4 & CHOPPER, "{chopconf:x}");
    assert_eq!((smarten, sgcsconf & 0x1_7F00), (0x8202, 0x300), "{smarten:x} {sgcsconf:x}");
    assert_eq!(drvconf & 0xF000, 0, "{drvconf:x}");
    // The configuration's 16 microsteps with interpolation, and the double edges the step engine makes.
    assert_eq!(drvctrl & (MRES | DEDGE | INTPOL), 4 | DEDGE | INTPOL, "{drvctrl:x}");
    let amps = bench.world(|world| world.driver(Alpha as usize).peak_current_amps(0.05));
    let plain = with("");
    let expected = plain.world(|world| world.driver(Alpha as usize).peak_current_amps(0.05));
    assert!((amps - expected).abs() < 1e-9, "{amps} A, not the {expected} A of its own setting");
}

#[test]
fn passive_fast_decay_is_on_unless_told_otherwise() {
    assert_ne!(registers(&with(""))[4] & EN_PFD, 0);
    assert_eq!(registers(&with("alpha.passive_fast_decay = false"))[4] & EN_PFD, 0);
}

/// SLPH, SLPL and SLP2, DRVCONF bits 15 to 11.
#[test]
fn gate_drive_is_the_default_s_or_the_registers_or_its_own() {
    const SLOPES: u32 = 0xF800;
    let slopes = |settings: &str| registers(&with(settings))[4] & SLOPES;
    assert_eq!(slopes(""), 0xF000, "as the maker's code for the chip starts");
    assert_eq!(slopes("alpha.reg = 0,901B4,A0000,D031F,EA810"), 0xA800);
    assert_eq!(slopes("alpha.reg = 0,901B4,A0000,D031F,EA810\nalpha.gate_drive = 1"), 0x5000);
    assert_eq!(slopes("alpha.gate_drive = 7"), 0xF800);
}

/// EN_S2VS, DRVCONF bit 0.
#[test]
fn shorts_to_the_supply_are_looked_for_unless_told_otherwise() {
    let looks = |settings: &str| registers(&with(settings))[4] & 1 == 1;
    assert!(looks(""));
    assert!(!looks("alpha.short_to_supply_detection = false"));
    assert!(!looks("alpha.reg = 0,901B4,A0000,D031F,E0010") && looks("alpha.reg = 0,901B4,A0000,D031F,E0011"));
}

#[test]
fn m911_prints_the_registers_as_a_setting() {
    let said = with("alpha.reg = 0,901B4,A8202,D031F,E0010").say("M911 P0");
    assert!(said.contains("alpha.reg = 00304,901B4,A8202,"), "{said}");
    // What it prints can be loaded again.
    let printed = said
        .lines()
        .find_map(|line| line.trim().strip_prefix("config-set tmc2590 alpha.reg"))
        .expect("a line of registers");
    let again = with(&format!("alpha.reg{printed}")).say("M911 P0");
    assert!(again.contains(printed), "{printed} is not in {again}");
}

#[test]
fn registers_that_are_none_are_refused_with_the_motor_s_name() {
    let bench = with("alpha.reg = 0,901B4,A8202,C031F,901B4");
    assert!(
        bench.greeting().contains("driver alpha: register words must be one for each register"),
        "{}",
        bench.greeting()
    );
}
