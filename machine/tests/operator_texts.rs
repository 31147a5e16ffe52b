//! Text is text: nothing of what a code says to a person is carried out, taken for a checksum or a fault.

use scenarios::{Bench, CARTESIAN, Plan};

fn stands_at(bench: &mut Bench, place: &str) {
    let said = bench.say("M114.1");
    assert!(said.contains(place), "{place}: {said}");
}

#[test]
fn a_stop_shows_its_text_and_carries_nothing_of_it_out() {
    for flavour in ["", ";FLAVOR:Marlin\n", "; gcode_flavor = klipper\n", "; gcode_flavor = reprapfirmware\n"] {
        let file = format!(
            "{flavour}G1 X20 F6000\nM0 Insert M3 nuts G1 Y50 now\nG1 X30\nM1 Load T1 spool, G28 over\nG1 X40\nM400\n"
        );
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        bench.type_in("play part.gcode -t\n");
        bench.hear_until("// Insert M3 nuts G1 Y50 now\n// the program waits (M0)", 20.0);
        bench.type_in("M24\n");
        let said = bench.hear_until("// Load T1 spool, G28 over\n// the program waits (M1)", 20.0);
        assert!(!said.contains("error"), "{said}");
        bench.type_in("M24\n");
        bench.hear_until("Done printing file", 20.0);
        bench.hear(0.5);
        stands_at(&mut bench, "X:40.0000 Y:0.0000");
    }
}

#[test]
fn a_stop_with_a_time_goes_on_by_itself() {
    let file = ";FLAVOR:Marlin\nG1 X20 F6000\nM0 S2\nG1 X30\nM1 P1500 Insert the nuts\nG1 X40\nM400\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", file).start();
    let begun_s = bench.now_s();
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear_until("Done printing file", 20.0);
    assert!(said.contains("// Insert the nuts\n"), "{said}");
    assert!((3.5..6.0).contains(&(bench.now_s() - begun_s)), "{}", bench.now_s() - begun_s);
    assert!(bench.say("check part.gcode").contains("waiting 3.5 s"), "a look ahead counts it");
    let mut bench = Plan::new(CARTESIAN).start();
    assert!(bench.say("M0 S100000").contains("error"), "longer than a day");
}

#[test]
fn a_star_in_a_files_text_is_no_checksum() {
    let file = "M117 Pass 3*4\nM118 Pass 3*4\nG1 X10 F3000 ; 5*3\nG1 X20 (2*3)\n(**** start ****)\nM117 *** done ***\nM486 Abox 2*2\nG1 X30\nM400\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", file).start();
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear_until("Done printing file", 20.0);
    assert!(said.contains("Pass 3*4") && !said.contains("error") && !said.contains("Error"), "{said}");
    bench.hear(0.5);
    stands_at(&mut bench, "X:30.0000");
    for console in ["M118 5*3", "echo 5*3"] {
        assert!(bench.say(console).contains("5*3"), "{console}");
    }
}

#[test]
fn a_damaged_line_makes_the_file_wait_and_halts_nothing() {
    for line in ["N3 G1 X30 F3000*99", "G1 X30 F3000*99", "G1 X3\u{e9}0"] {
        let file = format!("G1 X10 F3000\n{line}\nG1 X40\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        bench.type_in("play part.gcode -t\n");
        let said = bench.hear(5.0);
        assert!(said.contains("was not carried out") && !said.contains("Alarm/Halt"), "{line}: {said}");
        stands_at(&mut bench, "X:10.0000");
        assert!(bench.say("M105").starts_with("ok"), "{line}");
    }
}

#[test]
fn what_m118_says_has_the_prefix_that_it_asks_for() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert!(bench.say("M118 A1 action:pause").contains("// action:pause\n"));
    assert!(bench.say("M118 E1 here").contains("echo:here\n"));
    assert!(bench.say("M118 S\"a; b\"").contains("a; b\n"));
}
