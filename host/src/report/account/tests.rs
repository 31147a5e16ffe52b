//! The account of runs whose times are known, because the test makes them.

use super::super::fake::{self, Edge};
use super::*;
use units::MAX_ACTUATORS;

/// Machine that the test moves, from 0 on, with its home there.
struct Desk {
    machine: Machine,
    edges: Vec<Edge>,
    now_s: f64,
    at: [f64; 3],
}

impl Desk {
    fn new() -> Self {
        Self { machine: Machine::printer(), edges: Vec::new(), now_s: 0.0, at: [0.0; 3] }
    }

    fn go(&mut self, to: [f64; 3], fed: f64, seconds: f64) -> &mut Self {
        self.now_s = fake::line_in(&self.machine, &mut self.edges, [self.now_s, seconds], self.at, to, fed);
        self.at = to;
        self
    }

    fn stand(&mut self, seconds: f64) -> &mut Self {
        self.now_s += seconds;
        self
    }

    fn account(&mut self, text: &str) -> Account {
        self.edges.sort_by_key(|edge| edge.0);
        let program = Program::parse(text.as_bytes(), [Some(0.0); 3]);
        let executed = fake::executed(&self.edges);
        let samples = Samples::take(&executed, &self.machine, &[0.0; MAX_ACTUATORS], &self.machine.filament(), 0.001);
        Account::of(&executed, &samples, Some(&self.machine), Some(&program), self.now_s)
    }
}

const JOB: &str = "M190 S60
G28
M109 S200
;LAYER_CHANGE
;TYPE:Perimeter
EXCLUDE_OBJECT_START NAME=a
G1 X20 E2 F2400
G1 E1
EXCLUDE_OBJECT_END NAME=a
G0 Y20 F2400
G4 P500
G1 E2
;LAYER_CHANGE
;TYPE:Infill
G1 Z0.4
EXCLUDE_OBJECT_START NAME=b
G1 X0 E5
EXCLUDE_OBJECT_END NAME=b
";

/// Runs [`JOB`]: 30 s of heating, homing, 10 s of heating, and so on.
fn job() -> Account {
    let mut desk = Desk::new();
    desk.stand(30.0).go([-5.0, 0.0, 0.0], 0.0, 0.5).stand(0.05).go([0.0; 3], 0.0, 0.5).stand(10.0);
    desk.go([20.0, 0.0, 0.0], 2.0, 0.5).stand(0.005).go([20.0, 0.0, 0.0], -1.0, 0.2).stand(0.005);
    desk.go([20.0, 20.0, 0.0], 0.0, 0.5).stand(0.5).go([20.0, 20.0, 0.0], 1.0, 0.2);
    desk.go([20.0, 20.0, 0.4], 0.0, 0.01).go([0.0, 20.0, 0.4], 3.0, 0.5).stand(2.0);
    desk.account(JOB)
}

fn near(found: f64, expected: f64) -> bool {
    (found - expected).abs() < 0.02
}

#[test]
fn every_moment_of_a_job_is_told_once() {
    let times = job().times;
    let sum: f64 = times.kinds.iter().map(|row| row.seconds).sum();
    assert!((sum - times.seconds).abs() < 1e-6 && near(sum, 45.47), "{sum} of {}", times.seconds);
    for (kind, seconds) in [
        (Kind::Print, 1.0),
        (Kind::Travel, 0.51),
        (Kind::Filament, 0.41),
        (Kind::Own, 1.05),
        (Kind::Heating, 40.0),
        (Kind::Dwell, 0.5),
        (Kind::Pause, 0.0),
        (Kind::Standing, 2.0),
    ] {
        assert!(near(times.of_kind(kind), seconds), "{kind:?}: {} of {seconds}", times.of_kind(kind));
    }
    for pace in times.pace {
        assert!(pace.cruising > 0.8 * (pace.cruising + pace.accelerating + pace.braking), "{pace:?}");
    }
    let layers: f64 = times.layers.iter().map(|layer| layer.seconds).sum();
    let objects: f64 = times.objects.iter().map(|object| object.seconds).sum();
    assert!((layers - sum).abs() < 1e-6 && (objects - sum).abs() < 1e-6 && times.untold == 0.0);
}

