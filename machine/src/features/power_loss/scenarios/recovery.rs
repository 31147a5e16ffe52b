//! Between a power cut and the first line of the job that is gone on with: what is noted of a job that
//! waits, what a script may do, and what is left where it cannot be gone on with. The cuts at each write are
//! in `power_loss.rs`.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta, Gamma};

const CHANGE: &str = "\n[filament change]\nlift = 5\npark_x = 190\npark_y = 190\n";
/// X at which the job ends, mm.
const END: f64 = 20.0;

/// Six layers of two squares each, behind these lines.
fn part(start: &str) -> String {
    let mut text = format!("; a part\nM190 S50\nM109 S180\nG28\nG90\nG21\nM82\nG92 E0\n{start}");
    let mut e = 0.0;
    for layer in 1..=6 {
        text += &format!("G1 Z{:.2} F600\n", 0.3 * f64::from(layer));
        for (x, y) in [(20.0, 20.0), (60.0, 30.0)] {
            text += &format!("G0 X{x} Y{y} F9000\n");
            for (to_x, to_y) in [(15.0, 0.0), (15.0, 15.0), (0.0, 15.0), (0.0, 0.0)] {
                e += 0.6;
                text += &format!("G1 X{} Y{} F1200 E{e:.4}\n", x + to_x, y + to_y);
            }
        }
    }
    text + &format!("M104 S0\nM140 S0\nG1 Z{END} F600\n")
}

fn plan(start: &str) -> Plan {
    let plan = Plan::new(CARTESIAN).set("[player] power_loss = true").set("[player] power_loss_period = 2");
    plan.set("[player] power_loss_lift = 3").file("job.g", &part(start))
}

fn with_script(script: &str) -> Plan {
    plan("").set(&format!("[player] power_loss_gcode = {script}"))
}

fn until(bench: &mut Bench, is_there: impl Fn(&Bench) -> bool) {
    let end = bench.now_s() + 900.0;
    while !is_there(bench) {
        assert!(bench.now_s() < end, "it does not come there: {}", bench.hear(0.1));
        bench.hear(0.02);
    }
}

/// Returns a machine that prints in the second layer.
fn printing(plan: Plan) -> Bench {
    let mut bench = plan.start();
    bench.type_in("play /sd/job.g -t\n");
    until(&mut bench, |bench| (0.59..0.61).contains(&bench.carriage(Gamma)) && bench.carriage(Delta) > 5.5);
    bench.hear(1.0);
    bench
}

/// Cuts the power; the job is then offered.
fn cut(bench: &mut Bench) {
    bench.cycle_power();
    assert!(bench.greeting().contains("a job was interrupted"), "{}", bench.greeting());
}

fn interrupted(plan: Plan) -> Bench {
    let mut bench = printing(plan);
    cut(&mut bench);
    bench
}

/// Resumes, gives the height of Z when asked, and returns the messages.
fn go_on(bench: &mut Bench) -> String {
    let z = bench.carriage(Gamma);
    bench.type_in("M1000\n");
    let mut said = bench.hear(3.0);
    if said.contains("measure it, then M1000 Z") {
        bench.type_in(&format!("M1000 Z{z:.3}\n"));
    }
    said += &bench.hear_until("Done printing file", 900.0);
    let end = bench.carriage(Gamma);
    assert!((end - END).abs() < 0.05, "its Z was {:.2} mm beside the part's: {said}", end - END);
    assert!(said.contains("bed heats to 50 C") && said.contains("hotend heats to 180 C"), "{said}");
    said
}

// --- the script before going back ---

#[test]
fn the_script_goes_from_where_the_tool_is() {
    let mut bench = interrupted(with_script("G1_X50_F6000"));
    bench.type_in("M1000\n");
    let mut said = bench.hear_until("// homing", 900.0);
    let mut least = f64::INFINITY;
    while !said.contains("// back to") {
        said += &bench.hear(0.01);
        least = least.min(bench.carriage(Gamma));
    }
    assert!(least > 3.55, "down to {least} mm, which the script has not said");
    assert!((bench.carriage(Alpha) - 50.0).abs() < 0.05);
}

