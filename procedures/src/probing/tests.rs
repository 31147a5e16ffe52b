use super::search::{Search, search};
use super::*;
use crate::bench::{Bench, PROBE, machine, put_bed, unwired};
use base::bench::words;
use base::failure::{Answer, Failure, FailureKind};
use base::hands::Hands;
use base::ports::Input;
use base::reason::Alarm;
use gcode::Code;
use motion::compensation::Bed as Shape;
use program::{Contact, ProbeAlong, ProbeDown, State};
use proptest::prelude::*;
use std::cell::Cell;
use std::rc::Rc;
use units::{Actuator, Axis, AxisSet, Micros, MmPerSecond, PerAxis};

/// Makes a machine that stands at this place over a bed.
fn over_a_bed(more: &str, place: [f64; 3], height: impl Fn(f64, f64) -> f64 + 'static) -> Bench {
    let mut bench = machine(&format!("{PROBE}{more}"), [-30.0; 3]);
    put_bed(&mut bench, height);
    bench.stand_at(place);
    bench
}

fn z(bench: &mut Bench) -> f64 {
    bench.position()[Axis::Z]
}

const DOWN: ProbeDown = ProbeDown { rate: None, reversed: false, stays: false, reads: None };

fn line_to(bench: &mut Bench, x: f64, z: f64, until: Contact, must_find: bool) -> ProbeAlong {
    let mut target = bench.position();
    (target[Axis::X], target[Axis::Z]) = (x, z);
    ProbeAlong { target, rate: Some(MmPerSecond(6.0)), until, must_find }
}

fn refusal(bench: &Bench, done: Result<Answer, Failure>) -> String {
    let failure = done.unwrap_err();
    assert!(failure.is_refusal(), "{}", bench.text_of(failure));
    bench.text_of(failure)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn the_bed_is_found_to_a_step_at_any_speed(bed in -5.0..9.0, rate in 0.5..12.0, stays in any::<bool>()) {
        let mut bench = over_a_bed("", [5.0, 5.0, 10.0], move |_, _| bed);
        let probe = ProbeDown { rate: Some(MmPerSecond(rate)), stays, reads: Some(2.5), ..DOWN };
        prop_assert_eq!(probe_down(&mut bench, &probe), Ok(Answer::Ok));
        let (found, reads) = bench.contact.expect("a contact");
        prop_assert!((found - bed).abs() < 0.021 && reads == 2.5, "{found}");
        let ends = if stays { found } else { 10.0 };
        prop_assert!((z(&mut bench) - ends).abs() < 0.011);
        prop_assert!((bench.world.places[Actuator::Gamma] - ends).abs() < 0.021);
        let said = bench.heard();
        prop_assert!(said.contains(&format!("Z:{:.4}", 10.0 - found)), "{said}");
        prop_assert_eq!(bench.state(), State::Idle);
    }

    #[test]
    fn three_touches_make_the_plane_of_the_bed(slope in -0.02..0.02, across in -0.02..0.02, offset in -1.0..1.0) {
        prop_assume!(f64::abs(slope) + f64::abs(across) > 0.005);
        let mut bench = over_a_bed(THREE_POINTS, [5.0, 5.0, 10.0], move |x, y| offset + slope * x + across * y);
        prop_assert!(strategy(&mut bench, &words("G32"), Code::g(32)).is_ok());
        let Shape::Plane(plane) = bench.motion(|motion| motion.compensation().bed()) else { panic!("no plane") };
        prop_assert!((plane.x - slope).abs() < 6e-4 && (plane.y - across).abs() < 6e-4, "{plane:?}");
        // The first point is where Z has its zero.
        prop_assert!((plane.z + plane.x * 2.0 + plane.y * 3.0).abs() < 1e-6, "{plane:?}");
    }

    #[test]
    fn a_grid_of_touches_levels_the_bed(bow in 0.0..0.002, tilt in -0.01..0.01) {
        let height = move |x: f64, y: f64| bow * (x - 20.0) * (y - 10.0) + tilt * x;
        let mut bench = over_a_bed(GRID, [5.0, 5.0, 10.0], height);
        let plan = prepare(&mut bench, &words("G32"), Code::g(32)).unwrap().expect("a grid");
        touch_cartesian_grid(&mut bench, &plan).unwrap();
        prop_assert_eq!(bench.motion(|motion| motion.compensation().bed()), Shape::Grid);
        let level = |bench: &mut Bench, x: f64, y: f64| {
            let mut place = PerAxis([0.0; units::MAX_AXES]);
            (place[Axis::X], place[Axis::Y]) = (x, y);
            bench.motion(|motion| motion.compensation().motors(&place))[Axis::Z]
        };
        for (x, y) in [(0.0, 0.0), (20.0, 10.0), (40.0, 20.0), (40.0, 0.0)] {
            let off = level(&mut bench, x, y) - level(&mut bench, 0.0, 0.0) - (height(x, y) - height(0.0, 0.0));
            prop_assert!(off.abs() < 0.025, "X{x} Y{y}: {off}");
        }
    }
}

