//! Start codes of other machines: nothing is lost by going on without them, and it is told.

use scenarios::{CARTESIAN, Plan};

fn played(config: &str, lines: &str, dialect: &str) -> String {
    let file = format!("{dialect}G1 X10 F6000\n{lines}\nG1 X40\nM400\n");
    let mut bench = Plan::new(config).file("part.gcode", &file).start();
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear(6.0);
    said + &bench.say("M114.1")
}

const MARLIN: &str = ";FLAVOR:Marlin\n";
const KLIPPER: &str = "; gcode_flavor = klipper\n";

#[test]
fn a_machine_that_cannot_level_goes_on_and_tells_it_at_the_start() {
    let codes = ["M420 S1", "G29", "G29 P1", "G32", "M375", "M374", "G34", "G35"];
    for (line, dialect) in codes.map(|line| (line, MARLIN)).into_iter().chain([
        ("BED_MESH_CALIBRATE", KLIPPER),
        ("BED_MESH_PROFILE LOAD=default", KLIPPER),
        ("Z_TILT_ADJUST", KLIPPER),
    ]) {
        let said = played(CARTESIAN, line, dialect);
        assert!(said.contains("the job goes on without"), "{line}: {said}");
        assert!(said.contains("// NOTE not carried out: "), "{line}: {said}");
        assert!(!said.contains("error") && said.contains("X:40.0000"), "{line}: {said}");
        let mut bench = Plan::new(CARTESIAN).file("a.gcode", &format!("{dialect}{line}\n")).start();
        let said = bench.say("check a.gcode");
        assert!(said.contains("no probe and no leveling here") && said.contains("0 stop the job"), "{line}: {said}");
    }
}

#[test]
fn where_the_configuration_says_so_the_job_pauses() {
    let config = format!("{CARTESIAN}\n[player]\nwithout_leveling = pause\n");
    let said = played(&config, "M420 S1", MARLIN);
    assert!(said.contains("was not carried out") && said.contains("X:10.0000"), "{said}");
    let mut bench = Plan::new(&config).file("a.gcode", "M420 S1\n").start();
    assert!(bench.say("check a.gcode").contains("1 stop the job"));
}

#[test]
fn a_console_is_told_that_nothing_can_level() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert!(bench.say("M420 S1").contains("no grid strategy is configured"));
}

#[test]
fn what_switches_off_or_sets_nothing_stops_nobody() {
    for (line, counted) in [
        ("M280 P0 S160", "M280 1x"),
        ("T-1", "T-1 1x"),
        ("M104 S0 T1", "M104 1x"),
        ("M204 P0", "M204 1x"),
        ("M401\nM402", ""),
    ] {
        let said = played(CARTESIAN, line, MARLIN);
        assert!(said.contains(counted), "{line}: {said}");
        assert!(!said.contains("error") && said.contains("X:40.0000"), "{line}: {said}");
    }
    // A heater that is not there and would be hot is another thing.
    assert!(played(CARTESIAN, "M104 S200 T1", MARLIN).contains("was not carried out"));
    // Only -1 says so.
    assert!(Plan::new(CARTESIAN).start().say("T-10").contains("T needs a whole number"));
    assert!(Plan::new(CARTESIAN).start().say("T-1").contains("no extruder has tool_id -1"));
}