#[test]
fn the_tool_goes_back_over_the_part_wherever_the_script_has_left_it() {
    let mut bench = interrupted(with_script("G1_X150_Y150_F6000_G1_Z0.2_F600"));
    bench.type_in("M1000\n");
    let mut said = bench.hear_until("// back to", 900.0);
    while !said.contains("the job goes on") {
        let before = bench.carriage(Alpha);
        said += &bench.hear(0.01);
        let (moved, z) = (bench.carriage(Alpha) - before, bench.carriage(Gamma));
        let goes_on = said.contains("the job goes on");
        assert!(moved.abs() < 0.02 || z > 3.5 || goes_on, "over the bed at {z} mm: {said}");
    }
    bench.hear_until("Done printing file", 900.0);
}

#[test]
fn a_script_that_fails_leaves_a_machine_that_stands_and_an_offer() {
    for script in ["T9", "G1_X50_F6000_G1_X-900"] {
        let mut bench = interrupted(with_script(script));
        bench.type_in("M1000\n");
        let said = bench.hear_until("error:", 900.0);
        assert!(said.contains("// homing"), "{said}");
        bench.hear(3.0);
        let (x, e) = (bench.carriage(Alpha), bench.carriage(Delta));
        bench.hear(10.0);
        assert_eq!(
            (bench.carriage(Alpha), bench.carriage(Delta)),
            (x, e),
            "{script}: the job does not go on by itself"
        );
        assert!(!bench.heats(), "{script}");
        assert!(bench.say("progress").contains("Not currently playing"), "{script}");
        assert!(bench.say("M1000 S").contains("a job was interrupted"), "{script}");
        bench.run(&["G1 X12 F6000", "M400"]);
        assert!((bench.carriage(Alpha) - 12.0).abs() < 0.05, "{script}: the program is where the machine is");
        // And with another script it is gone on with, by a machine that knows where it is.
        cut(&mut bench);
    }
}

#[test]
fn a_cut_in_a_script_that_moves_z_asks_where_that_is() {
    let mut bench = interrupted(with_script("G1_Z1.5_F600_G4_S30"));
    bench.type_in("M1000\n");
    bench.hear_until("// homing", 900.0);
    bench.hear(20.0);
    assert!((bench.carriage(Gamma) - 1.5).abs() < 0.02);
    cut(&mut bench);
    let said = go_on(&mut bench);
    assert!(said.contains("power_loss_gcode may have moved Z: measure it"), "{said}");
}

// --- what is noted of a job that waits ---

#[test]
fn a_job_that_is_suspended_is_gone_on_with_hot_wherever_its_tool_waits() {
    for change in ["", CHANGE] {
        let mut bench = printing(plan("").adding(change));
        bench.type_in("M600\n");
        bench.hear_until("// Print Suspended", 60.0);
        bench.hear(30.0);
        assert!(!bench.heats());
        cut(&mut bench);
        go_on(&mut bench);
    }
}

#[test]
fn a_job_is_gone_on_with_that_was_on_its_way_back_from_a_suspension() {
    for height in [4.9, 2.5, 0.3] {
        let mut bench = printing(plan("").adding(CHANGE));
        bench.type_in("M600.1\n");
        bench.hear_until("// Print Suspended", 60.0);
        bench.hear(5.0);
        let below = bench.carriage(Gamma) - 5.0;
        bench.type_in("resume\n");
        bench.hear_until("// Restoring saved", 60.0);
        until(&mut bench, |bench| bench.carriage(Gamma) < below + height);
        cut(&mut bench);
        go_on(&mut bench);
    }
}

