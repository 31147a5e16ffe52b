//! Tags and marks: they come when the motors do, whatever happens on the way, and change no step.

use std::vec::Vec;

use proptest::prelude::*;
use units::{MmPerSecond, MmPerSecond3};

use super::{
    filters::shapers,
    rig::{Edge, Rig, at, cases, printer},
};
use crate::{Corner, FilterConfig, Mark, MotionConfig, Move, Passed, Tag};

/// Position of X after each move, mm: always further on.
fn places() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.02..6.0_f64, 2..40).prop_map(|lengths| {
        lengths
            .iter()
            .scan(0.0, |x, length| {
                *x += length;
                Some(*x)
            })
            .collect()
    })
}

/// Observation at each run of the feed: the progress of the motors, and the position of X.
type Seen = Vec<(Passed, f64)>;

fn look(rig: &Rig, seen: &mut Seen) {
    seen.push((rig.access.motion.passed(), rig.before));
}

/// Runs the moves, with a mark behind each, and holds and resumes at these ticks.
fn run(config: MotionConfig, places: &[f64], feed: f64, marks: bool, holds: &[u16]) -> (Vec<Edge>, Seen, Vec<Mark>) {
    let (mut rig, mut seen, mut made) = (Rig::new(config), Vec::new(), Vec::new());
    for (index, place) in places.iter().enumerate() {
        let tag = Tag(index as u32 + 1);
        let request = Move { tag, corner: Corner::Sharp, ..Move::feed(at(*place, 0.0, 0.0, 0.0), MmPerSecond(feed)) };
        while rig.motion().submit(&request).is_err() {
            rig.tick();
            look(&rig, &mut seen);
        }
        rig.motion().plan();
        if marks {
            made.push(rig.motion().mark().expect("room"));
        }
    }
    rig.motion().flush();
    let mut holds = holds.iter().copied().peekable();
    for tick in 0..200_000_u32 {
        if holds.next_if(|at| u32::from(*at) == tick).is_some() {
            rig.motion().hold();
            for _ in 0..400 {
                rig.tick();
                look(&rig, &mut seen);
            }
            rig.motion().resume();
        }
        rig.tick();
        look(&rig, &mut seen);
        if rig.motion().is_idle() {
            break;
        }
    }
    (rig.edges, seen, made)
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn a_mark_is_reached_in_the_period_in_which_the_motors_come_there(
        places in places(), feed in 1.0..400.0_f64, jerk in prop::option::of(20_000.0..500_000.0_f64),
        mut holds in prop::collection::vec(0_u16..400, 0..3),
    ) {
        holds.sort_unstable();
        holds.dedup();
        let mut config = printer();
        config.limits.jerk = jerk.map(MmPerSecond3);
        let (_, seen, made) = run(config, &places, feed, true, &holds);
        let step = 1.0 / 80.0;
        for (index, (place, mark)) in places.iter().zip(&made).enumerate() {
            let first = seen.iter().position(|(passed, _)| mark.is_reached_with(passed.mark)).expect("it is reached");
            let (now, x) = seen[first];
            prop_assert!(x >= place - step, "mark {index} is reached at {x}, its place is {place}");
            let before = if first == 0 { 0.0 } else { seen[first - 1].1 };
            prop_assert!(before <= place + step, "mark {index} is reached at {x}, the period before X was at {before} past {place}");
            // The next move is told from then on.
            let last = index + 1 == places.len();
            prop_assert!(last || now.tag.0 as usize >= index + 2, "{now:?}");
        }
        let (passed, _) = seen.last().unwrap();
        prop_assert_eq!(passed.tag, Tag(places.len() as u32));
    }

    #[test]
    fn marks_change_no_step_and_filters_lose_none(
        places in places(), feed in 1.0..400.0_f64, shapers in prop::array::uniform3(shapers()),
        mut holds in prop::collection::vec(0_u16..400, 0..3),
    ) {
        holds.sort_unstable();
        holds.dedup();
        let mut config = printer();
        config.filters = FilterConfig { shapers, ..FilterConfig::NONE };
        let (plain, _, _) = run(config, &places, feed, false, &holds);
        let (edges, seen, made) = run(config, &places, feed, true, &holds);
        prop_assert_eq!(edges, plain);
        let mut before = Mark(0);
        for (passed, _) in &seen {
            prop_assert!(before.is_reached_with(passed.mark), "{before:?} and then {passed:?}");
            before = passed.mark;
        }
        prop_assert_eq!(Some(&before), made.last());
    }
}

#[test]
fn a_stop_drops_what_it_drops_the_moves_of() {
    let mut rig = Rig::new(printer());
    let mut marks = Vec::new();
    for index in 0..5_u32 {
        let request = Move::feed(at(10.0 * f64::from(index + 1), 0.0, 0.0, 0.0), MmPerSecond(50.0));
        rig.submit(&Move { tag: Tag(index + 1), ..request });
        marks.push(rig.motion().mark().unwrap());
    }
    rig.motion().flush();
    for _ in 0..500 {
        rig.tick();
    }
    let passed = rig.motion().passed();
    assert_eq!((passed.tag, passed.mark), (Tag(2), marks[0]), "in the second move");
    rig.motion().stop();
    assert!(rig.motion().mark().is_err(), "a stop is under way");
    rig.finish();
    assert!(marks[4].is_reached_with(rig.motion().passed().mark), "nobody waits for what was dropped");
    assert_eq!(rig.motion().passed().tag, Tag(2));
    let after = rig.motion().mark().unwrap();
    rig.tick();
    assert_eq!(rig.motion().passed().mark, after);
}
