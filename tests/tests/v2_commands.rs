//! Commands of Smoothieware v2's console for whoever builds a machine: `test`, `gpio`, `ed`.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta};

fn start() -> Bench {
    Plan::new(CARTESIAN).start()
}

fn homed() -> Bench {
    let mut bench = start();
    bench.run(&["G28", "G1 X50 Y50 Z5 F6000", "M400"]);
    bench
}

// --- test ---

#[test]
fn figures_are_drawn_and_nothing_of_them_stays() {
    let mut bench = homed();
    bench.run(&["G91", "G1 F1500"]);
    let state = bench.say("$G");
    for (line, seconds) in [("test jog x 10 2", 0.8), ("test square 10 2 3000", 1.6), ("test circle 10 1 3000", 1.6)] {
        let (began, least) = (bench.now_s(), seconds);
        assert_eq!(bench.say(line), "ok\n", "{line}");
        assert!(bench.now_s() - began > least, "{line}: {} s", bench.now_s() - began);
        assert!((bench.carriage(Alpha) - 50.0).abs() < 0.02 && (bench.carriage(Beta) - 50.0).abs() < 0.02, "{line}");
        let now = bench.say("$G");
        assert_eq!(now.split(' ').skip(1).collect::<Vec<_>>(), state.split(' ').skip(1).collect::<Vec<_>>(), "{line}");
    }
    assert_eq!(bench.say("test jog y 5 1"), "ok\n");
    assert!((bench.carriage(Beta) - 55.0).abs() < 0.02, "an odd number of moves ends at the other end");
    bench.run(&["G20"]);
    assert_eq!(bench.say("test jog y 1 1 200"), "ok\n");
    assert!((bench.carriage(Beta) - 80.4).abs() < 0.02, "inches: {}", bench.carriage(Beta));
}

#[test]
fn a_figure_that_leaves_the_travel_does_not_begin() {
    let mut bench = homed();
    for line in ["test jog x 9999 2", "test square 9999 1", "test circle 60 1", "test acc x -60 10"] {
        let said = bench.say(line);
        assert!(said.contains("out of travel"), "{line}: {said}");
        bench.say("$X");
    }
    assert!((bench.carriage(Alpha) - 50.0).abs() < 0.02, "{}", bench.carriage(Alpha));
}

#[test]
fn a_figure_ends_by_ctrl_y_and_by_a_halt() {
    let mut bench = homed();
    bench.type_in("test jog x 10 1000 3000\n");
    assert_eq!(bench.hear(1.0), "");
    bench.send(b"\x19");
    assert_eq!(bench.hear(1.0), "ok\n");
    assert!(!bench.moves());
    let state = bench.say("$G");
    bench.type_in("test square 10 1000 3000\n");
    bench.hear(1.0);
    bench.type_in("M112\n");
    bench.hear(1.0);
    assert!(!bench.moves());
    assert_eq!(bench.say("test jog x 1 1"), "!!\n");
    assert!(bench.say("M999").ends_with("ok\n"));
    assert_eq!(bench.say("$G").contains(" G90 "), state.contains(" G90 "));
}

#[test]
fn one_motor_makes_so_many_steps() {
    let mut bench = homed();
    let steps = |bench: &mut Bench| -> i64 {
        let said = bench.say("get pos");
        let raw = said.lines().find(|line| line.starts_with("RAW:")).expect("steps");
        raw.split_whitespace().nth(1).expect("X").parse().expect("steps")
    };
    let before = steps(&mut bench);
    assert_eq!(bench.say("test raw x 123 1000"), "issuing 123 steps at a rate of 1000 steps/sec on the X axis\nok\n");
    assert_eq!(steps(&mut bench) - before, 123);
    assert_eq!(bench.say("test raw x -123 1000"), "issuing 123 steps at a rate of 1000 steps/sec on the X axis\nok\n");
    assert_eq!(steps(&mut bench), before);
    assert!(bench.say("test acc x 2 20").contains("on the X axis\nok\n"));
    assert!((bench.carriage(Alpha) - 52.0).abs() < 0.02);
    assert!(bench.say("test raw c 10 10").starts_with("error:axis is out of range"));
    assert!(bench.say("test").starts_with("error:usage: test jog|square"));
    assert!(bench.say("test -h").starts_with("test "));
}

// --- gpio ---

#[test]
fn a_pin_that_nothing_uses_is_looked_at_and_driven() {
    let mut bench = start();
    assert_eq!(bench.say("gpio PJ1"), "PJ1^:1\nok\n");
    assert_eq!(bench.say("gpio pj_1v in"), "PJ1v:0\nok\n");
    assert_eq!(bench.say("gpio PJ1!v"), "PJ1!v:1\nok\n");
    let began = bench.now_s();
    assert_eq!(bench.say("gpio PJ1 out on 500"), "PJ1:1: was set to on\nok\n");
    assert!(bench.now_s() - began > 0.5);
    bench.type_in("gpio PJ1 out off\n");
    assert_eq!(bench.hear(0.2), "PJ1:0: was set to off\n", "it is driven for two seconds");
    bench.send(b"\x19");
    assert_eq!(bench.hear(0.2), "ok\n");
}

