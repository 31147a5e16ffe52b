//! Functions for hosts (OctoPrint, Pronterface, senders for Marlin): commands that act at once (M108, M410,
//! `abort`), M115's capabilities, and resends of damaged lines.

use base::sessions::SessionId;
use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

/// The console beside the one that sends.
const OTHER: SessionId = SessionId(1);

fn numbered(line: &str) -> String {
    format!("{line}*{}", line.bytes().fold(0, |sum, byte| sum ^ byte))
}

/// Returns the hot end's temperature in an answer or report.
fn celsius(said: &str) -> f64 {
    let number = said.split("T:").nth(1).and_then(|text| text.split(' ').next()).expect("a temperature");
    number.parse().expect("a number")
}

/// Returns the travel of X since power-on.
fn x(bench: &Bench) -> f64 {
    bench.carriage(Alpha) - 30.0
}

/// A job is played, and is in its line 2 for two seconds.
fn in_line_2(before: &str, line: &str) -> Bench {
    let text = format!("{before}\n{line}\nG1 X60 F6000\nM400\n");
    let mut bench = Plan::new(CARTESIAN).file("job.g", &text).start();
    assert!(bench.say("play /sd/job.g").contains("Playing"));
    bench.hear(2.0);
    bench
}

/// Returns the hot end's target, as M105 reports it.
fn target(bench: &mut Bench) -> String {
    let said = bench.say("M105");
    said.split_whitespace().skip_while(|word| !word.starts_with("T:")).nth(1).unwrap_or(&said).to_owned()
}

// --- what acts at once ---

#[test]
fn abort_ends_whatever_the_job_waits_for() {
    for abort in ["abort", "M524", "CANCEL_PRINT"] {
        for line in ["M109 S200", "M190 S60", "M116", "G4 S300", "G28", "M400", "G1 X190 F60\nM400\nG1 X10\nM109 S60"] {
            let mut bench = in_line_2("M104 S200\nG1 X150 F120", line);
            let said = bench.say_on(OTHER, abort);
            assert!(said.contains("Please wait for abort to complete"), "{abort} in {line}: {said}");
            let place = bench.carriage(Alpha);
            bench.hear(1.0);
            assert!(bench.status().starts_with("<Idle"), "{line}: {}", bench.status());
            assert_eq!(bench.carriage(Alpha), place, "{line}: it stands");
            assert_eq!(target(&mut bench), "/200.0", "{line}: heaters are left alone");
            assert!(bench.say("progress").contains("Not currently playing"));
            // The machine still knows its position.
            bench.run(&["G91", "G1 X5 F6000", "M400"]);
            assert!((bench.carriage(Alpha) - place - 5.0).abs() < 0.02, "{line}: {}", bench.carriage(Alpha) - place);
        }
    }
}

#[test]
fn abort_ends_a_script_of_the_job_and_a_resumption_too() {
    let mut bench = Plan::new(CARTESIAN)
        .file("job.g", "G1 X5 F6000\nG1 X9\n")
        .adding("\n[player]\nbefore_job_gcode = G4 S300 | G1 X90\n")
        .start();
    bench.say("play /sd/job.g");
    bench.hear(2.0);
    assert!(bench.say("abort").contains("Please wait for abort to complete"));
    bench.hear(1.0);
    assert!((bench.carriage(Alpha) - 30.0).abs() < 0.02, "{}", bench.carriage(Alpha));

    let mut bench = Plan::new(CARTESIAN).file("job.g", "M104 S200\nG4 S300\n").start();
    bench.say("play /sd/job.g");
    bench.hear(1.0);
    bench.type_in("suspend\n");
    bench.hear_until("// Print Suspended", 5.0);
    bench.type_in("resume\n");
    bench.hear_until("// Waiting for heaters", 1.0);
    assert!(bench.say_on(OTHER, "abort").contains("Suspend cleared\n"));
    let said = bench.hear(0.5);
    assert!(said.contains("// NOTE ended\nok\n"), "whoever resumed is answered: {said}");
    assert!(bench.status().starts_with("<Idle"), "{}", bench.status());
}

#[test]
fn homing_that_was_ended_leaves_nothing_homed() {
    let mut bench = in_line_2("G28", "G1 X190 F12000\nG28");
    while bench.carriage(Alpha) < 180.0 || !bench.status().starts_with("<Home") {
        bench.hear(0.1);
    }
    bench.say("abort");
    assert!(bench.say("G28.6").contains("X:0"), "{}", bench.say("G28.6"));
    bench.run(&["G28"]);
    assert!(bench.say("G28.6").contains("X:1 Y:1 Z:1"));
}

