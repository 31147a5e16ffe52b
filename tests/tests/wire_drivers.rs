//! Drivers outside the board whose chips are on an auxiliary UART of one wire; and the codes for drivers that
//! others have.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::world::Fault;
use units::Actuator::{self, Delta, Epsilon, Zeta};

/// The fourth motor with such a driver: 10 full steps a millimetre, 16 microsteps.
fn plan(kind: &str, settings: &[&str]) -> Plan {
    let plan = [
        "[extruder] hotend.enable = false",
        "[actuator] delta.steps_per_mm = 160",
        "[actuator] delta.microsteps = 16",
        "[actuator] delta.max_rate = 6000",
        "[actuator] delta.step_pin = PJ5",
        "[actuator] delta.dir_pin = PJ1",
        "[current control] delta.current = 0.9",
    ]
    .iter()
    .fold(Plan::new(CARTESIAN), |plan, line| plan.set(line))
    .set(&format!("[actuator] delta.driver = {kind}"))
    .set("[uart console] enable = false")
    .set(&format!("[{kind}] delta.sense_resistor = 110"));
    settings.iter().fold(plan, |plan, line| plan.set(line))
}

fn word(bench: &Bench, motor: Actuator, register: u8) -> u32 {
    bench.world(|world| world.outside_driver(motor).expect("a driver outside").register(register))
}

fn drives(bench: &Bench, motor: Actuator) -> bool {
    bench.world(|world| world.outside_driver(motor).expect("a driver outside").drives())
}

fn inject(bench: &Bench, fault: &Fault) {
    bench.world(|world| world.inject(fault)).expect("a driver of this machine");
}

/// GCONF: en_spreadcycle, pdn_disable, mstep_reg_select, multistep_filt. IRUN: 32 * 0.9 A * 0.13 Ohm / 0.18 V
/// - 1 = 19.8, with vsense, bit 17 of CHOPCONF; MRES 4 for 16 microsteps; SENDDELAY 2.
#[test]
fn each_chip_gets_the_words_of_its_datasheet_and_moves_its_motor() {
    for kind in ["tmc2208", "tmc2209", "tmc2226"] {
        let mut bench = plan(kind, &[]).start();
        assert!(!bench.greeting().contains("ERROR") && !bench.greeting().contains("WARNING"), "{}", bench.greeting());
        for (register, expected) in [
            (0x00, 0x1C4),
            (0x01, 0),
            (0x03, 0x200),
            (0x10, 0x0006_1414),
            (0x13, 0),
            (0x6C, 0x0403_00C0),
            (0x70, 0xC10D_0024),
        ] {
            assert_eq!(word(&bench, Delta, register), expected, "{kind}: {register:02x}");
        }
        assert!(!drives(&bench, Delta), "off until something moves, though the chip drives by itself at power-on");
        bench.run(&["G91", "G1 A10 F600", "M400"]);
        assert_eq!(word(&bench, Delta, 0x6C), 0x0403_00C3);
        assert!((bench.carriage(Delta) - 10.0).abs() < 0.01, "{} mm", bench.carriage(Delta));
        let amps = bench.world(|world| world.outside_driver(Delta).expect("one").peak_current_amps(0.11));
        assert!((amps - 0.9).abs() < 0.025, "{amps} A");
    }
}