const THREE_POINTS: &str = "leveling = three point\n[three point leveling strategy]\nhome_first = false\n\
    point1 = 2,3\npoint2 = 42,3\npoint3 = 2,33\n";
const GRID: &str = "leveling = cartesian grid\n[cartesian grid leveling strategy]\ndo_home = false\n\
    x_size = 40\ny_size = 20\ngrid_x_size = 3\ngrid_y_size = 3\ninitial_height = 10\n";

#[test]
fn a_bed_that_is_flat_needs_no_plane() {
    let mut bench = over_a_bed(THREE_POINTS, [5.0, 5.0, 10.0], |_, _| 1.5);
    assert_eq!(strategy(&mut bench, &words("G32"), Code::g(32)), Ok(Answer::Ok));
    assert!(bench.heard().contains("The bed is flat"));
    assert_eq!(bench.motion(|motion| motion.compensation().bed()), Shape::Flat);
    assert!(bench.motors.homed().has(Axis::Z), "Z is known by the first touch");
    assert_eq!(strategy(&mut bench, &words("G29"), Code::g(29)), Ok(Answer::Ok));
    assert!(bench.heard().contains("max delta: 0.000000"));
}

#[test]
fn the_plane_and_the_contact_are_shown() {
    let mut bench = over_a_bed(THREE_POINTS, [5.0, 5.0, 10.0], |x, _| 0.01 * x);
    strategy(&mut bench, &words("G31"), Code::g(31)).unwrap();
    let said = bench.heard();
    assert!(said.contains("plane is not set\n") && said.contains("Probe is Not triggered"), "{said}");
    strategy(&mut bench, &words("G32"), Code::g(32)).unwrap();
    assert!(bench.heard().contains("Bed leveling plane: Z = 0.01"));
    bench.world.wire_input(Input::Probe, |_| true);
    bench.wait_for(Micros::from_millis(1)).unwrap();
    strategy(&mut bench, &words("G31"), Code::g(31)).unwrap();
    assert!(bench.heard().contains("Probe is Triggered"));
}

#[test]
fn a_grid_that_the_probe_does_not_reach_is_refused_before_anything_moves() {
    let mut bench = over_a_bed(&GRID.replace("x_size = 40", "x_size = 400"), [5.0, 5.0, 10.0], |_, _| 0.0);
    bench.motors.mark_homed(AxisSet::PRIMARY);
    let failure = prepare(&mut bench, &words("G32"), Code::g(32)).unwrap_err();
    assert!(bench.text_of(failure).contains("X"), "{}", bench.text_of(failure));
    assert_eq!(bench.world.places[Actuator::Alpha], 5.0);
}

