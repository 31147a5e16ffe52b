//! Guarantees for a sender, a host program or a person at the console: nothing moves that was not asked for,
//! no line is carried out that belongs to a file, none is lost without a word.

use base::sessions::SessionId;
use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta, Gamma};

fn grbl(plan: Plan) -> Plan {
    plan.with("grbl_mode = false", "grbl_mode = true")
}

/// Step edges so far.
fn edges(bench: &Bench) -> u64 {
    bench.world(|world| world.trace().total())
}

fn tool(bench: &Bench) -> [f64; 3] {
    [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor))
}

#[track_caller]
fn assert_at(bench: &Bench, place: [f64; 3]) {
    let at = tool(bench);
    let near = at.iter().zip(place).all(|(at, wanted)| (at - wanted).abs() < 0.013);
    assert!(near, "the tool is at {at:?}, not at {place:?}");
}

// --- the card ---

#[test]
fn the_card_is_the_current_directory_at_boot() {
    let mut bench = Plan::new(CARTESIAN).file("part.g", "G4 P1\n").start();
    for listing in ["ls", "ls /", "ls /sd", "ls ."] {
        let said = bench.say(listing);
        assert!(said.contains(" part.g\n") && said.contains(" config.ini\n"), "{listing}: {said}");
    }
    assert_eq!(bench.ask("cat part.g"), "G4 P1\n");
    assert_eq!(bench.ask("cat /part.g"), "G4 P1\n");
    assert!(bench.ask("play part.g").contains("Playing part.g\n"));
    bench.hear(1.0);
    assert_eq!(bench.ask("rm part.g"), "deleted part.g\n");
    assert_eq!(bench.read_card("part.g"), None);
    bench.run(&["mkdir parts", "cd parts", "cd /", "cd parts", "cd ..", "cd"]);
    assert!(bench.say("ls").contains(" config.ini\n"));
}

#[test]
fn an_upload_that_cannot_be_opened_is_swallowed_to_its_end() {
    for name in ["no/such/folder/up.g", "", "config.ini/up.g"] {
        let mut bench = Plan::new(CARTESIAN).start();
        let said = bench.say(&format!("M28 {name}"));
        assert!(said.starts_with(&format!("open failed, File: {name}.\n// WARNING ")), "{said}");
        assert!(said.ends_with(": everything up to M29 is discarded\nok\n"), "{said}");
        let before = (tool(&bench), bench.say("get wcs"));
        bench.run(&["G91", "G1 X50 F6000", "M104 S200", "G10 L2 P1 X9", "G28", "M112", "M500", "M502"]);
        bench.hear(2.0);
        assert_eq!((tool(&bench), bench.say("get wcs")), before, "a line was carried out");
        assert_eq!(edges(&bench), 0);
        assert_eq!(bench.duty("hotend"), 0.0);
        assert_eq!(bench.read_card("config-override"), None);
        assert_eq!(bench.say("M29"), "error:nothing was saved\nok\n");
        bench.run(&["G91", "G1 X5 F6000", "M400"]);
        assert_at(&bench, [35.0, 40.0, 10.0]);
    }
}

#[test]
fn a_halt_ends_an_upload_but_not_the_swallowing() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G91"]);
    assert_eq!(bench.say("M28 up.g"), "Writing to file: up.g\nok\n");
    // A byte of the file is no command; somebody else stops the machine.
    bench.type_on(SessionId(1), "\x18");
    bench.hear(0.1);
    bench.type_on(SessionId(1), "$X\n");
    bench.hear(0.5);
    bench.run(&["G1 X50 F6000", "M400"]);
    assert_eq!(edges(&bench), 0, "a line of the file was carried out");
    assert_eq!(bench.say("M29"), "error:nothing was saved\nok\n");
    bench.run(&["G1 X5 F6000", "M400"]);
    assert_at(&bench, [35.0, 40.0, 10.0]);
}