#[test]
fn drivers_of_one_wire_have_an_address_each() {
    let mut plan = plan("tmc2209", &["[tmc2209] delta.uart_address = 3"]);
    for (place, motor) in ["epsilon", "zeta"].into_iter().enumerate() {
        let kind = ["tmc2209", "tmc2226"][place];
        for line in [
            format!("[actuator] {motor}.driver = {kind}"),
            format!("[actuator] {motor}.steps_per_mm = 160"),
            format!("[actuator] {motor}.microsteps = 16"),
            format!("[actuator] {motor}.max_rate = 6000"),
            format!("[actuator] {motor}.step_pin = {}", ["PJ7", "PG1"][place]),
            format!("[actuator] {motor}.dir_pin = {}", ["PJ8", "PJ2"][place]),
            format!("[{kind}] {motor}.uart_address = {place}"),
            format!("[{kind}] {motor}.sense_resistor = 110"),
            format!("[current control] {motor}.current = 0.5"),
        ] {
            plan = plan.set(&line);
        }
    }
    let mut bench = plan.start();
    assert!(!bench.greeting().contains("ERROR") && !bench.greeting().contains("WARNING"), "{}", bench.greeting());
    bench.run(&["G91", "G1 A10 B5 C2 F600", "M400"]);
    for (motor, mm) in [(Delta, 10.0), (Epsilon, 5.0), (Zeta, 2.0)] {
        assert!(drives(&bench, motor));
        assert!((bench.carriage(motor) - mm).abs() < 0.01, "{}: {} mm", motor.name(), bench.carriage(motor));
    }
    bench.say("M906 B1200");
    let amps = |motor| bench.world(|world| world.outside_driver(motor).expect("one").peak_current_amps(0.11));
    assert!((amps(Epsilon) - 1.2).abs() < 0.04 && (amps(Zeta) - 0.5).abs() < 0.04 && (amps(Delta) - 0.9).abs() < 0.03);
    // With one driver silent the others still answer.
    inject(&bench, &Fault::DriverSilent(Epsilon));
    let said = bench.hear_until("motor driver B: driver does not answer, check its supply and wiring", 4.0);
    assert!(!said.contains("driver A") && !said.contains("driver C"), "{said}");
}

#[test]
fn one_that_does_not_answer_is_told_and_one_that_was_without_power_is_set_up_again() {
    let bench = plan("tmc2208", &[]).fault("driver-silent:delta").start();
    assert!(bench.greeting().contains("motor driver delta does not answer"), "{}", bench.greeting());
    let mut bench = plan("tmc2209", &["[actuator] common.halt_on_driver_alarm = false"]).start();
    bench.run(&["G91", "G1 A5 F600", "M400"]);
    let chopconf = word(&bench, Delta, 0x6C);
    inject(&bench, &Fault::DriverReset(Delta));
    assert_eq!(word(&bench, Delta, 0x6C), 0x1000_0053, "as it comes from the factory, by its pins");
    let said = bench.hear_until("A: the driver was without power", 3.0) + &bench.hear(3.0);
    assert_eq!(said.matches("without power").count(), 1, "{said}");
    assert!(!drives(&bench, Delta), "nothing is driven before something moves");
    let place = bench.carriage(Delta);
    bench.run(&["G1 A5 F600", "M400"]);
    assert!((bench.carriage(Delta) - place - 5.0).abs() < 0.01, "{} mm", bench.carriage(Delta));
    assert_eq!(word(&bench, Delta, 0x6C), chopconf);
}

#[test]
fn heat_and_shorts_are_told_in_the_words_of_the_board_s_drivers() {
    for (fault, words, is_fatal) in [
        (Fault::DriverTemperature(Delta, 125), "WARNING: A: Overtemperature Prewarning", false),
        (Fault::DriverTemperature(Delta, 155), "motor driver A: Overtemperature Shutdown", true),
        (Fault::DriverShort(Delta), "motor driver A: SHORT to ground on channel A", true),
        (Fault::DriverShortToSupply(Delta), "motor driver A: SHORT to supply on channel A", true),
    ] {
        let mut bench = plan("tmc2209", &[]).start();
        bench.run(&["G91", "G1 A1 F600", "M400"]);
        inject(&bench, &fault);
        let said = bench.hear_until(words, 4.0) + &bench.hear(2.5);
        assert_eq!(said.matches(words).count(), 1, "{said}");
        assert_eq!(bench.status().contains("Alarm"), is_fatal, "{words}: {}", bench.status());
    }
}

#[test]
fn a_disturbed_datagram_alarms_nobody() {
    let mut bench = plan("tmc2209", &[]).fault("driver-bit-errors:delta,61@1").start();
    let said = bench.hear(120.0);
    assert!(!said.contains("WARNING") && !said.contains("ERROR"), "{said}");
}

