//! The feed on demand: the same steps as by period, and whatever is asked for is felt sooner.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Actuator, MmPerSecond, MmPerSecond3, Ticks};

use super::rig::{Edge, Rig, at, cases, printer};
use crate::{FilterConfig, MotionConfig, Move, PressureAdvance, Shaper, ShaperKind, State};

/// Greatest end of the written steps after the run: the moment before a start, and the longest segment.
const FARTHEST: Ticks = Ticks::from_micros(700);

fn filtered() -> MotionConfig {
    let shaper = |frequency| Some(Shaper { kind: ShaperKind::Mzv, frequency, damping: 0.1 });
    let advance = Some(PressureAdvance { factor: 0.04, smooth_time: 0.04 });
    MotionConfig {
        filters: FilterConfig { shapers: [shaper(40.0), shaper(50.0), None], advance: [advance, None, None] },
        ..printer()
    }
}

/// Lines of every length and direction, some of which are but a step.
fn submit(rig: &mut Rig, lines: &[(f64, f64)]) {
    let (mut x, mut y) = (0.0, 0.0);
    for (dx, dy) in lines {
        (x, y) = (x + dx, y + dy);
        rig.submit(&Move::feed(at(x, y, 0.0, 0.05 * x), MmPerSecond(150.0)));
    }
    rig.motion().flush();
}

/// Edges by the time since the first.
fn edges(rig: &Rig) -> Vec<(u64, Actuator, i32)> {
    let first = rig.edges.first().map_or(0, |edge| edge.at);
    rig.edges.iter().map(|Edge { at, actuator, sign, .. }| (at - first, *actuator, *sign)).collect()
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn steps_are_the_same_as_by_period(
        lines in prop::collection::vec((-3.0..3.0_f64, -0.1..0.1_f64), 1..30),
        filters in any::<bool>(), jerk in any::<bool>(),
    ) {
        let config = || {
            let mut config = if filters { filtered() } else { printer() };
            config.limits.jerk = jerk.then_some(MmPerSecond3(100_000.0));
            config
        };
        let (mut by_period, mut on_demand) = (Rig::new(config()), Rig::on_demand(config()));
        for rig in [&mut by_period, &mut on_demand] {
            submit(rig, &lines);
            rig.finish();
        }
        prop_assert!(on_demand.access.motion.counters().late == 0 && on_demand.access.motion.counters().urgent == 0);
        let (expected, found) = (edges(&by_period), edges(&on_demand));
        prop_assert_eq!(expected.len(), found.len());
        for (expected, found) in expected.iter().zip(&found) {
            // The two runs begin at other parts of a tick.
            prop_assert!((expected.1, expected.2) == (found.1, found.2) && expected.0.abs_diff(found.0) <= 2);
        }
    }

    #[test]
    fn a_hold_is_felt_before_the_lead_and_a_segment_are_over(
        length in 0.3..3.0_f64, before in 1_u32..400, filters in any::<bool>(),
    ) {
        let config = || if filters { filtered() } else { printer() };
        let (mut held, mut free) = (Rig::on_demand(config()), Rig::on_demand(config()));
        for rig in [&mut held, &mut free] {
            let lines = [(length, 0.1 * length); 30];
            submit(rig, &lines);
            for _ in 0..before {
                rig.tick();
            }
        }
        let (asked, made) = (held.now, held.edges.len());
        held.motion().hold();
        let was_moving = held.motion().current_block().is_some();
        for rig in [&mut held, &mut free] {
            while rig.motion().state() == State::Holding || !(rig.motion().state() == State::Held || rig.motion().is_idle()) {
                rig.tick();
            }
            rig.tick();
            rig.tick();
            rig.tick();
        }
        let (held, free) = (held.edges, free.edges);
        let alike = held.iter().zip(&free).take_while(|(held, free)| held == free).last();
        // The move may brake anyhow in its second half.
        if let Some((last, _)) = alike.filter(|_| was_moving && 2 * made < free.len()) {
            prop_assert!(last.at <= asked.plus(FARTHEST).0, "{} us", last.at.saturating_sub(asked.0) / 200);
        }
    }
}
