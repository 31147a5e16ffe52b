//! Sensors behind converter chips on SPI: each heats as it should, each fault has its words, nothing heats by
//! what is old.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::converter::Leads;
use sim::world::Fault;

const KINDS: [(&str, &[&str]); 4] = [
    ("max31855", &[]),
    ("max31856", &["tc_type = J", "mains_frequency = 60"]),
    ("max31865", &["rtd_wires = 3"]),
    ("max31865", &["rtd_nominal = 1000", "rtd_reference = 4300"]),
];

/// The hot end's sensor behind a chip of this kind.
fn machine(kind: &str, more: &[&str]) -> Plan {
    let sensor = format!("sensor = {kind}");
    let lines = [sensor.as_str(), "spi_channel = 0", "spi_select_pin = PD10"];
    let set = |plan: Plan, line: &&str| plan.set(&format!("[temperature control] hotend.{line}"));
    more.iter().fold(lines.iter().fold(Plan::new(CARTESIAN), set), set)
}

fn inject(bench: &Bench, fault: Fault) {
    bench.world(|world| world.inject(&fault)).expect("a sensor with a chip");
}

fn hotend() -> String {
    "hotend".into()
}

/// Returns the temperature of the hot end in M105, C.
fn reported(bench: &mut Bench) -> f64 {
    let said = bench.say("M105");
    let (_, rest) = said.split_once("T:").unwrap_or_else(|| panic!("no T in {said}"));
    rest.split_whitespace().next().and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{said}"))
}

#[test]
fn every_kind_heats_to_its_target() {
    for (kind, more) in KINDS {
        let mut bench = machine(kind, more).start();
        let greeting = bench.greeting().to_owned();
        assert!(!greeting.contains("ERROR") && !greeting.contains("WARNING"), "{kind}: {greeting}");
        bench.hear(1.0);
        assert!((reported(&mut bench) - 22.0).abs() < 1.0, "{kind} at rest: {}", bench.say("M105"));
        bench.say("M109 S190");
        bench.hear(20.0);
        let (is, said) = (bench.celsius("hotend"), reported(&mut bench));
        assert!((is - 190.0).abs() < 2.0 && (said - is).abs() < 1.5, "{kind}: {is} C, reported {said}");
        assert!(bench.say("M305").contains(&format!("sensor= {kind}, temp= 1")), "{}", bench.say("M305"));
    }
}

/// Heats, then breaks the sensor; returns the messages until the halt, and the time taken.
fn broken(kind: &str, more: &[&str], fault: Fault) -> (String, f64) {
    let mut bench = machine(kind, more).start();
    bench.say("M104 S150");
    bench.hear(5.0);
    assert!(bench.duty("hotend") > 0.5, "{kind} heats");
    let from_s = bench.now_s();
    inject(&bench, fault);
    let said = bench.hear_until("MINTEMP or MAXTEMP triggered on T", 7.0);
    let took_s = bench.now_s() - from_s;
    bench.assert_safe();
    (said, took_s)
}

#[test]
fn every_fault_halts_within_a_second_and_says_what_to_check() {
    let (open, short) = (Fault::ThermistorOpen(hotend()), Fault::ThermistorShort(hotend()));
    let supply = Fault::SensorToSupply(hotend());
    let (silent, low) = (Fault::ConverterSilent(hotend()), Fault::ConverterLow(hotend()));
    for (kind, fault, words) in [
        ("max31855", &open, "thermocouple open: check its plug"),
        ("max31855", &short, "thermocouple shorted to ground"),
        ("max31855", &supply, "thermocouple shorted to the supply"),
        ("max31855", &silent, "no MAX31855 answers: check spi_select_pin"),
        ("max31855", &low, "the MAX31855's data line stays low"),
        ("max31856", &open, "thermocouple open: check its plug"),
        ("max31856", &supply, "a wire of the sensor touches a voltage"),
        ("max31856", &silent, "no MAX31856 answers: check spi_select_pin"),
        ("max31856", &low, "the MAX31856's data line stays low"),
        ("max31865", &open, "platinum sensor open: check its plug"),
        ("max31865", &short, "platinum sensor shorted: check its wires"),
        ("max31865", &supply, "a wire of the sensor touches a voltage"),
        ("max31865", &silent, "no MAX31865 answers: check spi_select_pin"),
        ("max31865", &low, "the MAX31865's data line stays low"),
    ] {
        let (said, took_s) = broken(kind, &[], fault.clone());
        let halted = said.split_once("triggered on T: ").is_some_and(|(_, why)| why.starts_with(words));
        assert!(halted, "{kind} {fault:?}: {said}");
        assert!(said.contains(&format!("WARNING: hotend: {words}")), "{said}");
        assert!(took_s < 1.0, "{kind} {fault:?}: {took_s} s");
    }
}

