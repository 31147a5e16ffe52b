use super::*;
use crate::bench::{Bench, machine, unwired};
use base::ports::Input;
use base::reason::Alarm;
use proptest::prelude::*;
use std::cell::Cell;
use std::rc::Rc;
use units::{Actuator, Micros};

const X: AxisSet = AxisSet::of(Axis::X);
const Z: AxisSet = AxisSet::of(Axis::Z);
/// Places of the switches for most tests, mm of the motors, and what they mean to the machine.
const SWITCHES: [f64; 3] = [-7.3, -4.2, -1.25];
const PLACES: [f64; 3] = [0.0, -2.0, 0.0];

fn reads(bench: &mut Bench) -> [f64; 3] {
    use base::hands::Hands;
    let position = bench.position();
    Axis::PRIMARY.map(|axis| position[axis])
}

/// Asserts that the machine knows to a step where its motors truly are.
fn assert_knows(bench: &mut Bench, switches: [f64; 3], places: [f64; 3]) {
    let (reads, truly) = (reads(bench), bench.world.places);
    for axis in 0..3 {
        let off = truly.0[axis] - switches[axis] - (reads[axis] - places[axis]);
        assert!(off.abs() < 0.03, "axis {axis} is {off} mm off");
    }
}

fn homed(bench: &Bench) -> AxisSet {
    bench.motors.homed()
}

fn fails(bench: &mut Bench, set: AxisSet, alarm: Alarm, text: &str) {
    let failure = home(bench, set).unwrap_err();
    assert_eq!((failure.alarm, failure.kind), (alarm, FailureKind::Alarm), "{}", bench.text_of(failure));
    assert!(bench.text_of(failure).contains(text), "{}", bench.text_of(failure));
    assert_eq!(homed(bench), AxisSet::NONE);
    assert!(bench.overheard().contains("ERROR: Homing cycle failed"));
    use base::hands::Hands;
    assert_eq!(bench.latch().armed(), 0, "nothing stays armed");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn homing_finds_the_switches_wherever_they_are(
        x in -50.0..-0.1, y in -50.0..-0.1, z in -40.0..-0.1, z_first in any::<bool>()
    ) {
        let mut bench = machine(&format!("common.home_z_first = {z_first}\n"), [x, y, z]);
        home(&mut bench, AxisSet::NONE).unwrap();
        assert_knows(&mut bench, [x, y, z], PLACES);
        prop_assert_eq!(reads(&mut bench), PLACES);
        prop_assert!(homed(&bench).has_all(AxisSet::PRIMARY));
    }

    #[test]
    fn homing_ends_where_a_preflight_says(limit in any::<bool>(), offset in -3.0..3.0) {
        let more = format!("minx.limit_enable = {limit}\ncommon.move_to_origin_after_home = {}\n", !limit);
        let mut bench = machine(&more, SWITCHES);
        bench.settings.set_home_offset(Axis::Y, offset);
        let config = base::hands::Hands::config(&bench);
        let ends = ends_at(config, &bench.settings, AxisSet::NONE, &PerAxis([9.0; units::MAX_AXES]));
        home(&mut bench, AxisSet::NONE).unwrap();
        let reads = reads(&mut bench);
        for axis in Axis::PRIMARY {
            prop_assert!((reads[axis as usize] - ends[axis]).abs() < 1e-6, "{:?} {:?}", reads, ends);
        }
        prop_assert_eq!(ends[Axis::A], 9.0);
    }
}

#[test]
fn only_the_named_axis_moves_and_counts_as_homed() {
    let mut bench = machine("", SWITCHES);
    home(&mut bench, X).unwrap();
    assert_eq!(homed(&bench), X);
    assert_eq!((bench.world.places[Actuator::Beta], bench.world.places[Actuator::Gamma]), (0.0, 0.0));
    assert!((bench.world.places[Actuator::Alpha] + 7.3).abs() < 0.03);
}

