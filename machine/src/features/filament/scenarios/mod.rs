//! The filament detector and changes of filament: M404 to M407, M412, M600 to M603, M701, M702.

mod cold_extrusion;
mod width;

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta, Gamma};

const DETECTOR: &str = "\n[filament detector]\nenable = true\ndetector_pin = PB7^\n";
const CHANGE: &str = "\n[filament change]\nretract = 2\nlift = 5\npark_x = 3\npark_y = 4\nunload_length = 40\n\
                      load_length = 30\npurge_length = 10\n";

fn press(bench: &mut Bench, name: &str, pressed: bool) {
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, name, pressed)).expect("a button of this machine");
}

/// A job that extrudes for some seconds.
fn job() -> String {
    let lines: String = (1..40).map(|n| format!("G1 X{} Y20 E{}\n", 20 + n % 2 * 40, n)).collect();
    format!("G28\nG92 E0\nG1 F2400\n{lines}M400\n")
}

fn printing(plan: Plan) -> Bench {
    let mut bench = plan.file("part.gcode", &job()).start();
    bench.say("play /sd/part.gcode");
    bench.hear(6.0);
    assert!(bench.moves(), "it prints");
    bench
}

#[test]
fn a_job_without_filament_is_suspended_and_resumed_when_there_is_some() {
    let mut bench = printing(Plan::new(CARTESIAN).adding(DETECTOR));
    press(&mut bench, "filament", true);
    let said = bench.hear_until("// Print Suspended", 60.0);
    assert!(said.contains("// Filament Detector: the filament has run out: the job is being suspended"), "{said}");
    assert!(!bench.moves());
    for way in ["resume", "M24", "M601"] {
        let said = bench.say(way);
        assert!(said.contains("the filament has run out: see to it, or M405 has it passed over"), "{way}: {said}");
    }
    assert!(bench.say("M407").contains("Now the filament has run out\nFilament detector is enabled\n"));
    press(&mut bench, "filament", false);
    bench.hear(0.2);
    bench.type_in("M24\n");
    bench.hear_until("// Resuming print", 20.0);
    bench.run(&["M400"]);
    bench.hear(30.0);
    assert!((bench.carriage(Delta) - 39.0).abs() < 0.05, "all of it is printed: {}", bench.carriage(Delta));
}

#[test]
fn m405_has_it_passed_over() {
    let mut bench = printing(Plan::new(CARTESIAN).adding(DETECTOR));
    bench.say("M412 S0");
    press(&mut bench, "filament", true);
    assert!(!bench.hear(3.0).contains("Filament Detector"));
    assert!(bench.say("M407").contains("Filament detector is disabled"));
    bench.say("M406");
    bench.hear_until("the job is being suspended", 3.0);
}

#[test]
fn a_wheel_that_stands_suspends_the_job() {
    let wheel = "\n[filament detector]\nenable = true\nencoder_pin = PB7^\nleave_heaters_on = true\n";
    let mut bench = printing(Plan::new(CARTESIAN).adding(wheel));
    bench.say("M404 S1 P1");
    assert_eq!(bench.say("M404"), "// pulses per mm: 1.000000, seconds per check: 1, heaters: on\nok\n");
    let said = bench.hear_until("// Print Suspended", 60.0);
    assert!(said.contains("the filament does not move: a jam, a break, or its end"), "{said}");
}

