//! Motors: every step at the tick that the host's moves say.

use proptest::prelude::*;

use crate::desk::Bench;
use crate::{Command, Response};

const STEPPERS: u32 = 3;
/// A trigger's object, behind the motors.
const TRIGGER: u32 = STEPPERS;

fn bench() -> Bench {
    let mut bench = Bench::with_oids(STEPPERS + 3);
    for motor in 0..STEPPERS {
        let both_edges = u32::MAX;
        bench.tell(Command::ConfigStepper, &[motor, 10 * motor, 10 * motor + 1, both_edges, 20]);
    }
    bench.tell(Command::ConfigTrsync, &[TRIGGER]);
    bench.tell(Command::ConfigEndstop, &[TRIGGER + 1, 100, 1]);
    bench.finalize();
    bench.heard();
    bench
}

/// A move of a motor: direction, interval, count, addend.
type Steps = (bool, u32, u32, i16);

/// Times and directions of the steps of moves, from a clock on.
fn expected(mut clock: u32, moves: &[Steps]) -> Vec<(u32, bool)> {
    let mut steps = Vec::new();
    for (direction, interval, count, add) in moves {
        for step in 1..=i64::from(*count) {
            let sum = step * i64::from(*interval) + i64::from(*add) * step * (step - 1) / 2;
            steps.push((clock.wrapping_add(sum as u32), *direction));
        }
        clock = steps.last().map_or(clock, |step| step.0);
    }
    steps
}

fn send(bench: &mut Bench, motor: u32, moves: &[Steps]) {
    for (direction, interval, count, add) in moves {
        bench.tell(Command::SetNextStepDir, &[motor, u32::from(*direction)]);
        bench.tell(Command::QueueStep, &[motor, *interval, *count, *add as i32 as u32]);
    }
}

fn moves() -> impl Strategy<Value = Vec<Steps>> {
    proptest::collection::vec((any::<bool>(), 1_000_u32..60_000, 1_u32..60, -12_i16..400), 1..12)
}

proptest! {
    #[test]
    fn every_step_comes_at_its_tick(all in proptest::array::uniform3(moves()), clocks in proptest::array::uniform3(0_u32..3_000_000)) {
        let mut bench = bench();
        let begin = bench.now().wrapping_add(20_000_000);
        for (motor, (moves, clock)) in all.iter().zip(clocks).enumerate() {
            bench.tell(Command::ResetStepClock, &[motor as u32, begin.wrapping_add(clock)]);
            send(&mut bench, motor as u32, moves);
        }
        bench.pass(200_000_000);
        for (motor, (moves, clock)) in all.iter().zip(clocks).enumerate() {
            let expected = expected(begin.wrapping_add(clock), moves);
            prop_assert_eq!(bench.steps(motor), expected.clone());
            let position: i32 = expected.iter().map(|(_, direction)| if *direction { 1 } else { -1 }).sum();
            let said = bench.tell(Command::StepperGetPosition, &[motor as u32]);
            prop_assert_eq!(said.last().expect("an answer").1[1] as i32, position);
        }
        // Turns keep their distance: a driver needs it on both sides.
        let mut last = [0_u32; 3];
        for event in &bench.played {
            let since = event.at.wrapping_sub(last[event.motor()]);
            prop_assert!(since >= 400 || last[event.motor()] == 0, "{}", since);
            last[event.motor()] = event.at;
        }
    }

    #[test]
    fn a_trigger_stops_its_motors_and_no_other(wait in 20_000_000_u32..40_000_000, stopped in 1_u32..8) {
        let mut bench = bench();
        let begin = bench.now().wrapping_add(20_000_000);
        let moves = [(true, 3_000, 2000, 1), (false, 5_000, 1500, -1), (true, 4_000, 1000, 0)];
        bench.tell(Command::TrsyncStart, &[TRIGGER, begin, 0, 2]);
        for motor in 0..STEPPERS {
            if stopped & 1 << motor != 0 {
                bench.tell(Command::StepperStopOnTrigger, &[motor, TRIGGER]);
            }
            bench.tell(Command::ResetStepClock, &[motor, begin.wrapping_add(1000 * motor)]);
            send(&mut bench, motor, &moves);
        }
        bench.pass(wait);
        let before: Vec<_> = (0..3).map(|motor| bench.steps(motor)).collect();
        let said = bench.tell(Command::TrsyncTrigger, &[TRIGGER, 9]);
        prop_assert_eq!(&said.last().expect("a state").1, &vec![TRIGGER, 0, 9, 0]);
        let positions: Vec<_> = (0..3).map(|motor| {
            bench.tell(Command::StepperGetPosition, &[motor]).pop().expect("an answer").1[1] as i32
        }).collect();
        bench.pass(60_000_000);
        for motor in 0..3 {
            let whole = expected(begin.wrapping_add(1000 * motor as u32), &moves);
            let made = bench.steps(motor);
            if stopped & 1 << motor == 0 {
                prop_assert_eq!(&made, &whole);
            } else {
                prop_assert_eq!(&made, &before[motor]);
            }
            let at_the_stop: i32 = before[motor].iter().map(|(_, up)| if *up { 1 } else { -1 }).sum();
            prop_assert_eq!(positions[motor], at_the_stop);
            // Moves before the clock is set anew are dropped; then the motor goes on, in the right direction.
            bench.tell(Command::QueueStep, &[motor as u32, 5000, 10, 0]);
            let clock = bench.now().wrapping_add(10_000_000);
            if stopped & 1 << motor != 0 {
                bench.tell(Command::ResetStepClock, &[motor as u32, clock]);
                let count = bench.played.len();
                send(&mut bench, motor as u32, &[(true, 9_000, 3, 0), (false, 9_000, 3, 0)]);
                bench.pass(20_000_000);
                let all = bench.steps(motor);
                let expected = expected(clock, &[(true, 9_000, 3, 0), (false, 9_000, 3, 0)]);
                prop_assert!(bench.played.len() > count);
                prop_assert_eq!(&all[all.len() - 6..], &expected[..]);
            } else {
                // A motor at rest gets its steps too late: a shutdown, which ends the case.
                break;
            }
        }
    }
}