#[test]
fn m911_and_m122_describe_it_and_m911_3_sets_it() {
    let mut bench = plan("tmc2209", &[]).start();
    bench.run(&["G91", "G1 A1 F600", "M400"]);
    let said = bench.say("M911 P3");
    for words in ["Chip type TMC2209", "Enabled: 1", "mA Peak", "CHOPCONF: 040300C3", "SGTHRS: 00000000"] {
        assert!(said.contains(words), "{words} is not in {said}");
    }
    assert!(bench.say("M122 A").contains("Chip type TMC2209"));
    assert!(bench.say("M911.1 P3").contains("A,0,3,32,5,-2,0"), "{}", bench.say("M911.1 P3"));
    bench.run(&["M911.3 P3 S1 U4 V24 W3 X1 Y0"]);
    assert_eq!(word(&bench, Delta, 0x6C) & 0x1_87FF, 4 | 2 << 4 | 4 << 7 | 1 << 15);
    bench.run(&["M911.3 P3 S7 O60", "M911.3 P3 S8 H64 I64 J1 K2 L1"]);
    assert_eq!((word(&bench, Delta, 0x40), word(&bench, Delta, 0x42)), (60, 1 << 15 | 1 << 13 | 2 << 8 | 2 << 5 | 2));
    for refused in ["M911.3 P3 S0 U4 V24 W3 X1 Y0", "M911.3 P3 S7 O256", "M911.2 P3 R1 V0", "M911.3 P3 S1 U4 V36 W3 X1"]
    {
        assert!(bench.say(refused).contains("the driver cannot be set so"), "{refused}");
    }
}

/// 12 MHz / (50 mm/s * 10 full steps/mm * 256) = 93.75.
#[test]
fn m913_and_m569_say_up_to_which_speed_stealth_chop_drives_and_m500_keeps_it() {
    let mut bench = plan("tmc2209", &["[tmc2209] delta.stealthchop_threshold = 50"]).start();
    let mode = |bench: &Bench| (word(bench, Delta, 0x00) >> 2 & 1, word(bench, Delta, 0x13));
    assert_eq!(mode(&bench), (0, 94));
    assert_eq!(bench.say("M913"), "delta: 50 mm/s\nok\n");
    bench.run(&["M913 A0"]);
    assert_eq!(mode(&bench), (1, 0));
    bench.run(&["M569 S1 A"]);
    assert_eq!(mode(&bench), (0, 0));
    bench.run(&["M569 S0", "M913 A25"]);
    assert_eq!(mode(&bench), (0, 188));
    assert!(bench.say("M913 X100").contains("alpha: its driver has no stealthChop"), "and the file goes on");
    assert!(bench.say("M913 A-1").contains("must not be negative"));
    assert!(bench.say("M503").contains("M913 A25"), "{}", bench.say("M503"));
}

#[test]
fn m914_is_what_counts_as_a_stall_while_homing() {
    let homing = ["[endstops] minx.pin", "[endstops] minx.slow_rate", "[endstops] minx.stall_homing = true"];
    let mut bench = plan("tmc2209", &homing).start();
    assert_eq!(bench.say("M914"), "alpha: 0\nok\n");
    bench.run(&["M914 X5 A200"]);
    assert_eq!(bench.say("M914"), "alpha: 5\nok\n");
    assert!(bench.say("M503").contains("M911.3 P0 S9 O5"), "{}", bench.say("M503"));
    assert!(bench.say("M914 X64").contains("alpha: -64 to 63"));
    assert!(bench.say("M914 A256").contains("delta: 0 to 255"));
}

#[test]
fn m912_makes_a_warning_news_again() {
    let mut bench = plan("tmc2209", &[]).start();
    inject(&bench, &Fault::DriverTemperature(Delta, 125));
    bench.hear_until("A: Overtemperature Prewarning", 4.0);
    assert!(!bench.hear(5.0).contains("Prewarning"));
    bench.run(&["M912 A"]);
    bench.hear_until("A: Overtemperature Prewarning", 4.0);
}

