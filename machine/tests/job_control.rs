//! Automatic pauses of jobs, the queue of files, and the statistics.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};
use sim::runner::CardState;
use units::Actuator::{Alpha, Beta, Delta, Gamma};

/// Three layers, each of ten moves, with a lift within each.
fn layers(mark: &str) -> String {
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

fn suspended(bench: &mut Bench) -> String {
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
fn what_jobs_took_outlives_a_reset() {
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).start();
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear_until("Done printing file", 60.0);
    // Ten ways of 10 mm a layer, the first of which is elsewhere, and a way to X40 and back.
    assert!(said.contains("of it still)") && said.contains("0.015 m of filament"), "{said}");
    bench.hear(0.5);
    let told = bench.say("M78");
    assert!(told.contains("jobs: 1 done, 0 broken off"), "{told}");
    bench.say("play part.gcode");
    bench.hear(2.0);
    bench.type_in("abort\n");
    bench.hear(3.0);
    let told = bench.say("M78");
    assert!(told.contains("jobs: 1 done, 1 broken off"), "{told}");
    let kept = bench.read_card("statistics.txt").expect("statistics on the card");
    let mut later = Plan::new(CARTESIAN).file("statistics.txt", &kept).start();
    assert!(later.say("M78").contains("jobs: 1 done, 1 broken off"));
    later.say("M78 S78");
    assert!(later.say("M78").contains("jobs: 0 done, 0 broken off"));
    let mut broken = Plan::new(CARTESIAN).file("statistics.txt", "jobs_done = 5\nnonsense\n").start();
    assert!(broken.greeting().contains("WARNING: /sd/statistics.txt: 1 lines were left out"));
    assert!(broken.say("M78").contains("jobs: 5 done"));
}

/// A heater of 40 W at full power for 20 s is 0.2 Wh; what the bed did stays, though it is not described.
#[test]
fn what_heaters_did_outlives_a_reset() {
    let kept = "heater_hotend_on_s = 7200\nheater_hotend_full_s = 3600\nheater_bed_on_s = 60\n";
    let mut bench = Plan::new(CARTESIAN).file("statistics.txt", kept).start();
    assert_eq!(bench.greeting().matches("WARNING").count(), 0, "{}", bench.greeting());
    let told = bench.say("M78");
    let expected =
        "heater hotend: on for 2:00:00, as much as 1:00:00 at full power, 0.040 kWh with a heater_power of 40 W\n";
    assert!(told.contains(expected), "{told}");
    bench.say("M104 S150");
    bench.hear(20.5);
    bench.say("M104 S0");
    bench.hear(2.0);
    let saved = bench.read_card("statistics.txt").expect("statistics on the card");
    let figure = |key: &str| -> f64 {
        let line = saved.lines().find_map(|line| line.strip_prefix(key)).expect(key);
        line.trim_start_matches(" = ").parse().expect("a figure")
    };
    assert!((7_220.0..7_223.0).contains(&figure("heater_hotend_on_s")), "{saved}");
    assert!((3_610.0..3_621.0).contains(&figure("heater_hotend_full_s")), "{saved}");
    assert_eq!(figure("heater_bed_on_s"), 60.0);
}

/// A card may take a quarter of a second for a block; the watchdog waits nearly four seconds for the
/// executor.
#[test]
fn statistics_are_saved_in_steps_that_the_watchdog_outlives() {
    let mut bench = Plan::new(CARTESIAN).file("statistics.txt", "jobs_done = 5\n").file("a.g", "G28\n").start();
    bench.type_in("play a.g -t\n");
    bench.hear_until("Done printing file", 60.0);
    bench.hear(0.5);
    assert!(bench.read_card("previous-statistics.txt").is_some(), "saved");
    assert!(bench.most_unseen_writes() <= 12, "{} writes without a word", bench.most_unseen_writes());
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

/// Returns the places where the extruder makes steps that push.
fn pushes(bench: &mut Bench, seconds: f64) -> Vec<[i64; 3]> {
    let mut places = Vec::new();
    let mut pushed = bench.carriage(Delta);
    for _ in 0..(seconds * 200.0) as u32 {
        bench.hear(0.005);
        let now = bench.carriage(Delta);
        if now > pushed {
            places.push([Alpha, Beta, Gamma].map(|motor| (bench.carriage(motor) * 10.0).round() as i64));
        }
        pushed = now;
    }
    places
}

#[test]
fn a_job_begins_in_the_middle_as_if_it_had_come_there() {
    let file = format!("M106 S255\nM140 S40\n{}", layers(";LAYER_CHANGE"));
    // Five lines, then fifteen a layer: its mark, Z, ten that print.
    let byte = file.lines().take(41).map(|line| line.len() + 1).sum::<usize>();
    for (from, lines) in [("layer 3", 10), ("line 42", 6), (&format!("byte {byte}")[..], 6)] {
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        bench.run(&["G28", "G92 E0"]);
        let before = bench.carriage(Delta);
        bench.type_in(&format!("play part.gcode -t --from {from}\n"));
        let said = bench.hear_until("// the job begins with line", 5.0);
        assert!(said.contains("the file is read up to there"), "{from}: {said}");
        bench.hear_until("Done printing file", 200.0);
        let pushed = bench.carriage(Delta) - before;
        assert!((pushed - 0.5 * f64::from(lines)).abs() < 0.02, "{from}: {pushed} mm were printed");
        assert!(bench.celsius("bed") > 38.0, "{from}: the bed was heated first");
        assert!(bench.world(|world| world.fan_speed(0)) > 0.5, "{from}: the fan is as the file had set it");
        assert!((bench.carriage(Gamma) - 0.6).abs() < 0.02);
    }
}

#[test]
fn what_is_printed_from_the_middle_is_where_it_belongs() {
    let mut whole = Plan::new(CARTESIAN).file("part.gcode", &layers(";LAYER_CHANGE")).start();
    whole.run(&["G28"]);
    whole.type_in("play part.gcode\n");
    let all = pushes(&mut whole, 20.0);
    let mut rest = Plan::new(CARTESIAN).file("part.gcode", &layers(";LAYER_CHANGE")).start();
    rest.run(&["G28"]);
    rest.type_in("play part.gcode --from layer 2\n");
    let some = pushes(&mut rest, 20.0);
    assert!(some.len() > 50 && some.len() < all.len());
    let heights: std::collections::BTreeSet<_> = some.iter().map(|place| place[2]).collect();
    assert_eq!(heights.into_iter().collect::<Vec<_>>(), [4, 6]);
    // Places are sampled every 5 ms, at 100 mm/s.
    let is_near = |one: &[i64; 3], other: &[i64; 3]| one.iter().zip(other).all(|(a, b)| (a - b).abs() <= 6);
    for place in some {
        assert!(all.iter().any(|other| is_near(&place, other)), "{place:?}");
    }
}

/// At its highest, where it is after homing, a delta goes nowhere else.
#[test]
fn a_delta_begins_in_the_middle_without_leaving_its_towers() {
    let mut bench = Plan::new(DELTA).file("part.gcode", &layers(";LAYER_CHANGE")).start();
    bench.run(&["G28"]);
    bench.type_in("play part.gcode -t --from layer 2\n");
    bench.hear_until("Done printing file", 200.0);
    for tower in [Alpha, Beta, Gamma] {
        assert!(bench.world(|world| world.lost_mm(tower)) < 1e-9, "not beyond the tower's end");
    }
}

/// A pause that the file asks for is one where its place is still to come, and nothing where it is not.
#[test]
fn pauses_of_the_part_that_is_read_over_come_where_they_belong() {
    let mark = ";LAYER_CHANGE\nSET_PAUSE_NEXT_LAYER";
    let file = layers(";LAYER_CHANGE").replacen(";LAYER_CHANGE", mark, 2);
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
    bench.run(&["G28", "G92 E0"]);
    // The first layer asks for the second, where the job begins; the second asks for the third.
    let line = file.lines().position(|line| line == "G1 Z0.4").expect("a second layer") + 3;
    bench.type_in(&format!("play part.gcode -t --from line {line}\n"));
    let said = suspended(&mut bench);
    assert!(said.contains("the job pauses at layer 3") && !said.contains("at layer 2"), "{said}");
    bench.type_in("resume\n");
    bench.hear_until("Done printing file", 60.0);
}

#[test]
fn a_job_that_cannot_begin_there_is_closed() {
    let probing = "G28\nG38.2 Z-5 F60\nG1 X5\nG1 X6\n";
    let plan = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).file("probe.ngc", probing);
    let mut bench = plan.set("[zprobe] enable = true").set("[zprobe] probe_pin = PB10^").start();
    let refused = |bench: &mut Bench, from: &str, why: &str| {
        bench.type_in(&format!("play {from}\n"));
        let said = bench.hear(2.0);
        assert!(said.contains(why), "{from}: {said}");
        assert!(bench.say("progress").contains("Not currently playing"), "{from}");
        assert!(!bench.moves() && bench.say("get mode").contains("idle"), "{from}");
    };
    refused(&mut bench, "part.gcode --from line 9", "home first");
    bench.run(&["G28"]);
    refused(&mut bench, "part.gcode --from line 900", "the file ends before this place, or marks no layers");
    refused(&mut bench, "part.gcode --from layer 2", "the file ends before this place, or marks no layers");
    refused(&mut bench, "part.gcode --from noon 2", "play takes: file --from line N, layer N or byte N");
    refused(&mut bench, "probe.ngc --from line 4", "the file probes or reads inputs before");
    bench.run(&["G1 X5 F3000", "M400"]);
    bench.say("M23 part.gcode");
    assert!(bench.say("M26 S100").contains("play file --from byte N"));
    bench.run(&["M26 S0"]);
}

/// Limits set by a file are in force for its job, and for no other one.
#[test]
fn limits_of_a_job_that_cannot_begin_there_are_put_back() {
    let file = format!("M204 S1234\nM205 X0.31\nM203 X77\nM201 X1111\nM900 K0.3\n{}", layers(";x"));
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
    bench.run(&["G28"]);
    let before = bench.say("M503");
    bench.type_in("play part.gcode --from line 900\n");
    bench.hear_until("the file ends before this place", 5.0);
    assert_eq!(bench.say("M503"), before);
    bench.type_in("play part.gcode -t --from line 30\n");
    bench.hear_until("Done printing file", 60.0);
    let said = bench.say("M503");
    assert!(said.contains("1234") && said.contains("0.31"), "{said}");
}

#[test]
fn nothing_is_left_heating_by_a_job_that_cannot_begin_there() {
    let file = format!("M140 S60\n{}", layers(";LAYER_CHANGE"));
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
    bench.run(&["G28"]);
    bench.world(|world| world.inject(&sim::world::Fault::MotorSupply(0.0))).expect("a supply");
    bench.hear(1.0);
    bench.run(&["G28.3"]);
    bench.type_in("play part.gcode --from layer 2\n");
    bench.hear_until("motor supply is off", 5.0);
    assert!(!bench.hear(3.0).contains("heats to"));
    assert!(bench.say("M105").contains("B:22.0 /0.0 "), "{}", bench.say("M105"));
}

/// A halt in any step of such a beginning (reading over, heating, rising, going there, going down) drops it.
#[test]
fn a_halt_in_any_step_of_a_beginning_in_the_middle_drops_it() {
    let file = format!("M106 S255\nM140 S40\n{}", layers(";LAYER_CHANGE"));
    let plan = || Plan::new(CARTESIAN).file("part.gcode", &file);
    let (mut bench, mut took) = (plan().start(), 0.0);
    bench.run(&["G28", "G1 X80 Y60 F6000", "M400"]);
    bench.type_in("play part.gcode --from layer 2\n");
    while !bench.moves() {
        bench.hear(0.01);
        took += 0.01;
    }
    for delay in [0.0, 0.002, 0.5, took - 0.05, took + 0.1, took + 0.4, took + 0.8, took + 1.2] {
        let mut bench = plan().start();
        bench.run(&["G28", "G1 X80 Y60 F6000", "M400"]);
        bench.type_in("play part.gcode --from layer 2\n");
        bench.hear(delay);
        bench.type_in("M112\n");
        bench.hear_until("ALARM", 1.0);
        bench.assert_safe();
        assert!(bench.say("progress").contains("Not currently playing"), "{delay}");
        bench.say("M999");
        assert!(bench.say("get mode").contains("idle"), "{delay}");
        bench.run(&["G28", "G1 X5 F3000", "M400"]);
        assert!((bench.carriage(Alpha) - 5.0).abs() < 0.05, "{delay}: the program is where the machine is");
    }
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