#[test]
fn a_switch_stops_the_motor_and_the_host_learns_when() {
    let mut bench = bench();
    let begin = bench.now().wrapping_add(20_000_000);
    bench.tell(Command::TrsyncStart, &[TRIGGER, begin, 15_000_000, 2]);
    bench.tell(Command::StepperStopOnTrigger, &[0, TRIGGER]);
    bench.tell(Command::TrsyncSetTimeout, &[TRIGGER, begin.wrapping_add(50_000_000)]);
    // Reads 15 us apart, four of them; a rest of 0.1 ms.
    bench.tell(Command::EndstopHome, &[TRIGGER + 1, begin, 3000, 4, 20_000, 1, TRIGGER, 1]);
    bench.tell(Command::ResetStepClock, &[0, begin]);
    send(&mut bench, 0, &[(true, 10_000, 6000, 0)]);
    bench.pass(20_000_000 + 1_234_567);
    // A spike that is shorter than the four reads is no switch.
    bench.wires.levels.borrow_mut().insert(100, true);
    bench.pass(8_000);
    bench.wires.levels.borrow_mut().insert(100, false);
    bench.pass(1_000_000);
    assert!(!bench.heard().iter().any(|(kind, words, _)| *kind == Response::TrsyncState && words[1] == 0));
    let closed = bench.now();
    bench.wires.levels.borrow_mut().insert(100, true);
    bench.pass(5_000_000);
    let fired: Vec<_> =
        bench.heard().into_iter().filter(|(kind, words, _)| *kind == Response::TrsyncState && words[1] == 0).collect();
    assert_eq!(fired.len(), 1);
    assert_eq!(fired[0].1[..3], [TRIGGER, 0, 1]);
    // The host ends the search before it asks when the switch was seen.
    bench.tell(Command::EndstopHome, &[TRIGGER + 1, 0, 0, 0, 0, 0, 0, 0]);
    let state = bench.tell(Command::EndstopQueryState, &[TRIGGER + 1]).pop().expect("an answer").1;
    let seen = state[2].wrapping_sub(20_000);
    assert_eq!((state[1], state[3]), (0, 1));
    assert!(seen.wrapping_sub(closed) <= 20_000, "{}", seen.wrapping_sub(closed));
    assert!(fired[0].1[3].wrapping_sub(seen) <= 3 * 3000 + 100);
    let last = bench.steps(0).last().expect("steps").0;
    assert!(fired[0].1[3].wrapping_sub(last) < 10_000);
}

#[test]
fn a_host_that_falls_silent_stops_the_motor_by_the_time_out() {
    let mut bench = bench();
    let begin = bench.now().wrapping_add(20_000_000);
    bench.tell(Command::TrsyncStart, &[TRIGGER, begin, 15_000_000, 4]);
    bench.tell(Command::StepperStopOnTrigger, &[1, TRIGGER]);
    bench.tell(Command::TrsyncSetTimeout, &[TRIGGER, begin.wrapping_add(50_000_000)]);
    bench.tell(Command::ResetStepClock, &[1, begin]);
    send(&mut bench, 1, &[(false, 10_000, 60_000, 0)]);
    bench.pass(20_000_000 + 100_000_000);
    let reports: Vec<_> = bench.heard().into_iter().filter(|(kind, ..)| *kind == Response::TrsyncState).collect();
    let states: Vec<_> =
        reports.iter().map(|(_, words, _)| (words[1], words[2], words[3].wrapping_sub(begin))).collect();
    assert_eq!(states, [(1, 0, 0), (1, 0, 15_000_000), (1, 0, 30_000_000), (1, 0, 45_000_000), (0, 4, 50_000_000)]);
    assert_eq!(bench.steps(1).len(), 5000);
}