#[test]
fn what_has_no_switch_cannot_be_homed() {
    let mut bench = unwired("");
    let failure = home(&mut bench, AxisSet::of(Axis::A)).unwrap_err();
    assert!(failure.is_refusal() && bench.text_of(failure).contains("nothing to home"));
    assert!(!bench.world.motor_power, "the motors stay as they are");
}

#[test]
fn an_axis_that_stands_on_its_switch_homes_too() {
    let mut bench = machine("", [3.0, 0.5, 1.0]);
    home(&mut bench, AxisSet::NONE).unwrap_err();
    let mut bench = machine("", [2.0, 0.5, 1.0]);
    home(&mut bench, AxisSet::NONE).unwrap();
    assert_knows(&mut bench, [2.0, 0.5, 1.0], PLACES);
}

#[test]
fn a_switch_out_of_reach_is_an_alarm_and_nothing_counts_as_homed() {
    let mut bench = machine("", [-7.0, -61.0, -1.0]);
    bench.motors.mark_homed(AxisSet::PRIMARY);
    fails(&mut bench, AxisSet::NONE, Alarm::HomingSearch, "Y miny: endstop was not reached within its travel");
    assert!((bench.world.places[Actuator::Beta] + 60.0).abs() < 0.03, "it has gone as far as it may");
}

#[test]
fn a_switch_that_never_opens_is_told_from_one_that_is_not_found() {
    let mut bench = unwired("");
    bench.world.wire_input(Input::Endstop(0), |_| true);
    fails(&mut bench, X, Alarm::HomingPullOff, "X minx: endstop does not open when backed off");
}

/// Closes for a single look at each whole millimetre, `sparks` times, and truly at -7.3 mm.
fn sparking(bench: &mut Bench, sparks: usize) {
    let (left, last) = (Cell::new(sparks), Cell::new(0.0_f64));
    bench.world.wire_input(Input::Endstop(0), move |motors| {
        let x = motors[Actuator::Alpha];
        let crossed = last.get().ceil() != x.ceil() && x < last.get();
        last.set(x);
        if crossed && left.get() > 0 {
            left.set(left.get() - 1);
            return true;
        }
        x <= -7.3
    });
}

#[test]
fn a_spark_is_no_switch() {
    let mut bench = unwired("");
    sparking(&mut bench, 3);
    home(&mut bench, X).unwrap();
    assert!((bench.world.places[Actuator::Alpha] + 7.3).abs() < 0.03);
    let mut bench = unwired("");
    sparking(&mut bench, 30);
    fails(&mut bench, X, Alarm::HomingSearch, "X minx: endstop fires but does not stay operated");
}

#[test]
fn a_hold_on_the_way_changes_nothing_about_the_place() {
    let mut bench = machine("", SWITCHES);
    for (hold, resume) in [(50, 700), (900, 1_500)] {
        bench.later(Micros::from_millis(hold), Bench::hold);
        bench.later(Micros::from_millis(resume), Bench::resume);
    }
    home(&mut bench, AxisSet::NONE).unwrap();
    assert_knows(&mut bench, SWITCHES, PLACES);
    assert_eq!(base::hands::Hands::state(&bench), program::State::Idle);
}

#[test]
fn a_halt_ends_homing_and_leaves_the_axis_unknown() {
    use base::hands::Hands;
    for after in [30, 200, 600] {
        let mut bench = machine("", [-40.0, -40.0, -1.0]);
        bench.later(Micros::from_millis(after), |bench| bench.halt(Alarm::Abort, format_args!("ALARM\n")));
        assert_eq!(home(&mut bench, AxisSet::NONE), Err(Failure::HALTED), "after {after} ms");
        assert!(homed(&bench).and(AxisSet::PRIMARY).is_empty());
        let before = bench.world.places;
        bench.wait_for(Micros::from_millis(500)).unwrap_err();
        assert!(bench.motion(|motion| motion.is_idle()));
        assert!((bench.world.places[Actuator::Alpha] - before[Actuator::Alpha]).abs() < 3.0, "it brakes");
    }
}

