//! No power where nothing may burn: at rest, in rapids, and behind the end.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Axis, MmPerSecond};

use super::{by_speed, constant, duties, machines, plain, with_laser};
use crate::{
    Mode, MotionConfig, Move, State,
    tests::{
        laws::ideal,
        rig::{Rig, at, cases},
    },
};

/// Working moves of X and Y with power, and rapids of Z.
pub fn jobs() -> impl Strategy<Value = Vec<Move>> {
    let step = (-15.0..15.0_f64, -15.0..15.0_f64, prop_oneof![Just(1.0), Just(0.05)], 0..65_535_u16, any::<bool>());
    let one = (step, 20.0..300.0_f64, prop::bool::weighted(0.2));
    prop::collection::vec(one, 2..30).prop_map(|steps| {
        let mut here = [0.0; 3];
        let mut move_on = |((x, y, scale, level, follows), feed, rapid): ((f64, f64, f64, u16, bool), f64, bool)| {
            here = if rapid {
                [here[0], here[1], here[2] + 0.05 * x]
            } else {
                [here[0] + x * scale, here[1] + y * scale, here[2]]
            };
            let power = if follows { by_speed(level) } else { constant(level) };
            let mode = if rapid { Mode::Rapid } else { Mode::Feed };
            Move { power, mode, ..Move::feed(at(here[0], here[1], here[2], 0.0), MmPerSecond(feed)) }
        };
        steps.into_iter().map(&mut move_on).collect()
    })
}

/// Wherever X and Y rest for a tenth of a millisecond there is no power.
pub fn is_dark_at_rest(rig: &Rig, config: MotionConfig) -> Result<(), TestCaseError> {
    let (ideal, duties) = (ideal(rig, config), duties(rig));
    let speed = |at: f64| {
        let velocity = ideal.machine(at).map_or([0.0; 2], |(_, velocity)| [velocity[Axis::X], velocity[Axis::Y]]);
        velocity[0].abs() + velocity[1].abs()
    };
    for (index, (from, duty)) in duties.iter().enumerate().filter(|(_, (_, duty))| *duty > 0) {
        let until = duties.get(index + 1).map_or(f64::INFINITY, |next| next.0);
        prop_assert!(until.is_finite(), "{duty} for ever since {from} ns");
        let mut at = from + 5e4;
        while at < until - 5e4 {
            let rests = [at - 5e4, at, at + 5e4].into_iter().all(|at| speed(at) == 0.0);
            prop_assert!(!rests, "{duty} at rest, at {at} ns");
            at += 5e4;
        }
    }
    Ok(())
}

/// Event that happens to a job under way.
#[derive(Clone, Copy, Debug)]
enum Event {
    Hold,
    Resume,
    Override(f64),
    Power(f32),
}

fn events() -> impl Strategy<Value = Vec<(u32, Event)>> {
    let event = prop_oneof![
        3 => Just(Event::Hold),
        3 => Just(Event::Resume),
        1 => (0.1..1.5_f64).prop_map(Event::Override),
        1 => (0.0..2.0_f32).prop_map(Event::Power),
    ];
    prop::collection::vec((0_u32..150, event), 0..12)
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn there_is_no_power_at_rest_in_rapids_and_behind_the_end(
        moves in jobs(), config in machines(), events in events(), stop in prop::bool::weighted(0.3),
    ) {
        let mut rig = with_laser(config, plain());
        let mut waiting = moves.iter().peekable();
        for (ticks, event) in events {
            for _ in 0..ticks {
                while waiting.peek().is_some_and(|next| rig.motion().submit(next).is_ok()) {
                    waiting.next();
                }
                rig.tick();
                let is_still = rig.motion().is_held_still();
                prop_assert!(!is_still || duties(&rig).last().is_none_or(|last| last.1 == 0), "held with power");
            }
            match event {
                Event::Hold => rig.motion().hold(),
                Event::Resume => rig.motion().resume(),
                Event::Override(factor) => rig.motion().set_overrides(factor, 1.0),
                Event::Power(factor) => rig.motion().set_power_override(factor),
            }
        }
        if stop {
            rig.motion().stop();
        } else {
            rig.motion().resume();
            waiting.for_each(|request| rig.submit(request));
        }
        rig.finish();
        prop_assert_eq!(rig.motion().state(), State::Running);
        is_dark_at_rest(&rig, config)?;
        prop_assert_eq!(rig.motion().counters().late, 0);
    }
}
