//! Commands typed while a job runs or waits, and the scripts of suspend and resume, do not change the job:
//! its modes, offsets and positions are its own.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta, Gamma};

/// Modes typed while the program is stopped do not change the program's own modes.
#[test]
fn modes_typed_at_a_stop_of_the_file_are_not_the_files() {
    for stop in ["M0", "M1 look", "M60"] {
        let file = format!("G28.3 X0 Y0 Z0\nG90\nM82\nG92 E0\nG1 X10 Z5 E1 F600\n{stop}\nG1 X20 Z2 E2\nM400\n");
        let mut bench = Plan::new(CARTESIAN).file("part.g", &file).start();
        let at_first = [Alpha, Gamma, Delta].map(|motor| bench.carriage(motor));
        bench.type_in("play part.g -t\n");
        bench.hear_until("the program waits", 60.0);
        for line in ["G91", "G20", "M83", "G1 Z0.2 F20", "G1 E0.1", "G55", "M400"] {
            bench.say(line);
        }
        bench.send(b"~");
        bench.hear_until("Done printing file", 60.0);
        bench.hear(0.5);
        let moved = [Alpha, Gamma, Delta].map(|motor| bench.carriage(motor));
        let way: Vec<f64> = moved.iter().zip(at_first).map(|(now, before)| now - before).collect();
        assert!((way[0] - 20.0).abs() < 0.02 && (way[1] - 2.0).abs() < 0.02, "{stop}: {way:?}");
        // 2 mm of the file, and what was typed.
        assert!((way[2] - 2.1).abs() < 0.02, "{stop}: {way:?}");
    }
}

/// Offsets that are set at a stop stay: setting them is the purpose of such a stop.
#[test]
fn offsets_set_at_a_stop_of_the_file_stay() {
    let file = "G28.3 X0 Y0 Z0\nG1 Z5 F600\nM0\nG1 Z2\nM400\n";
    let mut bench = Plan::new(CARTESIAN).file("part.g", file).start();
    let at_first = bench.carriage(Gamma);
    bench.type_in("play part.g -t\n");
    bench.hear_until("the program waits", 60.0);
    bench.say("G10 L20 P1 Z6");
    bench.send(b"~");
    bench.hear_until("Done printing file", 60.0);
    bench.hear(0.5);
    assert!((bench.carriage(Gamma) - at_first - 1.0).abs() < 0.02, "{}", bench.carriage(Gamma) - at_first);
}

fn suspended(plan: Plan) -> Bench {
    let mut bench = plan.file("part.g", "G28.3 X0 Y0 Z0\nG1 X10 F600\nM600\nG1 X20\nM400\n").start();
    bench.type_in("play part.g -t\n");
    bench.hear_until("Print Suspended", 60.0);
    bench
}

#[test]
fn lines_of_a_script_are_parted_as_in_smoothieware_v1() {
    let plan = Plan::new(CARTESIAN)
        .set("[player] after_suspend_gcode = M118_waiting|G91|G1_Z5_F600")
        .set("[player] before_resume_gcode = G1_E2_F300|M118_on");
    let mut bench = suspended(plan);
    assert!(!bench.greeting().contains("cannot be read"), "{}", bench.greeting());
    let fed = bench.carriage(Delta);
    bench.type_in("resume\n");
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(said.contains("on\n"), "{said}");
    assert!((bench.carriage(Delta) - fed - 2.0).abs() < 0.02, "{}", bench.carriage(Delta) - fed);
}

#[test]
fn a_script_that_cannot_be_read_is_told_at_the_start_and_loses_no_job() {
    let plan = Plan::new(CARTESIAN).set("[player] before_resume_gcode = G1_Ex_F300|M118_on");
    let mut bench = suspended(plan);
    let greeting = bench.greeting().to_owned();
    assert!(greeting.contains("before_resume_gcode") && greeting.contains("cannot be read"), "{greeting}");
    bench.type_in("resume\n");
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(said.contains("passed over") && said.contains("on\n"), "{said}");
}

/// A heater may be a tenth of a degree below its target for minutes, which must not delay a resume.
#[test]
fn resume_does_not_wait_for_the_last_tenth_of_a_degree() {
    let file = "M190 S60\nG1 X10 F600\nM600\nG1 X20\nM400\n";
    let plan = Plan::new(CARTESIAN).set("[player] leave_heaters_on_suspend = true").file("part.g", file);
    let mut bench = plan.start();
    bench.type_in("play part.g -t\n");
    bench.hear_until("Print Suspended", 900.0);
    // The loop ends with the reading within a degree below the target.
    while !(59.1..59.95).contains(&bench.celsius("bed")) {
        bench.hear(0.2);
        if bench.celsius("bed") > 59.95 {
            bench.say("M140 S59.5");
        }
    }
    let begun_s = bench.now_s();
    bench.type_in("resume\n");
    bench.hear_until("Resuming print", 60.0);
    assert!(bench.now_s() - begun_s < 6.0, "{}", bench.now_s() - begun_s);
}

/// The extruder of a suspended job is the job's, and so are its E and its offset.
#[test]
fn a_tool_chosen_while_a_job_is_suspended_or_waits_is_not_the_jobs() {
    for (stop, told, goes_on) in [("M600", "// Print Suspended", "resume\n"), ("M0", "the program waits", "~")] {
        let job = format!("G28.3 X0 Y0 Z0\nT0\nM82\nG92 E0\nG1 X10 E1 F1200\n{stop}\nG1 X20 E2\nM400\n");
        let mut bench = Plan::new(CARTESIAN)
            .set("[extruder] second.enable = true")
            .set("[extruder] second.tool_id = 1")
            .set("[extruder] second.x_offset = 7")
            .set("[actuator] epsilon.driver = external")
            .set("[actuator] epsilon.steps_per_mm = 400")
            .set("[actuator] epsilon.step_pin = PJ5")
            .set("[actuator] epsilon.dir_pin = PJ1")
            .file("part.g", &job)
            .start();
        let before = [Alpha, Delta].map(|motor| bench.carriage(motor));
        bench.type_in("play part.g -t\n");
        bench.hear_until(told, 30.0);
        bench.run(&["T1", "G92 E50", "G1 X30 F1200", "M400"]);
        bench.type_in(goes_on);
        bench.hear_until("Done printing file", 30.0);
        bench.hear(0.5);
        let moved = [Alpha, Delta].map(|motor| bench.carriage(motor));
        assert!((moved[0] - before[0] - 20.0).abs() < 0.02, "{stop}: X {}", moved[0] - before[0]);
        assert!((moved[1] - before[1] - 2.0).abs() < 0.01, "{stop}: E {}", moved[1] - before[1]);
    }
}
