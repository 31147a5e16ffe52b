//! Statistics of jobs and heaters: sums that outlive a reset.

use scenarios::{CARTESIAN, Plan};

use crate::job_control::layers;

#[test]
fn what_jobs_took_outlives_a_reset() {
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).start();
    bench.type_in("play part.gcode -t\n");
    let said = bench.hear_until("Done printing file", 60.0);
    // Ten ways of 10 mm a layer, the first of which is elsewhere, and a way to X40 and back.
    assert!(said.contains("of it still)") && said.contains("0.015 m of filament"), "{said}");
    bench.hear(0.5);
    let told = bench.say("M78");
    assert!(told.contains("jobs: 1 done, 0 broken off"), "{told}");
    bench.say("play part.gcode");
    bench.hear(2.0);
    bench.type_in("abort\n");
    bench.hear(3.0);
    let told = bench.say("M78");
    assert!(told.contains("jobs: 1 done, 1 broken off"), "{told}");
    let kept = bench.read_card("statistics.txt").expect("statistics on the card");
    let mut later = Plan::new(CARTESIAN).file("statistics.txt", &kept).start();
    assert!(later.say("M78").contains("jobs: 1 done, 1 broken off"));
    later.say("M78 S78");
    assert!(later.say("M78").contains("jobs: 0 done, 0 broken off"));
    let mut broken = Plan::new(CARTESIAN).file("statistics.txt", "jobs_done = 5\nnonsense\n").start();
    assert!(broken.greeting().contains("WARNING: /sd/statistics.txt: 1 lines were left out"));
    assert!(broken.say("M78").contains("jobs: 5 done"));
}

/// A heater of 40 W at full power for 20 s is 0.2 Wh; what the bed did stays, though it is not described.
#[test]
fn what_heaters_did_outlives_a_reset() {
    let kept = "heater_hotend_on_s = 7200\nheater_hotend_full_s = 3600\nheater_bed_on_s = 60\n";
    let mut bench = Plan::new(CARTESIAN).file("statistics.txt", kept).start();
    assert_eq!(bench.greeting().matches("WARNING").count(), 0, "{}", bench.greeting());
    let told = bench.say("M78");
    let expected =
        "heater hotend: on for 2:00:00, as much as 1:00:00 at full power, 0.040 kWh with a heater_power of 40 W\n";
    assert!(told.contains(expected), "{told}");
    bench.say("M104 S150");
    bench.hear(20.5);
    bench.say("M104 S0");
    bench.hear(2.0);
    let saved = bench.read_card("statistics.txt").expect("statistics on the card");
    let figure = |key: &str| -> f64 {
        let line = saved.lines().find_map(|line| line.strip_prefix(key)).expect(key);
        line.trim_start_matches(" = ").parse().expect("a figure")
    };
    assert!((7_220.0..7_223.0).contains(&figure("heater_hotend_on_s")), "{saved}");
    assert!((3_610.0..3_621.0).contains(&figure("heater_hotend_full_s")), "{saved}");
    assert_eq!(figure("heater_bed_on_s"), 60.0);
}

/// A card may take a quarter of a second for a block; the watchdog waits nearly four seconds for the
/// executor.
#[test]
fn statistics_are_saved_in_steps_that_the_watchdog_outlives() {
    let mut bench = Plan::new(CARTESIAN).file("statistics.txt", "jobs_done = 5\n").file("a.g", "G28\n").start();
    bench.type_in("play a.g -t\n");
    bench.hear_until("Done printing file", 60.0);
    bench.hear(0.5);
    assert!(bench.read_card("previous-statistics.txt").is_some(), "saved");
    assert!(bench.most_unseen_writes() <= 12, "{} writes without a word", bench.most_unseen_writes());
}
