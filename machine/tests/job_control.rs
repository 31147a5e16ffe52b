//! Automatic pauses of jobs, the queue of files, and the scripts around jobs.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::runner::CardState;
use units::Actuator::{Alpha, Delta, Gamma};

/// Three layers, each of ten moves, with a lift within each.
pub(crate) fn layers(mark: &str) -> String {
    let mut text = String::from("G28\nG92 E0\nG1 F6000\n");
    let mut pushed = 0.0;
    for layer in 0..3 {
        text += &format!("{}\nG1 Z{:.1}\n", mark.replace('#', &layer.to_string()), 0.2 * f64::from(layer + 1));
        for n in 0..10 {
            pushed += 0.5;
            text += &format!("G1 X{} Y{} E{pushed}\n", 20 + n % 2 * 10, 20 + layer);
        }
        text += &format!("G1 Z5\nG1 X40\nG1 Z{:.1}\n", 0.2 * f64::from(layer + 1));
    }
    text + "M400\n"
}

pub(crate) fn suspended(bench: &mut Bench) -> String {
    bench.hear_until("// Print Suspended", 60.0)
}

fn resume_to_the_end(bench: &mut Bench) {
    bench.type_in("resume\n");
    bench.hear_until("// Resuming print", 20.0);
    bench.hear_until("Done printing file", 60.0);
    assert!((bench.carriage(Delta) - 15.0).abs() < 0.05, "all of it is printed: {}", bench.carriage(Delta));
}

#[test]
fn a_job_pauses_at_a_layer() {
    // Klipper's command counts as its slicer does: here from 0.
    for (mark, second) in [(";LAYER_CHANGE", 2), (";LAYER:#", 2), ("SET_PRINT_STATS_INFO CURRENT_LAYER=#", 1)] {
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(mark)).start();
        let said = bench.say(&format!("pause at layer {second}"));
        assert!(said.contains(&format!("layer {second}: suspend h")), "{said}");
        bench.say("play part.gcode -t");
        let said = suspended(&mut bench);
        assert!(said.contains(&format!("// NOTE the job pauses at layer {second}")), "{mark}: {said}");
        assert!((bench.carriage(Delta) - 5.0).abs() < 0.05, "one layer is there: {}", bench.carriage(Delta));
        assert!(bench.say("pause list").contains(&format!("now in layer {second}")));
        resume_to_the_end(&mut bench);
    }
}

#[test]
fn a_job_pauses_at_a_line_and_with_a_command_of_ones_own() {
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).start();
    bench.say("pause at line 10 M117 ten");
    bench.say("pause at line 12");
    bench.say("play part.gcode -t");
    let said = suspended(&mut bench);
    assert!(said.contains("the job pauses at line 10: M117 ten"), "{said}");
    assert!(said.contains("the job pauses at line 12: suspend h"), "{said}");
    // G28, G92, G1 F, mark, Z, and six of ten moves.
    assert!((bench.carriage(Delta) - 3.0).abs() < 0.05, "{}", bench.carriage(Delta));
    resume_to_the_end(&mut bench);
}

#[test]
fn a_lift_is_no_height_of_the_part() {
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).start();
    bench.say("pause at height 0.55");
    bench.say("play part.gcode -t");
    suspended(&mut bench);
    assert!((bench.carriage(Delta) - 10.0).abs() < 0.05, "two layers are there: {}", bench.carriage(Delta));
    assert!((bench.carriage(Gamma) - 0.6).abs() < 0.05);
    resume_to_the_end(&mut bench);
}

#[test]
fn the_next_layer_and_at_once() {
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(";LAYER_CHANGE")).start();
    bench.say("play part.gcode -t -p");
    assert!(bench.say("pause next layer").contains("layer 1: suspend h"));
    assert_eq!(bench.say("pause clear"), "ok\n");
    assert!(bench.say("SET_PAUSE_NEXT_LAYER").contains("layer 1"));
    bench.say("pause clear");
    bench.say("M24");
    bench.hear(3.0);
    bench.type_in("pause\n");
    suspended(&mut bench);
    resume_to_the_end(&mut bench);
    let said = bench.say("pause at noon 12");
    assert!(said.contains("pause takes: at layer N, at line N"), "{said}");
    assert_eq!(bench.say("pause list"), "ok\n", "nothing is left of a job that has ended");
}

