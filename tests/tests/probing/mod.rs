//! Probing: G30, G38, M48 and M670 against a simulated bed, and everything that can be wrong with a probe.

mod calibration;
mod faults;
mod leveling;
mod limits;

use scenarios::{Bench, CARTESIAN, COREXY, DELTA, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator::{Alpha, Beta, Gamma};

/// A step of Z in the Cartesian sample, mm; of X and Y.
const Z_STEP: f64 = 1.0 / 400.0;
const XY_STEP: f64 = 1.0 / 80.0;

fn plan(config: &str) -> Plan {
    Plan::new(config)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] max_travel = 60")
}

/// A homed machine at X50 Y60 Z20.
fn homed(plan: Plan) -> Bench {
    let mut bench = plan.start();
    assert!(bench.greeting().find("ERROR").is_none(), "{}", bench.greeting());
    // $H homes whatever G28 means.
    bench.run(&["$H", "G1 X50 Y60 Z20 F6000", "M400"]);
    bench
}

/// Returns a homed delta machine.
fn homed_delta(plan: Plan) -> Bench {
    let mut bench = plan.start();
    assert!(bench.greeting().find("ERROR").is_none(), "{}", bench.greeting());
    bench.run(&["G28", "G1 Z30 F9000", "M400"]);
    bench
}

fn lay(bench: &Bench, surface: Surface) {
    bench.lay(surface);
}

fn lay_bed(bench: &Bench, bed: Bed) {
    lay(bench, Surface { bed: Some(bed), ..Surface::default() });
}

/// The numbers of a line like `Z:12.3456` or `[PRB:1.000,2.000,3.000:1]`.
fn numbers(answer: &str, head: &str) -> Vec<f64> {
    let line =
        answer.lines().find_map(|line| line.strip_prefix(head)).unwrap_or_else(|| panic!("no {head} in {answer}"));
    line.trim_end_matches(']').split([',', ':', ' ']).filter_map(|word| word.parse().ok()).collect()
}

fn assert_near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found} is not {wanted}");
}

#[test]
fn g30_measures_the_way_down_to_the_bed_and_returns() {
    let mut bench = homed(plan(CARTESIAN));
    for height in [0.0, 1.2345, -0.8] {
        lay_bed(&bench, Bed::level(height));
        let answer = bench.say("G30");
        assert!(answer.ends_with("ok\n") && answer.lines().count() == 2, "{answer}");
        assert_near(numbers(&answer, "Z:")[0], 20.0 - height, Z_STEP);
        assert_near(bench.carriage(Gamma), 20.0, 1e-9);
        assert!(bench.status().contains("MPos:50.0000,60.0000,20.0000"));
    }
}

#[test]
fn g30_z_sets_the_height_where_the_contact_was_and_l_stays_there() {
    let mut bench = homed(plan(CARTESIAN));
    lay_bed(&bench, Bed::level(1.5));
    assert_near(numbers(&bench.say("G30 Z0.2"), "Z:")[0], 18.5, Z_STEP);
    let status = bench.status();
    assert!(status.contains("WPos:50.0000,60.0000,0.2000"), "{status}");
    assert_near(bench.carriage(Gamma), 1.5, Z_STEP);
    bench.run(&["G1 Z10 F600", "M400"]);
    assert_near(bench.carriage(Gamma), 11.3, Z_STEP);
    assert_near(numbers(&bench.say("G30 L1"), "Z:")[0], 9.8, Z_STEP);
    assert_near(bench.carriage(Gamma), 1.5, Z_STEP);
}

#[test]
fn g30_r1_searches_the_other_way_and_reverse_z_always_does() {
    let mut bench = homed(plan(CARTESIAN));
    lay(&bench, Surface { bed: Some(Bed::level(25.0)), overhead: true, ..Surface::default() });
    assert_near(numbers(&bench.say("G30 R1"), "Z:")[0], -5.0, Z_STEP);
    let mut bench = homed(plan(CARTESIAN).set("[zprobe] reverse_z = true"));
    assert_near(numbers(&bench.say("G30"), "Z:")[0], -10.0, Z_STEP);
    lay_bed(&bench, Bed::level(3.0));
    assert_near(numbers(&bench.say("G30 R1"), "Z:")[0], 17.0, Z_STEP);
}

