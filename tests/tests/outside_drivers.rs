//! Drivers outside the board whose chips are set up and asked over SPI.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::world::Fault;
use units::Actuator::{self, Delta, Epsilon};

/// The fourth motor with such a driver: 10 full steps a millimetre, 16 microsteps.
const DELTA_OUTSIDE: &[&str] = &[
    "[extruder] hotend.enable = false",
    "[actuator] delta.steps_per_mm = 160",
    "[actuator] delta.microsteps = 16",
    "[actuator] delta.max_rate = 6000",
    "[actuator] delta.step_pin = PJ5",
    "[actuator] delta.dir_pin = PJ1",
];

fn plan(kind: &str, settings: &[&str]) -> Plan {
    let plan = DELTA_OUTSIDE.iter().fold(Plan::new(CARTESIAN), |plan, line| plan.set(line));
    let plan = plan.set(&format!("[actuator] delta.driver = {kind}")).set(&format!("[{kind}] delta.spi_cs_pin = PJ9"));
    settings.iter().fold(plan, |plan, line| plan.set(line))
}

fn tmc5160() -> Plan {
    plan("tmc5160", &["[tmc5160] delta.sense_resistor = 75", "[current control] delta.current = 2"])
}

/// Returns the words written to the driver's chip.
fn written(bench: &Bench, motor: Actuator) -> Vec<[u8; 5]> {
    bench.world(|world| world.outside_driver(motor).expect("a driver outside").written().to_vec())
}

fn assert_written(bench: &Bench, motor: Actuator, words: &[[u8; 5]]) {
    let written = written(bench, motor);
    for word in words {
        assert!(written.contains(word), "{word:02x?} is not in {written:02x?}");
    }
}

fn drives(bench: &Bench, motor: Actuator) -> bool {
    bench.world(|world| world.outside_driver(motor).expect("a driver outside").drives())
}

fn inject(bench: &Bench, fault: &Fault) {
    bench.world(|world| world.inject(fault)).expect("a driver of this machine");
}

/// CHOPCONF is the datasheets' example 000100C3, with MRES 4 in bits 24 to 27 for 16 microsteps; TOFF, the
/// last digit, is 0 while the motor is off.
#[test]
fn each_chip_gets_the_words_of_its_datasheet() {
    // GLOBALSCALER 256 * 2 A * 0.075 Ohm / 0.325 V = 118.2, IRUN 31; TPFD 4 in bits 20 to 23.
    let mut bench = tmc5160().start();
    assert!(!bench.greeting().contains("ERROR"), "{}", bench.greeting());
    assert_written(
        &bench,
        Delta,
        &[
            [0xEC, 0x04, 0x41, 0x00, 0xC0],
            [0x80, 0, 0, 0, 0x08],
            [0x8B, 0, 0, 0, 118],
            [0x90, 0, 6, 31, 31],
            [0x93, 0, 0, 0, 0],
            [0xF0, 0xC4, 0x0C, 0x00, 0x1E],
        ],
    );
    assert!(!drives(&bench, Delta));
    bench.run(&["G91", "G1 A10 F600", "M400"]);
    assert_written(&bench, Delta, &[[0xEC, 0x04, 0x41, 0x00, 0xC3]]);
    assert!((bench.carriage(Delta) - 10.0).abs() < 0.01, "{} mm", bench.carriage(Delta));
    assert_eq!(bench.world(|world| world.timing_faults()), 0);

    // 32 * 1.2 A * 0.13 Ohm / 0.18 V - 1 = 26.7, with vsense, bit 17.
    let bench =
        plan("tmc2130", &["[tmc2130] delta.sense_resistor = 110", "[current control] delta.current = 1.2"]).start();
    assert_written(
        &bench,
        Delta,
        &[[0xEC, 0x04, 0x03, 0x00, 0xC0], [0x80, 0, 0, 0, 0], [0x90, 0, 6, 27, 27], [0xF0, 0x00, 0x05, 0x04, 0x80]],
    );
    let amps = bench.world(|world| world.outside_driver(Delta).expect("one").peak_current_amps(0.11));
    assert!((amps - 1.2).abs() < 0.025, "{amps} A");

    // 2 A are the smallest range above 1.5 A: GLOBALSCALER 256 * 1.5 / 2 = 192.
    let bench =
        plan("tmc2240", &["[tmc2240] delta.reference_resistor = 12000", "[current control] delta.current = 1.5"])
            .start();
    assert_written(
        &bench,
        Delta,
        &[[0x8A, 0, 0, 0, 1], [0x8B, 0, 0, 0, 192], [0x90, 0, 6, 31, 31], [0xF0, 0xC4, 0x0C, 0x00, 0x1D]],
    );
}

/// 12 MHz / (50 mm/s * 10 full steps/mm * 256) = 93.75; en_pwm_mode is bit 2 of GCONF.
#[test]
fn a_threshold_of_stealth_chop_is_a_time_between_steps() {
    let bench = tmc5160().set("[tmc5160] delta.stealthchop_threshold = 50").start();
    assert_written(&bench, Delta, &[[0x93, 0, 0, 0, 94], [0x80, 0, 0, 0, 0x0C]]);
}

