//! `ed`: a file edited line by line into another one.

use scenarios::{CARTESIAN, Plan};

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
