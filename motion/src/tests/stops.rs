//! Hold, resume, stop, abort, override, triggers: new trajectories from the present state.

use proptest::prelude::*;
use units::{Actuator, MmPerSecond, Ticks};

use super::{
    laws::{step_error, within_goal},
    rig::{Rig, at, printer},
};
use crate::{Move, State, queue::StepEvent};

fn long_run(feed: f64) -> Rig {
    let mut rig = Rig::new(printer());
    for index in 1..=40 {
        let x = f64::from(index) * 2.0;
        rig.submit(&Move::feed(at(x, 0.3 * x, 0.0, 0.1 * x), MmPerSecond(feed)));
    }
    rig.motion().flush();
    rig
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_hold_brakes_soon_and_a_resume_loses_nothing(
        feed in 10.0..400.0_f64, before in 1_u32..400, halfway in any::<bool>(), pause in 0_u32..40,
    ) {
        let mut rig = long_run(feed);
        for _ in 0..before {
            rig.tick();
        }
        rig.motion().hold();
        if !halfway {
            while rig.motion().state() == State::Holding {
                rig.tick();
            }
            prop_assert_eq!(rig.motion().speed(), MmPerSecond(0.0));
            let edges = rig.edges.len();
            for _ in 0..10 {
                rig.tick();
            }
            let rest = rig.edges.get(edges..).unwrap_or_default();
            prop_assert!(rest.iter().all(|edge| edge.at < rig.now.0 - 600_000), "still stepping 2 ms after the hold");
        }
        for _ in 0..pause {
            rig.tick();
        }
        rig.motion().resume();
        rig.finish();
        prop_assert_eq!(rig.counts.0, [6_400, 1_920, 0, 3_200, 0, 0]);
        let error = step_error(&rig, printer())?;
        within_goal(&error)?;
        prop_assert_eq!(rig.access.motion.counters().late, 0);
        for piece in &rig.access.pieces {
            prop_assert!(piece.acceleration.abs() <= 3_003.0, "{piece:?}");
        }
    }

    #[test]
    fn deceleration_begins_within_the_horizon_of_a_stop(feed in 50.0..400.0_f64, before in 150_u32..300) {
        let mut rig = long_run(feed);
        for _ in 0..before {
            rig.tick();
        }
        prop_assume!(rig.motion().speed().get() > 0.9 * feed);
        // Time as if asked right after the feed had run.
        let asked = rig.now.since(super::rig::PERIOD);
        let known = rig.access.pieces.len();
        rig.motion().stop();
        rig.finish();
        let first = rig.access.pieces.get(known).expect("a braking piece");
        prop_assert!(first.acceleration < 0.0);
        let delay = crate::trajectory::whole_ticks(first.start).since(asked);
        prop_assert!(delay <= Ticks::from_micros(1_500), "{} ns", delay.nanoseconds());
        let error = step_error(&rig, printer())?;
        within_goal(&error)?;
        let place = rig.motion().commanded_position();
        let off = f64::from(rig.counts[Actuator::Alpha]) - place.0[0] * 80.0;
        prop_assert!(off.abs() <= 0.500_001, "{off} steps off");
    }

    #[test]
    fn an_override_changes_speed_within_the_acceleration(
        feed in 20.0..200.0_f64, before in 1_u32..300, factor in 0.1..2.0_f64, again in 0.1..2.0_f64,
    ) {
        let mut rig = long_run(feed);
        for _ in 0..before {
            rig.tick();
        }
        rig.motion().set_overrides(factor, 1.0);
        for _ in 0..30 {
            rig.tick();
        }
        rig.motion().set_overrides(again, 1.0);
        rig.finish();
        prop_assert_eq!(rig.counts.0, [6_400, 1_920, 0, 3_200, 0, 0]);
        for piece in &rig.access.pieces {
            prop_assert!(piece.acceleration.abs() <= 3_003.0, "{piece:?}");
        }
        for pair in rig.access.pieces.windows(2) {
            let cut = (pair[1].start - pair[0].start).to_num::<f64>() / 200e6;
            let speed = pair[0].speed_at(cut.min(pair[0].duration));
            prop_assert!((speed - pair[1].speed).abs() < 1e-3, "{speed} jumps to {}", pair[1].speed);
        }
        let error = step_error(&rig, printer())?;
        within_goal(&error)?;
    }

    #[test]
    fn a_trigger_tells_the_steps_at_its_tick(feed in 5.0..300.0_f64, before in 20_u32..300, late in 0_u32..99_999) {
        let mut rig = long_run(feed);
        for _ in 0..before {
            rig.tick();
        }
        rig.latch.arm(0b100);
        let tick = rig.now.plus(Ticks(u64::from(late)));
        rig.feed.run(rig.now, &mut rig.access, &rig.queue, &rig.latch);
        rig.play_until(tick);
        let then = rig.counts;
        rig.latch.report(2, tick.0 as u32, &rig.queue);
        rig.now = rig.now.plus(super::rig::PERIOD);
        rig.play_until(rig.now);
        rig.finish();
        let trigger = rig.motion().take_trigger().expect("it fired");
        prop_assert_eq!((trigger.input, trigger.at, trigger.steps), (2, tick, then));
        prop_assert!(rig.motion().take_trigger().is_none());
        prop_assert!(rig.motion().is_idle());
    }

    #[test]
    fn a_hard_trigger_stops_at_its_tick_and_tells_where(feed in 5.0..500.0_f64, before in 20_u32..300, late in 0_u32..99_999) {
        let mut rig = long_run(feed);
        for _ in 0..before {
            rig.tick();
        }
        rig.latch.arm_hard(0b100);
        let tick = rig.now.plus(Ticks(u64::from(late)));
        rig.feed.run(rig.now, &mut rig.access, &rig.queue, &rig.latch);
        rig.play_until(tick);
        let (then, edges) = (rig.counts, rig.edges.len());
        rig.latch.report(2, tick.0 as u32, &rig.queue);
        rig.finish();
        prop_assert_eq!(rig.edges.len(), edges, "not a step more");
        let trigger = rig.motion().take_trigger().expect("it fired");
        prop_assert_eq!((trigger.input, trigger.at, trigger.steps), (2, tick, then));
        prop_assert!(rig.motion().is_idle());
        prop_assert_eq!(rig.motion().steps(), then);
        // The machine moves as ever from there on.
        rig.submit(&Move::feed(at(0.0, 0.0, 0.0, 0.0), MmPerSecond(50.0)));
        rig.finish();
        prop_assert_eq!(rig.counts.0, [0; 6]);
    }

    #[test]
    fn steps_made_go_on_whatever_position_is_declared(
        ways in proptest::collection::vec((-30.0..30.0_f64, -500.0..500.0_f64, 0_u8..4, 0_u32..99), 1..8),
    ) {
        let mut rig = Rig::new(printer());
        for (way, declared, ends, before) in ways {
            let here = rig.motion().commanded_position();
            rig.submit(&Move::feed(at(here.0[0] + way, here.0[1] - 0.37 * way, here.0[2], 0.0), MmPerSecond(60.0)));
            rig.motion().flush();
            for _ in 0..before {
                rig.tick();
            }
            match ends {
                0 => rig.queue.cut(),
                1 => rig.motion().stop(),
                _ => {}
            }
            rig.finish();
            let made = rig.access.motion.steps_made(&rig.access.motion.steps());
            prop_assert_eq!(made, rig.counts);
            let (steps, motion) = (rig.motion().steps(), rig.motion());
            motion.set_position(at(declared, way, 0.0, declared)).expect("at rest");
            prop_assert_eq!(motion.steps_made(&motion.steps()), made, "before the feed knows");
            rig.tick();
            let changed = rig.motion().steps() != steps;
            prop_assert!(changed && rig.access.motion.steps_made(&rig.access.motion.steps()) == made);
        }
    }

    #[test]
    fn an_abort_leaves_the_position_where_the_motors_are(feed in 5.0..300.0_f64, before in 1_u32..300, cut in any::<bool>()) {
        let mut rig = long_run(feed);
        for _ in 0..before {
            rig.tick();
        }
        if cut { rig.queue.cut() } else { rig.motion().abort() }
        prop_assert!(cut || !rig.motion().is_idle());
        let edges = rig.edges.len();
        rig.tick();
        prop_assert_eq!(rig.edges.len(), edges, "nothing is played after the cut");
        prop_assert!(rig.motion().is_idle());
        prop_assert_eq!(rig.motion().steps(), rig.counts);
        let place = rig.motion().commanded_position();
        prop_assert!((place.0[0] * 80.0 - f64::from(rig.counts[Actuator::Alpha])).abs() < 1e-9);
        // The machine moves as ever from there on.
        rig.submit(&Move::feed(at(0.0, 0.0, 0.0, 0.0), MmPerSecond(50.0)));
        rig.finish();
        prop_assert_eq!(rig.counts.0, [0; 6]);
    }
}

