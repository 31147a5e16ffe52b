//! Moves that are passed take as long as moves that are made.

use std::{boxed::Box, vec::Vec};

use proptest::prelude::*;
use units::{Mm, MmPerSecond, MmPerSecond2, MmPerSecond3};

use super::{
    laws,
    random_programs::{program, strokes},
    rig::{Rig, at, cases, printer},
};
use crate::{Corner, Kinematics, Limits, Motion, MotionConfig, Move, Passage, Refusal};

/// Passes these moves as a file's are made: what waits is passed on when the queue is full.
fn passed(config: &MotionConfig, moves: &[Move]) -> Vec<Passage> {
    let mut motion = Box::new(Motion::new());
    motion.configure_to_pass(config).unwrap();
    let mut passages = Vec::new();
    for request in moves {
        while let Err(refusal) = motion.submit(request) {
            assert_eq!(refusal, Refusal::Full, "{request:?}");
            passages.push(motion.pass_block().expect("a full queue has one that can be begun"));
        }
    }
    motion.flush();
    passages.extend(std::iter::from_fn(|| motion.pass_block()));
    assert!(motion.is_idle() || moves.is_empty(), "{:?}", motion.queue_level());
    passages
}

/// Returns the time from the first step's piece to the end of the last one.
fn made_in(rig: &Rig) -> f64 {
    let pieces = &rig.access.pieces;
    let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else { return 0.0 };
    (last.start.to_num::<f64>() - first.start.to_num::<f64>()) / 200e6 + last.duration
}

fn smooth(jerk: f64) -> MotionConfig {
    let printer = printer();
    let limits = Limits { acceleration: MmPerSecond2(3_000.0), jerk: Some(MmPerSecond3(jerk)), ..printer.limits };
    MotionConfig { limits, ..printer }
}

fn gentle() -> MotionConfig {
    let printer = printer();
    MotionConfig { limits: Limits { cruise_ratio: 0.5, junction_deviation: Mm(0.01), ..printer.limits }, ..printer }
}

fn machines() -> impl Strategy<Value = MotionConfig> {
    prop_oneof![
        Just(printer()),
        Just(MotionConfig { kinematics: Kinematics::CoreXy, ..printer() }),
        (5_000.0..500_000.0_f64).prop_map(smooth),
        Just(gentle()),
        Just(MotionConfig { queue_size: 256, ..printer() }),
    ]
}

fn corners() -> impl Strategy<Value = Corner> {
    prop_oneof![Just(Corner::Sharp), Just(Corner::Stop), (0.001..0.5_f64).prop_map(Corner::Rounded)]
}

fn alike(config: MotionConfig, moves: &[Move]) -> Result<(), TestCaseError> {
    let rig = laws::run(config, moves);
    let (made, passages) = (made_in(&rig), passed(&config, moves));
    let passed: f64 = passages.iter().map(Passage::seconds).sum();
    let length: f64 = passages.iter().map(|passage| passage.length).sum();
    prop_assert!((passed - made).abs() <= 0.002 * made + 1e-6, "{passed} s passed over {length} mm, {made} s made");
    Ok(())
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn a_program_takes_as_long_passed_as_made(config in machines(), moves in laws::program()) {
        alike(config, &moves)?;
    }

    #[test]
    fn curves_and_rounded_corners_too(config in machines(), strokes in strokes(12), corner in corners()) {
        alike(config, &program(at(0.0, 0.0, 0.0, 0.0), &strokes, 1.0, corner))?;
    }
}

#[test]
fn a_block_says_what_its_time_goes_into() {
    let move_to = |x: f64| Move::feed(at(x, 0.0, 0.0, 0.0), MmPerSecond(100.0));
    let [passage] = passed(&printer(), &[move_to(50.0)])[..] else { panic!("one block") };
    // The ramps to 100 mm/s at 3000 mm/s2 take a thirtieth of a second, up and down, over 1.667 mm each.
    assert!((passage.ramp_seconds - 2.0 / 30.0).abs() < 1e-9 && (passage.peak - 100.0).abs() < 1e-9, "{passage:?}");
    assert!((passage.even_seconds - (50.0 - 10.0 / 3.0) / 100.0).abs() < 1e-9, "{passage:?}");
    assert_eq!((passage.length, passage.requested.get()), (50.0, 100.0));
}

#[test]
fn nothing_is_passed_before_it_is_settled() {
    let mut motion = Box::new(Motion::new());
    motion.configure_to_pass(&printer()).unwrap();
    motion.submit(&Move::feed(at(10.0, 0.0, 0.0, 0.0), MmPerSecond(50.0))).unwrap();
    assert_eq!(motion.pass_block(), None, "how fast it ends depends on what comes next");
    motion.flush();
    assert!(motion.pass_block().is_some());
    assert_eq!(motion.pass_block(), None);
    motion.submit(&Move::feed(at(20.0, 0.0, 0.0, 0.0), MmPerSecond(50.0))).unwrap();
    motion.flush();
    assert!(motion.pass_block().is_some_and(|passage| (passage.length - 10.0).abs() < 1e-9));
}
