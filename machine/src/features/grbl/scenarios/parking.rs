//! G28 and G30 before a Z was stored for them: CAM's programs lift by `G28 G91 Z0`, and go on with a rapid.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta, Gamma};

use super::{plan, refused};

/// Machine zero is at the top, where a limit is.
const MILL: &str = include_str!("../../../../../config/samples/cnc-mill.ini");

/// Returns a homed mill at X20 Y30 Z-30 of the machine, and the places of its carriages there.
fn deep(plan: Plan) -> (Bench, [f64; 3]) {
    let mut bench = plan.start();
    bench.say("$H");
    bench.run(&["G90 G53 G0 X20 Y30", "G53 G0 Z-30", "G4 P0"]);
    let at = [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor));
    (bench, at)
}

#[track_caller]
fn has_moved(bench: &mut Bench, from: [f64; 3], by: [f64; 3]) {
    bench.run(&["G4 P0"]);
    let now = [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor));
    for ((now, from), mm) in now.into_iter().zip(from).zip(by) {
        assert!((now - from - mm).abs() < 0.02, "{now} - {from}, not {mm}");
    }
}

#[test]
fn a_retraction_to_a_z_that_was_never_stored_is_refused() {
    let (mut bench, at) = deep(Plan::new(MILL));
    let said = refused(&mut bench, "G28 G91 Z0.", 20);
    assert!(said.contains("no Z is stored to park at: go to a safe height and store it with G28.1"), "{said}");
    has_moved(&mut bench, at, [0.0; 3]);
    bench.run(&["G90 G53 G0 Z-5"]);
    assert!(bench.say("G28.1").ends_with("ok\n"));
    bench.run(&["G53 G0 Z-30", "G28 G91 Z0."]);
    has_moved(&mut bench, at, [0.0, 0.0, 25.0]);
    // The same of a second place with X and Y alone.
    let (mut bench, at) = deep(Plan::new(MILL).set("[motion control] nist_G30 = true"));
    bench.run(&["G30.1 X25 Y25"]);
    assert!(refused(&mut bench, "G91 G30 Z0", 20).contains("G30.1"));
    bench.run(&["G91 G30 X0"]);
    has_moved(&mut bench, at, [5.0, 0.0, 0.0]);
}

#[test]
fn in_the_dialect_of_smoothieware_and_in_a_file_too() {
    let mut bench = Plan::new(CARTESIAN).start_homed();
    bench.run(&["G1 Z20 F600", "M400"]);
    assert!(bench.say("G28.2 Z0").starts_with("error:no Z is stored to park at"));
    assert!((bench.carriage(Gamma) - 20.0).abs() < 0.02);
    let file = "G90 G53 G0 X5 Z10\nG28 G91 Z0.\nG28 G91 X0. Y0.\n";
    let mut bench = plan().file("part.nc", file).start();
    bench.run(&["$H"]);
    bench.type_in("play part.nc\n");
    let said = bench.hear(5.0);
    assert!(said.contains("paused, line 2 of"), "{said}");
    assert!((bench.carriage(Alpha) - 5.0).abs() < 0.02, "the rapid behind it waits");
}

/// X and Y that were never stored are machine zero, as in GRBL, where the way there meets nothing: Z stays.
#[test]
fn x_and_y_that_were_never_stored_are_machine_zero() {
    // The switches stand at zero, and are limits in the sample.
    let mill = ["minx", "miny"]
        .iter()
        .fold(Plan::new(MILL), |plan, name| plan.set(&format!("[endstops] {name}.limit_enable = false")));
    let (mut bench, at) = deep(mill.clone());
    bench.run(&["G91 G28 X0"]);
    has_moved(&mut bench, at, [-20.0, 0.0, 0.0]);
    bench.run(&["G91 G28 X0 Y0"]);
    has_moved(&mut bench, at, [-20.0, -30.0, 0.0]);
    // The code alone asks for no lift: as in Smoothieware v2 X and Y go there.
    bench.run(&["G90 G53 G0 X20 Y30", "G28"]);
    has_moved(&mut bench, at, [-20.0, -30.0, 0.0]);
    // A second place is stored whole, or is none.
    let (mut bench, at) = deep(mill.set("[motion control] nist_G30 = true"));
    assert!(refused(&mut bench, "G91 G30 X0", 20).contains("G30.1"));
    has_moved(&mut bench, at, [0.0; 3]);
    // Elsewhere G28 homes, and G28.2 parks.
    for dialect in ["smoothie", "marlin", "reprapfirmware", "klipper"] {
        let mut bench = Plan::new(CARTESIAN).set(&format!("[general] dialect = {dialect}")).start();
        let _greeting = bench.greeting();
        // Hosts of some dialects hear that it is busy.
        bench.type_in("G28\n");
        bench.hear_until("ok\n", 60.0);
        bench.run(&["G1 X20 Y30 Z20 F6000", "M400"]);
        bench.run(&["G28.2 X0 Y0", "M400"]);
        let at = [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor));
        assert!(at.iter().zip([0.0, 0.0, 20.0]).all(|(at, wanted)| (at - wanted).abs() < 0.02), "{dialect}: {at:?}");
    }
}
