use super::*;
use crate::bench::{Bench, PROBE, machine, put_bed};
use base::bench::words;
use base::failure::Answer;
use base::hands::Hands;
use units::{Actuator, Axis, AxisSet};

/// A homed machine over a bed at zero, with the tool at this place.
fn homed(more: &str, place: [f64; 3]) -> Bench {
    let mut bench = machine(&format!("{PROBE}{more}"), [-30.0; 3]);
    put_bed(&mut bench, |_, _| 0.0);
    bench.stand_at(place);
    bench.motors.mark_homed(AxisSet::PRIMARY);
    bench
}

fn run(bench: &mut Bench, line: &str) -> Result<Answer, String> {
    paper_test(bench, &words(line)).map_err(|failure| bench.text_of(failure))
}

fn z(bench: &mut Bench) -> f64 {
    bench.position()[Axis::Z]
}

#[test]
fn a_test_needs_a_homed_machine_and_only_one_is_under_way() {
    let mut bench = homed("", [5.0, 5.0, 6.0]);
    assert!(run(&mut bench, "M851.2 Z-1").unwrap_err().contains("no paper test is under way"));
    assert_eq!(run(&mut bench, "M851.1 P2"), Ok(Answer::Ok));
    assert!(run(&mut bench, "M851.1 P2").unwrap_err().contains("a paper test is under way"));
    bench.motors.forget_all_homed();
    assert!(run(&mut bench, "M851.2 Z-1").unwrap_err().contains("home it"));
    assert!(run(&mut bench, "M851.1 P2").unwrap_err().contains("home it first"));
}

#[test]
fn the_tool_moves_by_what_is_asked_and_comes_down_from_above() {
    let mut bench = homed("", [5.0, 5.0, 6.0]);
    run(&mut bench, "M851.1 P2").unwrap();
    for (line, ends) in [("M851.2 Z-1", 5.0), ("M851.2 Z-0.1", 4.9), ("M851.2 Z2", 6.9)] {
        run(&mut bench, line).unwrap();
        assert!((z(&mut bench) - ends).abs() < 1e-9, "{line}: {}", z(&mut bench));
    }
    assert!(run(&mut bench, "M851.2 Z-50").is_err(), "a mistake");
    assert!((z(&mut bench) - 6.9).abs() < 1e-9);
    bench.heard();
    run(&mut bench, "M851.3").unwrap();
    assert!(bench.heard().contains("the paper drags at Z 6.9000"));
}

#[test]
fn the_tool_goes_over_where_the_probe_has_touched_and_the_difference_is_the_probe_s() {
    let mut bench = homed("probe_offsets = 12,-3,0\n", [5.0, 25.0, 8.0]);
    run(&mut bench, "M851.1 P0").unwrap();
    let here = bench.position();
    assert_eq!((here[Axis::X], here[Axis::Y]), (17.0, 22.0), "the tool is where the probe was");
    assert!((here[Axis::Z] - 5.0).abs() < 0.02, "some way above the bed: {}", here[Axis::Z]);
    assert!((bench.world.places[Actuator::Alpha] - 17.0).abs() < 0.03);
    // The paper drags two millimetres below the probe's contact.
    for line in ["M851.2 Z-5", "M851.2 Z-2"] {
        run(&mut bench, line).unwrap();
    }
    run(&mut bench, "M851.3").unwrap();
    let offset = bench.bed().probe_offsets[2];
    assert!((offset - 2.0).abs() < 0.02, "{offset}");
}

#[test]
fn a_test_that_is_given_up_changes_nothing() {
    let mut bench = homed("", [5.0, 5.0, 6.0]);
    run(&mut bench, "M851.1 P0").unwrap();
    run(&mut bench, "M851.2 Z-1").unwrap();
    let before = bench.bed().probe_offsets;
    run(&mut bench, "M851.4").unwrap();
    assert_eq!(bench.bed().probe_offsets, before);
    assert!(run(&mut bench, "M851.3").unwrap_err().contains("no paper test is under way"));
}
