//! Analog inputs, buttons, counters.

use crate::desk::Bench;
use crate::{Command, Reason, Response};

const MS: u32 = 200_000;

fn sums(bench: &mut Bench) -> Vec<(u32, u16)> {
    let said = bench.heard();
    let states = said.into_iter().filter(|(kind, ..)| *kind == Response::AnalogInState);
    states.map(|(_, words, sums)| (words[1], u16::from_le_bytes([sums[0], sums[1]]))).collect()
}

fn thermistor(range: (u32, u32)) -> (Bench, u32) {
    let mut bench = Bench::with_oids(2);
    bench.tell(Command::ConfigAnalogIn, &[0, 91]);
    bench.finalize();
    let begin = bench.now().wrapping_add(10 * MS);
    // As hosts ask: eight conversions a millisecond apart, every 300 ms, four sums out of range.
    bench.tell(Command::QueryAnalogIn, &[0, begin, MS, 8, 300 * MS, 2, range.0, range.1, 4]);
    (bench, begin)
}

#[test]
fn sums_come_with_the_clock_of_the_next() {
    let (mut bench, begin) = thermistor((0, 65_535));
    bench.pass(1000 * MS);
    let expected: Vec<_> = (1..=4).map(|sum| (begin.wrapping_add(sum * 300 * MS), 16_000)).collect();
    assert_eq!(sums(&mut bench), expected);
}

#[test]
fn four_sums_out_of_range_shut_the_board_down_and_readings_go_on() {
    let (mut bench, _) = thermistor((1000, 20_000));
    bench.wires.analog.set(Some(4000));
    bench.pass(910 * MS);
    assert!(bench.heard().iter().all(|(kind, ..)| *kind != Response::Shutdown));
    bench.pass(10 * MS);
    let said = bench.heard();
    let reason = u32::from(Reason::AdcOutOfRange.number());
    assert!(said.iter().any(|(kind, words, _)| *kind == Response::Shutdown && words[1] == reason));
    bench.wires.analog.set(Some(1000));
    bench.pass(1000 * MS);
    assert!(sums(&mut bench).len() >= 3);
}

#[test]
fn a_converter_that_has_stopped_is_a_shutdown() {
    let (mut bench, _) = thermistor((0, 65_535));
    bench.wires.analog.set(None);
    bench.pass(1000 * MS);
    let reason = u32::from(Reason::AdcStopped.number());
    assert!(bench.heard().iter().any(|(kind, words, _)| *kind == Response::Shutdown && words[1] == reason));
}

#[test]
fn no_change_of_a_button_is_lost() {
    let mut bench = Bench::with_oids(1);
    bench.tell(Command::ConfigButtons, &[0, 2]);
    bench.tell(Command::ButtonsAdd, &[0, 0, 33, 1]);
    bench.tell(Command::ButtonsAdd, &[0, 1, 34, 1]);
    bench.finalize();
    let begin = bench.now().wrapping_add(10 * MS);
    bench.tell(Command::ButtonsQuery, &[0, begin, 2 * MS, 50, 0]);
    bench.heard();
    let states = |bench: &mut Bench| -> Vec<_> {
        let said = bench.heard().into_iter().filter(|(kind, ..)| *kind == Response::ButtonsState);
        said.map(|(_, words, state)| (words[1], state)).collect()
    };
    bench.pass(20 * MS);
    assert!(states(&mut bench).is_empty());
    bench.wires.levels.borrow_mut().insert(33, true);
    bench.pass(10 * MS);
    assert_eq!(states(&mut bench), [(0, vec![1])]);
    bench.wires.levels.borrow_mut().insert(34, true);
    bench.pass(10 * MS);
    assert_eq!(states(&mut bench), [(0, vec![1, 3])]);
    // A change that is not acknowledged is reported again.
    bench.pass(150 * MS);
    assert_eq!(states(&mut bench), [(0, vec![1, 3])]);
    bench.tell(Command::ButtonsAck, &[0, 2]);
    bench.pass(300 * MS);
    assert!(states(&mut bench).is_empty());
    bench.wires.levels.borrow_mut().insert(33, false);
    bench.pass(10 * MS);
    assert_eq!(states(&mut bench), [(2, vec![2])]);
}

#[test]
fn a_tachometer_counts_both_edges() {
    let mut bench = Bench::with_oids(1);
    bench.tell(Command::ConfigCounter, &[0, 50, 1]);
    bench.finalize();
    let begin = bench.now().wrapping_add(10 * MS);
    bench.tell(Command::QueryCounter, &[0, begin, MS / 10, 100 * MS]);
    bench.pass(10 * MS);
    for turn in 0..30 {
        bench.wires.levels.borrow_mut().insert(50, turn % 2 == 0);
        bench.pass(2 * MS);
    }
    bench.pass(50 * MS);
    let said = bench.heard();
    let (_, words, _) = said.iter().find(|(kind, ..)| *kind == Response::CounterState).expect("a count");
    assert_eq!(words[2], 30);
    assert!(words[3].wrapping_sub(begin) < 60 * MS);
}