#[test]
fn a_pause_leaves_a_wait_which_begins_anew_when_the_job_goes_on() {
    for (pause, told) in [
        ("suspend", "// Print Suspended"),
        ("pause", "// Print Suspended"),
        ("M25", "ok\n"),
        ("PAUSE", "// Print Suspended"),
    ] {
        let mut bench = in_line_2("M117 x", "M109 S120 ; hot");
        bench.type_in(&format!("{pause}\n"));
        bench.hear_until(told, 1.5);
        // The suspended job leaves the console free for lines.
        bench.run(&["G91", "G1 X3 F6000", "M400", "G90"]);
        assert!((x(&bench) - 3.0).abs() < 0.02, "{pause}");
        bench.hear(0.5);
        bench.type_in(if pause == "M25" { "M24\n" } else { "resume\n" });
        bench.hear(2.0);
        assert!(x(&bench) < 4.0, "{pause}: it went on while it was cold");
        while x(&bench) < 5.0 {
            bench.hear(0.5);
        }
        let hot = bench.say("M105");
        assert!(celsius(&hot) > 115.0, "{pause}: {hot}");
    }
}

#[test]
fn a_pause_leaves_a_dwell_but_no_line_that_does_more() {
    let mut bench = in_line_2("M117 x", "G4 S20");
    bench.type_in("suspend\n");
    bench.hear_until("// Print Suspended", 1.0);
    bench.say("resume");
    bench.hear(19.0);
    assert!(x(&bench) < 1.0, "the dwell begins anew");
    bench.hear(3.0);
    assert!((x(&bench) - 60.0).abs() < 0.02);

    let mut bench = in_line_2("M117 x", "G91 G4 S5 G1 X10 F6000 G90");
    bench.type_in("suspend\n");
    assert!(!bench.hear(1.0).contains("Print Suspended"), "half of it is done");
    bench.hear_until("// Print Suspended", 6.0);
    assert!((x(&bench) - 10.0).abs() < 0.02, "{}", x(&bench));
}

#[test]
fn m26_begins_the_job_anew_while_it_waits() {
    let mut bench = in_line_2("G91\nG1 X2 F6000\nG90", "M109 S200");
    assert_eq!(bench.say("M26"), "ok\n");
    bench.hear(2.0);
    assert!((x(&bench) - 4.0).abs() < 0.02, "the first line was made twice: {}", x(&bench));
}

#[test]
fn m108_ends_a_wait_of_the_same_stream() {
    for wait in ["M109 S200", "M190 S100", "M116"] {
        let mut bench = Plan::new(CARTESIAN).start();
        bench.run(&["M104 S200"]);
        bench.type_in(&format!("{wait}\nM117 x\n"));
        bench.hear(1.0);
        bench.type_in("M108\nM104 S0\nM140 S0\n");
        let said = bench.hear(2.0);
        assert!(said.contains(" is not waited for any more (M108)\n"), "{wait}: {said}");
        assert_eq!(said.matches("ok").count(), 5, "{wait}: {said}");
    }
    // M108 ends the waits of a file and those for the operator, too; a hold is no such wait.
    for wait in ["M109 S200", "M0", "M0 S100"] {
        let mut bench = in_line_2("M117 x", wait);
        assert!(x(&bench) < 1.0);
        bench.say("M108");
        bench.hear(3.0);
        assert!((x(&bench) - 60.0).abs() < 0.02, "{wait}: {}", x(&bench));
    }
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("M0\n");
    bench.hear(1.0);
    bench.type_in("M108\n");
    assert_eq!(bench.hear(0.2).matches("ok\n").count(), 2);
    bench.type_in("G1 X90 F600\n");
    bench.hear(1.0);
    bench.type_in("!M108\n");
    bench.hear(1.0);
    assert!(bench.status().starts_with("<Hold"), "{}", bench.status());
}

#[test]
fn m410_stops_the_motors_along_their_path_and_they_know_where_they_are() {
    for line in ["M400", "G28 X", "G4 S100", "M109 S200", ""] {
        let mut bench = Plan::new(CARTESIAN).start();
        bench.run(&["G28", "G1 X190 F3000", "G1 X100", "G1 X150"]);
        bench.type_in(&format!("{line}\n"));
        bench.hear(1.0);
        bench.type_in("M410\n");
        let said = bench.hear(0.5);
        assert!(said.ends_with("ok\n"), "{line}: {said}");
        assert!(bench.status().starts_with("<Idle"), "{line}: {}", bench.status());
        let place = bench.carriage(Alpha);
        assert!((2.0..90.0).contains(&place), "{line}: it stopped at {place}");
        bench.hear(2.0);
        assert_eq!(bench.carriage(Alpha), place);
        bench.run(&["G90", "G1 X5 F6000", "M400"]);
        assert!((bench.carriage(Alpha) - 5.0).abs() < 0.02, "{line}: {}", bench.carriage(Alpha));
    }
}