#[test]
fn a_machine_has_more_motors_than_the_board_has_drivers() {
    let mut bench = [
        "[actuator] epsilon.driver = tmc2130",
        "[actuator] epsilon.steps_per_mm = 160",
        "[actuator] epsilon.microsteps = 16",
        "[actuator] epsilon.max_rate = 6000",
        "[actuator] epsilon.step_pin = PJ7",
        "[actuator] epsilon.dir_pin = PJ8",
        "[actuator] epsilon.en_pin = PJ11!",
        "[tmc2130] epsilon.spi_cs_pin = PJ10",
        "[tmc2130] epsilon.sense_resistor = 110",
        "[current control] epsilon.current = 1",
    ]
    .iter()
    .fold(tmc5160(), |plan, line| plan.set(line))
    .start();
    assert!(!bench.greeting().contains("ERROR") && !bench.greeting().contains("WARNING"), "{}", bench.greeting());
    assert!(!drives(&bench, Epsilon));
    bench.run(&["G91", "G1 A10 B5 F600", "M400"]);
    assert!(drives(&bench, Epsilon) && drives(&bench, Delta));
    for (motor, mm) in [(Delta, 10.0), (Epsilon, 5.0)] {
        assert!((bench.carriage(motor) - mm).abs() < 0.01, "{}: {} mm", motor.name(), bench.carriage(motor));
    }
    bench.say("M18");
    assert!(!drives(&bench, Epsilon) && !drives(&bench, Delta));
}

#[test]
fn currents_are_set_and_described_as_on_the_board() {
    let mut bench = tmc5160()
        .set("[tmc5160] delta.max_current = 2500")
        .set("[tmc5160] delta.standstill_current = 500")
        .set("[tmc5160] common.standstill_time = 2")
        .start();
    let amps = |bench: &Bench| bench.world(|world| world.outside_driver(Delta).expect("one").peak_current_amps(0.075));
    assert!((amps(&bench) - 2.0).abs() < 0.01);
    bench.say("M906 A1500");
    assert!((amps(&bench) - 1.5).abs() < 0.01);
    assert!(bench.say("M907 A3").contains("current cut to max_current 2.500 A"));
    assert!((amps(&bench) - 2.5).abs() < 0.01);
    bench.run(&["G91", "G1 A1 F600", "M400"]);
    bench.hear(3.0);
    assert!((amps(&bench) - 0.5).abs() < 0.01, "{} A at rest", amps(&bench));
    bench.run(&["G1 A1 F600"]);
    assert!((amps(&bench) - 2.5).abs() < 0.01, "{} A in motion", amps(&bench));
    bench.say("M400");
    let said = bench.say("M911 P3");
    for words in ["Chip type TMC5160", "Enabled: 1", "Current setting: 2505mA Peak", "CHOPCONF: 044100C3"] {
        assert!(said.contains(words), "{words} is not in {said}");
    }
    assert!(bench.say("M911.1 P3").contains("A,0,3,36,5,-2,0"), "{}", bench.say("M911.1 P3"));
    bench.say("M909 A8");
    assert!(written(&bench, Delta).contains(&[0xEC, 0x05, 0x41, 0x00, 0xC3]));
    assert!(bench.say("M911.2 P3 R1 V0").contains("the driver cannot be set so"));
}

#[test]
fn a_driver_that_never_answers_is_told_at_boot_and_one_that_stops_answering_later() {
    let mut bench = tmc5160().fault("driver-silent:delta").start();
    bench.hear(1.0);
    assert!(bench.greeting().contains("motor driver delta does not answer"), "{}", bench.greeting());
    let mut bench = tmc5160().start();
    bench.hear(1.0);
    inject(&bench, &Fault::DriverSilent(Delta));
    bench.hear_until("motor driver A: driver does not answer, check its supply and wiring", 4.0);
    bench.assert_safe();
}

/// Another chip is no answer either.
#[test]
fn a_chip_of_another_kind_is_told() {
    let resistor = "[tmc2130] delta.sense_resistor = 75";
    let plan = plan("tmc5160", &["[tmc5160] delta.sense_resistor = 75", "[current control] delta.current = 1"]).built();
    let bench = plan
        .set("[actuator] delta.driver = tmc2130")
        .set("[tmc5160] delta.spi_cs_pin")
        .set("[tmc5160] delta.sense_resistor")
        .set("[tmc2130] delta.spi_cs_pin = PJ9")
        .set(resistor)
        .start();
    assert!(bench.greeting().contains("motor driver delta does not answer"), "{}", bench.greeting());
}