#[test]
fn what_the_file_says_wrongly_is_told_with_the_fix() {
    for (changes, words) in [
        (
            &["[tmc2209] delta.sense_resistor", "[tmc2209] delta.off_time = 3"][..],
            "the resistor is that of the driver's own board",
        ),
        (&["[tmc2209] delta.sense_resistor"], "the motor's driver has no entry in [tmc2209]"),
        (
            &["[uart console] enable = true", "[uart console] channel = 0"],
            "UART 0 is that of [uart console]: a line cannot serve drivers and a console",
        ),
        (&["[switch] fan.output_pin = PD8"], "PD8"),
        (&["[tmc2209] delta.uart_address = 4"], "4"),
        (&["[tmc2209] delta.blank_time = 36"], "36"),
        (&["[tmc2209] delta.coolstep_lower = 64"], "measures load while stealthChop drives, which it never does"),
        (&["[actuator] delta.driver = tmc2208"], "a motor has one driver, and there is an entry for it in [tmc2209]"),
    ] {
        let bench = changes.iter().fold(plan("tmc2209", &[]), |plan, line| plan.set(line)).start();
        assert!(bench.greeting().contains(words), "{changes:?}: {}", bench.greeting());
    }
    let second = [
        "[actuator] epsilon.driver = tmc2208",
        "[actuator] epsilon.steps_per_mm = 160",
        "[actuator] epsilon.microsteps = 16",
        "[actuator] epsilon.max_rate = 6000",
        "[actuator] epsilon.step_pin = PJ7",
        "[actuator] epsilon.dir_pin = PJ8",
        "[tmc2208] epsilon.sense_resistor = 110",
        "[current control] epsilon.current = 0.5",
    ];
    let bench = plan("tmc2208", &second).start();
    assert!(bench.greeting().contains("delta has address 0 on UART 0 too"), "{}", bench.greeting());
    let stop = ["[endstops] minx.stall_homing = true", "[endstops] minx.stall_threshold = 100"];
    let bench = plan("tmc2209", &stop).start();
    assert!(bench.greeting().contains("100 is none of a tmc2590"), "{}", bench.greeting());
}

/// X with a driver outside, its DIAG on an input, without a switch.
fn homing(kind: &str, own: &[&str]) -> Plan {
    let search =
        ["[endstops] minx.slow_rate", "[endstops] minx.stall_homing = true", "[endstops] minx.stall_current = 0.8"];
    let plan = Plan::new(CARTESIAN).with_x_outside(kind);
    search.iter().chain(own).fold(plan, |plan, line| plan.set(line))
}

/// With the sensitivity of its own kind of measurement, current and chopper of the search's own, and back.
#[test]
fn an_axis_homes_without_a_switch_by_a_driver_outside() {
    let of_2209 =
        ["[tmc2209] alpha.sense_resistor = 110", "[endstops] minx.pin = PG0", "[endstops] minx.stall_threshold = 30"];
    let of_5160 = [
        "[tmc5160] alpha.sense_resistor = 75",
        "[tmc5160] alpha.spi_cs_pin = PJ9",
        "[tmc5160] alpha.stealthchop_threshold = 100",
        "[endstops] minx.pin = PG0!",
        "[endstops] minx.stall_threshold = 4",
    ];
    for (kind, own) in [("tmc2209", &of_2209[..]), ("tmc5160", &of_5160)] {
        let mut bench = homing(kind, own).start();
        assert!(!bench.greeting().contains("ERROR"), "{}", bench.greeting());
        let before = [0x00, 0x10, 0x13, 0x14, 0x40, 0x6D].map(|register| word(&bench, Actuator::Alpha, register));
        let mut places = Vec::new();
        for n in 0..8 {
            let said = bench.say("G28 X");
            assert_eq!(said, "ok\n", "{kind}: {said}");
            places.push(bench.carriage(Actuator::Alpha));
            bench.run(&[&format!("G1 X{} F6000", 20 + n), "M400"]);
        }
        let [least, most] = places.iter().fold([f64::MAX, f64::MIN], |[a, b], place| [a.min(*place), b.max(*place)]);
        assert!(most - least <= 0.4, "{kind}: {places:?}, within two full steps");
        assert!((least - 5.0).abs() < 0.4 && (most - 5.0).abs() < 0.4, "{kind}: {places:?}");
        let after = [0x00, 0x10, 0x13, 0x14, 0x40, 0x6D].map(|register| word(&bench, Actuator::Alpha, register));
        assert_eq!(after, before, "{kind}: as it was");
        // Far too sensitive it stalls on the way, and says so.
        bench.run(&[if kind == "tmc2209" { "M914 X200" } else { "M914 X-60" }]);
        let said = bench.say("G28 X");
        assert!(said.contains("stalls before its end"), "{kind}: {said}");
    }
}

