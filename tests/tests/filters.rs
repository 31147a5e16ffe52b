//! Input shaping and pressure advance on a whole machine.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta};

const SHAPED: &str = "[input shaper]\nshaper_type_x = ei\nshaper_freq_x = 40\nshaper_freq_y = 50\n\n[planner]";

fn shaped() -> Bench {
    Plan::new(CARTESIAN)
        .with("[planner]", SHAPED)
        .with("hotend.tool_id = 0 ", "hotend.pressure_advance = 0.05\nhotend.tool_id = 0 ")
        .start()
}

#[test]
fn shaped_moves_end_where_plain_ones_do_and_homing_finds_the_same_switches() {
    let program = ["M302 S0", "G28 X Y", "G91", "M83", "G1 X30 Y10 E2 F6000", "G1 X-10 Y5 E1", "G1 E-1 F1800", "M400"];
    let ends = [Plan::new(CARTESIAN).start(), shaped()].map(|mut bench| {
        for line in program {
            bench.say(line);
        }
        (bench.carriage(Alpha), bench.carriage(Delta), bench.say("M114"))
    });
    let [plain, shaped] = ends;
    assert!((plain.0 - shaped.0).abs() < 1e-9 && (plain.1 - shaped.1).abs() < 1e-9, "{plain:?} {shaped:?}");
    assert_eq!(plain.2, shaped.2);
}

#[test]
fn m900_sets_the_pressure_advance_of_the_tool_in_use() {
    let mut bench = shaped();
    assert_eq!(bench.say("M900"), "K:0.0500 smooth time:0.0400\nok\n");
    assert_eq!(bench.say("M900 K0.08"), "ok\n");
    assert_eq!(bench.say("M900"), "K:0.0800 smooth time:0.0400\nok\n");
    let refused = bench.say("M900 K-1");
    assert!(refused.contains("M900: K is 0 or more, column 6"), "{refused}");
    assert_eq!(bench.say("M900"), "K:0.0800 smooth time:0.0400\nok\n");
}

/// Filters look back on blocks that must still be there: none of what is configured is taken for that.
#[test]
fn the_longest_queue_is_as_long_as_it_says_with_filters_and_without() {
    for shaper in ["0", "40"] {
        let plan = Plan::new(CARTESIAN).set("[planner] planner_queue_size = 224");
        let mut bench = plan.set(&format!("[input shaper] shaper_freq_x = {shaper}")).start();
        assert_eq!(bench.queue_level(), (0, 224), "{shaper} Hz: {}", bench.greeting());
    }
    // A queue size that Smoothieware takes is taken, cut to the greatest size here.
    let mut bench = Plan::new(CARTESIAN).set("[planner] planner_queue_size = 1000").start();
    assert_eq!(bench.queue_level(), (0, 224), "{}", bench.greeting());
    assert!(bench.greeting().contains("1000 is taken as 224"), "{}", bench.greeting());
}