#[test]
fn a_bed_that_falls_away_between_two_points_ends_the_grid() {
    let mut bench = over_a_bed(GRID, [5.0, 5.0, 10.0], |x, _| if x > 30.0 { -25.0 } else { 0.0 });
    let plan = prepare(&mut bench, &words("G32"), Code::g(32)).unwrap().expect("a grid");
    let done = touch_cartesian_grid(&mut bench, &plan);
    let text = refusal(&bench, done);
    assert!(text.contains("far below the point before"), "{text}");
    assert!(bench.world.places[Actuator::Gamma] > 0.0, "the probe is lifted");
}

#[test]
fn the_objects_of_a_job_choose_a_part_of_the_grid() {
    let mut bench = over_a_bed(&GRID.replace("grid_x_size = 3", "grid_x_size = 5"), [5.0, 5.0, 10.0], |_, _| 0.0);
    let whole = prepare(&mut bench, &words("G32 D0"), Code::g(32)).unwrap().expect("a grid");
    assert_eq!(whole.shape.count, [5, 3]);
    assert!(bench.heard().contains("all of the bed is measured"));
    bench.area = Some([[11.0, 2.0], [19.0, 8.0]]);
    for margin in [0.0, 3.0, 8.0] {
        let plan = prepare(&mut bench, &words(&format!("G32 D{margin}")), Code::g(32)).unwrap().expect("a grid");
        let [[left, near], [right, far]] = crate::leveling::area::area_of(&plan.shape);
        assert!(left <= 11.0 - margin && right >= 19.0 + margin && left >= 0.0 && right <= 40.0, "{left} {right}");
        assert!(near <= f64::max(2.0 - margin, 0.0) && (8.0..=20.0).contains(&far), "{near} {far}");
        assert!(plan.shape.count[0] < 5, "it is a part");
    }
    bench.area = Some([[100.0, 2.0], [120.0, 8.0]]);
    let failure = prepare(&mut bench, &words("G32 D0"), Code::g(32)).unwrap_err();
    assert!(bench.text_of(failure).contains("lie beside the grid"));
}

#[test]
fn a_code_without_a_strategy_is_refused() {
    let mut bench = over_a_bed("", [5.0, 5.0, 10.0], |_, _| 0.0);
    let done = strategy(&mut bench, &words("G32"), Code::g(32));
    assert_eq!(refusal(&bench, done), "No strategy found to handle G32");
    assert_eq!(prepare(&mut bench, &words("G32"), Code::g(32)), Ok(None));
}

#[test]
fn without_a_probe_nothing_moves() {
    let mut bench = unwired("");
    assert_eq!(probe_down(&mut bench, &DOWN), Ok(Answer::Unknown));
    let line = line_to(&mut bench, 5.0, -5.0, Contact::Closes, true);
    assert!(refusal_text(&mut bench, &line).contains("no probe is configured"));
    assert_eq!(strategy(&mut bench, &words("G32"), Code::g(32)), Ok(Answer::Unknown));
    assert_eq!(repeatability(&mut bench, &words("M48")), Ok(Answer::Unknown));
    assert!(!bench.world.motor_power);
}

fn refusal_text(bench: &mut Bench, line: &ProbeAlong) -> String {
    let done = probe_along(bench, line);
    refusal(bench, done)
}

#[test]
fn a_machine_that_must_be_homed_probes_only_then() {
    let mut bench = machine(&format!("{PROBE}[motion control]\nmust_be_homed = true\n"), [-30.0; 3]);
    let failure = probe_down(&mut bench, &DOWN).unwrap_err();
    assert!(failure.is_alarm() && bench.text_of(failure).contains("Must be homed"));
    assert_eq!(bench.world.places[Actuator::Gamma], 0.0);
    bench.motors.mark_homed(AxisSet::PRIMARY);
    put_bed(&mut bench, |_, _| -3.0);
    assert_eq!(probe_down(&mut bench, &DOWN), Ok(Answer::Ok));
}

