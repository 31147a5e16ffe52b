//! Functions for mill files besides moves: outputs and inputs by number, overrides, modes, logs.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

/// A machine with an output that is on or off, one that takes a value, and an input, all with numbers.
fn with_switches() -> Plan {
    Plan::new(CARTESIAN).adding(
        "\n[switch]\nclamp.enable = true\nclamp.output_pin = PH6\nclamp.output_type = digital\nclamp.io_number = 3\n\
         air.enable = true\nair.output_pin = PH7\nair.output_type = sigmadeltapwm\nair.io_number = 1\n\
         lid.enable = true\nlid.input_pin = PB7^\nlid.io_number = 3\n",
    )
}

fn press(bench: &mut Bench, name: &str, pressed: bool) {
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, name, pressed)).expect("a button of this machine");
}

#[track_caller]
fn is(bench: &mut Bench, switch: &str, on: bool) {
    assert_eq!(bench.say(&format!("switch {switch}")), format!("switch {switch} is {}\nok\n", u8::from(on)));
}

#[test]
fn outputs_have_numbers() {
    let mut bench = with_switches().start();
    for (line, switch, on) in [
        ("M62 P3", "clamp", true),
        ("M63 P3", "clamp", false),
        ("M64 P3", "clamp", true),
        ("M65 P3", "clamp", false),
        ("M67 E1 Q100", "air", true),
        ("M67 E1 Q0", "air", false),
        ("M68 E1 Q100", "air", true),
        ("M65 P1", "air", false),
    ] {
        assert_eq!(bench.say(line), "ok\n", "{line}");
        is(&mut bench, switch, on);
    }
    let refused = bench.say("M62 P7");
    assert!(refused.starts_with("error:no output has io_number = 7 in [switch]"), "{refused}");
    let refused = bench.say("M67 E3 Q5");
    assert!(refused.starts_with("error:no output that takes a value has io_number = 3"), "{refused}");
}

#[test]
fn what_is_immediate_waits_for_the_end_of_the_path() {
    let mut bench = with_switches().start();
    let begun = bench.carriage(Alpha);
    bench.run(&["G91", "G1 X20 F3000"]);
    assert_eq!(bench.say("M64 P3"), "ok\n");
    assert!((bench.carriage(Alpha) - begun - 20.0).abs() < 0.02, "{}", bench.carriage(Alpha) - begun);
    is(&mut bench, "clamp", true);
}

#[test]
fn a_program_waits_for_an_input() {
    let job = "G91\nM66 P3 L3 Q20\nG1 X1 F3000\n(PRINT, was #5399)\nM66 P3 L0\n(PRINT, is #5399)\n\
               M66 P3 L1 Q0.2\n(PRINT, missed #5399)\nM66 P3 L2 Q20\n(PRINT, fell to #5399)\n";
    let mut bench = with_switches().file("a.g", job).start();
    let begun = bench.carriage(Alpha);
    bench.type_in("M32 a.g\n");
    bench.hear(1.0);
    assert!((bench.carriage(Alpha) - begun).abs() < 0.02, "it does not wait");
    press(&mut bench, "lid", true);
    let heard = bench.hear_until("missed", 5.0);
    assert!(heard.contains("// was 1.000000\n") && heard.contains("// is 1.000000\n"), "{heard}");
    press(&mut bench, "lid", false);
    let heard = heard + &bench.hear_until("Done printing file", 5.0);
    assert!(heard.contains("missed -1.000000\n") && heard.contains("fell to 0.000000\n"), "{heard}");
    let refused = bench.say("M66 P1 L0");
    assert!(refused.starts_with("error:no input has io_number = 1"), "{refused}");
}

/// Seconds that a way takes.
fn duration(bench: &mut Bench, line: &str) -> f64 {
    let begun = bench.now_s();
    bench.run(&[line, "M400"]);
    bench.now_s() - begun
}

#[test]
fn a_program_says_whether_overrides_count() {
    let mut bench = with_switches().start();
    bench.run(&["G91", "G1 F600"]);
    let plain = duration(&mut bench, "G1 X10");
    bench.run(&["M220 S50"]);
    let slow = duration(&mut bench, "G1 X10");
    assert!(slow > 1.7 * plain, "{slow} s at half speed, {plain} s at full");
    bench.run(&["M50 P0"]);
    let ignored = duration(&mut bench, "G1 X10");
    assert!((ignored - plain).abs() < 0.1 * plain, "{ignored} s, not {plain}");
    // Overrides that the operator sets meanwhile count afterwards.
    bench.run(&["M220 S25", "M50 P1"]);
    let slower = duration(&mut bench, "G1 X10");
    assert!(slower > 3.0 * plain, "{slower} s at a quarter, {plain} s at full");
    // So it does after a halt.
    bench.run(&["M220 S100", "M50 P0"]);
    bench.run(&["M220 S50"]);
    bench.say("M112");
    bench.say("M999");
    bench.run(&["G91", "G1 F600"]);
    let slow_again = duration(&mut bench, "G1 X10");
    assert!(slow_again > 1.7 * plain, "{slow_again} s at half speed, {plain} s at full");
    bench.run(&["M220 S100"]);
    // The end of a program lets them count, and forgets them.
    bench.run(&["M50 P0", "M2", "G91"]);
    let plain_again = duration(&mut bench, "G1 X10 F600");
    assert!((plain_again - plain).abs() < 0.1 * plain, "{plain_again} s, not {plain}");
}

