//! Outputs: at their times, and off when nobody renews them.

use crate::desk::Bench;
use crate::{Command, Reason, Response};

const PIN: u32 = 64;
const MS: u32 = 200_000;

/// A board with a heater, which may be on for 3 s without a change, of 100 ms of software PWM; or with a fan
/// without a limit.
fn bench(most_ticks: u32) -> Bench {
    let mut bench = Bench::with_oids(3);
    bench.tell(Command::ConfigDigitalOut, &[0, PIN, 0, 0, most_ticks]);
    bench.tell(Command::ConfigPwmOut, &[1, 150, 20_000, 0, 0, most_ticks]);
    bench.tell(Command::SetDigitalOutPwmCycle, &[0, 100 * MS]);
    bench.finalize();
    bench.heard();
    bench
}

fn is_on(bench: &Bench) -> bool {
    bench.wires.levels.borrow().get(&PIN) == Some(&true)
}

#[test]
fn pulses_begin_and_end_at_their_ticks() {
    let mut bench = bench(0);
    let begin = bench.now().wrapping_add(10 * MS);
    bench.tell(Command::QueueDigitalOut, &[0, begin, 30 * MS]);
    bench.tell(Command::QueueDigitalOut, &[0, begin.wrapping_add(250 * MS), 100 * MS]);
    bench.tell(Command::QueueDigitalOut, &[0, begin.wrapping_add(400 * MS), 0]);
    bench.pass(600 * MS);
    let changes: Vec<_> =
        bench.wires.changes.borrow().iter().map(|(at, pin, high)| (at.wrapping_sub(begin) / MS, *pin, *high)).collect();
    let at = |ms, high| (ms, PIN, high);
    assert_eq!(
        changes,
        [
            at(0, true),
            at(30, false),
            at(100, true),
            at(130, false),
            at(200, true),
            at(230, false),
            at(250, true),
            at(400, false)
        ]
    );
}

#[test]
fn a_heater_that_is_not_renewed_shuts_the_board_down() {
    let mut bench = bench(3000 * MS);
    let begin = bench.now().wrapping_add(10 * MS);
    bench.tell(Command::QueueDigitalOut, &[0, begin, 100 * MS]);
    // The host speaks, but not of the heater.
    for _ in 0..29 {
        bench.pass(100 * MS);
        assert!(bench.tell(Command::GetClock, &[]).iter().all(|(kind, ..)| *kind != Response::Shutdown));
        assert!(is_on(&bench));
    }
    bench.pass(200 * MS);
    let said = bench.heard();
    let (_, words, _) = said.iter().find(|(kind, ..)| *kind == Response::Shutdown).expect("a shutdown");
    assert_eq!(words[1], u32::from(Reason::MissedDigitalOut.number()));
    assert!(!is_on(&bench));
}

#[test]
fn a_heater_is_off_within_a_second_of_silence_and_goes_on_with_the_host() {
    let mut bench = bench(3000 * MS);
    let begin = bench.now().wrapping_add(10 * MS);
    bench.tell(Command::QueueDigitalOut, &[0, begin, 100 * MS]);
    bench.tell(Command::QueuePwmOut, &[1, begin, 32_768]);
    bench.pass(900 * MS);
    assert!(is_on(&bench));
    bench.pass(100 * MS);
    assert!(!is_on(&bench), "on after a second of silence");
    assert_eq!(bench.wires.pwm.borrow().last(), Some(&(150, 0)));
    bench.tell(Command::GetClock, &[]);
    assert!(is_on(&bench));
    assert_eq!(bench.wires.pwm.borrow().last(), Some(&(150, 32_768)));
}

#[test]
fn what_has_no_limit_stays_as_it_is_in_silence() {
    let mut bench = bench(0);
    let begin = bench.now().wrapping_add(10 * MS);
    bench.tell(Command::QueueDigitalOut, &[0, begin, 100 * MS]);
    bench.pass(2000 * MS);
    assert!(is_on(&bench));
    bench.tell(Command::EmergencyStop, &[]);
    assert!(!is_on(&bench));
}

#[test]
fn changes_too_far_apart_are_refused_at_once() {
    let mut bench = bench(3000 * MS);
    let begin = bench.now().wrapping_add(10 * MS);
    bench.tell(Command::QueueDigitalOut, &[0, begin, 100 * MS]);
    bench.pass(20 * MS);
    let said = bench.tell(Command::QueueDigitalOut, &[0, begin.wrapping_add(3001 * MS), 0]);
    let reason = u32::from(Reason::DigitalOutDuration.number());
    assert!(matches!(&said[..], [(Response::Shutdown, words, _)] if words[1] == reason), "{said:?}");
    assert!(!is_on(&bench));
}

#[test]
fn a_pin_has_one_owner() {
    let mut bench = bench(0);
    let mut bench_two = Bench::with_oids(4);
    bench_two.tell(Command::ConfigDigitalOut, &[0, PIN, 1, 1, 0]);
    let said = bench_two.tell(Command::ConfigDigitalOut, &[1, PIN, 0, 0, 0]);
    let reason = u32::from(Reason::NotAPin.number());
    assert!(matches!(&said[..], [(Response::Shutdown, words, _)] if words[1] == reason), "{said:?}");
    assert_eq!(bench.tell(Command::SetDigitalOut, &[PIN, 1])[0].0, Response::Shutdown);
}
