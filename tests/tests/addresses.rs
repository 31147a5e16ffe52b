//! Heaters, extruders and drivers are addressed by what the user wrote, never by a place in a list; and the
//! saved settings of Smoothieware v2 land where they land there.

use scenarios::{Bench, CARTESIAN, Plan};

/// Settings that Smoothieware v2 saves on a machine like the sample, with values that nothing has by default.
/// M500 writes the same.
const SAVED_BY_V2: &str = include_str!("data/config-override");

fn lines_without_comments(text: &str) -> Vec<&str> {
    text.lines().map(str::trim_end).filter(|line| !line.starts_with(';') && !line.is_empty()).collect()
}

#[test]
fn m303_p0_heats_the_hot_end_and_nothing_else() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("M303 P0 S150\n");
    bench.hear(8.0);
    assert!(bench.duty("hotend") > 0.5, "{}", bench.duty("hotend"));
    assert_eq!(bench.duty("bed"), 0.0);
    bench.type_in("\x18");
    bench.hear(0.1);
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("M303 P254 S60\n");
    bench.hear(8.0);
    assert!(bench.duty("bed") > 0.5 && bench.duty("hotend") == 0.0);
}

#[test]
fn an_id_that_nobody_has_is_refused_by_name_and_changes_nothing() {
    let mut bench = Plan::new(CARTESIAN).start();
    let before = bench.say("M503");
    let heater = |letter: char, code: &str, id: &str| {
        let list = format!("{letter}254 bed, {letter}253 board, {letter}0 hotend");
        format!("error:{code}: no temperature control has tool_id {id}; there are {list}\n")
    };
    for (line, expected) in [
        ("M303 P1 S150", heater('P', "M303", "1")),
        ("M303 P2 S150", heater('P', "M303", "2")),
        ("M303 P-1 S150", heater('P', "M303", "-1")),
        ("M303 P0.5 S150", heater('P', "M303", "0.5")),
        ("M303 P256 S150", heater('P', "M303", "256")),
        ("M301 S1 P5", heater('S', "M301", "1")),
        ("M143 S2 P300", heater('S', "M143", "2")),
        ("M143 S255 P300", heater('S', "M143", "255")),
        ("M104 S100 T1", "error:M104: no heater answers to T1, column 11\n".into()),
        ("M140 S60 T0", "error:M140: no heater answers to T0, column 10\n".into()),
        ("M207 S9 P1", "error:no extruder has tool_id 1; there are P0 hotend\n".into()),
        ("M208 S9 P3", "error:no extruder has tool_id 3; there are P0 hotend\n".into()),
        ("M200 D3 P0.5", "error:no extruder has tool_id 0.5; there are P0 hotend\n".into()),
        ("M221 S50 P-1", "error:no extruder has tool_id -1; there are P0 hotend\n".into()),
        ("M900 K1 P1", "error:no extruder has tool_id 1; there are P0 hotend\n".into()),
        ("M92 E1 P1", "error:no extruder has tool_id 1; there are P0 hotend\n".into()),
        ("M203 E1 P1", "error:no extruder has tool_id 1; there are P0 hotend\n".into()),
        ("M204 E1 P1", "error:no extruder has tool_id 1; there are P0 hotend\n".into()),
        ("M907 B1", "error:epsilon: has no driver whose current can be set\n".into()),
        ("M907 P1", "error:M907: P is the letter of no motor\n".into()),
        ("M906 S800", "error:M906: S is the letter of no motor\n".into()),
        ("M911 P7", "error:M911: P7 is the number of no driver; there are P0 X, P1 Y, P2 Z, P3 A\n".into()),
        ("T1", "error:no extruder has tool_id 1; there are P0 hotend\n".into()),
    ] {
        assert_eq!(bench.say(line), expected, "{line}");
    }
    assert_eq!(bench.say("M503"), before);
    bench.hear(3.0);
    assert!(bench.duty("hotend") == 0.0 && bench.duty("bed") == 0.0);
}

