//! Holds, stops and overrides while filters run behind: how soon they are felt, and that nothing else
//! changes.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Axis, MmPerSecond, MmPerSecond2, MmPerSecond3};

use super::{
    curves,
    filters::{advances, shapers, within_filtered_goal},
    laws::{ideal, program},
    rig::{Rig, at, cases, printer},
};
use crate::{
    FilterConfig, Kinematics, Limits, MotionConfig, Move, State,
    kinematics::LinearDelta,
    oracle::{Ideal, StepError},
};

/// Printers with shapers and pressure advance, trapezoids and jerk, cartesian, corexy and delta.
fn machines() -> impl Strategy<Value = MotionConfig> {
    let jerk = prop::option::weighted(0.4, 20_000.0..500_000.0_f64);
    let kinematics = prop_oneof![3 => Just(0), 1 => Just(1), 1 => Just(2)];
    let filters = (prop::array::uniform3(shapers()), advances());
    (filters, jerk, kinematics, 500.0..6_000.0_f64, 8_usize..64).prop_map(
        |((shapers, advance), jerk, kinematics, acceleration, queue_size)| {
            let printer = printer();
            let mut config = MotionConfig {
                kinematics: match kinematics {
                    0 => Kinematics::Cartesian,
                    1 => Kinematics::CoreXy,
                    _ => Kinematics::LinearDelta(LinearDelta::default()),
                },
                filters: FilterConfig { shapers, advance: [advance, None, None] },
                limits: Limits {
                    acceleration: MmPerSecond2(acceleration),
                    jerk: jerk.map(MmPerSecond3),
                    ..printer.limits
                },
                queue_size,
                ..printer
            };
            if kinematics == 2 {
                for motor in config.actuators.0.iter_mut().take(3).flatten() {
                    motor.steps_per_mm = 80.0;
                }
            }
            config
        },
    )
}

/// A program, and whether its extruder does what extruders do.
fn programs() -> impl Strategy<Value = (Vec<Move>, bool)> {
    prop_oneof![
        2 => program().prop_map(|moves| (moves, false)),
        2 => curves::flat_programs().prop_map(|moves| (moves, false)),
        3 => lines().prop_map(|moves| (moves, true)),
    ]
}

/// Lines along the axes, with and without filament, of every length.
fn lines() -> impl Strategy<Value = Vec<Move>> {
    let line =
        (0_usize..4, -1.0..1.0_f64, prop_oneof![Just(20.0), Just(2.0), Just(0.3)], 10.0..300.0_f64, any::<bool>());
    prop::collection::vec(line, 1..40).prop_map(|lines| {
        let mut here = [0.0; 4];
        lines
            .into_iter()
            .map(|(axis, share, scale, feed, extrudes)| {
                let way = share * scale * if axis == 2 { 0.1 } else { 1.0 };
                here[axis] += way;
                here[3] += if extrudes && axis < 2 { 0.05 * way.abs() } else { 0.0 };
                Move::feed(at(here[0], here[1], here[2], here[3]), MmPerSecond(feed))
            })
            .collect()
    })
}

/// Event that happens to a running program.
#[derive(Clone, Copy, Debug)]
enum Event {
    Hold,
    Resume,
    /// Hold, resume, and a hold again, before the feed comes to do any of it.
    Stutter,
    Override(f64),
}

fn events() -> impl Strategy<Value = Vec<(u32, Event)>> {
    let event = prop_oneof![
        3 => Just(Event::Hold),
        3 => Just(Event::Resume),
        1 => Just(Event::Stutter),
        2 => (0.1..1.5_f64).prop_map(Event::Override),
    ];
    prop::collection::vec((0_u32..150, event), 0..12)
}

fn happen(rig: &mut Rig, event: Event) {
    match event {
        Event::Hold => rig.motion().hold(),
        Event::Resume => rig.motion().resume(),
        Event::Stutter => {
            rig.motion().hold();
            rig.motion().resume();
            rig.motion().hold();
        }
        Event::Override(factor) => rig.motion().set_overrides(factor, 1.0),
    }
}

/// A program under way: what fits is submitted.
struct Job<'a> {
    rig: Rig,
    waiting: &'a [Move],
}

impl<'a> Job<'a> {
    fn new(config: MotionConfig, moves: &'a [Move]) -> Self {
        let mut rig = Rig::new(config);
        rig.motion().set_position(at(0.0, 0.0, 0.0, 0.0)).expect("at rest");
        rig.tick();
        rig.counts = rig.motion().steps();
        Self { rig, waiting: moves }
    }

    fn tick(&mut self) {
        while let Some((next, rest)) = self.waiting.split_first()
            && self.rig.motion().submit(next).is_ok()
        {
            self.waiting = rest;
        }
        if self.waiting.is_empty() {
            self.rig.motion().flush();
        }
        self.rig.tick();
    }