#[test]
fn a_pin_that_something_uses_is_refused() {
    let mut bench = start();
    for (line, why) in [
        ("gpio PD3", "PD3 is used by actuator.alpha"),
        ("gpio PE0 out on", "temperature control.hotend"),
        ("gpio PC8", "belongs to the SD card"),
        ("gpio PD5", "belongs to the debug UART"),
        ("gpio PJ14 out on", "the boot button drives it"),
        ("gpio XX", "Illegal pin name: XX"),
        ("gpio PJ1 sideways", "incorrect usage"),
    ] {
        let said = bench.say(line);
        assert!(said.starts_with("error:") && said.contains(why), "{line}: {said}");
    }
    assert_eq!(bench.say("gpio PJ14"), "PJ14^:1\nok\n", "to look at it is allowed");
}

// --- ed ---

const CONFIG: &str = "[fan]\npin = PE1\nspeed = 5\n\n[bed]\npin = PE3\n";

#[test]
fn a_file_is_edited_into_another_one() {
    let mut bench = Plan::new(CARTESIAN).file("in.ini", CONFIG).start();
    assert_eq!(bench.say("ed in.ini out.ini"), "  type %h to get help, %c to save file and exit\nok\n");
    assert_eq!(bench.say("p2"), "^[fan]\n^pin = PE1\nok\n");
    assert_eq!(bench.say("f/PE1/s/PE1!/"), "pin = PE1!^\nok\n", "no sign of the text acts");
    assert_eq!(bench.say("m"), "^speed = 5\nok\n");
    assert_eq!(bench.say("f/nosuch/"), "error:there is none\n");
    assert_eq!(bench.say("x"), "error:that is no command: %h lists them\n");
    assert_eq!(bench.say("k"), "^\nok\n");
    assert_eq!(bench.say("g2"), "ok\n");
    bench.run(&["M112", "? ! ~ # G1 X5"]);
    assert_eq!(bench.say("f/bed/r3"), "[bed^]\nok\n");
    assert_eq!(bench.say("m*"), "**END**\nok\n");
    bench.run(&["%q", "i/end/", "%c"]);
    let expected = "[fan]\npin = PE1!\nM112\n? ! ~ # G1 X5\n\n[bed]\npin = PE3\nend";
    assert_eq!(bench.read_card("out.ini").as_deref(), Some(expected));
    assert_eq!(bench.read_card("in.ini").as_deref(), Some(CONFIG));
    assert_eq!(bench.say("M115").lines().last(), Some("ok"), "codes are codes again");
    assert!(!bench.status().contains("Alarm"));
}

#[test]
fn a_long_file_goes_through_the_editor_whole() {
    let line = |number: u32| format!("G1 X{number} F3000 ; line {number}\n");
    let long: String = (0..5_000).map(line).collect();
    let mut bench = Plan::new(CARTESIAN).file("long.g", &long).start();
    assert!(bench.say("ed long.g new.g").ends_with("ok\n"));
    bench.run(&["%q"]);
    bench.run(&["f/line 4321/s/LINE 4321/", "m-3"]);
    assert_eq!(bench.say("p"), "^G1 X4318 F3000 ; line 4318\nok\n");
    assert!(bench.say("m-4000").starts_with("error:"), "no further than the piece that is kept");
    bench.run(&["m*", "%c"]);
    assert_eq!(bench.read_card("new.g"), Some(long.replace("line 4321", "LINE 4321")));
}

#[test]
fn what_cannot_be_edited_is_refused_and_ctrl_x_still_stops_the_machine() {
    let mut bench = Plan::new(CARTESIAN).file("a.g", "G1 X1\n").start();
    for (line, why) in [
        ("ed", "Need unique input file and output file"),
        ("ed a.g", "Need unique input file and output file"),
        ("ed a.g A.G", "Need unique input file and output file"),
        ("ed nosuch b.g", "nosuch: no such file"),
    ] {
        let said = bench.say(line);
        assert!(said.starts_with("error:") && said.contains(why), "{line}: {said}");
    }
    assert!(bench.read_card("b.g").is_none());
    bench.run(&["G1 X50 F600"]);
    bench.say("ed a.g b.g");
    assert!(bench.say("M5").starts_with("error:"), "no code acts: M goes to the next line");
    bench.send(b"\x18");
    assert!(bench.hear(1.0).contains("ALARM: Abort during cycle"));
    assert!(!bench.moves());
    bench.run(&["%c"]);
    assert_eq!(bench.read_card("b.g").as_deref(), Some("G1 X1\n"));
}

// --- files ---

// Smoothieware v2: M26 ends the job, and M23 answers with the size of the file that plays.
#[test]
fn a_file_that_plays_is_begun_anew_by_m26_and_keeps_its_place_from_m23() {
    let job = "G91\nG1 X10 F6000\nG4 S2\nG1 X-10\n".repeat(2);
    let mut bench = Plan::new(CARTESIAN).file("a.g", &job).file("b.g", "G28\n").start();
    bench.say("M23 a.g");
    bench.say("M24");
    bench.hear(1.0);
    let begun = bench.carriage(Alpha);
    assert!(bench.say("M23 b.g").starts_with("error:"));
    assert_eq!(bench.say("M26"), "ok\n");
    bench.hear(1.5);
    assert!((bench.carriage(Alpha) - begun - 10.0).abs() < 0.02, "its first line again");
}