/// A filament change leaves the program's modes alone: the program resumes with its position and filament.
#[test]
fn m600_changes_filament_as_configured() {
    let mut bench = printing(Plan::new(CARTESIAN).adding(CHANGE));
    bench.type_in("M600\n");
    bench.hear_until("// Print Suspended", 60.0);
    let at = [Alpha, units::Actuator::Beta, Gamma].map(|motor| bench.carriage(motor));
    assert!((at[0] - 3.0).abs() < 0.05 && (at[1] - 4.0).abs() < 0.05, "it waits where it is to: {at:?}");
    assert!((at[2] - 5.0).abs() < 0.05, "lifted: {at:?}");
    let out = bench.carriage(Delta);
    bench.type_in("resume\n");
    bench.hear_until("// Resuming print", 60.0);
    bench.run(&["M400"]);
    bench.hear(40.0);
    // 42 mm out, 40 in, and what was left of the print.
    let printed = out + 42.0;
    let end = bench.carriage(Delta);
    assert!((end - (39.0 - 42.0 + 40.0)).abs() < 0.1, "{printed} were printed, {end} in the end");
    assert!(bench.carriage(Gamma).abs() < 0.05);
}

/// Marlin's words of M600 apply with nothing configured.
#[test]
fn m600_says_itself_how_filament_is_changed() {
    let mut bench = printing(Plan::new(CARTESIAN));
    bench.say("M104 S40");
    assert!(bench.say("M600 T1").contains("select this tool first"));
    bench.type_in("M600 X10 Y12 Z3 E-1 U20 L15 R60 B2\n");
    bench.hear_until("// Print Suspended", 60.0);
    let at = [Alpha, units::Actuator::Beta, Gamma].map(|motor| bench.carriage(motor));
    assert!(at.iter().zip([10.0, 12.0, 3.0]).all(|(is, ought)| (is - ought).abs() < 0.05), "{at:?}");
    let out = bench.carriage(Delta);
    bench.type_in("resume\n");
    bench.hear_until("// Resuming print", 120.0);
    assert!((bench.celsius("hotend") - 60.0).abs() < 5.0, "it goes on with {} C", bench.celsius("hotend"));
    bench.run(&["M400"]);
    bench.hear(40.0);
    let end = bench.carriage(Delta);
    assert!((end - (39.0 - 21.0 + 15.0)).abs() < 0.1, "{out} before, {end} in the end");
    assert!(bench.carriage(Gamma).abs() < 0.05);
    // The next change is as configured.
    assert!(bench.say("M603").contains("M603 L0 U0"));
}

#[test]
fn filament_is_loaded_and_unloaded_by_hand() {
    let mut bench = Plan::new(CARTESIAN).adding(CHANGE).start();
    assert!(bench.say("M603").contains("M603 L30 U40"));
    assert!(bench.say("M702 U7").contains("// Taking 7 mm of filament out\nok\n"));
    assert!((bench.carriage(Delta) + 7.0).abs() < 0.05);
    bench.run(&["M603 L12"]);
    bench.say("M701");
    assert!((bench.carriage(Delta) - 15.0).abs() < 0.05, "12 in, 10 through the nozzle: {}", bench.carriage(Delta));
    let mut bare = Plan::new(CARTESIAN).start();
    assert!(bare.say("M701").contains("M701: how far? Give L, or set M603 L"));
    assert_eq!(bare.say("M407"), "ok - M407 ignored\n");
}

/// A moment in a job at which filament runs out.
struct Moment {
    name: &'static str,
    /// Types lines once the job is played, and waits for the moment.
    until: fn(&mut Bench),
    /// Message that is expected then.
    told: &'static str,
    /// Whether the job is suspended by the run-out; otherwise it is already.
    suspends: bool,
}