#[test]
fn layers_features_and_objects_have_their_times_and_filament() {
    let account = job();
    let layers: Vec<_> = account.times.layers.iter().map(|layer| (layer.number, layer.z)).collect();
    assert_eq!(layers, [(0, None), (1, Some(0.0)), (2, Some(0.4))]);
    let [before, first, second] = account.times.layers.as_slice() else { panic!() };
    assert!(near(before.seconds, 41.05) && near(before.waiting, 40.0), "{before:?}");
    assert!(near(first.seconds, 1.91) && near(first.waiting, 0.5) && near(first.filament, 2.0), "{first:?}");
    assert!(near(second.filament, 3.0) && near(second.to - second.from, 2.51), "{second:?}");
    let features: Vec<_> = account.times.features.iter().map(|row| (row.name.as_str(), row.place)).collect();
    assert_eq!(features, [("Perimeter", 1), ("Infill", 2)]);
    for row in &account.times.features {
        assert!(near(row.seconds, 0.5) && (row.length / row.seconds - 40.0).abs() < 1.0, "{row:?}");
    }
    let [none, a, b] = account.times.objects.as_slice() else { panic!() };
    assert!(near(a.seconds, 0.71) && near(a.printing, 0.5) && near(a.filament, 1.0), "{a:?}");
    assert!(near(b.printing, 0.5) && near(b.filament, 3.0) && none.name.is_empty() && !b.left_out, "{b:?}");
    let text = account.text(Some(&[]));
    for part in [
        "heating 40.0 s",
        "layers  2",
        "object  a: 0.7 s",
        "Perimeter 0.5 s at 40 mm/s",
        "starved: none seen; the planner counted 0",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
}

#[test]
fn an_object_that_is_left_out_has_no_moves() {
    let text = "EXCLUDE_OBJECT NAME=b\nEXCLUDE_OBJECT_START NAME=a\nG1 X10 E1 F2400\nEXCLUDE_OBJECT_END\nEXCLUDE_OBJECT_START NAME=b\nG1 X20 E2\nG1 Y20 E3\nEXCLUDE_OBJECT_END\nG1 X10 Y10 E4\n";
    let mut desk = Desk::new();
    desk.go([10.0, 0.0, 0.0], 1.0, 0.5).go([20.0, 20.0, 0.0], 0.0, 0.5).go([10.0, 10.0, 0.0], 1.0, 0.5);
    let account = desk.account(text);
    let left_out = account.times.objects.iter().find(|object| object.left_out).unwrap();
    assert_eq!((left_out.name.as_str(), left_out.seconds), ("b", 0.0));
    assert!(account.text(None).contains("object  b: 0.0 s, 0.0 mm of filament, left out"));
}

#[test]
fn without_a_program_the_edges_alone_tell_printing_from_travel() {
    let mut desk = Desk::new();
    desk.stand(1.0).go([20.0, 0.0, 0.0], 2.0, 0.5).go([20.0, 20.0, 0.0], 0.0, 0.5);
    let executed = fake::executed(&desk.edges);
    let samples = Samples::take(&executed, &desk.machine, &[0.0; MAX_ACTUATORS], &desk.machine.filament(), 0.001);
    let account = Account::of(&executed, &samples, Some(&desk.machine), None, 2.0);
    assert!(near(account.times.of_kind(Kind::Print), 0.5) && near(account.times.of_kind(Kind::Travel), 0.5));
    assert!(near(account.times.untold, 1.0) && account.starved.is_none());
    assert!(account.text(None).contains("untold  1.0 s of 1.0 s"), "{}", account.text(None));
}

const ROW: &str = "G1 X10 E1 F2400\nG1 X20 E2\nG1 X30 E3\n";

#[test]
fn a_stop_in_a_row_of_moves_is_seen_and_one_that_is_asked_for_is_not() {
    let stops = |text: &str, stand_s: f64| {
        let mut desk = Desk::new();
        desk.stand(1.0).go([10.0, 0.0, 0.0], 1.0, 0.25).stand(stand_s).go([30.0, 0.0, 0.0], 2.0, 0.5).stand(1.0);
        desk.account(text).starved.unwrap()
    };
    assert_eq!(stops(ROW, 0.0), []);
    let [stop] = stops(ROW, 0.1)[..] else { panic!() };
    assert!(near(stop.at, 1.25) && near(stop.stood, 0.1) && stop.line == Some(2), "{stop:?}");
    for asked in ["G4 P100", "M400", "M109 S200", "M600", "T1"] {
        assert_eq!(stops(&ROW.replacen('\n', &format!("\n{asked}\n"), 1), 0.1), [], "{asked}");
    }
    assert_eq!(stops(&ROW.replacen('\n', "\nM106 S100\n", 1), 0.1).len(), 1, "a fan stops nothing");
}

#[test]
fn braking_to_rest_on_a_straight_way_is_seen() {
    let stops = |crawl_s: f64, text: &str| {
        let mut desk = Desk::new();
        desk.stand(1.0).go([9.99, 0.0, 0.0], 1.0, 0.25).go([10.01, 0.0, 0.0], 0.0, crawl_s);
        desk.go([30.0, 0.0, 0.0], 2.0, 0.5).stand(1.0);
        desk.account(text).starved.unwrap()
    };
    assert_eq!(stops(0.0005, ROW), []);
    let [stop] = stops(0.024, ROW)[..] else { panic!() };
    assert!(near(stop.at, 1.262) && stop.stood == 0.0 && stop.line == Some(2), "{stop:?}");
    assert_eq!(stops(0.024, &ROW.replacen('\n', "\nM400\n", 1)), []);
}

#[test]
fn rows_of_moves_far_below_their_feed_are_told_with_their_lines() {
    // Asked for 200 mm/s, the second and third move go at 40, and so does a way without filament.
    let text = ";TYPE:Infill\nG1 X20 E1 F12000\nG1 Y1 E2\nG1 X19 E3\nG1 X0 E4\nG1 Y20\n";
    let mut desk = Desk::new();
    desk.stand(1.0).go([20.0, 0.0, 0.0], 1.0, 0.12).go([20.0, 1.0, 0.0], 1.0, 0.025);
    desk.go([19.0, 1.0, 0.0], 1.0, 0.025).go([0.0, 1.0, 0.0], 1.0, 0.1).go([0.0, 20.0, 0.0], 0.0, 0.5).stand(1.0);
    let account = desk.account(text);
    let [place] = account.slow.as_slice() else { panic!("{:?}", account.slow) };
    assert_eq!((place.line, place.last, place.moves, place.text.as_str()), (3, 4, 2, "G1 Y1 E2"));
    assert_eq!(place.feature, "Infill");
    assert!(
        (place.asked - 200.0).abs() < 1e-6 && (place.speed - 40.0).abs() < 2.0 && near(place.lost, 0.04),
        "{place:?}"
    );
    // Speeds beyond the machine's limits are not asked of it.
    desk.machine.max_speed = [50.0; 3];
    assert!(desk.account(text).slow.is_empty());
}
