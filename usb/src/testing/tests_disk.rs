//! The disk as hosts use it.

use proptest::prelude::*;

use super::disk::{Expects, ten};
use super::{Board, Failure, Options, Request};
use crate::storage::{BLOCK_BYTES, Fault, State};

/// Returns bytes of the card, as a computer would see them.
fn blocks(board: &Board, first: u32, count: u32) -> Vec<u8> {
    board.card.inside().blocks[first as usize * BLOCK_BYTES..(first + count) as usize * BLOCK_BYTES].to_vec()
}

#[test]
fn blocks_are_read_in_every_number() {
    let mut board = Board::with_disk();
    for (first, count) in [(0, 1), (0, 4), (1, 5), (60, 4), (0, 64), (63, 1)] {
        let ended = board.read_blocks(first, count);
        assert_eq!((ended.status, ended.residue, ended.was_halted), (0, 0, false));
        assert!(ended.data == blocks(&board, first, count.into()), "{count} blocks from {first}");
    }
    assert_eq!(board.read_blocks(5, 0).status, 0, "no blocks are no error");
}

#[test]
fn blocks_are_written_and_read_back() {
    let mut board = Board::with_disk();
    for (first, count) in [(0_u32, 1_usize), (3, 4), (8, 9), (62, 2)] {
        let data: Vec<u8> = (0..count * BLOCK_BYTES).map(|at| (at / 3 + first as usize) as u8).collect();
        let ended = board.write_blocks(first, &data);
        assert_eq!((ended.status, ended.residue), (0, 0));
        assert!(blocks(&board, first, count as u32) == data);
        assert!(board.read_blocks(first, count as u16).data == data);
    }
}

#[test]
fn the_card_works_while_the_bus_does() {
    let mut board = Board::with_disk();
    board.read_blocks(0, 16);
    assert_eq!(board.card.inside().operations, [('r', 0, 4), ('r', 4, 4), ('r', 8, 4), ('r', 12, 4)]);
    board.card.inside().operations.clear();
    board.write_blocks(0, &[7; 10 * BLOCK_BYTES]);
    assert_eq!(board.card.inside().operations, [('w', 0, 4), ('w', 4, 4), ('w', 8, 2)]);
}

#[test]
fn a_slow_card_is_waited_for() {
    let mut board = Board::with_disk();
    board.card.inside().slowness = 500;
    let data = [9; 12 * BLOCK_BYTES];
    assert_eq!(board.write_blocks(0, &data).status, 0);
    assert!(board.read_blocks(0, 12).data == data);
}

#[test]
fn a_status_comes_when_the_last_block_is_on_the_card() {
    let mut board = Board::with_disk();
    board.card.inside().slowness = 200;
    let data = [3; BLOCK_BYTES];
    board.host.bulk_out(3, &super::disk::command(1, Expects::Out(&data), &ten(0x2A, 7, 1))).unwrap();
    board.host.bulk_out(3, &data).unwrap();
    assert_eq!(board.host.try_in(5), Ok(None), "it is being written");
    let status = board.host.bulk_in(5, 13).unwrap();
    assert_eq!((status[12], blocks(&board, 7, 1) == data), (0, true));
}

#[test]
fn what_a_host_asks_first_is_answered() {
    let mut board = Board::enumerated();
    assert_eq!(board.host.ask(Request::new(0xA1, 0xFE, 0, 4, 1)).unwrap(), [0], "one unit");
    let inquiry = board.disk(Expects::In(36), &[0x12, 0, 0, 0, 36, 0]);
    assert_eq!((inquiry.status, inquiry.residue, inquiry.data.len()), (0, 0, 36));
    assert_eq!(inquiry.data[..8], [0, 0x80, 4, 2, 31, 0, 0, 0]);
    assert_eq!(&inquiry.data[8..], b"Velvet  SD card         1.0 ");
    let serial = board.disk(Expects::In(64), &[0x12, 1, 0x80, 0, 64, 0]);
    assert_eq!(&serial.data[4..], b"000012340000ABCD56789ABC");
    assert_eq!((serial.residue, serial.was_halted), (36, true));
    assert_eq!(board.disk(Expects::In(16), &[0xA0, 0, 0, 0, 0, 0, 0, 0, 0, 16, 0, 0]).data[3], 8, "one unit");
}

#[test]
fn the_capacity_is_told_in_every_form() {
    let mut board = Board::with_disk();
    assert_eq!(board.disk(Expects::In(8), &[0x25, 0, 0, 0, 0, 0, 0, 0, 0, 0]).data, [0, 0, 0, 63, 0, 0, 2, 0]);
    let mut sixteen = [0; 16];
    (sixteen[0], sixteen[1], sixteen[13]) = (0x9E, 0x10, 32);
    let long = board.disk(Expects::In(32), &sixteen).data;
    assert_eq!((long.len(), &long[..12]), (32, &[0, 0, 0, 0, 0, 0, 0, 63, 0, 0, 2, 0][..]));
    let formats = board.disk(Expects::In(12), &[0x23, 0, 0, 0, 0, 0, 0, 0, 12, 0]).data;
    assert_eq!(formats, [0, 0, 0, 8, 0, 0, 0, 64, 2, 0, 2, 0]);
}