#[test]
fn an_upload_belongs_to_the_console_it_began_on() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("M28 up.g"), "Writing to file: up.g\nok\n");
    assert_eq!(bench.say_on(SessionId(1), "G91"), "ok\n");
    assert_eq!(bench.say_on(SessionId(1), "G1 X5 F6000"), "ok\n");
    assert_eq!(bench.say_on(SessionId(1), "M28 other.g"), "error:another file is being uploaded\n");
    assert_eq!(bench.say_on(SessionId(1), "M400"), "ok\n");
    assert_at(&bench, [35.0, 40.0, 10.0]);
    bench.run(&["G1 X1"]);
    assert_eq!(bench.say("M29"), "Done saving file.\nok\n");
    assert_eq!(bench.read_card("up.g").as_deref(), Some("G1 X1\n"));
}

// --- homing and parking ---

#[test]
fn g28_that_parks_never_homes() {
    let unhomed = "[MSG:cannot move to predefined position as axis are not homed and MCS is unknown]\nerror:10\n";
    let mut bench = grbl(Plan::new(CARTESIAN)).start();
    for line in ["G28", "G28 Z0", "G91 G28 Z0", "G28 X0 Y0"] {
        assert_eq!(bench.say(line), unhomed, "{line}");
    }
    assert_eq!(edges(&bench), 0);
    bench.run(&["G90", "$H", "G1 X50 Y60 Z20 F6000"]);
    assert_eq!(bench.say("G28.1"), "[MSG:position saved, use M500 to make permanent]\nok\n");
    assert!(bench.say("$#").contains("[G28:50.000,60.000,20.000]\n"));
    bench.run(&["G1 X10 Y10 Z5", "G28", "M400"]);
    assert_at(&bench, [50.0, 60.0, 20.0]);
    // The words are distances to go first; then only what they name is parked.
    bench.run(&["G1 X10 Y10 Z5", "G91", "G28 Z0", "M400", "G90"]);
    assert_at(&bench, [10.0, 10.0, 20.0]);
    bench.run(&["G28.1 X5 Y6", "G28", "M400"]);
    assert_at(&bench, [5.0, 6.0, 20.0]);
    bench.run(&["G1 X10 Y10", "G28.2", "M400"]);
    assert_at(&bench, [0.0, 0.0, 0.0]);
}

#[test]
fn g28_2_parks_where_g28_homes() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert!(bench.say("G28.2").starts_with("error:cannot move to predefined position"));
    assert!(bench.say("G28.1").starts_with("error:Cannot set predefined position unless axis are homed"));
    assert_eq!(edges(&bench), 0);
    bench.run(&["G28", "G28.1 X30 Y20 Z10", "G28.2", "M400"]);
    assert_at(&bench, [30.0, 20.0, 10.0]);
    assert!(bench.say("G28.1 X3").starts_with("error:Must supply Y"));
    bench.say("M500");
    assert!(bench.read_card("config-override").unwrap().contains("\nG28.1 X30.0000 Y20.0000 Z10.0000\n"));
}

// Smoothieware v2: X and Y of the work, where a Z is stored.
#[test]
fn parking_is_in_machine_coordinates_whatever_offsets_are_in_force() {
    let offsets = ["G10 L2 P1 X7 Y8 Z3", "G92 X-4 Y2 Z1", "G55"];
    let mut bench = grbl(Plan::new(CARTESIAN)).set("[motion control] nist_G30 = true").start();
    bench.run(&["$H", "G90 G53 G0 X50 Y60 Z20", "G4 P0.1"]);
    for line in ["G28.1", "G30.1"] {
        assert!(bench.say(line).ends_with("ok\n"), "{line}");
    }
    bench.run(&offsets);
    for line in ["G28", "G30"] {
        bench.run(&["G90 G53 G0 X10 Y10 Z5", line, "G4 P0.1"]);
        assert_at(&bench, [50.0, 60.0, 20.0]);
        bench.run(&["G90 G53 G0 X10 Y10 Z5", &format!("G91 {line} Z0"), "G4 P0.1"]);
        assert_at(&bench, [10.0, 10.0, 20.0]);
        bench.run(&["G90 G53 G0 X10 Y10 Z5", &format!("G91 {line} X3"), "G4 P0.1"]);
        assert_at(&bench, [50.0, 10.0, 5.0]);
    }
    let mut bench = Plan::new(CARTESIAN).start_homed();
    bench.run(&["G28.1 X30 Y20 Z10"]);
    bench.run(&offsets);
    bench.run(&["G28.2", "M400"]);
    assert_at(&bench, [30.0, 20.0, 10.0]);
}