#[test]
fn a_search_ends_after_its_travel_and_says_so() {
    let mut bench = over_a_bed("", [0.0, 0.0, 10.0], |_, _| -50.0);
    let lowest = Rc::new(Cell::new(f64::INFINITY));
    let seen = lowest.clone();
    bench.world.wire_input(Input::Door, move |motors| {
        seen.set(seen.get().min(motors[Actuator::Gamma]));
        false
    });
    assert_eq!(probe_down(&mut bench, &DOWN), Ok(Answer::Ok));
    assert!(bench.heard().contains("ZProbe not triggered"));
    assert!((lowest.get() + 30.0).abs() < 0.02 && z(&mut bench) == 10.0, "{}", lowest.get());
    assert_eq!(bench.contact, None);
    bench.plays = true;
    let done = probe_down(&mut bench, &DOWN);
    assert_eq!(refusal(&bench, done), "ZProbe not triggered", "a file's next lines count on it");
}

#[test]
fn a_contact_that_is_closed_before_it_searches_is_refused_where_it_stands() {
    let mut bench = over_a_bed("", [0.0, 0.0, 1.0], |_, _| 2.0);
    let done = probe_down(&mut bench, &DOWN);
    assert!(refusal(&bench, done).contains("triggered before move"));
    assert_eq!((bench.world.places[Actuator::Gamma], bench.state()), (1.0, State::Idle));
}

#[test]
fn a_reversed_search_goes_up() {
    let mut bench = over_a_bed("", [0.0, 0.0, 1.0], |_, _| -100.0);
    bench.world.wire_input(Input::Probe, |motors| motors[Actuator::Gamma] >= 8.0);
    let probe = ProbeDown { reversed: true, stays: true, ..DOWN };
    assert_eq!(probe_down(&mut bench, &probe), Ok(Answer::Ok));
    assert!((z(&mut bench) - 8.0).abs() < 0.011);
    assert!(bench.heard().contains("Z:-7.0"));
}

#[test]
fn a_line_ends_where_the_contact_closes_or_opens() {
    let mut bench = over_a_bed("", [0.0, 0.0, 5.0], |x, _| if x > 12.0 { 6.0 } else { -20.0 });
    let line = line_to(&mut bench, 30.0, 5.0, Contact::Closes, true);
    assert_eq!(probe_along(&mut bench, &line), Ok(Answer::Ok));
    let ([x, _, z], found) = bench.last_probe.expect("a place");
    assert!(found && (x - 12.0).abs() < 0.03 && z == 5.0, "{x}");
    assert!(bench.heard().contains(":1]"));
    assert!((bench.world.places[Actuator::Alpha] - x).abs() < 0.03, "it stands there");
    let line = line_to(&mut bench, 0.0, 5.0, Contact::Opens, true);
    assert_eq!(probe_along(&mut bench, &line), Ok(Answer::Ok));
    assert!((bench.last_probe.expect("a place").0[0] - 12.0).abs() < 0.03);
}

#[test]
fn a_line_that_meets_nothing_halts_only_where_it_must_find() {
    let mut bench = over_a_bed("", [0.0, 0.0, 5.0], |_, _| -20.0);
    let line = line_to(&mut bench, 3.0, 5.0, Contact::Closes, false);
    assert_eq!(probe_along(&mut bench, &line), Ok(Answer::Ok));
    assert_eq!((bench.last_probe.map(|(_, found)| found), bench.alarm), (Some(false), None));
    assert!(bench.heard().contains(":0]"));
    let line = line_to(&mut bench, 6.0, 5.0, Contact::Closes, true);
    assert_eq!(probe_along(&mut bench, &line), Err(Failure::HALTED));
    assert_eq!(bench.alarm, Some(Alarm::ProbeMiss));
}