/// Before the motors stand, the first entry of a halt is all there is.
#[test]
fn the_first_entry_of_a_halt_has_the_temperatures() {
    for delay in [0.001, 0.002, 0.004, 0.008] {
        let mut bench = printing(plan(""));
        bench.type_in("M112\n");
        bench.hear(delay);
        cut(&mut bench);
        go_on(&mut bench);
    }
}

#[test]
fn what_was_moved_before_a_halt_counts_behind_it() {
    let mut bench = interrupted(plan(""));
    bench.run(&["G91", "G1 Z10 F600", "G90", "M400"]);
    for _ in 0..2 {
        bench.type_in("M1000\n");
        bench.hear_until("heats to", 10.0);
        bench.type_in("M112\n");
        bench.hear(2.0);
        bench.say("M999");
        bench.run(&["G91", "G1 Z5 F600", "G90", "M400"]);
    }
    go_on(&mut bench);
}

// --- what is refused ---

#[test]
fn what_is_refused_leaves_modes_and_heaters_as_they_were() {
    let before_it = "G92 X3\n";
    let mut bench = interrupted(plan(before_it));
    bench.write_card("job.g", part("").as_bytes());
    bench.say("M140 S40");
    bench.say("G92 Y7");
    let before = bench.say("$#");
    bench.type_in("M1000\n");
    assert!(bench.hear(1.0).contains("is not the file that was played"));
    assert!(bench.say("M105").contains("/40.0"), "{}", bench.say("M105"));
    // The same holds once the whole file has been read over.
    bench.write_card("job.g", part(before_it).as_bytes());
    let mut bench = asked_for_z(plan(before_it));
    bench.say("M140 S40");
    bench.say("G92 Y7");
    bench.type_in("M1000\n");
    assert!(bench.hear(1.0).contains("measure it, then M1000 Z"));
    assert_eq!(bench.say("$#"), before);
    assert!(bench.say("M105").contains("/40.0"), "{}", bench.say("M105"));
}

/// The power has gone on the way to the next layer.
fn asked_for_z(plan: Plan) -> Bench {
    let mut bench = printing(plan);
    until(&mut bench, |bench| bench.carriage(Gamma) > 0.7);
    cut(&mut bench);
    bench
}

#[test]
fn a_file_may_set_modes_that_are_not_those_of_boot() {
    for start in ["G64 P0.02\n", "G18\nG91.1\n", "G61.1\n"] {
        go_on(&mut interrupted(plan(start)));
    }
}

#[test]
fn a_console_that_changes_offsets_is_noticed_in_any_mode_of_the_file() {
    for start in ["", "G64 P0.02\n"] {
        let mut bench = printing(plan(start));
        bench.type_in("G92 X3\n");
        assert!(bench.hear(1.0).contains("a console has changed modes or offsets under the job"), "{start}");
    }
}

/// Ctrl-X in a hold drops the job without an alarm. The job can be resumed, and is noted as before.
#[test]
fn a_job_that_was_dropped_in_a_hold_is_noted_again_when_it_goes_on() {
    let mut bench = plan(";FLAVOR:Marlin\n").set("[general] grbl_mode = true").start();
    bench.type_in("play /sd/job.g\n");
    until(&mut bench, |bench| (0.59..0.61).contains(&bench.carriage(Gamma)) && bench.carriage(Delta) > 5.5);
    bench.type_in("!");
    bench.hear(2.0);
    bench.send(&[0x18]);
    bench.hear(2.0);
    assert!(!bench.heats() && !bench.moves());
    bench.type_in("M1000\n");
    until(&mut bench, |bench| bench.carriage(Gamma) < 1.3 && bench.carriage(Gamma) > 1.15 && bench.moves());
    bench.hear(5.0);
    cut(&mut bench);
    let said = bench.greeting().to_owned();
    assert!([" Z1.20", " Z1.50"].iter().any(|z| said.contains(z)), "the last entry was another one: {said}");
}