#[test]
fn tune_driver_finds_a_threshold_for_a_driver_outside() {
    let own = ["[tmc5160] alpha.sense_resistor = 75", "[tmc5160] alpha.spi_cs_pin = PJ9", "[endstops] minx.pin = PG0!"];
    let mut bench = homing("tmc5160", &own).start();
    bench.run(&["G28.3 X0"]);
    let said = bench.say("tune_driver X 50");
    assert!(said.contains("stall_threshold = "), "{said}");
    let threshold = word(&bench, Actuator::Alpha, 0x6D) >> 16 & 0x7F;
    assert!(said.contains(&format!("stall_threshold = {threshold}, ")), "{threshold}: {said}");
    assert_eq!(bench.say("G28 X"), "ok\n");
}

/// Tuning of stallGuard4: the threshold is held against the readings, for the watch and for homing. The axis
/// homes with the threshold found, and a crash is detected.
#[test]
fn tune_driver_finds_a_threshold_for_stall_guard_4() {
    let own = [
        "[tmc2209] alpha.sense_resistor = 110",
        "[tmc2209] alpha.stall_watch = true",
        "[tmc2209] alpha.stealthchop_threshold = 300",
        "[endstops] minx.pin = PG0",
    ];
    let mut bench = homing("tmc2209", &own).start();
    bench.run(&["G28.3 X0"]);
    let said = bench.say("tune_driver X");
    println!("{said}");
    let threshold = word(&bench, Actuator::Alpha, 0x40);
    assert!(said.contains(&format!("stall_threshold = {threshold}, the middle of ")), "{threshold}: {said}");
    assert!(said.contains("stall_threshold of its endstop = "), "{said}");
    assert_eq!(said.matches(": sure").count(), 2, "{said}");
    for n in 0..4 {
        assert_eq!(bench.say("G28 X"), "ok\n");
        assert!((bench.carriage(Actuator::Alpha) - 5.0).abs() < 0.4, "{}", bench.carriage(Actuator::Alpha));
        bench.run(&[&format!("G1 X{} F12000", 150 + n), "M400"]);
    }
    bench.world(|world| world.obstruct(Actuator::Alpha, [-3.0, 100.0]));
    bench.type_in("G1 X20 F6000\nG1 X150\n");
    bench.hear_until("motor X stalls", 5.0);
    let mut bench = plan("tmc2208", &[]).start();
    assert!(bench.say("tune_driver A 50").contains("its driver measures no load"));
}

/// MSCNT is read with each homing, so a noisy switch homes to the same step, and lost steps are seen.
#[test]
fn a_driver_outside_says_where_it_is_in_its_cycle() {
    for (kind, own) in [
        ("tmc2209", &["[tmc2209] alpha.sense_resistor = 110"][..]),
        ("tmc5160", &["[tmc5160] alpha.sense_resistor = 75", "[tmc5160] alpha.spi_cs_pin = PJ9"]),
    ] {
        let plan = homing(kind, own).set("[endstops] minx.stall_homing = false").set("[endstops] minx.stall_current");
        let mut bench = plan.set("[endstops] minx.phase_check = true").start();
        bench.run(&["G28 X"]);
        bench.world(|world| world.make_switch_noisy("minx", 0.02)).expect("a switch");
        let mut places = Vec::new();
        for n in 0..10 {
            bench.run(&[&format!("G1 X{} F6000", 20.0 + 3.7 * f64::from(n % 5)), "M400"]);
            let said = bench.say("G28 X");
            assert_eq!(said, "ok\n", "{kind}");
            places.push(bench.carriage(Actuator::Alpha));
        }
        let [least, most] = places.iter().fold([f64::MAX, f64::MIN], |[a, b], place| [a.min(*place), b.max(*place)]);
        assert!(most - least < 0.001, "{kind}: {places:?}");
    }
}