#[test]
fn a_search_that_cannot_begin_halts_a_sender_of_grbls_dialect_alone() {
    for (grbl, plays, halts) in [(true, false, true), (true, true, false), (false, false, false)] {
        let mut bench = over_a_bed("", [0.0, 0.0, 1.0], |_, _| 2.0);
        (bench.is_grbl, bench.plays) = (grbl, plays);
        let line = line_to(&mut bench, 5.0, 1.0, Contact::Closes, true);
        let failure = probe_along(&mut bench, &line).unwrap_err();
        assert_eq!(failure.kind == FailureKind::Alarm, halts, "{grbl} {plays}");
        assert_eq!(failure.alarm == Alarm::ProbeState, halts);
    }
}

/// A contact that sparks this often before it closes at Z 2.
fn sparking(sparks: usize) -> Bench {
    let mut bench = machine(&format!("{PROBE}debounce_ms = 2\n"), [-30.0; 3]);
    let (left, last) = (Cell::new(sparks), Cell::new(100.0_f64));
    bench.world.wire_input(Input::Probe, move |motors| {
        let z = motors[Actuator::Gamma];
        let crossed = last.get().ceil() > z.ceil();
        last.set(z);
        if crossed && left.get() > 0 {
            left.set(left.get() - 1);
            return true;
        }
        z <= 2.0
    });
    bench.stand_at([0.0, 0.0, 12.0]);
    bench
}

#[test]
fn a_spark_is_no_contact() {
    // The first look at the place where it stands takes one.
    let mut bench = sparking(3);
    assert_eq!(probe_down(&mut bench, &ProbeDown { stays: true, ..DOWN }), Ok(Answer::Ok));
    assert!((z(&mut bench) - 2.0).abs() < 0.011);
    let failure = probe_down(&mut sparking(40), &DOWN).unwrap_err();
    assert!(failure.is_alarm());
}

#[test]
fn a_hold_and_an_override_do_not_move_the_contact() {
    let mut bench = over_a_bed("", [0.0, 0.0, 10.0], |_, _| 3.0);
    bench.motion(|motion| motion.set_overrides(1.0, 0.5));
    bench.later(Micros::from_millis(300), Bench::hold);
    bench.later(Micros::from_millis(900), Bench::resume);
    let began = bench.now();
    assert_eq!(probe_down(&mut bench, &ProbeDown { stays: true, ..DOWN }), Ok(Answer::Ok));
    assert!((z(&mut bench) - 3.0).abs() < 0.011);
    let took = bench.now().since(began).0 as f64 / 1e6;
    assert!((2.2..3.2).contains(&took), "7 mm at 4 mm/s and a hold: {took} s");
}

#[test]
fn a_halt_in_a_search_leaves_the_filters_on() {
    let mut bench = over_a_bed("", [0.0, 0.0, 10.0], |_, _| 3.0);
    bench.later(Micros::from_millis(300), |bench| bench.halt(Alarm::Abort, format_args!("ALARM\n")));
    let down = Search::down(bench.position(), MmPerSecond(4.0), 20.0, false);
    assert_eq!(search(&mut bench, &down).unwrap_err(), Failure::HALTED);
    let before = bench.world.places[Actuator::Gamma];
    bench.wait_for(Micros::from_millis(300)).unwrap_err();
    assert!((bench.world.places[Actuator::Gamma] - before).abs() < 0.3 && before > 3.0);
}

#[test]
fn the_probe_dwells_before_it_searches() {
    let mut bench = over_a_bed("dwell_before_probing = 2\n", [0.0, 0.0, 4.0], |_, _| 3.0);
    assert_eq!(probe_down(&mut bench, &DOWN), Ok(Answer::Ok));
    assert!(bench.now() > Micros::from_seconds(2), "{:?}", bench.now());
}

