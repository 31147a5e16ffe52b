//! Holds, aborts, detours: power goes with the motion, and comes back with it.

use proptest::prelude::*;
use units::MmPerSecond;

use super::{by_speed, constant, duties, machines, plain, run, steps, with_laser};
use crate::{
    Move,
    queue::StepEvent,
    tests::{
        laser::raster::pictures,
        rig::{Rig, at, cases, printer},
    },
};

/// Share of full power times seconds.
fn energy(rig: &Rig) -> f64 {
    duties(rig).windows(2).map(|pair| f64::from(pair[0].1) / 65_535.0 * (pair[1].0 - pair[0].0) * 1e-9).sum()
}

fn line(length: f64) -> Move {
    Move { power: constant(40_000), ..Move::feed(at(length, 0.0, 0.0, 0.0), MmPerSecond(100.0)) }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn a_hold_neither_burns_more_nor_leaves_anything_out(config in machines(), follows in any::<bool>(), before in 250_u32..900) {
        // A line of 60 mm at 100 mm/s, held somewhere on it.
        let power = if follows { by_speed(40_000) } else { constant(40_000) };
        let request = Move { power, ..line(60.0) };
        let calm = run(config, plain(), &[request]);
        let mut held = with_laser(config, plain());
        held.submit(&request);
        held.motion().flush();
        (0..before).for_each(|_| held.tick());
        held.motion().hold();
        (0..600).for_each(|_| held.tick());
        prop_assert!(held.motion().is_held_still());
        prop_assert_eq!(duties(&held).last().map(|last| last.1), Some(0));
        held.motion().resume();
        held.finish();
        let share = energy(&held) / energy(&calm);
        prop_assert!((0.99..1.01).contains(&share), "{share} of the energy, {:?}\n{:?}", duties(&calm), duties(&held));
    }

    #[test]
    fn an_abort_puts_the_laser_out_before_anything_else(picture in pictures(), config in machines(), before in 0_u32..400, by_queue in any::<bool>()) {
        let (moves, _) = picture.moves();
        let mut rig = with_laser(config, plain());
        let mut waiting = moves.iter().peekable();
        for _ in 0..before {
            while waiting.peek().is_some_and(|next| rig.motion().submit(next).is_ok()) {
                waiting.next();
            }
            rig.tick();
        }
        let seen = rig.events.len();
        if by_queue { rig.queue.cut() } else { rig.motion().abort() }
        rig.tick();
        rig.tick();
        prop_assert_eq!(rig.events.get(seen).and_then(|(_, event)| event.laser_duty()), Some(0));
        prop_assert_eq!(rig.events.len(), seen + 1, "nothing else is played");
        // Motion goes on as ever.
        let here = rig.motion().commanded_position();
        let back = Move { power: constant(500), ..Move::feed(at(here.0[0] + 5.0, here.0[1], 0.0, 0.0), MmPerSecond(50.0)) };
        rig.submit(&back);
        rig.finish();
        let after: std::vec::Vec<u16> = rig.events[seen + 1..].iter().filter_map(|(_, event)| event.laser_duty()).collect();
        prop_assert_eq!(after, [500, 0]);
    }
}

#[test]
fn a_mark_lies_where_it_was_made() {
    let mut rig = with_laser(printer(), plain());
    rig.submit(&line(10.0));
    let mark = rig.motion().mark().expect("room");
    rig.submit(&line(20.0));
    rig.motion().flush();
    while !rig.motion().is_idle() {
        let reached = mark.is_reached_with(rig.motion().passed().mark);
        let x = f64::from(rig.motion().steps()[units::Actuator::Alpha]) / 80.0;
        // The feed looks at the steps every 16 ms.
        assert!(if reached { x > 8.0 } else { x < 12.0 }, "reached {reached} at {x}");
        rig.tick();
    }
}

#[test]
fn moves_that_differ_stay_apart_and_alike_ones_are_one() {
    let base = line(1.0);
    let count = |second: Move| {
        let mut rig = with_laser(printer(), plain());
        rig.motion().submit(&base).expect("room");
        rig.motion().submit(&second).expect("room");
        rig.motion().queue_level().0
    };
    let next = Move { power: constant(7), ..line(2.0) };
    let off_line = |y: f64| Move { target: at(2.0, y, 0.0, 0.0), ..next };
    assert_eq!((count(next), count(off_line(0.000_9))), (1, 1));
    let others = [
        off_line(0.001_1),
        Move { feed_rate: MmPerSecond(99.0), ..next },
        Move { power: by_speed(7), ..next },
        Move { mode: crate::Mode::Rapid, ..next },
        Move { corner: crate::Corner::Stop, ..next },
        Move { part: 3, ..next },
        Move { target: at(2.0, 0.0, 0.0, 1.0), ..next },
        Move { target: at(0.5, 0.0, 0.0, 0.0), ..next },
    ];
    for other in others {
        assert_eq!(count(other), 2, "{other:?}");
    }
    let mut rig = with_laser(printer(), plain());
    rig.motion().submit(&base).expect("room");
    rig.motion().flush();
    rig.motion().submit(&next).expect("room");
    assert_eq!(rig.motion().queue_level().0, 2, "a flush fixes what it lets go");
}

#[test]
fn a_board_s_feed_plays_the_same_power() {
    let moves = [line(20.0), Move { power: by_speed(9_000), ..line(40.0) }, line(40.5)];
    let by_period = run(printer(), plain(), &moves);
    let mut on_demand = Rig::on_demand(printer());
    on_demand.motion().configure_laser(Some(plain())).expect("a laser");
    moves.iter().for_each(|request| on_demand.submit(request));
    on_demand.finish();
    let relative = |rig: &Rig| {
        let first = steps(rig)[0].0 as f64 * 5.0;
        duties(rig).into_iter().map(|(at, duty)| (at - first, duty)).collect::<std::vec::Vec<_>>()
    };
    let (one, other) = (relative(&by_period), relative(&on_demand));
    assert_eq!(one.len(), other.len());
    for ((at, duty), (then, other)) in one.into_iter().zip(other) {
        assert!((at - then).abs() < 11.0 && duty.abs_diff(other) < 2, "{duty} at {at}, {other} at {then}");
    }
    assert_eq!(on_demand.events.last().map(|(_, event)| StepEvent::laser_duty(*event)), Some(Some(0)));
}
