//! A conversation of Klipper's host with the image, once more with the board of memory: it homes three axes
//! and moves. `peers/klippy/replay.py` has made the record.

use crate::Response;
use crate::desk::Bench;

const RECORD: &str = include_str!("home.wire");

/// What happens at a tick of the board's clock.
enum Event {
    Host(Vec<u8>),
    Switch(u32, bool),
}

/// Motor's object and its steps.
type Position = (u32, i32);

fn bytes(text: &str) -> Vec<u8> {
    let pairs = text.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).expect("text"));
    pairs.map(|pair| u8::from_str_radix(pair, 16).expect("hexadecimal")).collect()
}

/// Events in the order of their ticks, and the positions that the host was told.
fn record() -> (Vec<(u64, Event)>, Vec<Position>) {
    let (mut events, mut positions) = (Vec::new(), Vec::new());
    for line in RECORD.lines() {
        let words: Vec<_> = line.split(' ').collect();
        let number = |place: usize| words[place].parse::<i64>().expect("a number");
        match words[0] {
            "host" => events.push((number(1) as u64, Event::Host(bytes(words[2])))),
            "switch" => events.push((number(2) as u64, Event::Switch(number(1) as u32, number(3) != 0))),
            _ => positions.push((number(1) as u32, number(2) as i32)),
        }
    }
    events.sort_by_key(|(tick, _)| *tick);
    (events, positions)
}

#[test]
fn a_host_homes_as_it_did_on_the_image() {
    let (events, positions) = record();
    let mut bench = Bench::new(0);
    bench.heard();
    let mut told = Vec::new();
    let mut now = 0;
    for (tick, event) in events {
        bench.pass((tick - now) as u32);
        now = tick;
        let mut said = bench.heard();
        match event {
            Event::Host(content) => said.extend(bench.block(&content)),
            Event::Switch(pin, level) => drop(bench.wires.levels.borrow_mut().insert(pin, level)),
        }
        for (kind, words, _) in said {
            assert_ne!(kind, Response::Shutdown, "at {tick}: {words:?}");
            if kind == Response::StepperPosition {
                told.push((words[0], words[1] as i32));
            }
        }
    }
    assert_eq!(told, positions);
    bench.pass(200_000_000);
    assert!(bench.controller.is_at_rest());
    let steps: usize = (0..4).map(|motor| bench.steps(motor).len()).sum();
    assert_eq!(steps, 32_000);
}