#[test]
fn touches_of_a_place_are_averaged_and_must_agree() {
    let more = "samples = 3\nsamples_tolerance = 0.3\nsamples_retries = 1\nsamples_retract = 1\n";
    let contact = |heights: &'static [f64]| {
        let mut bench = machine(&format!("{PROBE}{more}"), [-30.0; 3]);
        bench.stand_at([5.0, 5.0, 8.0]);
        let (round, was) = (Cell::new(0), Cell::new(false));
        bench.world.wire_input(Input::Probe, move |motors| {
            let (z, height) = (motors[Actuator::Gamma], heights[round.get().min(heights.len() - 1)]);
            if was.get() && z > height + 0.5 {
                round.set(round.get() + 1);
                was.set(false);
            }
            was.set(was.get() || z <= height);
            was.get() && z <= height
        });
        bench
    };
    let mut bench = contact(&[2.0, 2.1, 2.2]);
    let found = touch_uncorrected(&mut bench, [5.0, 5.0], 8.0).unwrap();
    assert!((found[Axis::Z] - 2.1).abs() < 0.011, "{found:?}");
    let mut bench = contact(&[2.0, 2.9, 2.2, 2.0, 2.1, 2.0]);
    let found = touch_uncorrected(&mut bench, [5.0, 5.0], 8.0).unwrap();
    assert!((found[Axis::Z] - 2.0333).abs() < 0.011, "{found:?}");
    assert!(bench.heard().contains("touches at X5.0 Y5.0 lie 0.9"));
    let mut bench = contact(&[2.0, 2.9, 2.2, 2.0, 2.9, 2.0]);
    let failure = touch_uncorrected(&mut bench, [5.0, 5.0], 8.0).unwrap_err();
    assert!(failure.is_refusal() && bench.text_of(failure).contains("samples_tolerance is 0.3"));
}

#[test]
fn touching_here_comes_back_up() {
    let mut bench = over_a_bed("", [5.0, 6.0, 7.0], |x, y| 0.1 * x + 0.01 * y);
    let found = touch_here(&mut bench).unwrap();
    assert!((found[Axis::Z] - 0.56).abs() < 0.011 && z(&mut bench) == 7.0, "{found:?}");
}

#[test]
fn the_repeatability_of_a_still_bed_is_perfect() {
    let mut bench = over_a_bed("", [5.0, 5.0, 5.0], |_, _| 3.0);
    assert_eq!(repeatability(&mut bench, &words("M48 P4")), Ok(Answer::Ok));
    let said = bench.heard();
    assert_eq!(said.matches("Z:").count(), 4, "{said}");
    assert!(said.contains("Delta: 0.0000") && said.contains("Standard deviation: 0.0000"), "{said}");
    assert!(said.contains("Mean: 2.0") || said.contains("Mean: 1.99"), "{said}");
    let mut bench = over_a_bed("", [5.0, 5.0, 25.0], |_, _| 3.0);
    let done = repeatability(&mut bench, &words("M48 P4"));
    assert!(refusal(&bench, done).contains("within 20 mm"));
}

#[test]
fn lost_motion_is_the_way_between_closing_and_opening() {
    let mut bench = unwired(PROBE);
    let closed = Cell::new(false);
    // The contact opens 0.3 mm behind where it closes.
    bench.world.wire_input(Input::Probe, move |motors| {
        let x = motors[Actuator::Alpha];
        closed.set(if closed.get() { x > 9.7 } else { x >= 10.0 });
        closed.get()
    });
    lost_motion(&mut bench, Axis::X, 15.0).unwrap();
    let said = bench.heard();
    let mm: f64 = said.strip_prefix("X: ").and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!((mm - 0.3).abs() < 0.051, "{said}");
    assert_eq!(bench.position()[Axis::X], 0.0, "it goes back");
    let failure = lost_motion(&mut bench, Axis::X, 5.0).unwrap_err();
    assert!(bench.text_of(failure).contains("not triggered on its way"));
}

/// A probe that scripts bring out and stow, with an input that says so.
fn deployable() -> (Bench, Rc<Cell<bool>>) {
    let more = "deployed_pin = PC6\ndeploy_gcode = M280 S10\nstow_gcode = M280 S5\n";
    let mut bench = over_a_bed(more, [5.0, 5.0, 10.0], |_, _| 3.0);
    let out = Rc::new(Cell::new(false));
    let (sensed, moved) = (out.clone(), out.clone());
    bench.world.wire_input(Input::ProbeDeployed, move |_| sensed.get());
    bench.probe_script = Some(Box::new(move |key, _| {
        moved.set(key == "deploy_gcode");
        true
    }));
    (bench, out)
}

