//! Consoles at a USB port: whoever is there comes and goes, and may read slowly.

use base::sessions::SessionId;
use base::sessions::{ConsoleKind, SessionProfile};
use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator;

/// The first session that comes and goes.
const PORT: SessionId = SessionId(2);
const GREETING: &str = "Welcome to Smoothie\nok\n";

fn start(plan: Plan) -> Bench {
    let mut bench = plan.visitor(SessionProfile { kind: ConsoleKind::Usb, ..SessionProfile::SERIAL }).start();
    bench.set_open(PORT, true);
    assert_eq!(bench.hear_on(PORT, 0.1), GREETING);
    bench
}

/// Returns the position to which the machine has been sent.
fn place(bench: &mut Bench) -> String {
    let said = bench.say("M114");
    said.split(" Y:").next().unwrap_or_default().to_owned()
}

#[test]
fn a_file_sent_with_cat_is_carried_out_to_its_end() {
    let mut bench = start(Plan::new(CARTESIAN));
    let file: String = (0..120).map(|_| "G1 X1 F6000\n").collect();
    bench.type_on(PORT, "G91\n");
    bench.type_on(PORT, &file);
    // The port is closed as soon as the last byte has been taken.
    bench.set_open(PORT, false);
    let _long_enough = bench.hear(5.0);
    assert_eq!(place(&mut bench), "ok C: X:120.0000");
    assert_eq!(bench.hear_on(PORT, 0.1), "", "nobody hears the answers");
}

#[test]
fn half_a_line_is_forgotten_and_whoever_comes_next_finds_nothing_of_it() {
    let mut bench = start(Plan::new(CARTESIAN));
    bench.type_on(PORT, "G91\nG1 X2 F6000\nG4 P500\nG1 X3\nG1 X");
    bench.set_open(PORT, false);
    bench.set_open(PORT, true);
    bench.type_on(PORT, "50\n");
    let said = bench.hear_on(PORT, 3.0);
    assert!(said.starts_with(GREETING), "{said:?}");
    assert!(said[GREETING.len()..].contains("50"), "his own line is read as he wrote it: {said:?}");
    assert_eq!(said.lines().filter(|line| line.starts_with("ok")).count(), 2, "{said:?}");
    assert_eq!(place(&mut bench), "ok C: X:5.0000");
}

#[test]
fn what_was_moved_by_hand_stops_with_the_cable() {
    let mut bench = start(Plan::new(CARTESIAN));
    let start = bench.carriage(Actuator::Alpha);
    bench.type_on(PORT, "$J -c X1 F3000\n");
    let _moving = bench.hear(1.0);
    assert!(bench.carriage(Actuator::Alpha) - start > 30.0, "it jogs");
    bench.set_open(PORT, false);
    let _braking = bench.hear(0.5);
    let stopped = bench.carriage(Actuator::Alpha);
    let _standing = bench.hear(1.0);
    assert_eq!(bench.carriage(Actuator::Alpha), stopped, "it stands");
}

#[test]
fn what_is_moved_by_hand_does_not_begin_when_the_hand_has_gone() {
    let mut bench = start(Plan::new(CARTESIAN));
    let start = bench.carriage(Actuator::Alpha);
    bench.type_on(PORT, "G91\nG1 X20 F1200\n$J -c X1 F3000\n$J -c X1 F3000\n");
    bench.set_open(PORT, false);
    bench.set_open(PORT, true);
    let _long = bench.hear(10.0);
    let way = bench.carriage(Actuator::Alpha) - start;
    assert!((19.9..20.1).contains(&way), "{way}");
    assert!(bench.hear_on(PORT, 0.1).starts_with(GREETING), "and whoever came is there");
}

#[test]
fn whoever_comes_next_does_not_get_the_answer_of_the_one_before() {
    let mut bench = start(Plan::new(CARTESIAN));
    bench.type_on(PORT, "G91\nG1 X20 F1200\nM400\n");
    let _begun = bench.hear(0.3);
    bench.set_open(PORT, false);
    let _gone = bench.hear_on(PORT, 0.1);
    bench.set_open(PORT, true);
    assert_eq!(bench.hear_on(PORT, 0.1), GREETING, "at once: that line may take long");
    bench.type_on(PORT, "M114.1\n");
    let said = bench.hear_on(PORT, 3.0);
    assert!(said.starts_with("ok ") && said.lines().count() == 1, "the answer to M400 is not his: {said}");
}