#[test]
fn modes_come_back_when_a_subroutine_ends() {
    let job = "G21\nG90\no1 sub\nM73\nG20\nG91\nM50 P0\nG1 X0.1 F100\no1 endsub\nG1 X0 F3000\no1 call\nG1 X10\n\
               (PRINT, #<_metric> #<_feed_override>)\n";
    let mut bench = with_switches().with("grbl_mode = false", "grbl_mode = true").file("a.g", job).start();
    let begun = bench.carriage(Alpha);
    bench.type_in("M32 a.g\n");
    let heard = bench.hear_until("Done printing file", 10.0);
    assert!(heard.contains("1.000000 1.000000"), "{heard}");
    assert!((bench.carriage(Alpha) - begun - 10.0).abs() < 0.02);
}

#[test]
fn a_program_writes_logs() {
    let job = "(LOGOPEN, a.txt)\n(LOG, one)\n#1 = 2.5\n(LOG, two #1)\n(LOGCLOSE)\n(LOG, nowhere)\n\
               (LOGAPPEND, a.txt)\n(LOG, three)\n";
    let mut bench = Plan::new(CARTESIAN).file("a.g", job).start();
    bench.type_in("M32 a.g\n");
    bench.hear_until("Done printing file", 10.0);
    assert_eq!(bench.read_card("a.txt").as_deref(), Some("one\ntwo 2.500000\nthree\n"));
    // More than a block.
    let job = "(LOGOPEN, long.txt)\n#1 = 0\no1 while [#1 LT 100]\n#1 = [#1 + 1]\n(LOG, line #1)\no1 endwhile\n";
    let mut bench = Plan::new(CARTESIAN).file("a.g", job).start();
    bench.type_in("M32 a.g\n");
    bench.hear_until("Done printing file", 10.0);
    let written: String = (1..=100).map(|line| format!("line {line}.000000\n")).collect();
    assert_eq!(bench.read_card("long.txt"), Some(written));
}

#[test]
fn a_log_that_cannot_be_written_stops_the_program_by_name() {
    for (line, reason) in [
        ("(LOGOPEN, config.ini)", "config.ini: this file is the machine's own"),
        ("(LOGOPEN, nowhere/a.txt)", "nowhere/a.txt: "),
        ("(PROBEOPEN new-parameters.var)", "new-parameters.var: this file is the machine's own"),
        ("(LOGOPEN, a.g)", "a.g: "),
    ] {
        let mut bench = Plan::new(CARTESIAN).file("a.g", &format!("G91\n{line}\nG1 X5 F3000\n")).start();
        let begun = bench.carriage(Alpha);
        bench.type_in("M32 a.g\n");
        let heard = bench.hear_until("paused", 10.0);
        assert!(heard.contains(reason), "{line}: {heard}");
        bench.hear(0.5);
        assert!((bench.carriage(Alpha) - begun).abs() < 0.02, "{line}: it goes on");
    }
}

#[test]
fn contacts_are_written_down() {
    let job = "(PROBEOPEN points.txt)\nG38.2 Z-10 F300\nG0 Z5\nG91\nG0 X1\nG90\nG38.2 Z-10 F300\n(PROBECLOSE)\n";
    let mut bench = Plan::new(CARTESIAN)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .with("grbl_mode = false", "grbl_mode = true")
        .file("a.g", job)
        .start();
    bench.run(&["$H", "G1 X50 Y60 Z20 F6000", "G4 P0"]);
    bench.type_in("M32 a.g\n");
    bench.hear_until("Done printing file", 30.0);
    let written = bench.read_card("points.txt").unwrap();
    let points: Vec<Vec<f64>> =
        written.lines().map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect()).collect();
    assert_eq!(points.len(), 2, "{written}");
    assert!(points.iter().all(|point| point.len() == 9), "{written}");
    assert!((points[1][0] - points[0][0] - 1.0).abs() < 0.01, "{written}");
}