#[test]
fn dollar_p_probes_as_g30_does() {
    let mut bench = homed(plan(CARTESIAN));
    assert_near(numbers(&bench.say("$P F300"), "Z:")[0], 20.0, Z_STEP);
    assert_near(bench.carriage(Gamma), 20.0, 1e-9);
    assert_near(numbers(&bench.say("$P"), "Z:")[0], 20.0, Z_STEP);
    assert_eq!(bench.say("$P G1"), "error:$P takes the words of G30\n");
    assert!(Plan::new(CARTESIAN).start().say("$P").starts_with("error:no probe is configured"));
}

#[test]
fn g38_finds_the_bed_and_says_where_in_machine_coordinates() {
    let mut bench = homed(plan(CARTESIAN));
    lay_bed(&bench, Bed::level(2.0));
    bench.run(&["G92 X0 Y0 Z0"]);
    let answer = bench.say("G38.2 Z-30 F120");
    assert!(answer.ends_with(":1]\nok\n"), "{answer}");
    let found = numbers(&answer, "[PRB:");
    assert_eq!((found[0], found[1], found[3]), (50.0, 60.0, 1.0));
    assert_near(found[2], 2.0, Z_STEP);
    // The carriage stands where the contact was.
    assert_near(bench.carriage(Gamma), found[2], 0.0005);
    let offsets = bench.say("$#");
    assert_near(numbers(&offsets, "[PRB:")[2], 2.0, Z_STEP);
    assert_eq!(numbers(&offsets, "[PRB:")[3], 1.0);
}

#[test]
fn a_touch_plate_is_found_from_its_side() {
    let mut bench = homed(plan(CARTESIAN));
    let plate = [[80.0, 90.0], [40.0, 100.0], [0.0, 30.0]];
    lay(&bench, Surface { bed: None, blocks: vec![plate], ..Surface::default() });
    let found = numbers(&bench.say("G38.2 X60 F600"), "[PRB:");
    assert_near(found[0], 80.0, XY_STEP);
    assert_near(bench.carriage(Alpha), 80.0, XY_STEP);
    bench.run(&["G1 X110 Y30 F6000", "G1 Y110", "M400"]);
    // The other edge, and along both axes: Y falls three quarters as fast as X.
    let found = numbers(&bench.say("G38.3 X-40 Y-30 F600"), "[PRB:");
    assert_near(found[0], 90.0, 2.0 * XY_STEP);
    assert_near(found[1], 95.0, 2.0 * XY_STEP);
    assert_near(bench.carriage(Beta), found[1], XY_STEP);
}

#[test]
fn g38_4_and_5_search_for_the_contacts_end() {
    let mut bench = homed(plan(CARTESIAN));
    lay_bed(&bench, Bed::level(4.0));
    bench.say("G38.2 Z-30");
    bench.run(&["G91", "G1 Z-0.5 F60", "G90"]);
    let found = numbers(&bench.say("G38.4 Z5 F60"), "[PRB:");
    assert_near(found[2], 4.0, 2.0 * Z_STEP);
    assert_eq!(found[3], 1.0);
    assert_eq!(bench.say("G38.5 Z5"), "error:ZProbe triggered before move, aborting command.\n", "it is open");
    bench.run(&["G91", "G1 Z-3 F600", "G90", "M400"]);
    assert!(bench.say("G38.5 Z0.5").ends_with(":0]\nok\n"), "still closed at the end");
    assert!(bench.status().starts_with("<Idle"));
    let answer = bench.say("G38.4 Z0.5");
    assert!(answer.contains(":0]\nALARM: Probe fail\n"), "{answer}");
    bench.assert_safe();
}

#[test]
fn a_miss_halts_with_g38_2_and_not_with_g38_3() {
    let mut bench = homed(plan(CARTESIAN));
    let answer = bench.say("G38.3 Z-10");
    assert_eq!(answer, "[PRB:50.000,60.000,10.000:0]\nok\n");
    assert_near(bench.carriage(Gamma), 10.0, 1e-9);
    assert!(bench.status().starts_with("<Idle"));
    let answer = bench.say("G38.2 Z-5");
    assert_eq!(answer, "[PRB:50.000,60.000,5.000:0]\nALARM: Probe fail\n!!\n");
    bench.say("M999");
    assert_eq!(numbers(&bench.say("$#"), "[PRB:")[3], 0.0);
    let answer = bench.say("G38.2 Z-2");
    assert!(answer.contains("ALARM: Probe fail\n"), "{answer}");
    bench.assert_safe();
}

