//! Temperature sensors: each kind heats as it should, says what is wrong in words, and stops where it fails.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::world::Fault;

fn temperature(line: &str) -> String {
    format!("[temperature control] {line}")
}

fn machine(lines: &[&str]) -> Plan {
    lines.iter().fold(Plan::new(CARTESIAN), |plan, line| plan.set(&temperature(line)))
}

/// Returns the temperature of this label in M105, C.
fn reported(bench: &mut Bench, label: &str) -> f64 {
    let said = bench.say("M105");
    let (_, rest) = said.split_once(&format!("{label}:")).unwrap_or_else(|| panic!("no {label} in {said}"));
    rest.split_whitespace().next().and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{said}"))
}

#[test]
fn every_analogue_kind_heats_to_its_target_and_stops_with_its_own_words() {
    for (kind, more, words) in [
        ("pt1000", "", "platinum sensor open"),
        ("pt100", "", "platinum sensor open"),
        ("ad849x", "hotend.amplifier_offset = 0.2", "amplifier at its upper end"),
        ("voltage", "hotend.voltage_curve = 0,0.3, 100,1.3", "voltage at 3.3 V or above"),
    ] {
        let kind_line = format!("hotend.sensor = {kind}");
        let lines = [kind_line.as_str(), more];
        let mut bench = machine(&lines[..if more.is_empty() { 1 } else { 2 }]).start();
        assert!((reported(&mut bench, "T") - 22.0).abs() < 4.0, "{kind} at rest: {}", bench.say("M105"));
        bench.say("M109 S150");
        bench.hear(10.0);
        assert!((bench.celsius("hotend") - 150.0).abs() < 4.0, "{kind}: {} C", bench.celsius("hotend"));
        assert!(bench.say("M305").contains(&format!("sensor= {kind}, temp= 1")), "{}", bench.say("M305"));
        bench.world(|world| world.inject(&Fault::ThermistorOpen("hotend".into()))).expect("a heater");
        let said = bench.hear_until("MINTEMP or MAXTEMP triggered on T", 2.0);
        assert!(said.contains(words), "{kind}: {said}");
        bench.assert_safe();
    }
}

#[test]
fn a_combined_sensor_follows_its_parts_and_fails_with_any_of_them() {
    for (kind, of) in [("max", f64::max as fn(f64, f64) -> f64), ("min", f64::min), ("mean", |a, b| (a + b) / 2.0)] {
        let lines = [format!("board.sensor = {kind}"), "board.sensors = hotend, bed".into()];
        let mut bench = machine(&[&lines[0], &lines[1]]).start();
        bench.say("M104 S120");
        bench.hear(20.0);
        let (hotend, bed) = (reported(&mut bench, "T"), reported(&mut bench, "B"));
        let combined = reported(&mut bench, "P");
        assert!(hotend > bed + 20.0 && (combined - of(hotend, bed)).abs() < 2.0, "{kind} {combined} of {hotend} {bed}");
    }
}

#[test]
fn a_heater_by_a_combined_sensor_halts_when_a_part_fails_and_says_which() {
    let lines = ["hotend.sensor = max", "hotend.sensors = left,right"];
    let parts = ["left", "right"].into_iter().zip([1, 2]).flat_map(|(name, input)| {
        ["enable = true".to_owned(), format!("thermistor_pin = ADC1_{input}"), format!("designator = {name}")]
            .map(|line| temperature(&format!("{name}.{line}")))
            .into_iter()
            .chain([temperature(&format!("{name}.thermistor = Semitec"))])
    });
    let mut bench = parts.fold(machine(&lines), |plan, line| plan.set(&line)).start();
    bench.say("M104 S60");
    bench.hear(1.0);
    assert!(bench.duty("hotend") > 0.5, "it heats: {}", bench.greeting());
    bench.world(|world| world.inject(&Fault::ThermistorOpen("right".into()))).expect("a sensor");
    let said = bench.hear_until("MINTEMP or MAXTEMP triggered on T", 2.0);
    assert!(said.contains(": right: thermistor open: check"), "{said}");
    bench.assert_safe();
}

#[test]
fn the_checker_names_a_circle_and_parts_that_are_not_there() {
    let circle =
        ["board.sensor = max", "board.sensors = bed,hotend", "bed.sensor = mean", "bed.sensors = hotend,board"];
    let bench = machine(&circle).start();
    assert!(bench.greeting().contains("a circle: board is made of bed is made of board"), "{}", bench.greeting());
    for (sensors, words) in [
        ("hotend,oven", "there is no [temperature control] oven"),
        ("hotend", "max is of two or more sensors, and here are 1"),
        ("hotend,hotend", "hotend is there twice"),
    ] {
        let line = format!("board.sensors = {sensors}");
        let bench = machine(&["board.sensor = max", &line]).start();
        assert!(bench.greeting().contains(words), "{}", bench.greeting());
    }
    let bench = machine(&["hotend.sensor = difference", "hotend.sensors = bed,board"]).start();
    assert!(bench.greeting().contains("no temperature to heat to"), "{}", bench.greeting());
}

/// A sensor that fails high is caught as soon with a filter of a minute as without one: safety stands before
/// it.
#[test]
fn heat_safety_sees_what_the_filter_hides() {
    let mut bench = machine(&["hotend.sensor_filter = 60", "hotend.max_rise = 0", "hotend.runaway_range = 0"]).start();
    bench.say("M104 S100");
    bench.hear(1.0);
    bench.world(|world| {
        let hotend = world.heater_index("hotend").expect("a hotend");
        world.soak(hotend, 350.0);
    });
    let said = bench.hear_until("MINTEMP or MAXTEMP triggered on T", 1.0);
    assert!(said.contains("reads 3"), "{said}");
    assert!(reported(&mut bench, "T") < 60.0, "the filter still goes on: {}", bench.say("M105"));
    bench.assert_safe();
}

#[test]
fn the_chip_s_own_temperature_is_reported_and_heats_nothing() {
    let mut bench = machine(&["board.sensor = chip"]).start();
    assert!((reported(&mut bench, "P") - 30.0).abs() < 0.1);
    let bench = machine(&["hotend.sensor = chip"]).start();
    assert!(bench.greeting().contains("says nothing of a heater"), "{}", bench.greeting());
}