/// Faults that no conversion shows, or tells apart, are found by the chip's own test, every five seconds, and
/// four readings.
#[test]
fn a_single_wire_of_platinum_that_is_open_or_at_ground_is_found_by_the_chips_test() {
    for (leads, words) in [
        (Leads::ForceOpen, "platinum sensor open: check its plug, its FORCE wires and rtd_wires"),
        (Leads::MinusToGround, "platinum sensor: RTDIN- or FORCE- touches ground"),
        (Leads::PlusToGround, "platinum sensor"),
    ] {
        let (said, took_s) = broken("max31865", &["rtd_wires = 4"], Fault::SensorLead(hotend(), leads));
        assert!(said.contains(&format!("triggered on T: {words}")), "{leads:?}: {said}");
        assert!(took_s < 5.6, "{leads:?}: {took_s} s");
    }
}

/// The chip forgets its settings; they are written again, which is said, and it goes on reading.
#[test]
fn a_chip_that_was_reset_is_set_up_anew_and_told() {
    for kind in ["max31856", "max31865"] {
        let mut bench = machine(kind, &[]).start();
        bench.hear(1.0);
        let registers = |bench: &Bench| {
            bench.world(|world| world.converter_registers(world.heater_index("hotend").expect("one")).to_vec())
        };
        let before = registers(&bench);
        inject(&bench, Fault::ConverterReset(hotend()));
        assert_ne!(registers(&bench)[0], before[0]);
        let said = bench.hear_until("has lost its settings: check its supply", 0.5);
        assert!(said.contains("WARNING: hotend: the MAX318"), "{said}");
        bench.hear(1.0);
        assert_eq!(registers(&bench)[0], before[0], "{kind}");
        assert!((reported(&mut bench) - 22.0).abs() < 1.0);
        bench.say("M109 S40");
    }
    // The platinum sensor's converts again before heat safety gives up.
    let mut bench = machine("max31865", &[]).start();
    bench.say("M109 S100");
    inject(&bench, Fault::ConverterReset(hotend()));
    bench.hear(5.0);
    assert!((bench.celsius("hotend") - 100.0).abs() < 5.0 && bench.duty("hotend") > 0.0, "{}", bench.say("M105"));
}

/// A moment's noise on one frame halts nothing; off is the heater meanwhile.
#[test]
fn a_fault_of_a_moment_is_told_and_forgiven() {
    let mut bench = machine("max31855", &[]).start();
    bench.say("M109 S100");
    inject(&bench, Fault::ConverterSilent(hotend()));
    let said = bench.hear_until("no MAX31855 answers", 0.2);
    assert!(said.contains("WARNING: hotend"), "{said}");
    inject(&bench, Fault::Repaired);
    assert!(!bench.hear(3.0).contains("triggered"), "{}", bench.status());
    assert!((reported(&mut bench) - 100.0).abs() < 3.0);
}

/// The task that reads comes to run no more: after four of its periods the reading is none.
#[test]
fn what_is_old_heats_nothing() {
    for (per_second, least_s, most_s) in [(20, 0.4, 0.8), (2, 2.0, 2.8)] {
        let rate = format!("readings_per_second = {per_second}");
        let mut bench = machine("max31855", &[&rate]).start();
        bench.say("M104 S150");
        bench.hear(5.0);
        assert!(bench.duty("hotend") > 0.5);
        let from_s = bench.now_s();
        bench.hold_sensors(true);
        let said = bench.hear_until("MINTEMP or MAXTEMP triggered on T", 4.0);
        assert!(said.contains("the sensor has not been read"), "{said}");
        let took_s = bench.now_s() - from_s;
        // The last reading may have been a period old when the task stopped.
        assert!((least_s * 0.75..most_s).contains(&took_s), "{took_s} s");
        bench.assert_safe();
    }
}