#[test]
fn a_card_that_may_only_be_read_is_not_written() {
    let mut board = Board::enumerated();
    board.card.inside().state = State::Ready { blocks: 64, is_read_only: true, visit: 1 };
    board.disk(Expects::Nothing, &[0; 6]);
    let mode = board.disk(Expects::In(192), &[0x1A, 0, 0x3F, 0, 192, 0]);
    assert_eq!((mode.data.len(), mode.data[2]), (24, 0x80), "write protected");
    let before = blocks(&board, 0, 64);
    let ended = board.write_blocks(0, &[0; 2 * BLOCK_BYTES]);
    assert_eq!((ended.status, ended.was_halted, ended.residue), (1, true, 1024));
    assert_eq!(board.sense(), [7, 0x27, 0]);
    assert!(blocks(&board, 0, 64) == before && board.card.inside().operations.is_empty());
    assert!(board.read_blocks(0, 2).status == 0);
}

#[test]
fn nothing_is_cached() {
    let mut board = Board::with_disk();
    let mode = board.disk(Expects::In(28), &[0x5A, 0, 0x08, 0, 0, 0, 0, 0, 28, 0]).data;
    assert_eq!((mode.len(), mode[3], mode[8], mode[9], mode[10]), (28, 0, 0x08, 0x12, 0x01), "no cache for writes");
    let changeable = board.disk(Expects::In(28), &[0x5A, 0, 0x48, 0, 0, 0, 0, 0, 28, 0]).data;
    assert_eq!(changeable[10], 0, "and nothing that could be changed");
    assert_eq!(board.disk(Expects::Nothing, &ten(0x35, 0, 0)).status, 0);
    assert_eq!(board.disk(Expects::In(28), &[0x1A, 0, 0xC8, 0, 28, 0]).status, 1, "no saved values");
    assert_eq!(board.disk(Expects::In(28), &[0x1A, 0, 0x1C, 0, 28, 0]).status, 1, "no such page");
}

#[test]
fn an_empty_slot_is_no_error_of_the_disk() {
    let mut board = Board::enumerated();
    board.card.inside().state = State::Absent;
    for bytes in [&[0; 6][..], &ten(0x28, 0, 1), &ten(0x2A, 0, 1), &ten(0x25, 0, 0), &ten(0x35, 0, 0)] {
        let expects = match bytes[0] {
            0x28 | 0x25 => Expects::In(512),
            0x2A => Expects::Out(&[0; 512]),
            _ => Expects::Nothing,
        };
        let ended = board.disk(expects, bytes);
        assert_eq!(ended.status, 1, "{:#x}", bytes[0]);
        assert_eq!(board.sense(), [2, 0x3A, 0]);
    }
    assert_eq!(board.disk(Expects::In(12), &[0x23, 0, 0, 0, 0, 0, 0, 0, 12, 0]).data[8], 3, "no medium");
    assert_eq!(board.disk(Expects::In(36), &[0x12, 0, 0, 0, 36, 0]).status, 0);
}

#[test]
fn the_host_ejects_and_gets_the_card_again() {
    let mut board = Board::with_disk();
    assert_eq!(board.disk(Expects::Nothing, &[0x1E, 0, 0, 0, 1, 0]).status, 0, "it is in use");
    assert_eq!(board.disk(Expects::Nothing, &[0x1B, 0, 0, 0, 2, 0]).status, 1);
    assert_eq!(board.sense(), [5, 0x53, 2]);
    assert_eq!(board.card.inside().ejected, 0);
    assert_eq!(board.disk(Expects::Nothing, &[0x1E, 0, 0, 0, 0, 0]).status, 0);
    assert_eq!(board.disk(Expects::Nothing, &[0x1B, 0, 0, 0, 0, 0]).status, 0, "stopping alone ejects nothing");
    assert_eq!(board.disk(Expects::Nothing, &[0x1B, 0, 0, 0, 2, 0]).status, 0);
    assert_eq!(board.card.inside().ejected, 1);
    assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, 1);
    assert_eq!(board.sense(), [2, 0x3A, 0]);
    assert_eq!(board.disk(Expects::Nothing, &[0x1B, 0, 0, 0, 3, 0]).status, 1, "the host cannot load it");
    board.card.inside().state = State::Ready { blocks: 64, is_read_only: false, visit: 2 };
    assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, 1);
    assert_eq!(board.sense(), [6, 0x28, 0], "whatever the host remembers of it may have changed");
    assert_eq!(board.read_blocks(0, 1).status, 0);
}

#[test]
fn a_card_that_was_away_between_two_commands_is_another_one() {
    let mut board = Board::with_disk();
    board.card.inside().state = State::Ready { blocks: 64, is_read_only: false, visit: 2 };
    let ended = board.read_blocks(0, 1);
    assert_eq!((ended.status, ended.data.len()), (1, 0));
    assert_eq!(board.sense(), [6, 0x28, 0]);
}