#[test]
fn heat_and_shorts_are_told_in_the_words_of_the_board_s_drivers() {
    for (fault, words, is_fatal) in [
        (Fault::DriverTemperature(Delta, 125), "WARNING: A: Overtemperature Prewarning", false),
        (Fault::DriverTemperature(Delta, 155), "motor driver A: Overtemperature Shutdown", true),
        (Fault::DriverShort(Delta), "motor driver A: SHORT to ground on channel A", true),
        (Fault::DriverShortToSupply(Delta), "motor driver A: SHORT to supply on channel A", true),
    ] {
        let mut bench = tmc5160().start();
        bench.run(&["G91", "G1 A1 F600", "M400"]);
        inject(&bench, &fault);
        let said = bench.hear_until(words, 4.0) + &bench.hear(2.5);
        assert_eq!(said.matches(words).count(), 1, "{said}");
        assert_eq!(bench.status().contains("Alarm"), is_fatal, "{words}: {}", bench.status());
    }
}

#[test]
fn an_open_coil_is_told_in_slow_motion() {
    let mut bench = tmc5160().start();
    inject(&bench, &Fault::DriverOpenLoad(Delta));
    bench.type_in("G91\nG1 A60 F600\n");
    bench.hear_until("WARNING: A: no current through coil A", 9.0);
}

#[test]
fn a_driver_that_was_without_power_is_told_and_set_up_again() {
    for kind in ["tmc5160", "tmc2130"] {
        let resistor = format!("[{kind}] delta.sense_resistor = 110");
        let mut bench = plan(kind, &[&resistor, "[current control] delta.current = 1"])
            .set("[actuator] common.halt_on_driver_alarm = false")
            .start();
        bench.run(&["G91", "G1 A5 F600", "M400"]);
        let word = bench.world(|world| world.outside_driver(Delta).expect("one").register(0x6C));
        inject(&bench, &Fault::DriverReset(Delta));
        assert!(!drives(&bench, Delta));
        let said = bench.hear_until("A: the driver was without power", 4.0) + &bench.hear(3.0);
        assert_eq!(said.matches("without power").count(), 1, "{said}");
        assert!(!drives(&bench, Delta), "nothing is driven before something moves");
        let place = bench.carriage(Delta);
        bench.run(&["G1 A5 F600", "M400"]);
        assert!((bench.carriage(Delta) - place - 5.0).abs() < 0.01, "{} mm", bench.carriage(Delta));
        assert_eq!(bench.world(|world| world.outside_driver(Delta).expect("one").register(0x6C)), word);
    }
    // The machine halts if configured so.
    let mut bench = tmc5160().fault("driver-reset:delta@2").start();
    bench.hear_until("motor driver A: the driver was without power", 6.0);
    bench.assert_safe();
}

#[test]
fn a_disturbed_datagram_alarms_nobody() {
    let mut bench = tmc5160().fault("driver-bit-errors:delta,61@1").start();
    let said = bench.hear(120.0);
    assert!(!said.contains("WARNING") && !said.contains("ERROR"), "{said}");
}

#[test]
fn each_driver_is_asked_once_a_second_and_at_the_drivers_own_pace() {
    let mut bench = tmc5160().start();
    bench.hear(1.0);
    let datagrams = |bench: &Bench| bench.world(|world| world.outside_driver(Delta).expect("one").datagrams());
    let before = datagrams(&bench);
    bench.hear(10.0);
    assert_eq!(datagrams(&bench) - before, 40, "four for each poll");
}

#[test]
fn what_the_file_says_wrongly_is_told_with_the_fix() {
    let cs = "[tmc5160] delta.spi_cs_pin";
    let sense = "[tmc5160] delta.sense_resistor";
    for (change, words) in [
        (sense, "the resistor is that of the driver's own board"),
        (cs, "the driver needs a chip select"),
        ("[tmc5160] delta.spi_cs_pin = PJ9!", "a chip select is active low by itself"),
        ("[tmc5160] delta.spi_cs_pin = PJ5", "PJ5 is used by"),
        ("[tmc5160] delta.spi_cs_pin = PE6", "PE6 is used by SPI bus 1"),
        ("[tmc5160] delta.sense_resistor = 200", "2 A is above the driver's max_current of 1.625 A"),
        ("[tmc5160] delta.hysteresis_end = 11", "11 and hysteresis_start 5 make more than 15"),
        ("[tmc5160] delta.standstill_current = 5000", "5000 mA is above max_current"),
        ("[actuator] delta.driver = external", "a motor has one driver, and there is an entry for it in [tmc5160]"),
        ("[actuator] delta.driver = tmc2240", "the motor's driver has no entry in [tmc2240]"),
        ("[actuator] delta.microsteps = 12", "12 microsteps do not exist"),
    ] {
        let bench = tmc5160().set(change).start();
        assert!(bench.greeting().contains(words), "{change}: {}", bench.greeting());
    }
    let bench = tmc5160().set("[tmc5160] delta.sense_resistor = 200").set("[tmc5160] delta.max_current = 5000").start();
    let words = "2 A is more than the driver's resistor in [tmc5160] allows (write 1.62 or less)";
    assert!(bench.greeting().contains(words), "{}", bench.greeting());
}