#[test]
fn a_hold_at_any_moment_of_a_short_move_ends_held() {
    for ticks in 0..60 {
        let mut rig = Rig::new(printer());
        rig.submit(&Move::feed(at(1.0, 0.0, 0.0, 0.0), MmPerSecond(100.0)));
        rig.motion().flush();
        for _ in 0..ticks {
            rig.tick();
        }
        rig.motion().hold();
        for _ in 0..200 {
            rig.tick();
        }
        assert_eq!(rig.motion().state(), State::Held, "held {ticks} feed periods after the start");
        rig.motion().resume();
        rig.finish();
        assert_eq!(rig.counts.0, [80, 0, 0, 0, 0, 0]);
    }
}

#[test]
fn a_declared_position_moves_no_motor() {
    let mut rig = long_run(100.0);
    rig.finish();
    rig.motion().set_position(at(0.0, 10.0, 0.0, 0.0)).expect("idle");
    rig.tick();
    assert_eq!(rig.motion().steps().0, [0, 800, 0, 0, 0, 0]);
    let edges = rig.edges.len();
    rig.submit(&Move::feed(at(1.0, 10.0, 0.0, 0.0), MmPerSecond(50.0)));
    rig.finish();
    assert_eq!(rig.edges.len() - edges, 80);
    assert_eq!(rig.motion().live_position(), at(1.0, 10.0, 0.0, 0.0));
}

#[test]
fn a_feed_that_comes_too_late_is_counted_and_still_keeps_every_step() {
    let mut rig = long_run(100.0);
    for _ in 0..100 {
        rig.tick();
    }
    rig.now = rig.now.plus(Ticks::from_micros(10_000));
    rig.play_until(rig.now);
    rig.finish();
    assert!(rig.access.motion.counters().late > 0 && rig.access.motion.counters().urgent > 0);
    assert_eq!(rig.counts.0, [6_400, 1_920, 0, 3_200, 0, 0]);
    assert!(rig.events.is_sorted_by(|a: &(u64, StepEvent), b| a.0 <= b.0));
}