#[test]
fn what_cannot_be_homed_homes_nothing_else_instead() {
    let mut bench = Plan::new(CARTESIAN).start();
    for line in ["G28 E", "G28 E0", "G28 A0", "G28 X0 E0", "G28 W", "G28 F100", "G28 P1"] {
        let said = bench.say(line);
        assert!(said.starts_with("error:") && said.lines().count() == 1, "{line}: {said}");
    }
    bench.hear(1.0);
    assert_eq!(edges(&bench), 0);
    assert_eq!(bench.say("G28 E"), "error:G28: E is no axis that can be homed, column 5\n");
}

// --- commands ---

#[test]
fn asking_what_a_command_does_carries_none_out() {
    let part = "G91\nG1 X50 F600\nG1 X-50\n";
    let mut bench = Plan::new(CARTESIAN).file("part.g", part).file("-h", "M500\n").start();
    bench.run(&["G91", "G1 X1 F600", "M400"]);
    let listed = bench.say("help");
    let words = listed.lines().filter(|line| *line != "ok").filter_map(|line| line.split(' ').next());
    let words: Vec<&str> = words.collect();
    assert!(words.len() >= 30, "{words:?}");
    bench.ask("play part.g");
    bench.hear(0.5);
    let progress = |bench: &mut Bench| bench.say("progress").split('%').count();
    let before = progress(&mut bench);
    for word in words {
        let said = bench.say(&format!("{word} -h"));
        assert!(said.starts_with(word) && said.ends_with("\nok\n"), "{word}: {said}");
        assert_eq!(said.lines().count(), 2, "{word}: {said}");
    }
    assert_eq!(progress(&mut bench), before, "the job was touched");
    assert!(bench.status().starts_with("<Run"), "{}", bench.status());
    assert!(!bench.hear(2.0).contains("Welcome"), "it was reset");
    assert_eq!(bench.read_card("part.g").as_deref(), Some(part));
    assert_eq!(bench.read_card("config-override"), None);
    bench.hear(20.0);
    assert_at(&bench, [31.0, 40.0, 10.0]);
}

// --- lines ---

/// Lines typed while the machine is busy homing, and what is answered to each: one line.
fn type_ahead(bench: &mut Bench, lines: &[String]) -> Vec<String> {
    bench.type_in("G28\n");
    bench.hear(0.2);
    let whole: String = lines.iter().map(|line| format!("{line}\n")).collect();
    // The machine must report lines that do not fit its inbox.
    let _all = bench.try_type(&whole);
    let mut said = String::new();
    while said.lines().count() <= lines.len() {
        let more = bench.hear(1.0);
        said.push_str(&more);
        assert!(!more.is_empty() || bench.now_s() < 120.0, "only {} answers: {said}", said.lines().count());
    }
    said.push_str(&bench.hear(2.0));
    let mut answers: Vec<String> = said.split_inclusive('\n').map(str::to_owned).collect();
    assert_eq!(answers.remove(0), "ok\n", "the answer to G28");
    answers
}

#[test]
fn typing_ahead_loses_nothing() {
    let lines: Vec<String> = (0..180).map(|n| format!("G10 L2 P1 X{n} Y0 Z0")).collect();
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(type_ahead(&mut bench, &lines), vec!["ok\n"; lines.len()]);
    assert!(bench.say("$#").contains("[G54:179.0000,0.0000,0.0000]"));
}

#[test]
fn what_does_not_fit_is_lost_by_whole_lines_each_with_its_answer() {
    let lines: Vec<String> = (0..1_000).map(|n| format!("M117 line {n} of a flood that no inbox holds")).collect();
    let lines: Vec<String> =
        lines.iter().zip(0..).map(|(line, n)| if n % 2 == 0 { line.clone() } else { "G92 X7".into() }).collect();
    let mut bench = Plan::new(CARTESIAN).start();
    let answers = type_ahead(&mut bench, &lines);
    assert_eq!(answers.len(), lines.len(), "an answer for each line");
    let lost = "error:line lost, wait for ok before sending more\n";
    let kept = answers.iter().take_while(|answer| *answer == "ok\n").count();
    assert!(kept > 100, "only {kept} fitted");
    assert!(answers[kept..].iter().all(|answer| answer == lost), "{:?}", &answers[kept..][..10]);
    bench.run(&["G92 X0"]);
}