    fn ticks(&mut self, count: u32) {
        for _ in 0..count {
            self.tick();
        }
    }

    fn finish(&mut self) {
        for _ in 0..4_000_000 {
            self.tick();
            if self.waiting.is_empty() && self.rig.motion().is_idle() {
                return;
            }
        }
        panic!("never idle: {:?}", self.rig.motion().state());
    }
}

/// Speed, acceleration and jerk along the path go on and stay within their limits, and so do those of X, Y
/// and Z, whose filters only average.
fn keeps_limits(rig: &Rig, config: &MotionConfig) -> Result<(), TestCaseError> {
    let limits = config.limits;
    let pieces = &rig.access.pieces;
    for (index, piece) in pieces.iter().enumerate() {
        let next = pieces.get(index + 1);
        let until =
            next.map_or(f64::INFINITY, |next| (next.start.to_num::<f64>() - piece.start.to_num::<f64>()) / 200e6);
        let t = until.min(piece.duration);
        let (speed, acceleration) = (piece.speed_at(t), piece.acceleration_at(t));
        let goes_on = until < piece.duration + 1e-6;
        let (after, pull) = match next {
            Some(next) if goes_on => (next.speed, next.acceleration),
            _ => (0.0, 0.0),
        };
        prop_assert!((speed - after).abs() < 1e-3, "speed jumps from {speed} to {after} after {piece:?}, {next:?}");
        if let Some(jerk) = limits.jerk {
            let jump = (acceleration - pull).abs();
            prop_assert!(
                jump < limits.acceleration.get() * 2e-3,
                "acceleration jumps by {jump} after {piece:?}, {next:?}"
            );
            prop_assert!(piece.duration < 1e-7 || piece.jerk.abs() <= jerk.get() * 1.001, "{piece:?}");
        }
        for acceleration in [piece.acceleration, acceleration] {
            prop_assert!(acceleration.abs() <= limits.acceleration.get() * 1.001, "{piece:?}");
        }
        for speed in [piece.speed, speed] {
            prop_assert!(speed > -1e-6, "backwards: {piece:?}");
            for (axis, limit) in Axis::PRIMARY.into_iter().zip(limits.axis_speed) {
                let own = (piece.tangent_after(0.0)[axis] * speed).abs();
                prop_assert!(own <= limit.map_or(f64::INFINITY, |limit| limit.get()) * 1.001, "{axis:?} at {own} mm/s");
            }
        }
    }
    Ok(())
}

/// Every edge against the reference: of X, Y and Z always, of the extruder where it moves as extruders do.
fn keeps_time(rig: &Rig, config: MotionConfig, sane: bool) -> Result<(), TestCaseError> {
    let ideal = ideal(rig, config);
    let mut error = StepError::default();
    for edge in rig.edges.iter().filter(|edge| sane || (edge.actuator as usize) < 3) {
        let distance = ideal.edge_error(edge.actuator, edge.at as f64 * 5.0, edge.count, edge.sign);
        prop_assert!(distance.is_some(), "{edge:?} belongs to no crossing");
        error.add(distance.unwrap_or_default());
    }
    within_filtered_goal(&error)
}

/// The output goes on where trajectory was taken back: X, Y and Z as if it had never been, extruders with
/// their corrections.
fn goes_on(ideal: &Ideal) -> Result<(), TestCaseError> {
    // Places only: filters put knots, and so these moments, where speeds may jump anyway. Edges tell of
    // speeds.
    for (at, place, _) in ideal.jumps() {
        for axis in Axis::ALL {
            prop_assert!(place[axis].abs() < 1e-7, "{axis:?} jumps by {} mm at {at} ns", place[axis]);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(6))]

    #[test]
    fn nothing_that_happens_loses_a_step_or_breaks_a_limit(
        (moves, sane) in programs(), config in machines(), events in events(), stop in prop::bool::weighted(0.3),
    ) {
        let mut job = Job::new(config, &moves);
        for (ticks, event) in events {
            job.ticks(ticks);
            happen(&mut job.rig, event);
        }
        if stop {
            job.rig.motion().stop();
            job.waiting = &[];
        } else {
            job.rig.motion().resume();
        }
        job.finish();
        let rig = &mut job.rig;
        let target = rig.motion().commanded_position();
        let motors = config.kinematics.actuators(&target);
        for (actuator, motor) in units::Actuator::ALL.into_iter().zip(config.actuators.0) {
            let off = f64::from(rig.counts[actuator]) - motors[actuator] * motor.map_or(0.0, |motor| motor.steps_per_mm);
            prop_assert!(off.abs() <= 0.500_001, "{:?} is {} steps off", actuator, off);
        }
        if !stop {
            // A move too short to count may be missing at the end.
            let wanted = moves.last().expect("a move").target;
            prop_assert!(Axis::ALL.into_iter().all(|axis| (target[axis] - wanted[axis]).abs() <= 1e-4), "ends at {target:?}");
        }
        prop_assert_eq!(rig.motion().state(), State::Running);
        // Chords in place of many short pieces keep to the path and its speeds, roughly.
        if rig.motion().counters().lumped == 0 {
            keeps_limits(rig, &config)?;
        }
        goes_on(&ideal(rig, config))?;
        keeps_time(rig, config, sane)?;
        prop_assert_eq!(rig.motion().counters().late, 0);
    }
}