const MOMENTS: [Moment; 7] = [
    Moment {
        name: "heating",
        until: |bench| drop(bench.hear(1.0)),
        told: "the job is being suspended",
        suspends: true,
    },
    Moment {
        name: "homing",
        until: |bench| wait_until(bench, |bench| bench.carriage(Alpha) < 25.0),
        told: "the job is being suspended",
        suspends: true,
    },
    Moment {
        name: "printing",
        until: |bench| wait_until(bench, |bench| bench.carriage(Delta) > 3.0),
        told: "the job is being suspended",
        suspends: true,
    },
    Moment {
        name: "paused",
        until: |bench| {
            wait_until(bench, |bench| bench.carriage(Delta) > 3.0);
            bench.say("M25");
            wait_until(bench, |bench| !bench.moves());
        },
        told: "// NOTE the filament has run out",
        suspends: false,
    },
    Moment { name: "suspended", until: suspend, told: "// NOTE the filament has run out", suspends: true },
    Moment {
        name: "resuming",
        until: |bench| {
            suspend(bench);
            bench.type_in("resume\n");
            bench.hear(0.3);
        },
        told: "the filament has run out",
        suspends: true,
    },
    Moment {
        name: "changing filament",
        until: |bench| {
            wait_until(bench, |bench| bench.carriage(Delta) > 3.0);
            bench.type_in("M600\n");
            bench.hear_until("Going aside", 90.0);
            bench.hear(0.5);
        },
        told: "// NOTE the filament has run out",
        suspends: true,
    },
];

fn wait_until(bench: &mut Bench, is_there: impl Fn(&Bench) -> bool) {
    let end = bench.now_s() + 120.0;
    while !is_there(bench) {
        assert!(bench.now_s() < end, "it does not come to it");
        bench.hear(0.02);
    }
}

fn suspend(bench: &mut Bench) {
    wait_until(bench, |bench| bench.carriage(Delta) > 3.0);
    bench.type_in("M600\n");
    bench.hear_until("// Print Suspended", 90.0);
}

#[test]
fn filament_that_runs_out_at_any_moment_of_a_job_is_told_and_all_is_printed() {
    for moment in MOMENTS {
        // More lines than are planned ahead.
        let lines: String =
            (1..=150).map(|n| format!("G1 X{} Y20 E{:.1}\n", 20 + n % 2 * 10, f64::from(n) / 5.0)).collect();
        let part = format!("M109 S40\nG28\nG92 E0\nG1 F2400\n{lines}M400\n");
        let mut bench = Plan::new(CARTESIAN).adding(CHANGE).adding(DETECTOR).file("part.gcode", &part).start();
        bench.say("play /sd/part.gcode");
        (moment.until)(&mut bench);
        press(&mut bench, "filament", true);
        let mut said = bench.hear_until(moment.told, 30.0);
        let was_suspended = matches!(moment.name, "suspended" | "changing filament");
        if moment.suspends && moment.name != "suspended" {
            said += &bench.hear_until("// Print Suspended", 90.0);
        }
        said += &bench.hear(5.0);
        let (name, count) = (moment.name, said.matches("filament has run out").count());
        // On its way back the job rests, and then goes on.
        assert!(count == 1 || name == "resuming" && count == 2, "{name}: told {count} times: {said}");
        assert!(!bench.moves(), "{name}: it goes on");
        assert!(!was_suspended || !said.contains("is being suspended"), "{name}: {said}");
        let refused = bench.say("M24");
        assert!(refused.contains("the filament has run out: see to it"), "{name}: {refused}");
        press(&mut bench, "filament", false);
        bench.hear(0.2);
        bench.type_in("M24\n");
        if moment.suspends {
            bench.hear_until("// Resuming print", 60.0);
        }
        wait_until(&mut bench, |bench| bench.moves());
        wait_until(&mut bench, |bench| !bench.moves());
        bench.hear(10.0);
        wait_until(&mut bench, |bench| !bench.moves());
        // 30 mm are the part's; each change takes 2 mm more out than it puts in.
        let changes =
            said.matches("// Print Suspended").count() + usize::from(matches!(name, "suspended" | "resuming"));
        let (filament, wanted) = (bench.carriage(Delta), 30.0 - 2.0 * changes as f64);
        assert!((filament - wanted).abs() < 0.1, "{name}: {filament} mm of filament, not {wanted}: {said}");
        assert!(bench.carriage(Gamma).abs() < 0.05, "{name}: it ends at Z{}", bench.carriage(Gamma));
    }
}