#[test]
fn gains_and_limits_go_to_the_heater_with_that_number() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["M301 S254 P54", "M143 S254 P100", "M301 S0 P11", "M143 S0 P280"]);
    let said = bench.say("M301");
    assert!(said.contains("B(S254): PonM: 0 P: 54.000000 ") && said.contains("T(S0): PonM: 0 P: 11.000000 "), "{said}");
    let said = bench.say("M143");
    let expected =
        "Maximum temperature for B(254) is 100.000000\u{b0}C\nMaximum temperature for T(0) is 280.000000\u{b0}C\nok\n";
    assert_eq!(said, expected);
    assert!(bench.say("M140 S101").starts_with("error:bed: 101.0 C is above its max_temp 100.0 C"));
    assert_eq!(bench.say("M104 S280"), "ok\n");
}

#[test]
fn every_way_to_choose_a_heater_agrees() {
    let mut bench = Plan::new(CARTESIAN).start();
    for (id, name, label) in [("0", "hotend", "T"), ("254", "bed", "B")] {
        let said = bench.say("get temp");
        assert!(said.contains(&format!("{name}: {label} ({id}) temp:")), "{said}");
        assert!(bench.say("M303").contains(&format!("({label}) {name}, select tool id with P{id}")));
        assert!(bench.say(&format!("M301 S{id}")).starts_with(&format!("{label}(S{id}):")));
    }
}

/// The sample with the seek rate that the file was saved at, and without what it does not say of a motor.
fn with_saved(saved: &str) -> Bench {
    let plan = ["[general] config-override = true", "[motion control] default_seek_rate = 4000"]
        .into_iter()
        .chain(["[actuator] alpha.acceleration", "[actuator] beta.acceleration", "[motion control] max_speed"])
        .fold(Plan::new(CARTESIAN), Plan::set);
    plan.file("config-override", saved).start()
}

#[test]
fn the_settings_v2_saves_load_without_a_word_and_are_written_as_they_were() {
    let mut bench = with_saved(SAVED_BY_V2);
    let loaded = "configuration override /sd/config-override loaded\n";
    assert_eq!(bench.greeting().matches(loaded).count(), 1, "{}", bench.greeting());
    for word in ["WARN", "rror", "refused"] {
        assert!(!bench.greeting().contains(word), "{}", bench.greeting());
    }
    assert_eq!(bench.say("M500"), "Settings Stored to /sd/config-override\nok\n");
    let written = bench.read_card("config-override").expect("the file");
    assert_eq!(lines_without_comments(&written), lines_without_comments(SAVED_BY_V2));
    // And once more from what was written.
    let mut again = with_saved(&written);
    again.say("M500");
    assert_eq!(again.read_card("config-override"), Some(written));
}

#[test]
fn the_settings_v2_saves_land_where_they_land_there() {
    let mut bench = with_saved(SAVED_BY_V2);
    assert_eq!(bench.say("M92"), "X:100.000000 Y:100.000000 Z:400.000000 E:701.000000 \nok\n");
    assert!(bench.say("M203").contains(" P:0.000000 E:51.000000 V:0.000000"), "{}", bench.say("M203"));
    assert_eq!(bench.say("M203.1"), " X:500.000000  Y:500.000000  Z:30.000000 E:51.000000 V:0.000000\nok\n");
    let gains = bench.say("M301");
    assert!(gains.contains("B(S254): PonM: 0 P: 54.000000 I: 0.500000 D: 254.000000 X(I_max):254.000000 max pwm: 254"));
    assert!(gains.contains("T(S0): PonM: 0 P: 11.000000 I: 0.100000 D: 111.000000 X(I_max):111.000000 max pwm: 111"));
    assert!(bench.say("M143").contains("B(254) is 120.0") && bench.say("M143").contains("T(0) is 300.0"));
    let currents = bench.say("M907");
    assert!(currents.contains("alpha: 1.50000 Amps") && currents.contains("delta: 0.80000 Amps"), "{currents}");
    // The bed keeps its own limit.
    assert!(bench.say("M140 S130").starts_with("error:bed: 130.0 C is above its max_temp 120.0 C"));
}
