//! A suspended job goes on at the place of the work where it was, whatever a person does meanwhile; or it
//! says why it cannot.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta, Gamma};

/// Suspended at X30 Y30 Z2, before the line to X40.
fn suspended(plan: Plan, begins: &str) -> Bench {
    let file = format!("{begins}\nG1 X30 Y30 Z2 F6000\nG1 X40\nM400\n");
    let mut bench = plan.file("part.g", &file).start();
    bench.say("pause at line 3");
    bench.say("play part.g -t");
    bench.hear_until("// Print Suspended", 60.0);
    stands_at(&bench, [30.0, 30.0, 2.0]);
    bench
}

#[track_caller]
fn stands_at(bench: &Bench, place: [f64; 3]) {
    let now = [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor));
    assert!(now.iter().zip(place).all(|(now, wanted)| (now - wanted).abs() < 0.02), "{now:?}, not {place:?}");
}

#[track_caller]
fn goes_on(bench: &mut Bench, word: &str) {
    bench.type_in(word);
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(said.contains("// Resuming print\n"), "{said}");
}

/// As reports on other firmwares have it, the rest was printed from where homing had ended.
#[test]
fn homing_leaves_the_place_of_a_suspended_job() {
    for word in ["M24\n", "resume\n"] {
        let mut bench = suspended(Plan::new(CARTESIAN), "G28");
        bench.run(&["G91", "G1 Z5 F600", "G90", "G28 X Y", "M400"]);
        stands_at(&bench, [0.0, 0.0, 7.0]);
        assert!(bench.say("get mode").contains("(suspended)"));
        goes_on(&mut bench, word);
        stands_at(&bench, [40.0, 30.0, 2.0]);
    }
}

/// A cutter that is 8 mm longer touches off 8 mm higher.
#[test]
fn offsets_that_were_set_meanwhile_stay() {
    for line in ["G92 Z18", "G10 L20 P1 Z18", "M290 Z8"] {
        let mut bench = suspended(Plan::new(CARTESIAN), "G28");
        bench.run(&["G1 Z26 F600"]);
        bench.say(line);
        // Modes are the job's again, and so is the coordinate system.
        bench.run(&["G55", "G91", "G20"]);
        goes_on(&mut bench, "resume\n");
        stands_at(&bench, [40.0, 30.0, 10.0]);
        let modes = bench.say("$G");
        assert!(["G54", "G90", "G21"].iter().all(|mode| modes.contains(mode)), "{line}: {modes}");
    }
    // Another place of the work, too.
    let mut bench = suspended(Plan::new(CARTESIAN), "G28");
    bench.run(&["G1 Z26 X20 Y35 F6000", "G92 X30 Y30"]);
    goes_on(&mut bench, "resume\n");
    stands_at(&bench, [30.0, 35.0, 2.0]);
}

#[test]
fn a_place_that_the_machine_does_not_know_any_more_is_not_gone_to() {
    let mut bench = suspended(Plan::new(CARTESIAN), "G28");
    bench.run(&["M18 X"]);
    for word in ["resume", "M24"] {
        assert_eq!(bench.say(word), "error:X is not where it reads: home it, then resume; abort ends the job\n");
    }
    bench.run(&["G28 X"]);
    goes_on(&mut bench, "resume\n");
    stands_at(&bench, [40.0, 30.0, 2.0]);
    // A position that was never homed cannot be found again.
    let plan = || Plan::new(CARTESIAN).set("[motion control] must_be_homed = false");
    let begins = "G28.5";
    for line in ["M18", "G28 X", "G28.3 X5", "G92.4 X5"] {
        let mut bench = plan().start();
        let zero = bench.carriage(Alpha);
        drop(bench);
        let file = format!("{begins}\nG1 X5 F6000\nG1 X9\nM400\n");
        bench = plan().file("part.g", &file).start();
        bench.say("pause at line 3");
        bench.say("play part.g -t");
        bench.hear_until("// Print Suspended", 60.0);
        bench.run(&[line]);
        let refused =
            "error:X is not where it reads: it was not homed when the job was suspended: abort ends the job\n";
        assert_eq!(bench.say("resume"), refused, "{line}");
        assert!((bench.carriage(Alpha) - zero - 5.0).abs() < 0.02 || line == "G28 X", "{line}: it has moved");
        bench.say("abort");
        bench.hear(1.0);
        assert!(!bench.say("get mode").contains("suspended"));
    }
}

/// A halt ends it, and says so: nothing goes on from there.
#[test]
fn a_halt_ends_a_suspended_job_and_says_so() {
    for stop in ["M112\n", "\x18"] {
        let mut bench = suspended(Plan::new(CARTESIAN), "G28");
        bench.type_in(stop);
        bench.hear_until("// NOTE Suspend cleared due to HALT\n", 3.0);
        for word in ["resume", "M24"] {
            assert_eq!(bench.say(word), "!!\n");
        }
        bench.say("M999");
        assert!(!bench.say("get mode").contains("suspended"));
        for word in ["resume", "M24"] {
            let said = bench.say(word);
            assert!(!said.contains("Resuming"), "{word}: {said}");
        }
        bench.hear(3.0);
        stands_at(&bench, [30.0, 30.0, 2.0]);
    }
}

#[test]
fn what_ends_a_halt_leaves_a_suspended_job() {
    for line in ["M999", "M999 P1"] {
        let mut bench = suspended(Plan::new(CARTESIAN), "G28");
        bench.run(&["G1 Z9 F600", line]);
        assert!(bench.say("get mode").contains("(suspended)"), "{line}");
        goes_on(&mut bench, "resume\n");
        stands_at(&bench, [40.0, 30.0, 2.0]);
    }
}

/// A job that waits behind a line that was refused goes on from where the tool is, as after M25: it was not
/// suspended, and keeps no place.
#[test]
fn a_job_that_waits_behind_a_line_goes_on_from_where_the_tool_is() {
    let file = "G28\nG1 X30 Y30 Z2 F6000\nG0 X35 R2\nG1 X40\nM400\n";
    let mut bench = Plan::new(CARTESIAN).file("part.g", file).start();
    bench.type_in("play part.g -t\n");
    bench.hear_until("error:paused, line 3 of", 60.0);
    bench.run(&["M400"]);
    stands_at(&bench, [30.0, 30.0, 2.0]);
    bench.run(&["G1 Y50 Z9 F600", "M400"]);
    bench.type_in("M24\n");
    bench.hear_until("Done printing file", 60.0);
    stands_at(&bench, [40.0, 50.0, 9.0]);
}
