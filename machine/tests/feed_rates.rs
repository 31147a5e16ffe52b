//! Feed rates of zero and below, and files that are sure to halt.

use scenarios::{CARTESIAN, Plan};

#[test]
fn marlin_and_reprapfirmware_keep_the_rate_that_they_have() {
    for flavour in [";FLAVOR:Marlin\n", "; gcode_flavor = reprapfirmware\n"] {
        for line in ["G1 X20 F0", "G0 F0 X20", "G1 F-100 X20"] {
            let file = format!("{flavour}G1 X10 F3000\nG0 X11 F3000\n{line}\nG1 X30\nM400\n");
            let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
            bench.type_in("play part.gcode -t\n");
            let said = bench.hear_until("Done printing file", 20.0);
            assert!(!said.contains("rror") && !said.contains("WARNING"), "{line}: {said}");
            assert!(bench.say("M114.1").contains("X:30.0000"), "{line}");
        }
    }
}

#[test]
fn klippers_file_waits_at_a_rate_of_zero() {
    let file = "; gcode_flavor = klipper\nG1 X10 F3000\nG1 X20 F0\nG1 X30\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", file).start();
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear(5.0);
    assert!(said.contains("G1: F must be above 0, column 8") && !said.contains("Halt"), "{said}");
    assert!(bench.say("M114.1").contains("X:10.0000"));
}

#[test]
fn a_file_that_is_sure_to_halt_is_not_begun() {
    for line in ["G1 X20 F0", "G0 F0 X20 Y5", "G1 X20 F-100"] {
        let file = format!("M104 S50\nG1 X10 F3000\n{line}\nG1 X30\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        bench.type_in("play part.gcode -t\n");
        let said = bench.hear(5.0);
        assert!(said.contains("the job was not begun: a line of it would halt the machine"), "{line}: {said}");
        assert!(said.contains("line 3: stops: ") && said.contains("(correct the line)"), "{line}: {said}");
        assert!(bench.say("M114.1").contains("X:0.0000"), "{line}");
        assert!(bench.say("M105").starts_with("ok"), "{line}");
    }
}

/// Nothing stands still for ever: a factor below a tenth is a tenth.
#[test]
fn a_speed_factor_of_zero_is_a_tenth() {
    for flavour in ["", ";FLAVOR:Marlin\n", "; gcode_flavor = reprapfirmware\n", "; gcode_flavor = klipper\n"] {
        for line in ["M220 S0", "M220 S-50", "M220 S3"] {
            let file = format!("{flavour}{line}\nG1 X10 F3000\nM400\n");
            let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
            let begun_s = bench.now_s();
            bench.type_in("play part.gcode -t\n");
            let said = bench.hear_until("Done printing file", 60.0);
            assert!(!said.contains("rror"), "{flavour}{line}: {said}");
            // 10 mm at 5 mm/s.
            let took_s = bench.now_s() - begun_s;
            assert!((2.0..2.6).contains(&took_s), "{flavour}{line}: {took_s}");
            assert!(bench.say("M220").contains("10.00 %"), "{line}");
        }
    }
}