#[test]
fn two_chips_on_one_bus_are_read_each_by_its_own_select() {
    let plan = ["sensor = max31865", "spi_channel = 0", "spi_select_pin = PD12", "rtd_wires = 4"];
    let set = |all: Plan, line: &&str| all.set(&format!("[temperature control] bed.{line}"));
    let mut bench = plan.iter().fold(machine("max31855", &[]), set).start();
    bench.hear(1.0);
    bench.world(|world| {
        let bed = world.heater_index("bed").expect("a bed");
        world.soak(bed, 60.0);
    });
    bench.hear(1.0);
    let said = bench.say("M105");
    assert!(said.contains("T:2") && (said.contains("B:59.") || said.contains("B:60.")), "{said}");
    inject(&bench, Fault::ConverterSilent("bed".into()));
    assert!(bench.hear(1.0).contains("WARNING: bed: no MAX31865 answers"));
    assert!((reported(&mut bench) - 22.0).abs() < 1.0);
}

/// A chip that is not there is told at boot, without anything heating.
#[test]
fn a_chip_that_is_missing_is_told_and_heats_nothing() {
    let mut bench = machine("max31856", &[]).fault("converter-silent:hotend").start();
    let said = bench.greeting().to_owned() + &bench.hear(1.0);
    assert!(said.contains("WARNING: hotend: no MAX31856 answers"), "{said}");
    bench.say("M104 S100");
    let said = bench.hear_until("MINTEMP or MAXTEMP triggered on T", 1.0);
    assert!(said.contains("no MAX31856 answers"), "{said}");
    bench.assert_safe();
}

#[test]
fn the_checker_names_the_setting_and_the_fix() {
    let whole = |kind: &str, more: &[&str]| machine(kind, more).start().greeting().to_owned();
    for (kind, more, reason, fix) in [
        ("max31855", "spi_channel = -1", "nobody knows where the max31855 is", "write 0 (SPI1: SCK PA5"),
        ("max31856", "spi_select_pin = nc", "the max31856 is never read", "as in PD10"),
        ("max31855", "spi_select_pin = PD10o", "rises too slowly", "delete the o"),
        ("max31855", "spi_select_pin = PA6", "PA6 is used by SPI bus 0 already", "use another pin"),
        ("max31855", "spi_select_pin = PE0", "PE0 is used by", "use another pin for one of them"),
        ("max31855", "tc_type = J", "max31855 has no such setting", "write sensor = max31856"),
        ("max31855", "rtd_wires = 3", "max31855 has no such setting", "write sensor = max31865"),
        ("max31865", "tc_averaging = 8", "max31865 has no such setting", "write sensor = max31855"),
        ("thermistor", "mains_frequency = 60", "thermistor has no such setting", "or delete it"),
        ("max31865", "rtd_reference = 43", "reads as open", "430 for a PT100"),
        ("max31865", "rtd_reference = 4300", "43.0 times rtd_nominal", "430 is 4300"),
    ] {
        let said = whole(kind, &[more]);
        assert!(said.contains(reason) && said.contains(fix), "{kind} {more}: {said}");
    }
    let said = whole("max31856", &["max_temp = 500", "tc_type = T"]);
    assert!(said.contains("a thermocouple of type T is read up to 400"), "{said}");
}

/// A converter that takes most of a second for its first reading is not taken for a broken one, and nothing
/// heats before it.
#[test]
fn a_target_right_after_boot_waits_for_the_first_reading() {
    let plan = machine("max31856", &["tc_averaging = 16"]).set("[player] on_boot_gcode_enable = true");
    let mut bench = plan.file("on_boot.gcode", "M104 S60\n").start();
    let said = bench.greeting().to_owned() + &bench.hear(3.0);
    assert!(!said.contains("triggered") && bench.duty("hotend") > 0.1, "{said}");
}