#[test]
fn distances_are_relative_but_in_grbl_mode_follow_the_distance_mode() {
    let mut bench = homed(plan(CARTESIAN));
    assert_eq!(bench.say("G38.3 Z-4"), "[PRB:50.000,60.000,16.000:0]\nok\n");
    bench.run(&["G20"]);
    assert_eq!(bench.say("G38.3 X0.5 F20"), "[PRB:62.700,60.000,16.000:0]\nok\n");
    let mut bench = homed(plan(CARTESIAN).with("grbl_mode = false", "grbl_mode = true"));
    bench.run(&["G92 Z0"]);
    assert_eq!(bench.say("G38.3 Z-4"), "[PRB:50.000,60.000,16.000:0]\nok\n");
    assert_eq!(bench.say("G38.3 Z-5"), "[PRB:50.000,60.000,15.000:0]\nok\n");
    bench.run(&["G91"]);
    assert_eq!(bench.say("G38.3 X1 Z-5"), "[PRB:51.000,60.000,10.000:0]\nok\n");
    assert_eq!(bench.say("G53 G38.3 Z9"), "[PRB:51.000,60.000,9.000:0]\nok\n");
}

#[test]
fn wrong_words_are_refused_and_nothing_moves() {
    let mut bench = homed(plan(CARTESIAN));
    let edges = bench.world(|world| world.trace().total());
    for (line, reason) in [
        ("G38.6 Z-1", "Only G38.2 to G38.5 are supported, column 1"),
        ("G38.2", "at least one of X Y or Z must be specified, column 1"),
        ("G38.2 F100", "at least one of X Y or Z must be specified, column 1"),
        ("G38.2 X1 Z-1", "Z cannot be probed at the same time as X or Y, column 10"),
        ("G38.2 Z-1 A2", "only X Y and Z can be probed along, column 11"),
        ("G38.2 Z0", "the way to probe along has no length, column 1"),
        ("G38.2 Z-1 F0", "the feed rate of a search must be above zero, column 11"),
        ("M48 P0", "M48: P is 1 or more, column 5"),
        ("M670 S0", "M670: S must be above 0, column 6"),
        ("M670 H-1", "M670: H must be above 0, column 6"),
        ("M670 H0", "M670: H must be above 0, column 6"),
        ("M670 K10 D61", "M670: D is 60 at most, column 10"),
    ] {
        assert_eq!(bench.say(line), format!("error:{reason}\n"), "{line}");
    }
    assert_eq!(bench.world(|world| world.trace().total()), edges);
}

#[test]
fn without_a_probe_g38_is_refused_and_a_printers_codes_are_ignored() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("G30"), "ok - G30 ignored\n");
    assert_eq!(bench.say("G29"), "ok - G29 ignored\n");
    assert_eq!(bench.say("M48"), "ok - M48 ignored\n");
    assert_eq!(bench.say("G38.2 Z-5"), "error:no probe is configured: [zprobe] enable\n");
}

#[test]
fn inversion_can_be_toggled() {
    let mut bench = homed(plan(CARTESIAN));
    lay_bed(&bench, Bed::level(1.0));
    assert!(bench.say("M119").contains("(Probe)PB10^:0 "));
    assert!(bench.say("M670 I").ends_with("inverted:1\nok\n"));
    assert!(bench.say("M119").contains("(Probe)PB10^:1 "));
    assert!(bench.say("G30").starts_with("error:ZProbe triggered before move"));
    // The inverted contact opens where the bed is.
    assert_near(numbers(&bench.say("G38.4 Z-30"), "[PRB:")[2], 1.0, Z_STEP);
    bench.say("M670 I1");
    // I0 leaves the sense as it is.
    assert!(bench.say("M670 I0").ends_with("inverted:0\nok\n"));
    bench.run(&["G1 Z20 F600"]);
    assert_near(numbers(&bench.say("G30"), "Z:")[0], 19.0, Z_STEP);
}

#[test]
fn m48_tells_how_far_probes_of_one_place_differ() {
    let mut bench = homed(plan(CARTESIAN));
    lay_bed(&bench, Bed::level(4.3));
    let answer = bench.say("M48 P4 F600");
    let heights: Vec<_> = answer.lines().filter_map(|line| line.strip_prefix("Z:")).collect();
    assert_eq!(heights.len(), 4, "{answer}");
    assert!(
        answer.contains("\nDelta: 0.0000\nMean: 15.7") && answer.contains("Standard deviation: 0.0000\nok\n"),
        "{answer}"
    );
    assert!(
        answer.contains("\nMinimum: 15.7") && answer.contains(" Maximum: 15.7") && answer.contains(" Median: 15.7")
    );
    assert_near(bench.carriage(Gamma), 20.0, 1e-9);
    bench.lay(Surface { bed: Some(Bed::level(4.3)), noise_mm: 0.05, ..Surface::default() });
    let answer = bench.say("PROBE_ACCURACY SAMPLES=7 PROBE_SPEED=4");
    let mut heights: Vec<f64> =
        answer.lines().filter_map(|line| line.strip_prefix("Z:")).map(|text| text.parse().expect("a number")).collect();
    heights.sort_by(f64::total_cmp);
    let told = numbers(&answer.replace("imum: ", "imum:").replace("Median: ", "Median:"), "Minimum:");
    assert_eq!(told[0], heights[0], "{answer}");
    assert!(answer.contains(&format!("Maximum: {:.4} Median: {:.4}\n", heights[6], heights[3])), "{answer}");
    lay_bed(&bench, Bed::level(4.3));
    bench.run(&["G1 Z30 F600"]);
    assert_eq!(bench.say("M48"), "error:ZProbe not triggered within 20 mm\n");
}