#[test]
fn steps_that_come_too_late_are_a_shutdown_and_none_is_made() {
    let mut bench = bench();
    let now = bench.now();
    bench.tell(Command::ResetStepClock, &[0, now]);
    let said = bench.tell(Command::QueueStep, &[0, 1000, 10, 0]);
    let reason = u32::from(crate::Reason::TimerTooClose.number());
    assert_eq!(said[0], (Response::Shutdown, vec![now, reason], vec![]));
    bench.pass(10_000_000);
    assert!(bench.steps(0).is_empty());
}

#[test]
fn a_turn_with_a_long_pulse_comes_in_order_or_not_at_all() {
    // A pulse of 1 ms, which a direction is set ahead as well: twice the time that is written ahead.
    const PULSE: u32 = 200_000;
    for lead in [PULSE + 90_000, PULSE + 110_000] {
        let mut bench = Bench::with_oids(2);
        for motor in 0..2 {
            bench.tell(Command::ConfigStepper, &[motor, 10 * motor, 10 * motor + 1, 0, PULSE]);
        }
        bench.finalize();
        bench.heard();
        let begin = bench.now().wrapping_add(20_000_000);
        bench.tell(Command::ResetStepClock, &[0, begin]);
        bench.tell(Command::QueueStep, &[0, 500_000, 100, 0]);
        bench.pass(30_000_000);
        let now = bench.now();
        bench.tell(Command::ResetStepClock, &[1, now.wrapping_sub(1_000_000)]);
        bench.tell(Command::SetNextStepDir, &[1, 1]);
        let said = bench.tell(Command::QueueStep, &[1, 1_000_000 + lead, 1, 0]);
        let is_late = said.iter().any(|(kind, ..)| *kind == Response::Shutdown);
        assert_eq!(is_late, lead < PULSE + 101_000, "{lead}");
        bench.pass(50_000_000);
        assert_eq!(bench.steps(1).len(), usize::from(!is_late));
        assert!(bench.played.windows(2).all(|pair| pair[1].at.wrapping_sub(pair[0].at) as i32 >= 0));
    }
}

#[test]
fn a_host_that_asks_for_too_many_steps_is_stopped() {
    let mut bench = bench();
    let begin = bench.now().wrapping_add(20_000_000);
    bench.tell(Command::ResetStepClock, &[0, begin]);
    bench.tell(Command::QueueStep, &[0, 10, 60_000, 0]);
    // Nobody plays them: the queue is full until the next step is a millisecond late.
    bench.wires.clock.set(begin);
    bench.controller.run();
    bench.wires.clock.set(begin.wrapping_add(150_000));
    bench.controller.run();
    assert!(bench.heard().iter().all(|(kind, ..)| *kind != Response::Shutdown));
    bench.wires.clock.set(begin.wrapping_add(300_000));
    bench.controller.run();
    let reason = u32::from(crate::Reason::StepperTooLate.number());
    assert!(bench.heard().iter().any(|(kind, words, _)| *kind == Response::Shutdown && words[1] == reason));
}

#[test]
fn a_board_without_time_for_commands_is_stopped() {
    let mut bench = bench();
    let begin = bench.now().wrapping_add(20_000_000);
    bench.tell(Command::ResetStepClock, &[0, begin]);
    bench.tell(Command::QueueStep, &[0, 300_000_000, 1, 0]);
    bench.wires.clock.set(begin.wrapping_add(70_000_000));
    bench.controller.run();
    assert!(bench.heard().iter().any(|(kind, ..)| *kind == Response::Shutdown));
}

#[test]
fn the_memory_of_moves_is_as_large_as_it_says_and_comes_back() {
    let mut bench = bench();
    for _ in 0..3 {
        let begin = bench.now().wrapping_add(40_000_000);
        bench.tell(Command::ResetStepClock, &[0, begin]);
        // The first move is under way, the others wait.
        for _ in 0..=4096 {
            assert!(bench.tell(Command::QueueStep, &[0, 2000, 1, 0]).is_empty());
        }
        bench.pass(60_000_000);
    }
    let begin = bench.now().wrapping_add(40_000_000);
    bench.tell(Command::ResetStepClock, &[0, begin]);
    let said: Vec<_> = (0..=4097).flat_map(|_| bench.tell(Command::QueueStep, &[0, 2000, 1, 0])).collect();
    assert_eq!(said[0].0, Response::Shutdown);
}
