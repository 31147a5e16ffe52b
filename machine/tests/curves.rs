//! Arcs, splines and rounded corners, from a program's words to where the tool really goes.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};

fn homed(config: &str) -> Bench {
    let mut bench = Plan::new(config).start();
    assert_eq!(bench.say("G28"), "ok\n");
    bench.run(&["G90", "G1 X20 Y20 Z5 F6000", "M400"]);
    bench
}

/// Returns the places of the tool, 20 ms apart, from the last of these lines until the tool stands.
fn way(bench: &mut Bench, lines: &[&str]) -> Vec<[f64; 3]> {
    bench.run(lines);
    let mut places: Vec<[f64; 3]> = Vec::new();
    for _ in 0..3_000 {
        bench.hear(0.02);
        let here = bench.world(|world| world.tool_mm());
        // The queue waits a tenth of a second before it runs.
        if places.len() > 10 && places.iter().rev().take(8).all(|place| *place == here) {
            return places;
        }
        places.push(here);
    }
    panic!("never stands still");
}

/// A step of X or Y of the sample printers.
const STEP_MM: f64 = 0.0126;

fn assert_end(places: &[[f64; 3]], end: [f64; 2]) {
    let last = places.last().expect("places");
    assert!((last[0] - end[0]).abs() < STEP_MM && (last[1] - end[1]).abs() < STEP_MM, "ends at {last:?}, not {end:?}");
}

fn assert_on_circle(places: &[[f64; 3]], centre: [f64; 2], radius: f64) {
    for place in places {
        let off = (place[0] - centre[0]).hypot(place[1] - centre[1]) - radius;
        assert!(off.abs() < 2.0 * STEP_MM, "{off} mm off the circle at {place:?}");
    }
}

#[test]
fn arcs_by_centre_radius_and_turns_go_round_their_centres() {
    let mut bench = homed(CARTESIAN);
    let by_centre = way(&mut bench, &["G2 X40 Y20 I10 J0 F3000"]);
    assert_on_circle(&by_centre, [30.0, 20.0], 10.0);
    assert!(by_centre.iter().any(|place| place[1] > 29.0), "clockwise goes over the top");
    let shorter = way(&mut bench, &["G3 X40 Y40 R14.142136"]);
    assert_on_circle(&shorter, [30.0, 30.0], 14.142136);
    let longer = way(&mut bench, &["G3 X40 Y20 R-14.142136"]);
    assert!(longer.iter().any(|place| place[1] > 43.0 || place[0] > 63.0), "the long way round");
    bench.run(&["G1 X40 Y20"]);
    let turns = way(&mut bench, &["G3 X40 Y20 Z8 I-10 J0 P3"]);
    assert_on_circle(&turns, [30.0, 20.0], 10.0);
    let crossings = turns.windows(2).filter(|pair| pair[0][1] < 20.0 && pair[1][1] >= 20.0).count();
    assert_eq!(crossings, 3);
    assert_end(&turns, [40.0, 20.0]);
    assert!((turns.last().expect("places")[2] - 8.0).abs() < 0.01);
}

#[test]
fn arcs_stay_arcs_on_a_delta_and_chords_where_they_are_asked_for() {
    let mut bench = Plan::new(DELTA).start();
    bench.run(&["G28", "G90", "G1 X-50 Y0 Z20 F6000", "M400"]);
    let places = way(&mut bench, &["G2 X50 Y0 I50 J0 F6000"]);
    assert_on_circle(&places, [0.0, 0.0], 50.0);
    let coarse = Plan::new(CARTESIAN).with("[motion control]", "[motion control]\nmm_max_arc_error = 2\n");
    let mut bench = coarse.start();
    bench.run(&["G28", "G90", "G1 X20 Y20 F6000", "M400"]);
    let places = way(&mut bench, &["G2 X40 Y20 I10 J0 F3000"]);
    let inside = places.iter().map(|place| 10.0 - (place[0] - 30.0).hypot(place[1] - 20.0)).fold(0.0, f64::max);
    assert!(inside > 1.0 && inside < 2.02, "the chords come {inside} mm inside");
}

