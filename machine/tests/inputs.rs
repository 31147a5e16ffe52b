//! Lines that input switches, buttons and the filament detector send beside a job: they act as if they were
//! typed, at once where they end or pause what the job waits for.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

/// A button and a switch, each of which sends this line.
const WAYS: [[&str; 3]; 2] = [
    ["[button box] one.pin = PB7^", "[button box] one.enable = true", "[button box] one.press ="],
    ["[switch] one.input_pin = PB7^", "[switch] one.enable = true", "[switch] one.output_on_command ="],
];

/// A job that does this line after a move of 10 mm, and then goes to X60; the line is in work.
fn in_line_2(way: [&str; 3], sends: &str, line: &str) -> Bench {
    let text = format!("G1 X10 F6000\n{line}\nG1 X60 F6000\nM400\n");
    let plan = Plan::new(CARTESIAN).set(way[0]).set(way[1]).set(&format!("{} {sends}", way[2]));
    let mut bench = plan.file("job.g", &text).start();
    assert!(bench.say("play /sd/job.g").contains("Playing"));
    bench.hear(2.0);
    bench
}

fn press(bench: &mut Bench) {
    for pressed in [true, false] {
        let at_ns = (bench.now_s() * 1e9) as u64;
        bench.world(|world| world.press(at_ns, "one", pressed)).expect("a button of this machine");
        bench.hear(0.2);
    }
}

#[test]
fn abort_by_a_button_ends_whatever_the_job_waits_for() {
    for way in WAYS {
        for line in ["M109 S200", "G4 S300", "G1 X190 F60\nM400", "M0 look"] {
            let mut bench = in_line_2(way, "abort", line);
            press(&mut bench);
            let place = bench.carriage(Alpha);
            bench.hear(3.0);
            assert!(bench.say("progress").contains("Not currently playing"), "{} in {line}", way[0]);
            assert_eq!(bench.carriage(Alpha), place, "{} in {line}: it stands", way[0]);
        }
    }
}

#[test]
fn a_pause_by_a_button_leaves_a_wait_for_heat() {
    for way in WAYS {
        for pause in ["M600", "suspend", "M25"] {
            let mut bench = in_line_2(way, pause, "M109 S120");
            press(&mut bench);
            bench.hear(1.0);
            // The console is free while the nozzle is cold.
            bench.run(&["G91", "G1 X3 F6000", "M400", "G90"]);
            assert!(bench.celsius("hotend") < 100.0, "{pause}");
        }
    }
}

#[test]
fn a_job_that_waits_for_the_operator_goes_on_by_a_button() {
    for way in WAYS {
        for (resume, stop) in [("M24", "M0 look"), ("M108", "M1")] {
            let mut bench = in_line_2(way, resume, stop);
            let place = bench.carriage(Alpha);
            let said = bench.hear(0.1);
            assert!(!bench.moves(), "{stop} waits: {said}");
            press(&mut bench);
            bench.hear(2.0);
            assert!((bench.carriage(Alpha) - place - 50.0).abs() < 0.02, "{resume} by {}", way[0]);
        }
    }
}

#[test]
fn m112_and_m410_by_a_button_act_while_the_job_waits() {
    for way in WAYS {
        let mut bench = in_line_2(way, "M112", "M109 S200");
        press(&mut bench);
        bench.assert_safe();
        assert!(!bench.heats(), "{}", way[0]);
        let mut bench = in_line_2(way, "M410", "G1 X190 F60\nM400");
        press(&mut bench);
        assert!(!bench.moves(), "{}", way[0]);
        assert!(bench.say("progress").contains("paused"), "{}", way[0]);
    }
}
