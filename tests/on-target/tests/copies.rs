//! The board package's own `memcpy`, `memmove` and `memset`, at every alignment and every length that takes a
//! path of its own.
//!
//! Lengths and places go through `black_box`, so that the calls are real ones.
#![no_std]
#![no_main]

use on_target as _;

/// Longest copy, more than two of the longest strides.
const LONGEST: usize = 100;
const ROOM: usize = 256;
/// Offset of the destination, with room around it to see which bytes were touched.
const AT: usize = 64;

/// A pattern in which every byte differs from its neighbours, and from the same place of another one.
fn pattern(seed: u8) -> [u8; ROOM] {
    let mut bytes = [0; ROOM];
    for (index, byte) in bytes.iter_mut().enumerate() {
        *byte = (index as u8).wrapping_mul(37).wrapping_add(seed);
    }
    bytes
}

/// Every offset from a word of source and destination, every length.
fn cases() -> impl Iterator<Item = (usize, usize, usize)> {
    let offsets = (0..4).flat_map(|from| (0..4).map(move |to| (from, to)));
    offsets.flat_map(|(from, to)| (0..=LONGEST).map(move |length| (from, to, length)))
}

#[repr(align(8))]
struct Aligned([u8; ROOM]);

#[defmt_test::tests]
mod tests {
    use super::{AT, Aligned, ROOM, cases, pattern};
    use core::hint::black_box;
    use on_target::{Bench, bench};

    #[init]
    fn init() -> Bench {
        bench()
    }

    #[test]
    fn a_copy_is_the_source_and_nothing_beside_it_changes(bench: &mut Bench) {
        let source = Aligned(pattern(1));
        for (from, to, length) in cases() {
            let (from, to, length) = black_box((from, AT + to, length));
            let mut target = Aligned(pattern(200));
            target.0[to..to + length].copy_from_slice(&source.0[from..from + length]);
            let before = pattern(200);
            for index in 0..ROOM {
                let copied = index >= to && index < to + length;
                let expected = if copied { source.0[from + index - to] } else { before[index] };
                defmt::assert_eq!(target.0[index], expected, "{} bytes, {} to {}, at {}", length, from, to, index);
            }
            bench.watchdog.feed();
        }
    }

    #[test]
    fn an_overlapping_move_is_as_if_the_source_had_been_put_aside(bench: &mut Bench) {
        for (from, to, length) in cases() {
            // Far before, overlapping from below and from above, and in place.
            for shift in [0, 3, 32, 61] {
                let (from, to, length) = black_box((AT - 32 + from + shift, AT + to, length));
                let (before, mut bytes) = (pattern(7), Aligned(pattern(7)));
                bytes.0.copy_within(from..from + length, to);
                for index in 0..ROOM {
                    let moved = index >= to && index < to + length;
                    let expected = if moved { before[from + index - to] } else { before[index] };
                    defmt::assert_eq!(bytes.0[index], expected, "{} bytes, {} to {}, at {}", length, from, to, index);
                }
            }
            bench.watchdog.feed();
        }
    }

    #[test]
    fn a_fill_reaches_its_ends_and_no_further(bench: &mut Bench) {
        for (value, to, length) in cases() {
            let (value, to, length) = black_box((value as u8 * 85, AT + to, length));
            let (before, mut bytes) = (pattern(9), Aligned(pattern(9)));
            bytes.0[to..to + length].fill(value);
            for index in 0..ROOM {
                let filled = index >= to && index < to + length;
                let expected = if filled { value } else { before[index] };
                defmt::assert_eq!(bytes.0[index], expected, "{} bytes of {} at {}, at {}", length, value, to, index);
            }
            bench.watchdog.feed();
        }
    }
}