#[test]
fn filters_and_compensation_are_as_before_behind_a_homing() {
    use base::hands::Hands;
    for switches in [SWITCHES, [-100.0; 3]] {
        for was in [false, true] {
            let mut bench = machine("", switches);
            bench.motion(|motion| motion.suspend_compensation(was)).unwrap();
            let _ = home(&mut bench, AxisSet::NONE);
            assert_eq!(bench.motion(|motion| motion.compensation().is_suspended()), was);
        }
    }
}

#[test]
fn z_rises_before_x_and_y_move_and_goes_to_its_own_place() {
    let mut bench = machine("common.home_lift = 5\ncommon.safe_z_x = 20\ncommon.safe_z_y = 10\n", SWITCHES);
    let (lowest, z_began) = (Rc::new(Cell::new(f64::INFINITY)), Rc::new(Cell::new(None)));
    let (seen, began) = (lowest.clone(), z_began.clone());
    bench.world.wire_input(Input::Door, move |motors| {
        let [x, y, z] = [0, 1, 2].map(|axis| motors.0[axis]);
        if x != 0.0 {
            seen.set(seen.get().min(if z < 4.9 && began.get().is_none() {
                began.set(Some([x, y]));
                z
            } else {
                seen.get()
            }));
        }
        false
    });
    home(&mut bench, AxisSet::NONE).unwrap();
    let [x, y] = z_began.get().expect("Z came down");
    assert!((x - SWITCHES[0] - 20.0).abs() < 0.03 && (y - SWITCHES[1] - 12.0).abs() < 0.03, "{x} {y}");
    assert!(lowest.get() > 4.0, "{}", lowest.get());
}

#[test]
fn z_does_not_home_at_its_place_before_x_and_y_are_known() {
    let mut bench = machine("common.safe_z_x = 20\n", SWITCHES);
    let failure = home(&mut bench, Z).unwrap_err();
    assert!(failure.is_refusal() && bench.text_of(failure).contains("home X and Y first"));
    assert_eq!(bench.world.places[Actuator::Gamma], 0.0);
}

#[test]
fn the_order_is_the_one_asked_for() {
    for (order, first) in [("ZXY", 2), ("YZX", 1), ("XYZ", 0)] {
        let mut bench = machine(&format!("common.homing_order = {order}\n"), SWITCHES);
        let moved = Rc::new(Cell::new(None));
        let seen = moved.clone();
        bench.world.wire_input(Input::Door, move |motors| {
            let moves = (0..3).filter(|axis| motors.0[*axis] != 0.0).collect::<Vec<_>>();
            if moves.len() == 1 && seen.get().is_none() {
                seen.set(Some(moves[0]));
            }
            false
        });
        home(&mut bench, AxisSet::NONE).unwrap();
        assert_eq!(moved.get(), Some(first), "{order}");
        assert_knows(&mut bench, SWITCHES, PLACES);
    }
}

/// Wires a switch of X that closes at the next of these places in each approach, mm.
fn loose(bench: &mut Bench, places: &'static [f64]) {
    let (round, was) = (Cell::new(0), Cell::new(false));
    bench.world.wire_input(Input::Endstop(0), move |motors| {
        let (x, place) = (motors[Actuator::Alpha], places[round.get().min(places.len() - 1)]);
        if was.get() && x > place + 1.0 {
            round.set(round.get() + 1);
            was.set(false);
        }
        was.set(was.get() || x <= place);
        was.get() && x <= place
    });
}

#[test]
fn approaches_that_disagree_are_repeated_and_their_mean_counts() {
    let more = "common.homing_samples = 2\ncommon.homing_tolerance = 0.1\ncommon.homing_retries = 1\n";
    let mut bench = unwired(more);
    loose(&mut bench, &[-7.0, -7.0, -6.5, -6.9, -7.0]);
    home(&mut bench, X).unwrap();
    assert!(bench.heard().contains("// X: 2 approaches within"), "it is said");
    // The second round has found it at 0.1 and at 0.
    let off = bench.world.places[Actuator::Alpha] + 7.0 - 0.05;
    assert!(off.abs() < 0.03, "{off}");
    let mut bench = unwired(more);
    loose(&mut bench, &[-7.0, -7.0, -6.5, -7.0, -6.5, -7.0, -6.5]);
    let failure = home(&mut bench, X).unwrap_err();
    assert!(bench.text_of(failure).contains("approaches lie 0.5"), "{}", bench.text_of(failure));
}