/// A computer that sleeps while it sends a file, and goes on when it wakes.
#[test]
fn whoever_comes_back_in_the_middle_of_a_file_moves_nothing() {
    for is_seen in [true, false] {
        let mut bench = start(Plan::new(CARTESIAN));
        bench.type_on(PORT, "G91\nM28 part.g\n");
        let _open = bench.hear_on(PORT, 0.2);
        bench.type_on(PORT, &("G1 X1 F6000\n".repeat(50) + "G1 X"));
        bench.set_open(PORT, false);
        if is_seen {
            let _looked = bench.hear(0.2);
        }
        bench.come_back(PORT);
        bench.try_type_on(PORT, &("5\n".to_owned() + &"G1 X1 F6000\n".repeat(50)));
        let said = bench.hear_on(PORT, 1.0);
        assert!(said.starts_with("Error: the file that was being sent is not kept") && !said.contains("ok"), "{said}");
        assert!(!bench.try_type_on(PORT, "G1 X1 F6000\nM29\nG1 X1\n"), "nothing more is taken");
        assert_eq!(bench.hear_on(PORT, 1.0), "");
        assert_eq!(place(&mut bench), "ok C: X:0.0000");
        assert_eq!(bench.read_card("part.g"), None);
        bench.set_open(PORT, false);
        bench.set_open(PORT, true);
        assert_eq!(bench.hear_on(PORT, 0.1), GREETING);
        assert_eq!(bench.say_on(PORT, "G1 X2 F6000"), "ok\n");
        let _there = bench.hear(1.0);
        assert_eq!(place(&mut bench), "ok C: X:2.0000");
    }
}

/// A request is dropped when its session goes before the request's turn.
#[test]
fn a_file_that_nobody_is_there_to_send_takes_nothing_of_the_next_one() {
    for (command, kept) in [("M28 part.g", true), ("upload part.g", false), ("dl part.g 500", false), ("ry", false)] {
        let mut bench = start(Plan::new(CARTESIAN));
        bench.type_on(PORT, &format!("G91\nG1 X20 F1200\nM400\n{command}\nG1 X5\nG1 X5\n"));
        bench.set_open(PORT, false);
        let _gone = bench.hear_on(PORT, 0.1);
        bench.set_open(PORT, true);
        bench.type_on(PORT, "G1 X1 F6000\n");
        assert_eq!(bench.hear_on(PORT, 5.0), GREETING.to_owned() + "ok\n", "{command}");
        assert_eq!(place(&mut bench), "ok C: X:21.0000", "{command}");
        assert_eq!(bench.read_card("part.g"), None, "{command}: it never ended");
        if kept {
            // All of it was there.
            bench.type_on(PORT, "G1 X5 F1200\nM400\nM28 part.g\nG1 X5\nM29\nG1 X2 F6000\n");
            bench.set_open(PORT, false);
            let _done = bench.hear(3.0);
            assert_eq!(bench.read_card("part.g").as_deref(), Some("G1 X5\n"));
            assert_eq!(place(&mut bench), "ok C: X:28.0000");
        }
    }
}

#[test]
fn a_copy_that_was_asked_for_is_made_though_nobody_waits_for_it() {
    let text = "G1 X1\n".repeat(3_000);
    let mut bench = start(Plan::new(CARTESIAN).file("a.g", &text));
    bench.type_on(PORT, "cp a.g b.g\n");
    bench.set_open(PORT, false);
    let _copied = bench.hear(3.0);
    assert_eq!(bench.read_card("b.g"), Some(text));
}

#[test]
fn a_computer_that_does_not_read_holds_its_own_lines_alone() {
    let mut bench = start(Plan::new(CARTESIAN));
    bench.set_room(PORT, 0);
    bench.type_on(PORT, &("help\n".repeat(20) + "G91\nG1 X7 F6000\n"));
    let _long = bench.hear(10.0);
    assert_eq!(place(&mut bench), "ok C: X:0.0000", "its lines wait for it");
    assert_eq!(bench.say("G91"), "ok\n", "nobody else does");
    bench.set_room(PORT, usize::MAX);
    let said = bench.hear_on(PORT, 3.0);
    assert!(said.matches("$SLP").count() == 20 && said.ends_with("ok\nok\nok\n"), "{said}");
    assert_eq!(place(&mut bench), "ok C: X:7.0000");
}

#[test]
fn whoever_comes_is_told_that_the_configuration_has_errors() {
    let plan = Plan::new(CARTESIAN).set("[system] step_pulse_us = lots");
    let mut bench = plan.visitor(SessionProfile { kind: ConsoleKind::Usb, ..SessionProfile::SERIAL }).start();
    bench.set_open(PORT, true);
    let said = bench.hear_on(PORT, 0.1);
    assert_eq!(said, format!("{GREETING}There was an error detected in the config.ini\nPlease check the uart log\n"));
}
