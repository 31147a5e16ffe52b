//! Codes that change how moves are made (M220, M204, M205, M900...) act at their place in the file: on the
//! moves after them, never on those that are planned already.

use scenarios::{Bench, CARTESIAN, Plan};

const DIALECTS: [&str; 4] = ["", ";FLAVOR:Marlin\n", "; gcode_flavor = klipper\n", "; gcode_flavor = reprapfirmware\n"];

/// Returns the time that a file takes, s.
fn seconds_of(bench: &mut Bench, name: &str) -> f64 {
    let begun_s = bench.now_s();
    bench.type_in(&format!("play {name} -t\n"));
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(!said.contains("error"), "{said}");
    bench.now_s() - begun_s
}

#[test]
fn m220_in_a_file_scales_what_follows_it() {
    for flavour in DIALECTS {
        // 40 mm at 20, at 40 and at 20 mm/s.
        let file = format!("{flavour}G1 X40 F1200\nM220 B\nM220 S200\nG1 X80\nM220 R\nG1 X120\nM400\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        let said = bench.say("check part.gcode");
        assert!(said.contains("time: 00:00:05"), "{said}");
        let took_s = seconds_of(&mut bench, "part.gcode");
        assert!((5.0..5.8).contains(&took_s), "{flavour}: {took_s}");
        assert!(bench.say("M220").contains("100.00 %"));
    }
}

#[test]
fn m220_typed_beside_a_file_acts_at_once_and_the_file_does_not_lose_it() {
    let file = "G1 X150 F600\nM220 B\nM220 S200\nG1 X100\nM220 R\nG1 X0\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", file).start();
    let begun_s = bench.now_s();
    bench.type_in("play part.gcode -t\n");
    bench.hear(1.0);
    bench.type_in("M220 S500\n");
    bench.hear_until("Done printing file", 60.0);
    // 10 mm at 10 mm/s, then five times as fast: 140 mm at 50, 50 at 100, 100 at 50.
    let took_s = bench.now_s() - begun_s;
    assert!((6.0..7.2).contains(&took_s), "{took_s}");
}

#[test]
fn m220_that_a_host_sends_between_moves_leaves_those_before_it() {
    let mut bench = Plan::new(CARTESIAN).start();
    let begun_s = bench.now_s();
    for line in ["G1 X40 F1200", "M220 S200", "G1 X80", "M400"] {
        bench.type_in(&format!("{line}\n"));
    }
    bench.hear_until("ok\nok\nok\nok\n", 60.0);
    let took_s = bench.now_s() - begun_s;
    assert!((3.0..3.8).contains(&took_s), "{took_s}");
    assert!(bench.say("M220").contains("200.00 %"));
}

#[test]
fn limits_in_a_file_hold_for_what_follows_them() {
    // The first 20 mm are made without the limit that comes behind them, the others within it.
    for limit in ["M203 X10", "M204 S20", "M201 X20"] {
        let file = format!("G1 X60 F6000\n{limit}\nG1 X80\nM400\n");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        let took_s = seconds_of(&mut bench, "part.gcode");
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &format!("{limit}\nG1 X80 F6000\nM400\n")).start();
        let all_s = seconds_of(&mut bench, "part.gcode");
        assert!(took_s < 0.6 * all_s, "{limit}: {took_s} of {all_s}");
    }
}