/// Returns the time after `asked` at which the first axis does something else than its undisturbed twin, ns.
fn first_different(held: &Ideal, calm: &Ideal, asked: f64) -> Option<f64> {
    let differs = |after: &f64| {
        let at = asked + after;
        let (Some((_, held)), Some((_, calm))) = (held.machine(at), calm.machine(at)) else { return false };
        Axis::ALL.into_iter().any(|axis| (held[axis] - calm[axis]).abs() > 1e-8)
    };
    (0..5_000).map(|n| f64::from(n) * 2e4).find(differs)
}

/// The trajectory that holds in the end, before the filters.
fn unfiltered(rig: &Rig, config: MotionConfig) -> Ideal {
    let mut ideal = Ideal::new(MotionConfig { filters: FilterConfig::NONE, ..config });
    rig.access.pieces.iter().for_each(|piece| ideal.push(piece));
    ideal
}

/// Held or stopped somewhere, and its twin that was not.
struct Twins {
    held: Rig,
    calm: Rig,
    /// Time of the request, ns: right after the feed has run, which is the worst moment.
    asked: f64,
}

impl Twins {
    fn new(config: MotionConfig, moves: &[Move], before: u32, stop: bool) -> Self {
        let begin = || {
            let mut job = Job::new(config, moves);
            job.ticks(before);
            job
        };
        let (mut held, mut calm) = (begin(), begin());
        let asked = held.rig.now.since(super::rig::PERIOD).0 as f64 * 5.0;
        if stop {
            held.rig.motion().stop();
            held.waiting = &[];
        } else {
            held.rig.motion().hold();
        }
        held.ticks(200);
        calm.ticks(200);
        Self { held: held.rig, calm: calm.rig, asked }
    }

    /// Returns the time from the request until it is felt, ms.
    fn delay(&self, config: MotionConfig) -> f64 {
        let (held, calm) = (ideal(&self.held, config), ideal(&self.calm, config));
        first_different(&held, &calm, self.asked).map_or(f64::INFINITY, |delay| delay * 1e-6)
    }

    /// The twin moves any of these when a hold could first be felt.
    fn moves(&self, config: MotionConfig, axes: &[Axis]) -> bool {
        let calm = ideal(&self.calm, config);
        let velocity = calm.machine(self.asked + 1.5e6).map(|(_, velocity)| velocity);
        velocity.is_some_and(|velocity| axes.iter().any(|axis| velocity[*axis].abs() > 1e-3))
    }

    /// Returns the reason, if any, for which the request cannot be felt within two milliseconds.
    fn excuse(&self, config: MotionConfig) -> Option<&'static str> {
        let (held, calm) = (unfiltered(&self.held, config), unfiltered(&self.calm, config));
        if self.held.access.motion.counters().lumped > 0 {
            return Some("pieces so short that they are not remembered one by one");
        }
        // Without anything taken back the change comes at the head of the trajectory, two milliseconds ahead
        // at most.
        let taken = self.held.access.motion.last_taken_back().map(|taken| taken.from.to_num::<f64>() * 5.0);
        let (since, soon) = taken.map_or((self.asked, 2.03e6), |from| (from, 5e4));
        let Some(after) = first_different(&held, &calm, since).filter(|after| *after < soon) else {
            return Some("it brakes already, as hard as it may");
        };
        let from = taken.unwrap_or(since + after);
        let moving = |at: f64, axis: Axis| calm.machine(at).is_some_and(|(_, velocity)| velocity[axis].abs() > 1e-7);
        if Axis::ALL.into_iter().any(|axis| moving(from - 2e5, axis) && !moving(from + 6e4, axis)) {
            return Some("an axis has used all of its way");
        }
        None
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn a_hold_or_a_stop_is_felt_within_two_milliseconds(
        (moves, _) in programs(), config in machines(), before in 0_u32..600, stop in any::<bool>(),
    ) {
        prop_assume!(config.filters.latency() > 0.0);
        let twins = Twins::new(config, &moves, before, stop);
        let delay = twins.delay(config);
        // The difference is looked for every 20 us. The first change in the window of an extruder alone is
        // too little to see.
        let seen = if twins.moves(config, &Axis::PRIMARY) { 2.05 } else { 3.0 };
        if delay > seen && twins.moves(config, &Axis::ALL) {
            prop_assert!(twins.excuse(config).is_some(), "felt after {delay} ms of {} ms", config.filters.latency() * 1e3);
        }
    }
}
