//! Tests of the travel by homing and by configuration, and of moves that leave it.

use super::*;
use config::EndstopConfig;
use motion::geometry::{Arc, ArcShape};
use motion::path::Path;
use proptest::prelude::*;
use units::Mm;

fn machine() -> MachineConfig {
    let mut config = MachineConfig::default();
    config.soft_endstops.enable = true;
    config
}

fn stop(axis: Axis, homing_direction: HomingDirection, position: f64, travel: f64) -> EndstopConfig {
    EndstopConfig {
        axis: Some(axis),
        homing_direction,
        homing_position: Mm(position),
        max_travel: Mm(travel),
        ..EndstopConfig::default()
    }
}

/// Returns a mill: X from -5 to 215, Y without switch, Z from -100 to 0.
fn mill() -> MachineConfig {
    let mut config = machine();
    config.endstops.push(stop(Axis::X, HomingDirection::ToMin, -5.0, 220.0)).unwrap();
    config.endstops.push(stop(Axis::Z, HomingDirection::ToMax, 0.0, 100.0)).unwrap();
    config
}

fn travel(config: &MachineConfig) -> Travel {
    corrected(config, &Tuning::new(config))
}

fn corrected(config: &MachineConfig, tuning: &Tuning) -> Travel {
    Travel::default().up_to_date(config, tuning).clone()
}

fn at(x: f64, y: f64, z: f64) -> PerAxis<f64> {
    PerAxis([x, y, z, 0.0, 0.0, 0.0])
}

#[test]
fn travel_ends_at_the_switch_and_max_travel_from_it() {
    let travel = travel(&mill());
    let from = at(0.0, 0.0, 0.0);
    for inside in [at(-5.0, -1e6, -100.0), at(215.0, 1e6, 0.0), at(215.000_05, 0.0, 0.0)] {
        assert_eq!(travel.check(&from, &inside, AxisSet::ALL), Ok(()), "{inside:?}");
        assert!(travel.has(&inside, AxisSet::ALL), "{inside:?}");
    }
    for (target, axis, end) in [
        (at(-5.1, 0.0, 0.0), Axis::X, -5.0),
        (at(215.1, 0.0, 0.0), Axis::X, 215.0),
        (at(0.0, 0.0, 0.1), Axis::Z, 0.0),
        (at(0.0, 0.0, -101.0), Axis::Z, -100.0),
    ] {
        let out = travel.check(&from, &target, AxisSet::ALL).unwrap_err();
        assert_eq!(out, OutOfTravel { axis, target: target[axis], end });
        assert!(!travel.has(&target, AxisSet::ALL) && travel.has(&target, AxisSet::ALL.without(AxisSet::of(axis))));
        assert_eq!(travel.check(&from, &target, AxisSet::ALL.without(AxisSet::of(axis))), Ok(()), "not homed");
    }
    let out = travel.check(&from, &at(300.0, 0.0, 0.0), AxisSet::ALL).unwrap_err();
    let text = "machine X 300.000 is out of travel, which ends at 215.000 ([soft endstop] x_max)";
    assert_eq!(out.to_string(), text);
}

#[test]
fn a_correction_moves_the_end_and_a_probe_above_the_bed_does_not_hide_it() {
    let mut config = mill();
    config.endstops.push(stop(Axis::Y, HomingDirection::ToMin, 0.0, 200.0)).unwrap();
    let mut tuning = Tuning::new(&config);
    tuning.set_home_offset(Axis::Y, -2.0);
    let offset = corrected(&config, &tuning);
    assert_eq!(offset.check(&at(0.0, 0.0, 0.0), &at(0.0, -2.0, 0.0), AxisSet::ALL), Ok(()));
    assert!(offset.check(&at(0.0, 0.0, 0.0), &at(0.0, -2.1, 0.0), AxisSet::ALL).is_err());

    let mut printer = machine();
    printer.endstops.push(stop(Axis::Z, HomingDirection::ToMin, 1.5, 200.0)).unwrap();
    let printer = travel(&printer);
    assert_eq!(printer.check(&at(0.0, 0.0, 1.5), &at(0.0, 0.0, 0.0), AxisSet::ALL), Ok(()));
    assert!(printer.check(&at(0.0, 0.0, 1.5), &at(0.0, 0.0, -0.1), AxisSet::ALL).is_err());
}

#[test]
fn of_towers_and_arms_only_the_top_of_a_delta_is_known() {
    let mut config = machine();
    for axis in Axis::ALL {
        config.endstops.push(stop(axis, HomingDirection::ToMax, 250.0, 300.0)).unwrap();
    }
    let from = at(0.0, 0.0, 0.0);
    let far = PerAxis([-1e4, 1e4, -1e4, 1e4, 1e4, 1e4]);
    for arms in [ArmSolution::LinearDelta, ArmSolution::RotaryDelta, ArmSolution::Morgan, ArmSolution::Winch] {
        config.motion.arm_solution = arms;
        assert_eq!(travel(&config).check(&from, &far, AxisSet::ALL), Ok(()), "{arms:?}");
    }
    config.motion.arm_solution = ArmSolution::LinearDelta;
    let mut tuning = Tuning::new(&config);
    tuning.set_trim([0.0, -0.5, 0.2]);
    let delta = corrected(&config, &tuning);
    assert_eq!(delta.check(&from, &at(0.0, 0.0, 250.5), AxisSet::ALL), Ok(()));
    assert!(delta.check(&from, &at(0.0, 0.0, 251.0), AxisSet::ALL).is_err());
}