#[test]
fn what_the_card_fails_at_is_told() {
    let cases = [
        (Fault::Unreadable, [3, 0x11, 0]),
        (Fault::NotWritten, [3, 0x03, 0]),
        (Fault::Silent, [4, 0x08, 1]),
        (Fault::Gone, [2, 0x3A, 0]),
        (Fault::ReadOnly, [7, 0x27, 0]),
    ];
    for (fault, sense) in cases {
        let mut board = Board::with_disk();
        board.card.inside().bad = Some((9, fault));
        let ended = board.read_blocks(0, 16);
        assert_eq!((ended.status, ended.was_halted), (1, true));
        assert_eq!(ended.residue as usize, 16 * BLOCK_BYTES - ended.data.len());
        assert!(ended.data.len() <= 8 * BLOCK_BYTES && ended.data == blocks(&board, 0, 16)[..ended.data.len()]);
        assert_eq!(board.sense(), sense);
        let ended = board.write_blocks(4, &[1; 24 * BLOCK_BYTES]);
        assert_eq!((ended.status, ended.was_halted), (1, true));
        assert_eq!(board.sense(), sense);
        assert_eq!(board.write_blocks(9, &[1; BLOCK_BYTES]).status, 1, "the last block, when all is sent");
        assert_eq!(board.sense(), sense);
        board.card.inside().bad = None;
        assert_eq!(board.read_blocks(0, 16).status, 0, "and it goes on");
    }
}

#[test]
fn verifying_reads_and_sends_nothing() {
    let mut board = Board::with_disk();
    assert_eq!(board.disk(Expects::Nothing, &ten(0x2F, 0, 20)).status, 0);
    let read: u32 = board.card.inside().operations.iter().map(|(_, _, count)| count).sum();
    assert_eq!(read, 20);
    board.card.inside().bad = Some((9, Fault::Unreadable));
    assert_eq!(board.disk(Expects::Nothing, &ten(0x2F, 0, 20)).status, 1);
    assert_eq!(board.sense(), [3, 0x11, 0]);
    let mut compare = ten(0x2F, 0, 1);
    compare[1] = 2;
    assert_eq!(board.disk(Expects::Out(&[0; 512]), &compare).status, 1, "with data it is refused");
    assert_eq!(board.sense(), [5, 0x24, 0]);
}

#[test]
fn blocks_behind_the_end_are_refused() {
    let mut board = Board::with_disk();
    for (first, count) in [(64, 1), (63, 2), (u32::MAX, 1), (u32::MAX, 0xFFFF), (0, 65)] {
        assert_eq!(board.read_blocks(first, count).status, 1, "{count} from {first}");
        assert_eq!(board.sense(), [5, 0x21, 0]);
        let data = vec![0; usize::from(count) * BLOCK_BYTES];
        assert_eq!(board.write_blocks(first, &data).status, 1);
    }
    assert_eq!(board.read_blocks(63, 1).status, 0);
}

#[test]
fn the_card_may_go_in_the_middle_of_a_transfer() {
    let mut board = Board::with_disk();
    let wrapper = super::disk::command(1, Expects::In(64 * 512), &ten(0x28, 0, 64));
    board.host.bulk_out(3, &wrapper).unwrap();
    for _ in 0..5 {
        board.host.in_packet(5).unwrap();
    }
    board.card.inside().state = State::Absent;
    let Err((_, failure)) = board.host.bulk_in(5, 64 * 512) else { panic!("all of it cannot come") };
    assert_eq!(failure, Failure::Stall);
    board.host.clear_halt(0x85);
    assert_eq!(board.host.bulk_in(5, 13).unwrap()[12], 1);
    assert_eq!(board.sense(), [2, 0x3A, 0]);
}

#[test]
fn without_a_disk_there_is_none() {
    let mut board = Board::new(Options { disk: false, ..Options::ALL });
    board.host.enumerate();
    assert_eq!(board.host.ask(Request::new(0xA1, 0xFE, 0, 4, 1)), Err(Failure::Stall));
    assert_eq!(board.host.ask(Request::new(0x82, 0, 0, 0x85, 2)), Err(Failure::Stall));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Reads return the data written last, for random reads and writes.
    #[test]
    fn the_disk_is_the_card(
        accesses in prop::collection::vec((any::<bool>(), 0_u32..64, 1_u16..20, any::<u8>()), 1..12),
        slowness in 0_u32..12,
    ) {
        let mut board = Board::with_disk();
        board.card.inside().slowness = slowness;
        let mut expected = blocks(&board, 0, 64);
        for (writes, first, count, fill) in accesses {
            let count = count.min((64 - first) as u16);
            let range = first as usize * BLOCK_BYTES..(first as usize + usize::from(count)) * BLOCK_BYTES;
            if writes {
                let data: Vec<u8> = range.clone().map(|at| (at as u8).wrapping_mul(31) ^ fill).collect();
                prop_assert_eq!(board.write_blocks(first, &data).status, 0);
                expected[range].copy_from_slice(&data);
            } else {
                prop_assert!(board.read_blocks(first, count).data == expected[range]);
            }
        }
        prop_assert!(blocks(&board, 0, 64) == expected);
    }
}