#[test]
fn measuring_tells_how_far_off_a_machine_was() {
    let mut bench = machine("", SWITCHES);
    home(&mut bench, X).unwrap();
    assert!(measure(&mut bench, Axis::X, 3).unwrap().abs() < 0.03);
    bench.heard();
    bench.world.places[Actuator::Alpha] += 1.5;
    let off = measure(&mut bench, Axis::X, 3).unwrap();
    assert!((off + 1.5).abs() < 0.03, "{off}");
    assert!(bench.heard().contains("3 approaches within 0.0000 mm, standard deviation 0.0000 mm"));
}

#[test]
fn an_axis_leaves_a_switch_that_is_a_limit() {
    let mut bench = machine("minx.limit_enable = true\n", SWITCHES);
    home(&mut bench, AxisSet::NONE).unwrap();
    assert_eq!(reads(&mut bench), [3.0, -2.0, 0.0]);
    assert_knows(&mut bench, SWITCHES, PLACES);
}

#[test]
fn a_line_that_homes_is_run_by_its_owner_before_probing() {
    let mut bench = machine("common.home_gcode = G28 X0\n", SWITCHES);
    let failure = home_before_probing(&mut bench).unwrap_err();
    assert!(failure.is_refusal() && bench.text_of(failure).contains("home_gcode"));
    bench.motors.mark_homed(AxisSet::PRIMARY);
    home_before_probing(&mut bench).unwrap();
    assert_eq!(bench.world.places[Actuator::Alpha], 0.0, "nothing has moved");
    let mut bench = machine("", SWITCHES);
    home_before_probing(&mut bench).unwrap();
    assert!(homed(&bench).has_all(AxisSet::PRIMARY));
}

#[test]
fn overrides_do_not_move_the_place() {
    use base::hands::Hands;
    for feed in [0.3, 2.0] {
        let mut bench = machine("", SWITCHES);
        bench.motion(|motion| motion.set_overrides(feed, 1.0));
        home(&mut bench, AxisSet::NONE).unwrap();
        assert_knows(&mut bench, SWITCHES, PLACES);
    }
}

/// A machine whose X homes against its end, which is at -20 mm; the load's reserve on the way is `free`.
fn against_its_end(free: u16, stalls_at: &'static [f64]) -> Bench {
    let more = "minx.stall_homing = true\nminx.stall_current = 0.6\nminx.stall_threshold = 5\nminx.slow_rate = 40\nminx.retract = 15\n";
    let mut bench = unwired(more);
    bench.world.bank.reserve = free;
    loose(&mut bench, stalls_at);
    bench
}

#[test]
fn an_axis_homes_against_its_end_and_backs_off_it() {
    let mut bench = against_its_end(400, &[-20.0]);
    base::hands::Hands::motion(&mut bench, |motion| motion.set_overrides(0.5, 0.7));
    home(&mut bench, X).unwrap();
    assert_eq!(reads(&mut bench)[0], 15.0, "it does not go on pushing");
    assert!((bench.world.places[Actuator::Alpha] + 5.0).abs() < 0.1);
    assert_eq!(bench.world.bank.searching[Actuator::Alpha], None, "the driver is as before");
    let overrides = base::hands::Hands::motion(&mut bench, |motion| motion.overrides());
    assert_eq!((overrides.feed, overrides.rapid), (0.5, 0.7));
}

