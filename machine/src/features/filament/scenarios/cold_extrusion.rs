//! Filament in a nozzle that is too cold: no motion of it where a guard was asked for.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta};

/// Returns the travel of X since power-on.
fn x(bench: &Bench) -> f64 {
    bench.carriage(Alpha) - 30.0
}

#[test]
fn a_cold_nozzle_extrudes_only_where_nobody_asked_for_a_guard() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G91", "G1 E1 F300"]);
    assert_eq!(bench.say("M302"), "Cold extrusion is allowed\nok\n");
    bench.run(&["M302 S170"]);
    assert_eq!(bench.say("M302"), "Cold extrusion is refused below 170 C, to draw back 170 C\nok\n");
    for line in ["G1 X1 E1", "G1 E-1", "G10", "G2 X1 Y1 I1 E1"] {
        let said = bench.say(line);
        assert_eq!(said, "error:hotend is below 170 C: wait with M109, or M302 P1\n", "{line}");
    }
    bench.run(&["G1 X1"]);
    bench.say("M302 R0");
    bench.run(&["G1 E-1"]);
    for line in ["M701 L20", "M702 U20"] {
        bench.say("M302 S170 R170");
        assert!(bench.say(line).starts_with("error:hotend is below 170 C"), "{line}");
    }
    bench.say("M302 R0");
    assert_eq!(bench.say("M702 U1"), "// Taking 1 mm of filament out\nok\n");
    for allows in ["M302 P1", "M302 S0"] {
        bench.say("M302 P0");
        assert!(bench.say("G1 E1").starts_with("error:"), "{allows}");
        bench.say(allows);
        bench.run(&["G1 E1"]);
    }
}

#[test]
fn a_file_waits_where_it_would_extrude_cold_and_is_told_so_before() {
    let guarded = || Plan::new(CARTESIAN).set("[extruder] hotend.min_extrude_temp = 170");
    let job = "G1 X5 F3000\nG1 X10 E1\nM109 S180\nG1 X20 E2\n";
    let mut bench = guarded().file("job.g", job).start();
    let said = bench.say("check job.g");
    assert!(said.contains("line 2: stops: filament is fed while hotend is off"), "{said}");
    bench.type_in("play --force /sd/job.g -t\n");
    let said = bench.hear(2.0);
    assert!(said.contains("hotend is below 170 C") && said.contains("error:paused, line 2 of"), "{said}");
    assert!((x(&bench) - 5.0).abs() < 0.02, "nothing of its line is made");
    bench.type_in("M24\n");
    bench.hear_until("Done printing file", 300.0);
    assert!((x(&bench) - 20.0).abs() < 0.02);
    // Without a guard it is a warning, as it was.
    let mut bench = Plan::new(CARTESIAN).file("job.g", job).start();
    assert!(bench.say("check job.g").contains("line 2: warning: filament is fed while hotend is off"));
}

#[test]
fn a_move_of_the_extruder_alone_is_no_longer_than_it_may_be() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[extruder] hotend.max_extrude_only_distance = 50")
        .file("job.g", "G28\nM83\nG1 X5 E60 F3000\nG1 E60\n")
        .start();
    bench.run(&["G91", "M83", "G1 E50 F3000", "G1 X10 E60", "G1 E-50"]);
    let before = bench.carriage(Delta);
    for line in ["G1 E50.1", "G1 E-51", "G1 E1000"] {
        let said = bench.say(line);
        assert_eq!(said, "error:an extruder alone moves at most 50 mm: [extruder] hotend.max_extrude_only_distance\n");
    }
    assert_eq!(bench.carriage(Delta), before);
    let said = bench.say("check job.g");
    assert!(said.contains("line 4: stops: an extruder alone moves at most 50 mm"), "{said}");
    assert!(!said.contains("line 3: stops"), "{said}");
}

#[test]
fn m600_leaves_filament_in_a_nozzle_that_is_too_cold() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[extruder] hotend.min_extrude_temp = 170")
        .set("[filament change] retract = 2")
        .set("[filament change] unload = 50")
        .set("[filament change] load = 50")
        .file("part.g", "G4 S1\nM600\nG4 S1\n")
        .start();
    let before = bench.carriage(Delta);
    bench.type_in("play part.g -t\n");
    let said = bench.hear_until("// Print Suspended", 20.0);
    assert!(said.contains("hotend is below 170 C") && said.contains("M600 leaves the filament in"), "{said}");
    bench.type_in("resume\n");
    bench.hear_until("Done printing file", 20.0);
    assert_eq!(bench.carriage(Delta), before);
}