#[test]
fn a_search_brings_the_probe_out_and_its_command_stows_it() {
    let (mut bench, out) = deployable();
    let done = probe_down(&mut bench, &DOWN);
    assert_eq!(done, Ok(Answer::Ok));
    assert!(out.get() && bench.extra.deployment == Deployment::BySearch);
    assert_eq!(stow_after(&mut bench, done), Ok(Answer::Ok));
    assert!(!out.get() && bench.extra.deployment == Deployment::Stowed);
}

#[test]
fn a_probe_that_was_brought_out_by_hand_stays_until_it_is_stowed_by_hand() {
    let (mut bench, out) = deployable();
    assert_eq!(deploy_or_stow(&mut bench, true), Ok(Answer::Ok));
    assert!(out.get());
    let done = probe_down(&mut bench, &DOWN);
    assert_eq!(stow_after(&mut bench, done), Ok(Answer::Ok));
    assert!(out.get(), "M401 had brought it out");
    assert_eq!(deploy_or_stow(&mut bench, true), Ok(Answer::Ok));
    assert!(bench.heard().contains("the probe is deployed already"));
    assert_eq!(deploy_or_stow(&mut bench, false), Ok(Answer::Ok));
    assert!(!out.get());
}

#[test]
fn a_probe_that_does_not_come_out_does_not_search() {
    let (mut bench, out) = deployable();
    bench.probe_script = Some(Box::new(|_, _| true));
    let done = probe_down(&mut bench, &DOWN);
    assert!(refusal(&bench, done).contains("the probe is not deployed"));
    assert_eq!((bench.world.places[Actuator::Gamma], out.get()), (10.0, false));
    bench.probe_script = Some(Box::new(|_, _| false));
    probe_down(&mut bench, &DOWN).unwrap_err();
    assert_eq!(bench.extra.deployment, Deployment::Unknown);
    assert!(bench.heard().contains("deploy_gcode has not come to its end"));
}

#[test]
fn a_probe_that_came_off_is_not_searched_with() {
    let (mut bench, out) = deployable();
    assert_eq!(deploy_or_stow(&mut bench, true), Ok(Answer::Ok));
    out.set(false);
    bench.wait_for(Micros::from_millis(1)).unwrap();
    let done = probe_down(&mut bench, &DOWN);
    assert!(refusal(&bench, done).contains("has it come off?"));
    assert_eq!(bench.world.places[Actuator::Gamma], 10.0);
}

#[test]
fn behind_a_halt_the_probe_stays_out_and_it_is_said() {
    let (mut bench, out) = deployable();
    probe_down(&mut bench, &DOWN).unwrap();
    assert_eq!(stow_after(&mut bench, Err(Failure::HALTED)), Err(Failure::HALTED));
    assert!(out.get() && bench.extra.deployment == Deployment::ByCommand);
    assert!(bench.heard().contains("the probe is still deployed"));
}

#[test]
fn a_probe_that_does_not_stow_is_told() {
    let (mut bench, _) = deployable();
    let done = probe_down(&mut bench, &DOWN);
    bench.probe_script = Some(Box::new(|_, _| true));
    let stowed = stow_after(&mut bench, done);
    assert!(refusal(&bench, stowed).contains("still deployed"));
    assert_eq!(bench.extra.deployment, Deployment::ByCommand);
}

#[test]
fn hosts_may_ask_any_printer_to_bring_its_probe_out() {
    let mut bench = over_a_bed("", [0.0, 0.0, 5.0], |_, _| 0.0);
    assert_eq!(deploy_or_stow(&mut bench, true), Ok(Answer::PassedOver));
    assert_eq!(deploy_or_stow(&mut unwired(""), false), Ok(Answer::PassedOver));
}