#[test]
fn a_stall_on_the_way_is_not_taken_for_the_end() {
    let failed = |mut bench: Bench| {
        let failure = home(&mut bench, X).unwrap_err();
        assert_eq!(bench.world.bank.searching[Actuator::Alpha], None, "the driver is set back");
        bench.text_of(failure)
    };
    assert!(failed(against_its_end(60, &[-20.0])).contains("stalls before its end"));
    assert!(failed(against_its_end(400, &[-20.0, -12.0])).contains("stalls before its end"));
    assert!(failed(against_its_end(400, &[-20.0, -30.0])).contains("does not stall where it did at first"));
    assert!(failed(against_its_end(400, &[-90.0])).contains("did not stall within its travel"));
}

#[test]
fn the_search_for_a_stall_is_set_in_the_driver() {
    let mut bench = against_its_end(400, &[-20.0]);
    let during = Rc::new(Cell::new(None));
    let seen = during.clone();
    bench.later(Micros::from_millis(100), move |bench| seen.set(bench.world.bank.searching[Actuator::Alpha]));
    home(&mut bench, X).unwrap();
    let search = during.get().expect("a search was under way");
    assert_eq!((search.current, search.threshold), (Some(units::Amps(0.6)), 5));
    let mut bench = against_its_end(400, &[-20.0]);
    bench.world.bank.fault = Some(base::ports::DriverFault::Silent);
    let failure = home(&mut bench, X).unwrap_err();
    assert!(failure.is_alarm());
}

/// A linear delta whose carriages stand so high, mm, with switches at the upper ends.
fn delta(carriages: [f64; 3], switches: [f64; 3]) -> Bench {
    let mut bench = Bench::new(DELTA);
    for (index, place) in switches.into_iter().enumerate() {
        bench.world.wire_input(Input::Endstop(index as u8), move |motors| motors.0[index] >= place);
    }
    for (motor, mm) in Actuator::ALL.into_iter().zip(carriages) {
        bench.world.put(motor, mm);
    }
    bench
}

const DELTA: &str = "\
[motion control]
arm_solution = linear_delta
default_acceleration = 1000
[linear delta]
arm_length = 100
arm_radius = 50
[actuator]
alpha.steps_per_mm = 40
alpha.step_pin = PD3
alpha.dir_pin = PD4
beta.steps_per_mm = 40
beta.step_pin = PK2
beta.dir_pin = PG2
gamma.steps_per_mm = 40
gamma.step_pin = PG3
gamma.dir_pin = PG4
[endstops]
common.move_to_origin_after_home = false
maxx.enable = true
maxx.pin = PD0^
maxx.axis = X
maxx.homing_direction = home_to_max
maxx.max_travel = 90
maxx.fast_rate = 50
maxx.retract = 3
maxy.enable = true
maxy.pin = PI1^
maxy.axis = Y
maxy.homing_direction = home_to_max
maxy.max_travel = 90
maxy.fast_rate = 50
maxy.retract = 3
maxz.enable = true
maxz.pin = PI0^
maxz.axis = Z
maxz.homing_direction = home_to_max
maxz.homing_position = 120
maxz.max_travel = 90
maxz.fast_rate = 50
maxz.retract = 3
";

#[test]
fn the_towers_of_a_delta_home_together_and_the_tool_is_in_the_middle() {
    for named in [AxisSet::NONE, X, Z] {
        // Where the carriages begin, and where the switches sit by their own count.
        let (carriages, switches) = ([10.0, 25.0, 40.0], [60.0, 61.5, 59.0]);
        let mut bench = delta(carriages, switches);
        home(&mut bench, named).unwrap();
        let [x, y, z] = reads(&mut bench);
        assert!(x.abs() < 0.03 && y.abs() < 0.03 && (z - 120.0).abs() < 0.03, "{x} {y} {z}");
        for (motor, place) in Actuator::ALL.into_iter().zip(switches) {
            assert!((bench.world.places[motor] - place).abs() < 0.06, "{:?}", bench.world.places);
        }
        assert!(homed(&bench).has_all(AxisSet::PRIMARY));
        use base::hands::Hands;
        let config = bench.motion_config().unwrap();
        assert!(matches!(config.kinematics, motion::Kinematics::LinearDelta(_)), "they are in force again");
    }
}
