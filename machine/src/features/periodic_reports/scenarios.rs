//! Reports that sessions get without asking: M155, M27 S and `busy`.

use base::sessions::SessionId;
use scenarios::{CARTESIAN, Plan};

/// The console beside the one that sends.
const OTHER: SessionId = SessionId(1);

#[test]
fn temperatures_are_said_by_themselves_to_whoever_asks_and_not_in_an_upload() {
    let mut bench = Plan::new(CARTESIAN).start();
    let _greeting = bench.hear_on(OTHER, 0.1);
    assert_eq!(bench.say("M155 S2"), "ok\n");
    let said = bench.hear(6.5);
    assert_eq!(said.matches("T:").count(), 3, "{said}");
    assert!(!said.contains("ok") && said.lines().all(|line| line.starts_with("B:") && line.contains(" T:")), "{said}");
    assert_eq!(bench.hear_on(OTHER, 0.1), "", "it did not ask");
    // Reports come while a line is in work, too.
    bench.type_in("G4 S5\n");
    assert_eq!(bench.hear(4.1).matches("T:").count(), 2);
    bench.hear(2.0);
    bench.say("M28 up.g");
    assert!(!bench.hear(5.0).contains("T:"));
    bench.say("M29");
    assert!(bench.hear(2.5).contains("T:"));
    bench.run(&["M155 S0"]);
    assert_eq!(bench.hear(5.0), "");
    assert!(bench.say("M155 S99").starts_with("error:"));
}

#[test]
fn how_far_the_file_is_is_said_by_itself() {
    let mut bench = Plan::new(CARTESIAN).file("job.g", "G1 X1 F600\nG4 S9\n").start();
    assert_eq!(bench.say("M27 S1"), "ok\n");
    bench.say("play /sd/job.g");
    let said = bench.hear(3.2);
    assert_eq!(said.matches("SD printing byte ").count(), 3, "{said}");
    bench.run(&["M27 S0"]);
    assert_eq!(bench.hear(3.0), "");
    assert!(bench.say("M27").contains("SD printing byte "), "asked, it says so");
}

#[test]
fn that_a_line_takes_its_time_is_said_in_marlins_dialect_or_to_whoever_asks() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("G4 S5\n");
    assert_eq!(bench.hear(5.5), "ok\n", "Smoothieware says nothing");
    assert_eq!(bench.say("M113"), "M113 S0\nok\n");
    bench.say("dialect marlin");
    assert_eq!(bench.say("M113"), "M113 S2\nok\n");
    bench.type_in("G4 S5\n");
    assert_eq!(bench.hear(5.5), "echo:busy: processing\necho:busy: processing\nok\n");
    bench.run(&["M113 S1", "dialect smoothie"][..1]);
    bench.type_in("M0\n");
    let said = bench.hear(2.5);
    assert!(said.ends_with("echo:busy: paused for user\necho:busy: paused for user\n"), "{said}");
    bench.type_in("~");
    bench.hear(0.5);
    bench.run(&["M113 S0"]);
    bench.type_in("G4 S5\n");
    assert_eq!(bench.hear(5.5), "ok\n");
}
