//! Frames that make no sense: nothing fails, and nothing is left behind.

use crate::random::Random;
use crate::testing::{BOARD, BOARD_MAC, Bench, DESK, DESK_MAC, MS, SECOND, arp, echo, syn};

/// Frames of all that the board speaks, as they were heard on the wire.
fn samples() -> Vec<Vec<u8>> {
    let mut bench = Bench::new(Bench::settings());
    bench.wire.listens = true;
    let desk = bench.desk.bind(5353);
    bench.get_address();
    let client = bench.connect(23);
    bench.desk.send(client, b"\xFF\xFD\x01M115\n");
    bench.run(10 * SECOND);
    bench.desk.tcp(client).close();
    bench.run(2 * SECOND);
    let _heard = desk;
    let mut samples = std::mem::take(&mut bench.wire.heard);
    samples.extend([syn((DESK, 9), (BOARD, 23)), echo(DESK, BOARD, 64), arp(true, DESK_MAC, DESK, BOARD)]);
    samples
}

/// Turns a frame of the board into one for it: addresses and ports are swapped.
fn returned(frame: &[u8]) -> Vec<u8> {
    let mut frame = frame.to_vec();
    if frame.len() > 34 && frame[6..12] == BOARD_MAC {
        for at in 0..6 {
            frame.swap(at, at + 6);
        }
        if frame[12..14] == [8, 0] {
            (0..4).for_each(|at| frame.swap(26 + at, 30 + at));
            if frame.len() > 37 {
                (0..2).for_each(|at| frame.swap(34 + at, 36 + at));
            }
        }
    }
    frame
}

fn mutated(samples: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut frame = returned(&samples[random.below(samples.len() as u32) as usize]);
    for _ in 0..random.below(6) {
        let at = random.below(frame.len().max(1) as u32) as usize;
        match random.below(5) {
            0 if !frame.is_empty() => frame[at] = random.next() as u8,
            1 if !frame.is_empty() => frame[at] ^= 1 << random.below(8),
            2 => frame.truncate(at),
            3 => frame.extend((0..random.below(60)).map(|_| random.next() as u8)),
            _ if frame.len() > at => frame[at] = [0, 1, 0x7F, 0x80, 0xFF][random.below(5) as usize],
            _ => {}
        }
    }
    frame.truncate(1_514);
    frame
}

/// Feeds frames to a board, and then sees whether it is as good as new.
fn feed(count: u32, seed: u64) {
    let (samples, mut random) = (samples(), Random::new(seed));
    let mut bench = Bench::with_address();
    for turn in 0..count {
        let frame = if random.below(8) == 0 {
            let mut frame: Vec<u8> = BOARD_MAC.to_vec();
            frame.extend((0..random.below(1_500)).map(|_| random.next() as u8));
            frame
        } else {
            mutated(&samples, &mut random)
        };
        bench.port.inject(&frame);
        bench.step();
        if turn % 64 == 0 {
            bench.run(u64::from(random.below(20)) * MS);
        }
    }
    bench.run(60 * SECOND);
    bench.get_address();
    let clients = [bench.connect(23), bench.connect(23), bench.connect(2323), bench.connect(2323)];
    bench.run(50 * MS);
    for line in &bench.lines {
        assert!(line.visitor.is_some(), "a console is lost");
    }
    bench.desk.send(clients[0], b"M115\n");
    assert!(bench.until(SECOND, |bench| bench.lines.iter().any(|line| line.text().ends_with("M115\n"))));
}

#[test]
fn frames_that_make_no_sense_do_no_harm() {
    (1..4).for_each(|seed| feed(3_000, seed));
}

#[test]
#[ignore = "minutes of frames: make net runs it"]
fn many_frames_that_make_no_sense_do_no_harm() {
    (100..300).for_each(|seed| feed(20_000, seed));
}