#[test]
fn m410_pauses_a_job_and_m24_goes_on_with_the_next_line() {
    let mut bench = Plan::new(CARTESIAN).file("job.g", "G1 X100 F600\nM400\nG1 X120 F6000\n").start();
    bench.say("play /sd/job.g");
    bench.hear(2.0);
    bench.type_in("M410\n");
    let said = bench.hear(1.0);
    assert!(said.contains("// NOTE stopped (M410): M24 goes on with the next line"), "{said}");
    assert!(x(&bench) < 30.0 && bench.status().starts_with("<Idle"), "{}", x(&bench));
    bench.say("M24");
    bench.hear(5.0);
    assert!((x(&bench) - 120.0).abs() < 0.02, "{}", x(&bench));
}

#[test]
fn m410_and_abort_end_what_is_held() {
    for (stops, state) in [("M410", "<Hold"), ("abort", "<Hold")] {
        let mut bench = in_line_2("G1 X100 F600", "M400");
        bench.type_in("!");
        bench.hear(1.0);
        let place = x(&bench);
        assert!(bench.say(stops).ends_with("ok\n"), "{stops}");
        bench.hear(0.5);
        assert!(bench.status().starts_with(state), "{stops}: {}", bench.status());
        bench.type_in("~");
        bench.hear(2.0);
        assert!((x(&bench) - place).abs() < 0.02 && bench.status().starts_with("<Idle"), "{stops}: {}", bench.status());
    }
}

// --- damaged lines ---

#[test]
fn a_line_that_was_damaged_on_its_way_is_asked_for_again() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.ask("N1 G91*7x"), "rs N1\n", "the checksum has junk behind it");
    assert_eq!(bench.ask(&numbered("N0 M110 N0")), "ok\n");
    assert_eq!(bench.ask(&numbered("N1 G91")), "ok\n");
    for damaged in ["N2 G1 X5 F6000", "N2 G1 X5 F6000*", "N2 G1 X5 F6000*300", "N2", "N*4", "N2 G1 X5 F6000*41 9"] {
        assert_eq!(bench.ask(damaged), "rs N2\n", "{damaged}");
    }
    // Two lines that have run together.
    assert_eq!(bench.ask(&"N2 G1 X5 F6000".repeat(30)), "rs N2\n");
    assert_eq!(bench.ask(&numbered("N2 G1 X5 F6000")), "ok\n");
    bench.run(&["M400"]);
    assert!((bench.carriage(Alpha) - 35.0).abs() < 0.02, "it was made once: {}", bench.carriage(Alpha));
    // A malformed line that arrived intact is refused, not asked for again: sent again it would be no better.
    let said = bench.ask(&numbered("N3 G28 X0 Y0 :"));
    assert!(said.starts_with("error:") && said.ends_with(" - N3 G28 X0 Y0 :\n") && said.lines().count() == 1, "{said}");
    assert_eq!(bench.ask(&numbered("N4 G90")), "ok\n");
    assert!(bench.ask("G28 X0 Y0 :").ends_with("ok\n"), "what is typed in between is answered as before");
}

#[test]
fn m115_says_what_hosts_may_count_on() {
    let mut bench = Plan::new(CARTESIAN).start();
    let said = bench.say("M115");
    for name in ["AUTOREPORT_TEMP", "AUTOREPORT_SD_STATUS", "EMERGENCY_PARSER", "SDCARD", "HOST_ACTION_COMMANDS"] {
        assert!(said.contains(&format!("\nCap:{name}:1\n")), "{name}: {said}");
    }
    assert!(said.contains("\nCap:PROMPT_SUPPORT:0\nok\n") && said.contains("\nCap:Z_PROBE:0\n"), "{said}");
    let mut bench = Plan::new(CARTESIAN).set("[general] grbl_mode = true").start();
    assert!(!bench.say("M115").contains("Cap:"));
}