#[test]
fn m670_changes_the_searches_and_m500_keeps_it() {
    let mut bench = homed(plan(CARTESIAN));
    assert_eq!(bench.say("M670"), "S:5.00 K:100.00 R:10.00 Z:60.00 H:5.00 D:0.00 inverted:0\nok\n");
    let answer = bench.say("M670 S8 K20 R0 Z12.5 H2 D0.25");
    assert_eq!(answer, "S:8.00 K:20.00 R:16.00 Z:12.50 H:2.00 D:0.25 inverted:0\nok\n");
    assert!(bench.say("M503").contains("M670 S8.00000 K20.00000 R16.00000 Z12.50000 H2.00000 D0.25000\n"));
    let before = bench.now_s();
    assert_eq!(bench.say("G30"), "ZProbe not triggered\nok\n");
    // Down 12.5 mm at 8 mm/s after a quarter of a second, back at 10 mm/s (the axis allows no more).
    let took = bench.now_s() - before;
    assert!((1.7..3.5).contains(&took), "{took} s");
}

#[test]
fn the_feed_override_does_not_change_the_speed_of_a_search() {
    let took = |percent: &str| {
        let mut bench = homed(plan(CARTESIAN));
        bench.run(&[percent]);
        let before = bench.now_s();
        bench.say("G38.3 Z-5 F300");
        bench.now_s() - before
    };
    assert_near(took("M220 S300"), took("M220 S100"), 0.002);
}

// Smoothieware v2: F of G30 and M48 is mm/min always, and G38 is 25.4 times too fast.
#[test]
fn feed_rates_of_searches_are_in_the_units_of_the_program() {
    let took = |units: &str, line: &str| {
        let mut bench = homed(plan(CARTESIAN));
        lay_bed(&bench, Bed::level(10.0));
        bench.run(&[units]);
        let before = bench.now_s();
        assert!(bench.say(line).ends_with("ok\n"), "{line}");
        bench.now_s() - before
    };
    for (mm, inches, without) in [
        ("G30 F254", "G30 F10", "G30"),
        ("M48 P2 F254", "M48 P2 F10", "M48 P2"),
        ("G38.3 Z-5.08 F254", "G38.3 Z-0.2 F10", "G38.3 Z-0.2"),
    ] {
        let took_s = took("G20", inches);
        assert_near(took_s, took("G21", mm), 0.002);
        assert!((took_s - took("G20", without)).abs() > 0.1, "{inches}: {took_s}");
    }
}

#[test]
fn filters_do_not_shift_what_a_search_finds() {
    let shaped = plan(CARTESIAN).set("[input shaper] z.shaper = ei").set("[input shaper] z.frequency = 20");
    let mut bench = homed(shaped);
    assert!(bench.greeting().find("rror").is_none(), "{}", bench.greeting());
    lay_bed(&bench, Bed::level(2.0));
    assert_near(numbers(&bench.say("G38.2 Z-30 F600"), "[PRB:")[2], 2.0, Z_STEP);
    assert_near(bench.carriage(Gamma), 2.0, Z_STEP);
}

#[test]
fn a_delta_and_a_corexy_probe_as_well() {
    let mut bench = plan(DELTA).start();
    bench.run(&["G28", "G1 X30 Y-40 Z20 F6000", "M400"]);
    lay_bed(&bench, Bed::tilted(0.5, [0.01, 0.02]));
    let tool = bench.world(|world| world.tool_mm());
    // A carriage's step is 0.0125 mm; the others' rounding moves the tool along and sideways.
    assert_near(numbers(&bench.say("G30"), "Z:")[0], tool[2] - (0.5 + 0.3 - 0.8), 0.03);
    assert_near(numbers(&bench.say("G38.2 Z-30"), "[PRB:")[2], 0.0, 0.03);
    let mut bench = plan(COREXY).start();
    bench.run(&["G28", "G1 X50 Y60 Z20 F6000", "M400"]);
    let plate = [[80.0, 90.0], [40.0, 100.0], [0.0, 30.0]];
    lay(&bench, Surface { bed: None, blocks: vec![plate], ..Surface::default() });
    assert_near(numbers(&bench.say("G38.2 X60 F600"), "[PRB:")[0], 80.0, 0.02);
}