#[test]
fn files_are_played_one_after_the_other() {
    let files = |plan: Plan| plan.file("a.g", "G28 X\nG1 X5 F3000\n").file("b.g", "G28 X\nG1 X9 F3000\n");
    let mut bench = files(Plan::new(CARTESIAN)).start();
    bench.say("queue add a.g");
    assert_eq!(bench.say("queue add b.g"), "1: /sd/a.g\n2: /sd/b.g\nok\n");
    bench.type_in("queue next\n");
    let said = bench.hear_until("// NOTE /sd/b.g is next: clear the bed, then queue next", 10.0);
    assert!(said.contains("Playing /sd/a.g"), "{said}");
    assert!(
        (bench.carriage(Alpha) - 5.0).abs() < 0.05 && !bench.hear(2.0).contains("Playing"),
        "it waits for a person"
    );
    bench.type_in("queue next\n");
    bench.hear_until("Done printing file", 10.0);
    assert!(bench.say("queue next").contains("no file waits"));

    let mut bench = files(Plan::new(CARTESIAN).set("[player] queue_auto = true")).start();
    bench.say("queue add a.g 2");
    bench.say("queue add b.g");
    bench.type_in("queue next\n");
    bench.hear_until("Playing /sd/b.g", 10.0);
    bench.hear(2.0);
    assert!((bench.carriage(Alpha) - 9.0).abs() < 0.05);
    assert!(bench.say("M78").contains("jobs: 3 done, 0 broken off"));
}

#[test]
fn a_setting_follows_the_height() {
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).start();
    bench.say("TUNING_TOWER COMMAND=M220 PARAMETER=S START=100 STEP_DELTA=-10 STEP_HEIGHT=0.4");
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear_until("Done printing file", 60.0);
    let set: Vec<_> = said.lines().filter(|line| line.contains("M220")).collect();
    assert_eq!(set, ["// NOTE height 0.20 mm: M220 S100", "// NOTE height 0.40 mm: M220 S90"]);
    assert!((bench.carriage(Delta) - 15.0).abs() < 0.05, "and all of it is printed");
    assert!(bench.say("M220").contains("90"));
    assert!(bench.say("TUNING_TOWER COMMAND=M900 PARAMETER=K START=0").contains("TUNING_TOWER needs FACTOR"));
    bench.run(&["M220 S100"]);
    bench.type_in("play part.gcode -t\n");
    assert!(!bench.hear_until("Done printing file", 60.0).contains("M220"), "the next job is as its file says");
}

#[test]
fn scripts_stand_before_behind_and_in_place_of_a_jobs_end() {
    let plan = Plan::new(CARTESIAN)
        .set("[player] before_job_gcode = M118_begins")
        .set("[player] after_job_gcode = M118_ends")
        .set("[player] after_abort_gcode = G91_G1_Z5_F600_G90_M118_broken_off");
    let mut bench = plan.file("part.gcode", &layers(";x")).start();
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear_until("Done printing file", 60.0);
    let places =
        ["begins", "ends", "Done printing"].map(|word| said.find(word).unwrap_or_else(|| panic!("{word}: {said}")));
    assert!(places.is_sorted(), "{said}");
    assert_eq!((said.matches("begins").count(), said.matches("ends").count()), (1, 1), "{said}");
    bench.type_in("play part.gcode\n");
    let said = bench.hear(2.0);
    assert!(bench.moves(), "{said}");
    let height = bench.carriage(Gamma);
    bench.type_in("abort\n");
    let said = bench.hear_until("broken off", 10.0);
    assert!(!said.contains("ends"), "{said}");
    bench.hear(1.0);
    assert!(bench.carriage(Gamma) > height + 4.0);
}

#[test]
fn a_script_around_a_job_that_fails_says_why() {
    let plan = || Plan::new(CARTESIAN).file("a.g", "G28\nG1 X5 F3000\n");
    let mut bench = plan().set("[player] before_job_gcode = T9_M118_behind").start();
    bench.type_in("play a.g -t\n");
    let said = bench.hear(3.0);
    assert!(said.contains("error:no extruder has tool_id 9"), "{said}");
    assert!(said.contains("// the job has not begun: M24 begins it all the same, abort ends it"), "{said}");
    assert!(bench.say("progress").contains("SD print is paused at 0/"));
    bench.type_in("M24\n");
    bench.hear_until("Done printing file", 20.0);
    let mut bench = plan().set("[player] after_job_gcode = T9_M118_behind").start();
    bench.type_in("play a.g -t\n");
    let said = bench.hear_until("Done printing file", 20.0);
    assert!(said.contains("error:no extruder has tool_id 9") && !said.contains("behind"), "{said}");
}

