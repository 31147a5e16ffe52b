//! Moves that are left out behind a hold, and the way to those behind them.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Actuator, MmPerSecond, PerAxis};

use super::{
    laws::{step_error, within_goal},
    rig::{Edge, Rig, at, cases, printer},
};
use crate::{
    Corner, FilterConfig, MotionConfig, Move, PressureAdvance, Shaper, ShaperKind, State,
    path::{Arc, Curve},
};

/// Two parts: a zigzag from X0 that is one, and one from X100 that is the other; so much of E is pushed by
/// each move. In each the fifth move is an arc.
fn two_parts(moves: usize, corner: Corner, filament: f64) -> Vec<Move> {
    let mut all = Vec::new();
    for (part, from) in [(1, 0.0), (2, 100.0)] {
        for n in 0..moves {
            let e = filament * all.len() as f64;
            let (x, y) = (from + 0.5 * (n + 1) as f64, if n % 2 == 0 { 4.0 } else { 0.0 });
            let mut request = Move { part, corner, ..Move::feed(at(x, y, 0.0, e), MmPerSecond(80.0)) };
            if n == 4 {
                let before: &Move = all.last().unwrap();
                let [dx, dy] = [x - before.target.0[0], y - before.target.0[1]];
                // Half a turn about the middle of the line.
                let arm = [-0.5 * dx, -0.5 * dy, 0.0];
                let ahead = [-arm[1], arm[0], 0.0];
                request.curve = Curve::Arc(Arc::new(arm, ahead, core::f64::consts::PI, 0.0));
                request.corner = Corner::Sharp;
            }
            all.push(request);
            if n == 0 && part == 2 {
                all.last_mut().unwrap().target.0[3] = all[all.len() - 2].target.0[3];
            }
        }
    }
    all
}

fn submit_all(rig: &mut Rig, moves: &[Move]) {
    for request in moves {
        rig.submit(request);
    }
    rig.motion().flush();
}

/// Returns the beginning of the second part's moves: that of a travel.
fn begin_of_second(moves: &[Move]) -> PerAxis<f64> {
    moves.iter().rfind(|request| request.part == 1).unwrap().target
}

/// Holds, leaves the first part out, declares E to be what the file counts, and goes over to the second.
fn leave_first_out(rig: &mut Rig, moves: &[Move]) -> Option<f64> {
    rig.motion().hold();
    for _ in 0..4_000 {
        rig.tick();
        if rig.motion().is_held_still() {
            break;
        }
    }
    let here = rig.motion().held_at();
    let left: Vec<_> = rig.motion().waiting().collect();
    let dropped = left.iter().take_while(|waiting| waiting.request.part == 1).count();
    if dropped == 0 {
        // The machine has come to rest in the second part.
        return None;
    }
    let begin = begin_of_second(moves);
    let counted = PerAxis([here.0[0], here.0[1], here.0[2], begin.0[3], 0.0, 0.0]);
    let up = PerAxis([here.0[0], here.0[1], 0.4, begin.0[3], 0.0, 0.0]);
    let over = PerAxis([begin.0[0], begin.0[1], 0.4, begin.0[3], 0.0, 0.0]);
    let way = [up, over, begin].map(|target| Move::rapid(target, MmPerSecond(200.0)));
    assert_eq!(rig.motion().go_round(dropped, counted, &way), Ok(()));
    assert_eq!(rig.motion().state(), State::Held);
    rig.motion().resume();
    Some(begin.0[3] - here.0[3])
}

/// The steps of a motor behind the last one of Z, from where it then is, or of all.
fn steps_behind_lift(edges: &[Edge], motor: Actuator) -> Vec<i32> {
    let from = edges.iter().rposition(|edge| edge.actuator == Actuator::Gamma).map_or(0, |last| last + 1);
    edges.iter().skip(from).filter(|edge| edge.actuator == motor).map(|edge| edge.count).collect()
}

const FILTERED: usize = 3;

fn configs() -> [MotionConfig; 4] {
    let plain = MotionConfig { queue_size: 250, ..printer() };
    let (mut jerk, mut ratio, mut filtered) = (plain, plain, plain);
    jerk.limits.jerk = Some(units::MmPerSecond3(100_000.0));
    ratio.limits.cruise_ratio = 0.5;
    let shaper = Some(Shaper { kind: ShaperKind::Mzv, frequency: 40.0, damping: 0.1 });
    let mut filters = FilterConfig { shapers: [shaper, shaper, None], ..FilterConfig::NONE };
    filters.advance[0] = Some(PressureAdvance { factor: 0.04, smooth_time: 0.02 });
    filtered.filters = filters;
    [plain, jerk, ratio, filtered]
}

proptest! {
    #![proptest_config(cases(12))]

    #[test]
    fn what_follows_is_made_as_without_what_is_left_out(
        kind in 0_usize..4, before in 1_u32..900, size in 40_usize..110, rounded in any::<bool>(),
        pushes in any::<bool>(),
    ) {
        let config = configs()[kind];
        let corner = if rounded { Corner::Rounded(0.05) } else { Corner::Sharp };
        let moves = two_parts(size, corner, if pushes { 0.03 } else { 0.0 });
        let mut whole = Rig::new(config);
        submit_all(&mut whole, &moves);
        whole.finish();
        let mut rig = Rig::new(config);
        submit_all(&mut rig, &moves);
        let mut ticks = 0;
        while ticks < before && rig.motion().part_now() == Some(1) {
            rig.tick();
            ticks += 1;
        }
        prop_assume!(rig.motion().part_now() == Some(1));
        let (e_before, edges_before) = (rig.counts[Actuator::Delta], rig.edges.len());
        let shift = leave_first_out(&mut rig, &moves);
        prop_assume!(shift.is_some());
        rig.finish();
        prop_assert_eq!(rig.motion().counters().late, 0);
        prop_assert_eq!(rig.motion().commanded_position(), moves.last().unwrap().target);
        // Nothing but the way to rest is pushed of what is left out.
        let pushed = rig.edges[edges_before..].iter().filter(|edge| edge.actuator == Actuator::Delta);
        let of_second: f64 = moves.last().unwrap().target.0[3] - begin_of_second(&moves).0[3];
        let braking = f64::from(pushed.map(|edge| edge.sign).sum::<i32>()) / 400.0 - of_second;
        prop_assert!((-0.2..0.1).contains(&braking), "{braking} mm pushed while braking from {e_before}");
        // X and Y come to the end by the same steps.
        for motor in [Actuator::Alpha, Actuator::Beta] {
            let (mut some, all) = (steps_behind_lift(&rig.edges, motor), steps_behind_lift(&whole.edges, motor));
            if kind == FILTERED {
                // The deviation of a shaper at a corner depends on the speed there, which is another at
                // first.
                some.drain(..some.len() / 2);
            }
            prop_assert!(some.len() > 100 && all.ends_with(&some), "{motor:?}: {} of {}", some.len(), all.len());
        }
        let off = f64::from(rig.counts[Actuator::Delta]) - 400.0 * (moves.last().unwrap().target.0[3] - shift.unwrap_or(0.0));
        prop_assert!(off.abs() <= 1.5, "E is {off} steps off");
        // The oracle knows of no position that was declared.
        if !pushes {
            let error = step_error(&rig, config)?;
            within_goal(&error)?;
        }
    }
}