#[test]
fn hosts_are_told_when_a_job_pauses_goes_on_and_is_cancelled() {
    let job = "G1 X5 F600\nG4 S1\nG1 X&\nG4 S1\nM0\nG1 X1\nG1 X2\n";
    let mut bench = Plan::new(CARTESIAN).file("job.g", job).start();
    bench.say("play /sd/job.g");
    bench.hear(0.3);
    // Texts that OctoPrint and Pronterface read.
    bench.type_on(OTHER, "M25\n");
    assert!(bench.hear(3.0).contains("// action:paused\n"));
    bench.type_on(OTHER, "M24\n");
    let said = bench.hear(3.0);
    assert!(said.contains("// action:resumed\n"), "{said}");
    assert!(said.contains("error:paused, line 3 of") && said.ends_with("// action:paused\n"), "{said}");
    bench.type_in("M24\n");
    assert!(bench.hear(3.0).ends_with("// action:paused\n"), "M0");
    bench.type_in("M108\n");
    assert!(bench.hear(0.1).contains("// action:resumed\n"));
    bench.type_in("suspend\n");
    assert!(bench.hear(2.0).contains("// action:pause"));
    bench.type_on(OTHER, "abort\n");
    assert!(bench.hear(1.0).contains("// action:cancel\n"));
    assert!(!bench.say("abort").contains("action:"), "there is no job");
    // Without a job on the card, the host itself may be printing and must pause.
    bench.type_in("suspend\n");
    assert!(bench.hear(1.0).contains("// action:pause\n"));
    bench.type_in("resume\n");
    assert!(bench.hear(1.0).contains("// action:resume\n"));
}

// --- what hosts ask ---

#[test]
fn m114_is_answered_as_the_firmware_of_the_dialect_does() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G1 X10 Y5 E2 F3000", "M400"]);
    assert_eq!(bench.say("M114"), "ok C: X:10.0000 Y:5.0000 Z:0.0000 E:2.0000 \n");
    for (dialect, said) in [
        ("marlin", "X:10.00 Y:5.00 Z:0.00 E:2.00 Count X:800 Y:400 Z:0\nok\n"),
        ("reprapfirmware", "X:10.00 Y:5.00 Z:0.00 E:2.00 Count 800 400 0\nok\n"),
        ("klipper", "X:10.00 Y:5.00 Z:0.00 E:2.00\nok\n"),
    ] {
        bench.say(&format!("dialect {dialect}"));
        assert_eq!(bench.say("M114"), said, "{dialect}");
    }
    bench.say("dialect marlin");
    bench.run(&["G92 X1"]);
    let said = bench.say("M114 D");
    assert!(
        said.starts_with("X:1.00 ") && said.contains("\nLogical: X:1.000 Y:5.000 Z:0.000\nRaw: X:10.000 "),
        "{said}"
    );
    bench.type_in("G1 X100 F600\n");
    bench.hear(2.0);
    let [planned, live] = ["M114", "M114 R"].map(|line| {
        let said = bench.say(line);
        said.split([':', ' ']).nth(1).expect("X").parse::<f64>().expect("a number")
    });
    assert!(planned == 100.0 && (5.0..40.0).contains(&live), "{planned} {live}");
}

#[test]
fn help_has_a_line_for_each_command() {
    let mut bench = Plan::new(CARTESIAN).start();
    let mut said = bench.ask("help");
    while !said.ends_with("\nok\n") {
        said += &bench.hear(0.1);
    }
    assert!(said.contains("\nversion  - firmware, board and clock\n"), "{said}");
    assert!(said.lines().all(|line| line == "ok" || line.contains(" - ")), "{said}");
}

#[test]
fn m105_in_an_upload_is_a_line_of_the_file_and_is_answered() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.say("M28 up.g");
    let said = bench.say("M105");
    assert!(
        said.starts_with("ok B:") && said.contains(" T:") && said.ends_with('\n') && said.matches("ok").count() == 1,
        "{said}"
    );
    assert_eq!(bench.ask(&numbered("N0 M110 N0")), "ok\n");
    assert_eq!(bench.ask(&numbered("N1 G1 X5")), "ok\n");
    assert!(bench.ask(&numbered("N2 M105")).starts_with("ok B:"));
    assert_eq!(bench.ask("N3 G1 X6*1"), "rs N3\n");
    assert_eq!(bench.ask(&numbered("N3 G1 X6")), "ok\n");
    assert!(bench.ask(&numbered("N4 M29")).ends_with("ok\n"));
    let file = bench.read_card("up.g").expect("it is there");
    assert_eq!(file.lines().count(), 5, "{file}");
    bench.say("play up.g");
    bench.hear(3.0);
    assert!((x(&bench) - 6.0).abs() < 0.02, "{}", x(&bench));
}