#[test]
fn what_the_configuration_says_counts_in_place_of_homing_and_where_nothing_homes() {
    let mut config = mill();
    config.soft_endstops.least = [Some(Mm(-8.0)), Some(Mm(1.0)), None];
    config.soft_endstops.most = [None, Some(Mm(2.0)), Some(Mm(-1.0))];
    let [least, most] = travel(&config).ends();
    let by_axis = Axis::PRIMARY.map(|axis| (least[axis], most[axis]));
    assert_eq!(by_axis, [(-8.0, 215.0), (1.0, 2.0), (-100.0, -1.0)]);
    for arms in [ArmSolution::LinearDelta, ArmSolution::Morgan] {
        config.motion.arm_solution = arms;
        let out = travel(&config).check(&at(0.0, 1.5, -5.0), &at(0.0, 3.0, -5.0), AxisSet::ALL);
        assert_eq!(out, Err(OutOfTravel { axis: Axis::Y, target: 3.0, end: 2.0 }), "{arms:?}");
    }
}

#[test]
fn switched_off_nothing_is_out_until_it_is_switched_on_or_homing_is_corrected() {
    let (mut config, to) = (mill(), at(300.0, 0.0, 0.0));
    let is_free = |travel: &Travel| travel.check(&at(0.0, 0.0, 0.0), &to, AxisSet::ALL).is_ok();
    let mut tuning = Tuning::new(&config);
    let mut travel = Travel::default();
    assert!(is_free(&travel) && !is_free(travel.up_to_date(&config, &tuning)));
    travel.switch(false);
    assert!(is_free(travel.up_to_date(&config, &tuning)));
    tuning.set_home_offset(Axis::X, 100.0);
    assert!(is_free(travel.up_to_date(&config, &tuning)), "what M211 says stays");
    travel.switch(true);
    assert!(is_free(travel.up_to_date(&config, &tuning)), "X ends at 315");
    tuning.set_home_offset(Axis::X, 0.0);
    assert!(!is_free(travel.up_to_date(&config, &tuning)), "X ends at 215 again");
    config.soft_endstops.enable = false;
    assert!(is_free(Travel::default().up_to_date(&config, &tuning)));
    assert!(!is_free(travel.up_to_date(&config, &tuning)), "M211 is stronger");
}

#[test]
fn a_move_out_of_travel_is_refused_or_halts_as_configured() {
    let mut config = mill();
    let out = OutOfTravel { axis: Axis::Z, target: -101.0, end: -100.0 };
    let text = "machine Z -101.000 is out of travel, which ends at -100.000 ([soft endstop] z_min)";
    for (halts, kind) in [(false, FailureKind::Refused), (true, FailureKind::Alarm)] {
        config.soft_endstops.halt = halts;
        let texts = Texts::new();
        let failure = out.failure(&texts, &config);
        assert_eq!((failure.kind, failure.reason, failure.alarm), (kind, Reason::Target, Alarm::SoftLimit));
        assert_eq!(texts.of(failure).to_string(), text);
    }
}

#[test]
fn a_jog_along_two_axes_ends_where_its_line_leaves_the_travel() {
    let travel = travel(&mill());
    let cut = travel.cut(&at(205.0, 0.0, 0.0), &at(225.0, 40.0, 0.0), AxisSet::ALL);
    assert_eq!(cut, at(215.0, 20.0, 0.0));
}

proptest! {
    /// From anywhere: the way inwards is free, no move goes further out than it begins, and a cut move passes
    /// the check.
    #[test]
    fn a_move_from_outside_may_come_closer_only(from in -500.0..500.0_f64, to in -500.0..500.0_f64) {
        let travel = travel(&mill());
        let outside = |x: f64| (-5.0 - x).max(x - 215.0).max(0.0);
        let (start, target) = (at(from, 0.0, 0.0), at(to, 3.0, 0.0));
        let same_side = (from - 105.0) * (to - 105.0) > 0.0;
        let allowed = outside(to) <= ROUNDING || same_side && outside(to) <= outside(from) + ROUNDING;
        let check = travel.check(&start, &target, AxisSet::ALL);
        prop_assert_eq!(check.is_ok(), allowed, "{:?}", check);
        let cut = travel.cut(&start, &target, AxisSet::ALL);
        prop_assert!(travel.check(&start, &cut, AxisSet::ALL).is_ok());
        prop_assert!((cut[Axis::X] - from) * (to - from) >= 0.0, "turned back: {:?}", cut);
        prop_assert_eq!(cut == target, check.is_ok());
    }

    /// A curve passes exactly when the straight ways from its beginning to all its places do.
    #[test]
    fn an_arc_passes_when_every_place_of_it_does(
        x in -100.0..320.0_f64, centre in (-150.0..150.0_f64, -150.0..150.0_f64), clockwise in any::<bool>(),
    ) {
        let (travel, from) = (travel(&mill()), at(x, 0.0, -50.0));
        let (plane, (to_centre_first, to_centre_second)) = (units::Plane::Xz, centre);
        let shape = ArcShape { plane, to_centre_first, to_centre_second, clockwise, turns: 1 };
        let arc = Arc::new(from, from, &shape).expect("a circle");
        let (_, curve) = arc.parts(1).next().expect("a part");
        let path = Path::new(from, &from, curve.length(), curve);
        let place = |n: u32| path.point(curve.length() * f64::from(n) / 10_000.0);
        let all = (0..=10_000).all(|n| travel.check(&from, &place(n), AxisSet::ALL).is_ok());
        let whole = travel.check_bounds(&from, &arc.bounds(), AxisSet::ALL);
        // Between two places the curve bulges by a ten-thousandth of a mm.
        let narrowly = whole.is_err_and(|out| {
            let beyond = if out.target < out.end { out.end - out.target } else { out.target - out.end };
            beyond < 10.0 * ROUNDING
        });
        prop_assert!(whole.is_ok() == all || narrowly, "{whole:?}");
    }
}