#[test]
fn splines_follow_their_control_points() {
    let mut bench = homed(CARTESIAN);
    // The parabola y = 20 + x - x^2 / 40 from its ends' tangents.
    let parabola = way(&mut bench, &["G5.1 X60 Y20 I20 J20 F3000"]);
    for [x, y, _] in &parabola {
        let expected = 20.0 + (x - 20.0) - (x - 20.0) * (x - 20.0) / 40.0;
        assert!((y - expected).abs() < 2.0 * STEP_MM, "{x} {y} is not {expected}");
    }
    assert_end(&parabola, [60.0, 20.0]);
    let s = way(&mut bench, &["G5 X90 Y20 I0 J10 P0 Q-10", "G5 X120 Y20 P0 Q10"]);
    assert_end(&s, [120.0, 20.0]);
    assert!(s.iter().any(|place| (place[0] - 90.0).abs() < 3.0), "through its middle");
    // A NURBS of order 3 with weight cos 45 degrees in its corner is a quarter of a circle.
    bench.run(&["G1 X120 Y40", "M400", "G5.2 P1 L3", "X120 Y60 P0.70710678", "X100 Y60 P1"]);
    let quarter = way(&mut bench, &["G5.3"]);
    assert_on_circle(&quarter, [100.0, 40.0], 20.0);
    assert_end(&quarter, [100.0, 60.0]);
}

#[test]
fn bad_words_of_curves_halt_and_say_where() {
    for (lines, complaint) in [
        (&["G2 X40 Y20"][..], "the arc has no radius, column 1"),
        (&["G2 X40 Y20 I12 J0"], "the end of the arc is 4.000 mm off its circle, column 12"),
        (&["G2 X20 Y20 R5"], "an arc by R must end elsewhere: write a full circle with I J K, column 12"),
        (&["G2 X60 Y20 R5"], "the ends of the arc are 40.000 mm apart, more than twice R, column 12"),
        (&["G2 X40 Y20 I10 P1.5"], "P is the number of turns, a whole number above zero, column 16"),
        (&["G5 X40 Y20 P1 Q1"], "G5 needs I and J where no other G5 goes before, column 1"),
        (&["G5 X40 Y20 I1 P1 Q1"], "I and J belong together, column 12"),
        (&["G5 X40 Y20 I1 J1"], "G5 needs P and Q, column 1"),
        (&["G5.1 X40 Y20"], "G5.1 needs I or J, column 1"),
        (&["G18", "G5.1 X40 I1"], "splines lie in the plane of G17, column 1"),
        (&["G5.2 X1 Y1 L9"], "L is the order, 2 to 6, column 12"),
        (&["G5.2 X1 Y1", "X2 Z1"], "G5.2 takes X Y P L only, not Z, column 4"),
        (&["G5.2 X1 Y1 P0"], "P is a weight above zero, column 12"),
        (&["G5.2 X1 Y1", "G5.3"], "a spline of order 3 needs as many control points, column 1"),
        (&["G5.2 X1 Y1", "G1 X1"], "G5.2 is not closed: G5.3 must come first, column 1"),
        (&["G5.3"], "G5.3 without G5.2, column 1"),
    ] {
        let mut bench = homed(CARTESIAN);
        let (last, first) = lines.split_last().expect("lines");
        bench.run(first);
        let answer = bench.ask(last);
        assert!(answer.starts_with(&format!("Error: {complaint}\n")), "{lines:?}: {answer}");
    }
}

#[test]
fn corners_are_rounded_as_far_as_g64_allows_and_kept_by_g61() {
    let mut bench = homed(CARTESIAN);
    let corner = |places: &[[f64; 3]]| {
        places.iter().map(|place| (place[0] - 60.0).hypot(place[1] - 20.0)).fold(f64::INFINITY, f64::min)
    };
    assert!(bench.say("$G").contains(" G94 G61 "));
    // Slowly, so that the corner is looked at often.
    let sharp = way(&mut bench, &["G1 X60 Y20 F600", "X60 Y60"]);
    assert!(corner(&sharp) < 0.2, "{}", corner(&sharp));
    bench.run(&["G1 X20 Y20", "M400", "G64 P2"]);
    assert!(bench.say("$G").contains(" G94 G64 "));
    let round = way(&mut bench, &["G1 X60 Y20 F600", "X60 Y60"]);
    assert!((corner(&round) - 2.0).abs() < 0.03, "{}", corner(&round));
    assert_end(&round, [60.0, 60.0]);
    assert_eq!(bench.say("G64 P-1"), "error:P is a distance, zero or more, column 5\n");
    assert_eq!(bench.say("G64 P0.1 Q0.1"), "// NOTE: Q is not needed, short lines are kept\nok\n");
    bench.run(&["G61"]);
    assert!(bench.say("$G").contains(" G94 G61 "));
}