/// At any speed the result is the place of the contact, to the step, the brake begins within 2 ms of it, and
/// afterwards the machine stands where it says.
#[test]
fn speed_costs_no_accuracy() {
    for (n, feed) in [30.0, 61.7, 119.3, 240.0, 300.0, 433.3, 600.0].into_iter().enumerate() {
        let (start, height) = (8.0 + 0.731 * n as f64, 6.013 - 1.177 * n as f64);
        let mut bench = homed(plan(CARTESIAN));
        bench.run(&[&format!("G1 Z{start:.4} F600"), "M400"]);
        lay_bed(&bench, Bed::level(height));
        bench.world(|world| world.trace_mut().take());
        let answer = bench.say(&format!("G38.2 Z-30 F{feed:.1}"));
        let found = numbers(&answer, "[PRB:")[2];
        assert_near(found, height, Z_STEP + 0.0005);
        assert_near(bench.carriage(Gamma), found, 0.0006);
        assert_eq!(bench.world(|world| world.lost_mm(Gamma)), 0.0);
        let delay_ns = brake_delay(&mut bench, start, height);
        assert!(delay_ns <= 2_000_000, "{delay_ns} ns from the contact to the brake at F{feed}");
        println!("F{feed}: {delay_ns} ns from the contact to the brake");
    }
}

/// From the step that closed the contact to the first one that comes later than at the speed before, ns.
fn brake_delay(bench: &mut Bench, start: f64, height: f64) -> i64 {
    let edges: Vec<_> =
        bench.world(|world| world.trace_mut().take()).into_iter().filter(|e| e.actuator == Gamma).collect();
    let to_contact = ((start - height) / Z_STEP).ceil() as usize;
    let contact = edges[to_contact - 1].time_ns;
    let before = edges[to_contact - 1].time_ns - edges[to_contact - 2].time_ns;
    let later = edges
        .windows(2)
        .skip(to_contact - 1)
        .find(|pair| pair[1].time_ns - pair[0].time_ns > before + before / 200 + 20);
    let Some(pair) = later else { return 0 };
    pair[0].time_ns as i64 - contact as i64
}

// Smoothieware v2: each touch of G30, M48 and a grid sets it to 0, 0 and a distance.
#[test]
fn what_g38_found_stays_in_prb_whatever_else_is_probed() {
    let mut bench = homed(plan(CARTESIAN));
    lay_bed(&bench, Bed::level(1.5));
    bench.say("G38.2 Z-30");
    let prb = |bench: &mut Bench| numbers(&bench.say("$#"), "[PRB:");
    let found = prb(&mut bench);
    assert_near(found[2], 1.5, Z_STEP);
    bench.run(&["G1 X70 Z10 F6000"]);
    for line in ["G30", "M48 P3"] {
        assert!(bench.say(line).ends_with("ok\n"), "{line}");
        assert_eq!(prb(&mut bench), found, "{line}");
    }
}

// Smoothieware v2 leaves the pin's sense inverted after an error.
#[test]
fn a_g38_4_that_fails_leaves_the_probe_as_it_was() {
    let mut bench = homed(plan(CARTESIAN));
    lay_bed(&bench, Bed::level(1.5));
    let refused = bench.say("G38.4 Z5");
    assert!(refused.starts_with("error:"), "it is open already: {refused}");
    bench.run(&["$X"]);
    let found = numbers(&bench.say("G38.2 Z-30"), "[PRB:");
    assert_near(found[2], 1.5, Z_STEP);
    assert_eq!(found[3], 1.0);
}

// Smoothieware v2: words that are left out become 0, so `M565 Z1` probes beside the point.
#[test]
fn m565_keeps_what_is_left_out() {
    let mut bench = homed(plan(CARTESIAN));
    bench.say("M565 X-20 Y5 Z1.5");
    bench.say("M565 Z1.25");
    let asked = bench.say("M565");
    assert_eq!(asked, "Probe offsets: X:-20.0000 Y:5.0000 Z:1.2500\nok\n");
    assert_eq!(bench.say("M565"), asked, "asking changes nothing");
}
