//! Settings of the motor drivers, as written to the chips.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::world::Fault;
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

// Smoothieware v2 drops the off time that is written, and the top bit of a fast decay of 8 or more.
#[test]
fn an_off_time_of_zero_keeps_the_usual_one_and_a_long_fast_decay_stays_whole() {
    const OFF_TIME: u32 = 0xF;
    let running = |chopper: &str| {
        let mut bench = with(&format!("alpha.reg = 00000,{chopper},A0000,D031F,E0010"));
        bench.run(&["G91", "G1 X1 F600", "M400"]);
        registers(&bench)[1]
    };
    // As a dump of a motor that is off has it: the same, with an off time of 0.
    assert_eq!(running("901B0") & (CHOPPER | OFF_TIME), 0x1_01B5);
    assert_eq!(running("901B7") & (CHOPPER | OFF_TIME), 0x1_01B7);
    // A constant off time (bit 14) of 4 with a fast decay of 8 + 3: bits 11, 5 and 4.
    assert_eq!(running("9C9B4") & (CHOPPER | OFF_TIME), 0x1_C9B4);
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
    // The printed registers can be loaded again.
    let printed = said
        .lines()
        .find_map(|line| line.trim().strip_prefix("config-set tmc2590 alpha.reg"))
        .expect("a line of registers");
    let again = with(&format!("alpha.reg{printed}")).say("M911 P0");
    assert!(again.contains(printed), "{printed} is not in {again}");
}