#[test]
fn filament_that_runs_out_beside_a_job_is_told_once_or_not() {
    let mut bench = Plan::new(CARTESIAN).adding(DETECTOR).start();
    press(&mut bench, "filament", true);
    let said = bench.hear(5.0);
    assert_eq!(said.matches("// NOTE the filament has run out").count(), 1, "{said}");
    bench.run(&["G28", "G1 X5 F3000", "M400"]);
    press(&mut bench, "filament", false);
    bench.hear(0.2);
    // A halted machine has other things to say; once it is released it is idle.
    bench.type_in("M112\n");
    bench.hear_until("ALARM", 1.0);
    press(&mut bench, "filament", true);
    assert!(!bench.hear(3.0).contains("filament"));
    bench.say("M999");
    assert_eq!(bench.hear(3.0).matches("filament has run out").count(), 1);
}

/// A halt during a filament change, in any step, drops the change.
#[test]
fn a_halt_in_any_step_of_a_change_drops_it() {
    for delay in [0.1, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0] {
        let mut bench = printing(Plan::new(CARTESIAN).adding(CHANGE).adding(DETECTOR));
        press(&mut bench, "filament", true);
        bench.hear(delay);
        bench.type_in("M112\n");
        bench.hear_until("ALARM", 1.0);
        bench.assert_safe();
        bench.say("M999");
        press(&mut bench, "filament", false);
        assert!(bench.say("get mode").contains("idle"), "{delay}");
        bench.run(&["G28", "G1 X5 F3000", "M400"]);
        let said = bench.hear(1.0);
        assert!(!said.contains("Suspend"), "{delay}: {said}");
    }
}

#[test]
fn the_tool_is_parked() {
    let mut bench = Plan::new(CARTESIAN).adding(CHANGE).start();
    bench.run(&["G28", "G1 X50 Y50 F6000", "G27", "M400"]);
    let at = [Alpha, units::Actuator::Beta, Gamma].map(|motor| bench.carriage(motor));
    assert!(at.iter().zip([3.0, 4.0, 5.0]).all(|(is, ought)| (is - ought).abs() < 0.05), "{at:?}");
    bench.run(&["G1 X10 F3000", "M400"]);
    assert!((bench.carriage(Alpha) - 10.0).abs() < 0.05 && (bench.carriage(Gamma) - 5.0).abs() < 0.05);
    assert!(bench.say("G27 P1").contains("leave P out"));
    assert!(Plan::new(CARTESIAN).start().say("G27").contains("G27: where to?"));
}

/// Each of its lines can be carried out at once, so the look-ahead queue is never full.
#[test]
fn a_job_that_always_has_a_line_is_suspended_too() {
    let lines: String = (1..400).map(|n| format!("G1 X{} Y20 E{n}\nG4 P1\n", 20 + n % 2 * 40)).collect();
    let plan = Plan::new(CARTESIAN).adding(DETECTOR).file("a.g", &format!("G28\nG92 E0\nG1 F6000\n{lines}"));
    let mut bench = plan.start();
    bench.type_in("play /sd/a.g\n");
    bench.hear(20.0);
    press(&mut bench, "filament", true);
    bench.hear_until("// Print Suspended", 5.0);
}

#[test]
fn a_job_without_filament_is_suspended_before_its_first_move() {
    let mut bench = Plan::new(CARTESIAN).adding(DETECTOR).file("part.gcode", &job()).start();
    press(&mut bench, "filament", true);
    bench.hear(1.0);
    let at = [Alpha, Gamma, Delta].map(|motor| bench.carriage(motor));
    bench.type_in("play /sd/part.gcode -t\n");
    bench.hear_until("// Print Suspended", 10.0);
    assert_eq!([Alpha, Gamma, Delta].map(|motor| bench.carriage(motor)), at);
    press(&mut bench, "filament", false);
    bench.hear(0.2);
    bench.type_in("resume\n");
    bench.hear_until("Done printing file", 120.0);
    assert!((bench.carriage(Delta) - 39.0).abs() < 0.05, "all of it is printed: {}", bench.carriage(Delta));
}
