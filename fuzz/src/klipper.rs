//! The target `klipper`: bytes and messages of a host, in any order, and time that passes between them.
//!
//! An input is a row of records: a kind, a length, and so many bytes. Bytes of a line go to the board as they
//! are; content is put into a block of the number that the board expects; time passes by milliseconds, or by
//! as many ticks as the bytes say.
//!
//! Whatever comes, the board answers, steps come in the order of their times and never late, and what has a
//! limit is at its default level a second after the last word.

use klipper::desk::Bench;
use klipper::{Command, Response};

/// Kinds of records.
const BYTES: u8 = 0;
const CONTENT: u8 = 1;
const MILLISECONDS: u8 = 2;
const TICKS: u8 = 3;

/// Ticks of a millisecond.
const MS: u32 = 200_000;

/// Records to make inputs of. The messages have the numbers of the table, which `pieces_are_messages` holds
/// them to.
pub const PIECES: &[&[u8]] = &[
    // allocate_oids 8; steppers 0 and 1 on both edges; trsync 2; endstop 3; digital out 4 of 3 s; analog 5.
    &[CONTENT, 2, 5, 8],
    &[CONTENT, 7, 23, 0, 10, 11, 0x7F, 20, 10],
    &[CONTENT, 7, 23, 1, 12, 13, 0x7F, 20, 10],
    &[CONTENT, 2, 32, 2],
    &[CONTENT, 4, 29, 3, 20, 1],
    &[CONTENT, 10, 13, 4, 40, 0, 0, 0x82, 0x9E, 0x80, 0x80, 0],
    &[CONTENT, 4, 21, 5, 0x80, 0x5B],
    &[CONTENT, 2, 6, 7],
    // Time, a clock from it, steps, a turn.
    &[MILLISECONDS, 1, 1],
    &[MILLISECONDS, 1, 200],
    &[TICKS, 3, 1, 0x12, 0x34],
    &[CONTENT, 7, 26, 0, 0x81, 0xA0, 0x80, 0x80, 0],
    &[CONTENT, 7, 26, 1, 0x81, 0xA1, 0x80, 0x80, 0],
    &[CONTENT, 7, 24, 0, 0x80, 0xA7, 0x10, 60, 3],
    &[CONTENT, 7, 24, 1, 0x80, 0xA7, 0x10, 60, 0x7F],
    &[CONTENT, 3, 25, 0, 1],
    &[CONTENT, 3, 25, 1, 0],
    &[CONTENT, 3, 28, 0, 2],
    &[CONTENT, 6, 33, 2, 0, 0x80, 0x60, 4],
    &[CONTENT, 3, 35, 2, 9],
    &[CONTENT, 2, 27, 0],
    // What shuts down, and what begins anew.
    &[CONTENT, 1, 7],
    &[CONTENT, 1, 8],
    &[BYTES, 2, 0x7E, 0x7E],
    &[BYTES, 7, 0x1B, 0x01, 0x00, 0x01, 0x0E, 0x11, 0x04],
];

/// Runs an input.
pub fn run(input: &[u8]) {
    let mut bench = Bench::new(0xFFFF_0000);
    let mut limited = Vec::new();
    let mut rest = input;
    while let [kind, length, behind @ ..] = rest {
        let (bytes, later) = behind.split_at(usize::from(*length).min(behind.len()));
        rest = later;
        match kind % 4 {
            BYTES => drop(bench.bytes(bytes)),
            CONTENT => {
                let content = &bytes[..bytes.len().min(59)];
                let claimed = bench.wires.claimed.borrow().len();
                let _said = bench.block(content);
                // A message that was refused has claimed no pin.
                if bench.wires.claimed.borrow().len() > claimed {
                    limited.extend(limited_output(content));
                }
            }
            MILLISECONDS => bench.pass(u32::from(bytes.first().copied().unwrap_or(0)) * MS),
            _ => bench.pass(bytes.iter().take(3).fold(0, |ticks, byte| ticks << 8 | u32::from(*byte))),
        }
    }
    bench.pass(1000 * MS);
    for (pin, default_high) in limited {
        let level = bench.wires.levels.borrow().get(&pin).copied();
        assert!(level == Some(default_high), "pin {pin} is {level:?} after a second of silence");
    }
    in_order(&bench);
    bench.heard();
    // Noise may be the beginning of a block: the ends of one close it.
    bench.bytes(&[0x7E; 66]);
    let said = bench.tell(Command::GetClock, &[]);
    assert!(said.iter().any(|(kind, ..)| *kind == Response::Clock), "no answer: {said:?}");
    bench.give_back();
}

/// Returns pin and default level of a message that alone configures an output with a limit.
fn limited_output(content: &[u8]) -> Option<(u32, bool)> {
    let (number, mut rest) = klipper::read_integer(content)?;
    if number != Command::ConfigDigitalOut.number() as u32 {
        return None;
    }
    let mut words = [0; 5];
    for word in &mut words {
        (*word, rest) = klipper::read_integer(rest)?;
    }
    let [_, pin, _, default_level, most_ticks] = words;
    (rest.is_empty() && most_ticks != 0).then_some((pin, default_level != 0))
}

/// Steps were played in the order of their times.
fn in_order(bench: &Bench) {
    for pair in bench.played.windows(2) {
        let [first, second] = pair else { continue };
        assert!(second.at.wrapping_sub(first.at) as i32 >= 0, "{second:?} behind {first:?}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_messages() {
        let mut bench = Bench::new(0);
        let mut shutdowns = 0;
        for piece in &PIECES[..8] {
            let said = bench.block(&piece[2..]);
            shutdowns += said.iter().filter(|(kind, ..)| *kind == Response::Shutdown).count();
        }
        assert_eq!(shutdowns, 0);
        assert!(bench.wires.has_begun.get());
        for piece in PIECES {
            assert_eq!(usize::from(piece[1]), piece.len() - 2, "{piece:?}");
        }
    }
}