#[test]
fn nothing_of_a_job_that_was_broken_off_is_open_in_the_next_one() {
    let plan = Plan::new(CARTESIAN)
        .file("a.g", "G28\nO1 while [1 EQ 1]\nG1 X10 F6000\nG1 X20\nO1 endwhile\n")
        .file("b.g", "G1 X5 F3000\nO1 repeat [2]\nG91\nG1 X1\nG90\nO1 endrepeat\n");
    for (end, next) in [("abort", "play b.g -t"), ("M25", "M32 b.g")] {
        let mut bench = plan.clone().start();
        bench.type_in("play a.g\n");
        bench.hear(10.0);
        bench.say(end);
        bench.hear(3.0);
        bench.type_in(&format!("{next}\n"));
        let said = bench.hear_until("Done printing file", 10.0);
        assert!(!said.contains("error"), "{end}: {said}");
        assert!((bench.carriage(Alpha) - 7.0).abs() < 0.05, "{end}");
    }
}

#[test]
fn a_log_is_whole_when_a_paused_job_is_broken_off() {
    let lines: String = (1..40).map(|n| format!("G1 X{} F3000\n", 20 + n % 2 * 40)).collect();
    let mut bench = Plan::new(CARTESIAN).file("a.ngc", &format!("(LOGOPEN,l.txt)\n(LOG,hello)\n{lines}")).start();
    bench.type_in("play a.ngc\n");
    bench.hear(2.0);
    bench.type_in("pause\n");
    suspended(&mut bench);
    bench.type_in("abort\n");
    bench.hear(2.0);
    assert_eq!(bench.read_card("l.txt").as_deref(), Some("hello\n"));
}

#[test]
fn m26_begins_with_the_jobs_own_file_from_its_first_layer() {
    let mut bench = Plan::new(CARTESIAN)
        .file("a.g", ";LAYER_CHANGE\nM118 main\nO<sub> call\nM118 back\n")
        .file("sub.ngc", "O<sub> sub\nM118 within\nG4 P900\nG4 P900\nO<sub> endsub\n")
        .start();
    bench.type_in("play a.g -t\n");
    bench.hear_until("within", 5.0);
    bench.say("M25");
    bench.run(&["M26"]);
    bench.type_in("M24\n");
    let said = bench.hear_until("main", 5.0);
    assert!(bench.say("pause list").contains("now in layer 1"), "{said}");
    let said = bench.hear_until("Done printing file", 8.0);
    assert!(said.contains("back") && !said.contains("error"), "{said}");
}

#[test]
fn a_look_at_another_file_leaves_what_is_known_of_the_job() {
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).file("other.g", "G28\nG1 X5\n").start();
    bench.say("play part.gcode");
    bench.hear(3.0);
    assert!(bench.say("progress").contains("by the planner"));
    let said = bench.say("check other.g");
    assert!(said.contains("lines"), "{said}");
    let said = bench.say("progress");
    assert!(said.contains("by the planner"), "{said}");
}

#[test]
fn a_card_that_is_gone_before_the_first_line_pauses_the_job_once() {
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).start();
    bench.say("play part.gcode -t -p");
    bench.set_card(CardState::Missing);
    bench.type_in("M24\n");
    let said = bench.hear(2.0);
    assert_eq!(said.matches("error:paused, reading the file being played failed").count(), 1, "{said}");
    bench.set_card(CardState::Good);
    bench.type_in("M24\n");
    bench.hear_until("Done printing file", 60.0);
    assert!((bench.carriage(Delta) - 15.0).abs() < 0.05, "{}", bench.carriage(Delta));
}

/// The pause comes wherever in the file the line stands.
#[test]
fn a_line_that_leaves_the_travel_pauses_the_job_before_it_even_at_the_files_end() {
    for before in 0..6 {
        let moves = "G1 X9\n".repeat(before);
        let file = format!("G28\nG1 F6000\nG1 X30\n{moves}G1 X20\nG4 S3\nG1 X999");
        let mut bench = Plan::new(CARTESIAN).set("[player] preflight = warn").file("a.g", &file).start();
        bench.type_in("play a.g\n");
        let said = bench.hear(20.0);
        assert!(said.contains("the job pauses before it"), "{before}: {said}");
        assert!(said.contains("// Print Suspended"), "{before}: {said}");
    }
}
