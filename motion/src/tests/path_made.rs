//! Ends of moves as they are told to whoever draws the path: all of them, in order, and none before the
//! motors are there.

use std::vec::Vec;

use proptest::prelude::*;
use units::{MmPerSecond, MmPerSecond3};

use super::rig::{Rig, at, cases, printer};
use crate::{Corner, Move, MoveEnd};

/// Takes the ends that are told. Each comes when X is there.
fn look(rig: &mut Rig, told: &mut Vec<MoveEnd>) -> Result<(), TestCaseError> {
    while let Some(end) = rig.motion().take_end_of_move() {
        prop_assert!(rig.before >= f64::from(end.at[0]) - 1.0 / 80.0, "{end:?} is told at X{}", rig.before);
        told.push(end);
    }
    Ok(())
}

fn xs(told: &[MoveEnd]) -> Vec<f32> {
    told.iter().map(|end| end.at[0]).collect()
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn every_end_is_told_once_and_when_the_motors_are_there(
        lengths in prop::collection::vec(0.02..6.0_f64, 2..40), feed in 4.0..400.0_f64,
        jerk in prop::option::of(20_000.0..500_000.0_f64), mut changes in prop::collection::vec((0_u16..400, any::<bool>()), 0..4),
    ) {
        // 240 mm at half of 4 mm/s: 120 s, with as much again to spare.
        const TICKS: u32 = 480_000;
        changes.sort_unstable();
        let mut config = printer();
        config.limits.jerk = jerk.map(MmPerSecond3);
        let (mut rig, mut told, mut x, mut expected) = (Rig::new(config), Vec::new(), 0.0, Vec::from([0.0]));
        rig.motion().watch_path(true);
        for length in &lengths {
            x += length;
            expected.push(x as f32);
            let request = Move { corner: Corner::Sharp, ..Move::feed(at(x, 0.0, 0.0, x), MmPerSecond(feed)) };
            while rig.motion().submit(&request).is_err() {
                rig.tick();
                look(&mut rig, &mut told)?;
            }
            rig.motion().plan();
        }
        rig.motion().flush();
        for tick in 0..TICKS {
            for (_, holds) in changes.iter().filter(|(at, _)| u32::from(*at) == tick) {
                if *holds {
                    rig.motion().hold();
                } else {
                    // Trajectory is taken back, and begins anew.
                    rig.motion().set_overrides(0.5, 1.0);
                }
            }
            if tick == 1_000 {
                rig.motion().resume();
            }
            rig.tick();
            look(&mut rig, &mut told)?;
            if tick > 1_000 && rig.motion().is_idle() {
                break;
            }
        }
        rig.tick();
        look(&mut rig, &mut told)?;
        prop_assert!(rig.motion().is_idle(), "{TICKS} turns of the feed were too few");
        prop_assert_eq!(xs(&told), expected);
        prop_assert!(told[1..].iter().all(|end| end.is_work && end.extrudes) && !told[0].is_work);
    }
}

#[test]
fn a_move_that_is_cut_off_ends_where_the_next_one_begins() {
    let (mut rig, mut told) = (Rig::new(printer()), Vec::new());
    rig.motion().watch_path(true);
    for x in [10.0, 20.0, 30.0] {
        rig.submit(&Move::feed(at(x, 0.0, 0.0, 0.0), MmPerSecond(50.0)));
    }
    rig.motion().flush();
    for _ in 0..500 {
        rig.tick();
    }
    rig.motion().stop();
    rig.finish();
    let stopped = rig.motion().commanded_position().0[0];
    assert!(stopped > 10.0 && stopped < 30.0);
    rig.submit(&Move::feed(at(0.0, 5.0, 0.0, 0.0), MmPerSecond(50.0)));
    rig.finish();
    rig.tick();
    while let Some(end) = rig.motion().take_end_of_move() {
        told.push(end);
    }
    let expected: Vec<f32> = [0.0, 10.0, 20.0, 30.0].into_iter().filter(|x| *x < stopped).map(|x| x as f32).collect();
    assert_eq!(xs(&told), [expected, Vec::from([stopped as f32, 0.0])].concat());
    assert!(told.iter().all(|end| !end.extrudes));
}

#[test]
fn nothing_is_noted_while_nobody_watches_and_much_is_told_as_less() {
    let mut rig = Rig::new(printer());
    let line = |x: f64| Move::feed(at(x, 0.0, 0.0, 0.0), MmPerSecond(50.0));
    rig.submit(&line(1.0));
    rig.finish();
    assert_eq!(rig.motion().take_end_of_move(), None);
    rig.motion().watch_path(true);
    for number in 0..100 {
        rig.submit(&line(1.0 + f64::from(number % 2)));
    }
    rig.finish();
    rig.tick();
    let told = std::iter::from_fn(|| rig.motion().take_end_of_move()).collect::<Vec<_>>();
    assert_eq!((told.len(), told.last().map(|end| end.at[0])), (48, Some(2.0)));
}