/// SMARTEN with SEMIN 2, SEMAX 4, SEDN 1 and SEUP 2 is 2 | 4 << 8 | 1 << 13 | 2 << 5.
#[test]
fn m911_3_keeps_what_it_is_not_told_and_switches_coolstep_on_by_s5_alone() {
    let mut bench = with("alpha.reg = 0,901B4,A0000,D031F,E0010");
    bench.run(&["M911.3 P0 S8 H64 I128 J1 K2 L0"]);
    assert_eq!(registers(&bench)[2] & 0xF, 0, "S8 switches nothing on");
    bench.run(&["M911.3 P0 S5 Z1"]);
    let on = 2 | 4 << 8 | 1 << 13 | 2 << 5;
    assert_eq!(registers(&bench)[2] & 0x1_FFFF, on);
    bench.run(&["M911.3 P0 S5 Z0"]);
    assert_eq!(registers(&bench)[2] & 0xF, 0);
    bench.run(&["M911.3 P0 S5 Z1"]);
    assert_eq!(registers(&bench)[2] & 0x1_FFFF, on);
    // The first line changes one spreadCycle value alone; a blanking time that the chip does not have is
    // refused.
    assert_eq!(bench.say("M911.1 P0"), "X,0,4,36,4,0,0\nok\n");
    bench.run(&["M911.3 P0 S1 W2", "M911.3 P0 S1 V60"]);
    assert_eq!(bench.say("M911.1 P0"), "X,0,4,54,2,0,0\nok\n");
    assert!(bench.say("M911.3 P0 S1").contains("cannot be set so"));
    // On is Z1 and nothing else; each word of stallGuard2 keeps the other one.
    let pfd = |bench: &Bench| registers(bench)[4] & EN_PFD != 0;
    for (line, on) in [("S6 Z0", false), ("S6 Z1", true), ("S6 Z2", false)] {
        bench.run(&[&format!("M911.3 P0 {line}")]);
        assert_eq!(pfd(&bench), on, "{line}");
    }
    bench.run(&["M911.3 P0 S5 Z2"]);
    assert_eq!(registers(&bench)[2] & 0xF, 0);
    let stall_guard = |bench: &Bench| registers(bench)[3] & (0x1_7F00);
    for (line, expected) in [("O-3 Q1", 0x1_7D00), ("O5", 0x1_0500), ("Q0", 0x500), ("O-64", 0x4000), ("Q1", 0x1_4000)]
    {
        bench.run(&[&format!("M911.3 P0 S7 {line}")]);
        assert_eq!(stall_guard(&bench), expected, "{line}");
    }
    assert!(bench.say("M911.3 P0 S7").contains("cannot be set so"));
    // Without P the code writes a register of all drivers.
    bench.run(&["M911.2 R3 V0"]);
    assert_eq!(registers(&bench)[2] & 0xF, 0);
    assert!(bench.say("M911.2 R3").contains("cannot be set so"));
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

/// Registers SMARTEN, and SGT with SFILT of SGCSCONF.
#[test]
fn cool_step_and_load_measurement_reach_the_chip() {
    let of = |settings: &str| {
        let [_, _, smarten, sgcsconf, _] = registers(&with(settings));
        (smarten, sgcsconf >> 8)
    };
    assert_eq!(of(""), (0, 0x100 | 10), "off; threshold 10, filtered");
    assert_eq!(of("alpha.stall_threshold = -5\nalpha.stall_filter = false"), (0, 0x7B));
    // SEMIN 2, SEMAX 1: the current falls from 32 (2 + 1 + 1) on.
    assert_eq!(of("alpha.coolstep_lower = 64"), (1 << 8 | 2, 0x10A));
    let all = "alpha.coolstep_lower = 96\nalpha.coolstep_upper = 256\nalpha.coolstep_up = 4\n\
               alpha.coolstep_down = 8\nalpha.coolstep_least = quarter";
    assert_eq!(of(all).0, 1 << 15 | 1 << 13 | 4 << 8 | 2 << 5 | 3);
    for (wrong, word) in [
        ("alpha.coolstep_lower = 70", "70 is no multiple of 32"),
        ("alpha.coolstep_lower = 64\nalpha.coolstep_upper = 64", "64 is no multiple of 32 above coolstep_lower = 64"),
        ("alpha.coolstep_upper = 64", "coolStep is off"),
    ] {
        let bench = with(wrong);
        assert!(bench.greeting().contains(word), "{wrong}: {}", bench.greeting());
    }
}

#[test]
fn a_motor_that_rests_has_its_full_current_before_its_first_step() {
    let mut bench = with("alpha.standstill_current = 400\ncommon.standstill_time = 2");
    let amps = |bench: &Bench| bench.world(|world| world.driver(Alpha as usize).peak_current_amps(0.05));
    for line in ["G1 X5 F6000", "$J X1", "G28 X"] {
        bench.say("G1 X10 F6000");
        bench.say("M400");
        let full = amps(&bench);
        let place = bench.carriage(Alpha);
        bench.hear(3.0);
        assert!(amps(&bench) < 0.5 * full, "it rests");
        assert!((bench.carriage(Alpha) - place).abs() < 1e-9, "where it stood");
        let before = bench.world(|world| world.trace().total());
        bench.type_in(&format!("{line}\n"));
        let end = bench.now_s() + 5.0;
        while bench.world(|world| world.trace().total()) == before {
            assert!(bench.now_s() < end, "{line} moves nothing");
            bench.hear(0.000_5);
        }
        assert!((amps(&bench) - full).abs() < 1e-9, "{line}: {} A at the first step, not {full}", amps(&bench));
        bench.say("M400");
    }
}

/// Smoothieware's rule, as the documentation has it. M500 says every motor's own, so nothing changes with it.
#[test]
fn a_slave_takes_its_master_s_current_unless_it_is_named() {
    let lines = ["steps_per_mm = 400", "max_rate = 900", "acceleration = 200", "microsteps = 16", "slaved_to = gamma"];
    let plan = Plan::new(CARTESIAN).set("[extruder] hotend.enable = false").set("[current control] delta.current");
    let plan = lines.iter().fold(plan, |plan, line| plan.set(&format!("[actuator] delta.{line}")));
    let mut bench = plan.start();
    let mut currents = |line: &str| {
        let refused = bench.say(line);
        assert_eq!(refused, "ok\n", "{line}");
        let said = bench.say("M907");
        let of = |name: &str| -> f64 {
            let line = said.lines().find_map(|line| line.strip_prefix(name)).expect(name);
            line.trim_start_matches(": ").trim_end_matches(" Amps").parse().expect("amperes")
        };
        [of("gamma"), of("delta")]
    };
    assert_eq!(currents("M400"), [1.2, 1.2]);
    assert_eq!(currents("M906 Z900"), [0.9, 0.9]);
    assert_eq!(currents("M906 A700"), [0.9, 0.7]);
    assert_eq!(currents("M907 Z1 A1.1"), [1.0, 1.1]);
}

/// Drivers without settings are assumed to be the board's own, and the assumption is reported.
#[test]
fn a_configuration_without_driver_settings_works_and_says_what_it_takes_for_granted() {
    let start = CARTESIAN.find("[tmc2590]").expect("a section");
    let end = start + CARTESIAN[start..].find("\n[").expect("another one");
    let without = format!("{}{}", &CARTESIAN[..start], &CARTESIAN[end..]);
    let mut bench = Plan::new(&without).start();
    let said = bench.greeting().to_owned();
    assert!(said.contains("taken for the board's own: sense resistor 50 mOhm, at most 5.5 A"), "{said}");
    bench.say("G28");
    bench.run(&["G1 X20 F6000", "M400"]);
    assert!((bench.carriage(Alpha) - 20.0).abs() < 0.02);
    let amps = bench.world(|world| world.driver(Alpha as usize).peak_current_amps(0.05));
    assert!((amps - 1.2).abs() < 0.1, "{amps} A");
}

#[test]
fn a_driver_that_gets_hot_says_what_to_do_and_one_that_shuts_down_is_not_homed() {
    let mut bench = Plan::new(CARTESIAN).start_homed();
    let heat = |bench: &Bench, celsius| {
        let fault = Fault::DriverTemperature(Alpha, celsius);
        bench.world(|world| world.inject(&fault)).expect("a driver");
    };
    heat(&bench, 110);
    let said = bench.hear_until("lower its current (M906), or cool it", 5.0);
    assert!(said.contains("WARNING: X: Overtemperature Prewarning"), "{said}");
    // The temperature crosses the limit again and again, but is reported once.
    for n in 0..20 {
        heat(&bench, if n % 2 == 0 { 95 } else { 105 });
        assert!(!bench.hear(2.5).contains("Prewarning"));
    }
    heat(&bench, 95);
    bench.hear(40.0);
    heat(&bench, 110);
    bench.hear_until("Overtemperature Prewarning", 5.0);
    assert!(!bench.say("G28.6").contains("X:0"), "a warning moves nothing");
    heat(&bench, 155);
    let said = bench.hear_until("Overtemperature Shutdown", 5.0);
    assert!(said.contains("let it cool, lower its current, home"), "{said}");
    heat(&bench, 40);
    bench.hear(1.5);
    bench.say("M999");
    assert_eq!(bench.say("G28.6"), "X:0 Y:0 Z:0 \nok\n", "belts go where several motors are");
}

/// A dip of the supply resets one chip: nothing but the chip itself has noticed it.
#[test]
fn a_driver_that_lost_its_settings_is_told_set_up_again_and_its_axis_is_not_homed() {
    for plan in [Plan::new(CARTESIAN), Plan::new(CARTESIAN).on_tmc2660()] {
        let mut bench = plan.set("[actuator] common.halt_on_driver_alarm = false").start_homed();
        bench.run(&["G1 X50 Y50 F6000", "M400"]);
        let before = registers(&bench);
        bench.world(|world| world.inject(&Fault::DriverReset(Alpha))).expect("a driver");
        assert_eq!(registers(&bench), [0; 5]);
        let said = bench.hear_until("WARNING: X: the driver was without power", 1.5) + &bench.hear(5.0);
        assert_eq!(said.matches("without power").count(), 1, "{said}");
        assert_eq!(bench.say("G28.6"), "X:0 Y:0 Z:0 \nok\n");
        assert!(!bench.is_energised(Alpha), "nothing is driven before something moves");
        bench.run(&["G28 X", "G1 X20 F6000", "M400"]);
        assert_eq!(registers(&bench), before);
        assert!((bench.carriage(Alpha) - 20.0).abs() < 0.02, "{} mm", bench.carriage(Alpha));
    }
}

/// The current at rest is written without a report that the driver lost its settings, and must not hide the
/// loss.
#[test]
fn a_current_that_falls_at_rest_hides_no_loss() {
    for plan in [Plan::new(CARTESIAN), Plan::new(CARTESIAN).on_tmc2660()] {
        let kind = if plan.is_tmc2660() { "tmc2660" } else { "tmc2590" };
        let mut bench = plan
            .set("[actuator] common.halt_on_driver_alarm = false")
            .set(&format!("[{kind}] alpha.standstill_current = 400"))
            .set(&format!("[{kind}] common.standstill_time = 1"))
            .start_homed();
        // The settings are lost shortly before the current falls, and before the next check of the chip.
        bench.run(&["G1 X50 F6000", "M400"]);
        for _ in 0..20 {
            bench.run(&["G1 X49 F6000", "G1 X50", "M400"]);
            bench.hear(0.97);
            bench.world(|world| world.inject(&Fault::DriverReset(Alpha))).expect("a driver");
            bench.hear_until("X: the driver was without power", 1.5);
            bench.hear(0.05);
        }
    }
}

#[test]
fn a_job_ends_where_a_driver_lost_its_settings() {
    let mut bench = Plan::new(CARTESIAN).file("job.g", &"G1 X100 F6000\nG1 X10\n".repeat(40)).start_homed();
    bench.type_in("play /sd/job.g\n");
    bench.hear(2.0);
    bench.world(|world| world.inject(&Fault::DriverReset(Alpha))).expect("a driver");
    bench.hear_until("ERROR: motor driver X: the driver was without power", 1.5);
    bench.assert_safe();
}
