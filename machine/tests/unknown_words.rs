//! Words that a code does not take are not dropped: what might lead elsewhere is refused, the rest is told.

use scenarios::{CARTESIAN, Plan};

#[test]
fn a_word_that_would_lead_elsewhere_makes_the_file_wait() {
    let cases = [
        ("; gcode_flavor = reprapfirmware\n", "G1 R1 X0 Y0", "G1 takes no R here"),
        ("; gcode_flavor = reprapfirmware\n", "G0 R2 Z2", "G0 takes no R here"),
        ("; gcode_flavor = reprapfirmware\n", "G1 X50 H1", "G1 takes no H here"),
        ("; gcode_flavor = reprapfirmware\n", "G1 U5", "G1 takes no U here"),
        (";FLAVOR:Marlin\n", "G61 X Y F6000", "G61"),
        (";FLAVOR:Marlin\n", "G90 X5", "G90 takes no X here"),
        ("", "G1 X50 R3", "G1 takes no R here"),
        ("", "G92 I5", "G92 takes no I here"),
    ];
    for (flavour, line, told) in cases {
        let file = format!("{flavour}G1 X20 Y20 F6000\n{line}\nG1 X30\nM400\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        bench.type_in("play part.gcode -t\n");
        let said = bench.hear(5.0);
        assert!(said.contains(told) && said.contains("was not carried out"), "{line}: {said}");
        assert!(bench.say("M114.1").contains("X:20.0000 Y:20.0000"), "{line}");
        assert!(bench.say("M105").starts_with("ok"), "{line}");
        bench.type_in("abort\n");
        bench.hear(1.0);
        let said = bench.say("check part.gcode");
        assert!(said.contains(told), "{line}: {said}");
    }
}

#[test]
fn a_word_that_changes_nothing_is_counted() {
    let file = "; gcode_flavor = reprapfirmware\nG1 X20 F6000 H0\nG1 X30 Q1\nG1 X40 Q1\nM400 Q2\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", file).start();
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear_until("not carried out", 20.0);
    assert!(said.contains("// NOTE not carried out: G1 H 1x, G1 Q 2x, M400 Q 1x\n"), "{said}");
    assert!(bench.say("M114.1").contains("X:40.0000"));
    let said = bench.say("check part.gcode");
    assert!(said.contains("G1 takes no Q: the part is the same without"), "{said}");
}

#[test]
fn at_a_console_such_a_move_is_refused() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert!(bench.say("G1 R1 X10 F600").contains("G1 takes no R here"));
    assert!(bench.say("M114.1").contains("X:0.0000"));
    assert!(bench.say("G28.3 X0 Y0 Z0").contains("ok"));
    assert!(bench.say("M105 Q1").starts_with("ok"));
}
