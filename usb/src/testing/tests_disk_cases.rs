//! Hosts and commands that disagree: the thirteen cases of the bulk-only transport (BOT section 6.7), and
//! invalid commands (section 6.6).

use proptest::prelude::*;

use super::bus::Event;
use super::disk::{Expects, command, ten};
use super::{Board, Failure, Request};

const PASSED: u8 = 0;
const FAILED: u8 = 1;
const PHASE_ERROR: u8 = 2;
const BLOCK: [u8; 512] = [0x5A; 512];

/// Case: number, the host's expectation, the command, status, residue, halt, number of received bytes.
pub type Case<'c> = (u8, Expects<'c>, Vec<u8>, u8, u32, bool, usize);

/// Returns all thirteen cases (BOT section 6.7: H host, D device; n no data, i in, o out).
pub fn cases() -> Vec<Case<'static>> {
    let two = [0x5A; 1024].as_slice();
    vec![
        // Case 1: Hn = Dn.
        (1, Expects::Nothing, vec![0; 6], PASSED, 0, false, 0),
        // Case 2: Hn < Di.
        (2, Expects::Nothing, vec![0x12, 0, 0, 0, 36, 0], PHASE_ERROR, 0, false, 0),
        (2, Expects::Nothing, ten(0x28, 0, 1).to_vec(), PHASE_ERROR, 0, false, 0),
        // Case 3: Hn < Do.
        (3, Expects::Nothing, ten(0x2A, 0, 1).to_vec(), PHASE_ERROR, 0, false, 0),
        // Case 4: Hi > Dn.
        (4, Expects::In(36), vec![0; 6], PASSED, 36, true, 0),
        (4, Expects::In(512), ten(0x28, 0, 0).to_vec(), PASSED, 512, true, 0),
        (4, Expects::In(8), vec![0x77; 6], FAILED, 8, true, 0),
        // Case 5: Hi > Di.
        (5, Expects::In(64), vec![0x12, 0, 0, 0, 64, 0], PASSED, 28, true, 36),
        (5, Expects::In(1024), ten(0x28, 0, 1).to_vec(), PASSED, 512, true, 512),
        // Case 6: Hi = Di.
        (6, Expects::In(36), vec![0x12, 0, 0, 0, 36, 0], PASSED, 0, false, 36),
        (6, Expects::In(512), ten(0x28, 0, 1).to_vec(), PASSED, 0, false, 512),
        // Case 7: Hi < Di.
        (7, Expects::In(512), ten(0x28, 0, 2).to_vec(), PHASE_ERROR, 512, true, 0),
        // Case 8: Hi <> Do.
        (8, Expects::In(512), ten(0x2A, 0, 1).to_vec(), PHASE_ERROR, 512, true, 0),
        // Case 9: Ho > Dn.
        (9, Expects::Out(&BLOCK), vec![0; 6], PASSED, 512, true, 0),
        (9, Expects::Out(&BLOCK), vec![0x77; 6], FAILED, 512, true, 0),
        // Case 10: Ho <> Di.
        (10, Expects::Out(&BLOCK), ten(0x28, 0, 1).to_vec(), PHASE_ERROR, 512, true, 0),
        // Case 11: Ho > Do.
        (11, Expects::Out(two), ten(0x2A, 2, 1).to_vec(), PASSED, 512, true, 0),
        // Case 12: Ho = Do.
        (12, Expects::Out(&BLOCK), ten(0x2A, 2, 1).to_vec(), PASSED, 0, false, 0),
        // Case 13: Ho < Do.
        (13, Expects::Out(&BLOCK), ten(0x2A, 2, 2).to_vec(), PHASE_ERROR, 512, true, 0),
    ]
}

/// Runs a single case.
#[track_caller]
pub fn run_case((number, expects, bytes, status, residue, halted, length): &Case<'_>) {
    let mut board = Board::with_disk();
    let ended = board.disk(*expects, bytes);
    let name = format!("case {number}, command {bytes:x?}");
    assert_eq!((ended.status, ended.residue, ended.was_halted), (*status, *residue, *halted), "{name}");
    assert_eq!(ended.data.len(), *length, "{name}");
    let written = board.card.inside().operations.iter().filter(|(kind, ..)| *kind == 'w').count();
    assert_eq!(written, usize::from(matches!(number, 11 | 12)), "{name}");
    if *status == PHASE_ERROR {
        board.recover_disk();
    }
    assert_eq!(board.read_blocks(0, 3).status, PASSED, "behind {name}");
}

#[test]
fn the_thirteen_cases_end_as_the_specification_says() {
    cases().iter().for_each(run_case);
}

#[test]
fn what_is_no_command_halts_both_pipes_until_the_transport_is_reset() {
    let good = command(1, Expects::Nothing, &[0; 6]);
    let mut wrongs = vec![vec![], vec![0; 31], good[..30].to_vec(), [&good[..], &[0]].concat(), vec![0x55; 64]];
    for (place, value) in [(3, b'S'), (12, 0x01), (13, 0xF0), (14, 0), (14, 17)] {
        let mut wrong = good.clone();
        wrong[place] = value;
        wrongs.push(wrong);
    }
    for wrong in wrongs {
        let mut board = Board::with_disk();
        board.host.out_packet(3, &wrong).unwrap();
        assert_eq!(board.host.try_in(5), Err(Failure::Stall), "{wrong:x?}");
        assert_eq!(board.host.try_out(3, &good), Err(Failure::Stall));
        // Ending the halts alone is not enough.
        board.host.clear_halt(0x85);
        board.host.clear_halt(0x03);
        assert_eq!(board.host.try_in(5), Err(Failure::Stall));
        assert_eq!(board.host.try_out(3, &good), Err(Failure::Stall));
        board.recover_disk();
        assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, PASSED);
    }
}

#[test]
fn another_unit_than_the_first_there_is_not() {
    let mut board = Board::with_disk();
    let mut wrapper = command(0x1234_5678, Expects::Nothing, &[0; 6]);
    wrapper[13] = 1;
    board.host.bulk_out(3, &wrapper).unwrap();
    assert_eq!(board.host.bulk_in(5, 13).unwrap()[12], FAILED);
    assert_eq!(board.sense(), [5, 0x25, 0]);
}

#[test]
fn a_reset_of_the_transport_may_come_at_any_moment() {
    for packets in 0..20 {
        let mut board = Board::with_disk();
        board.card.inside().slowness = 40;
        board.host.bulk_out(3, &command(1, Expects::In(8192), &ten(0x28, 0, 16))).unwrap();
        for _ in 0..packets {
            board.host.in_packet(5).unwrap();
        }
        board.recover_disk();
        assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, PASSED, "behind {packets} packets");
        assert!(board.read_blocks(1, 2).status == PASSED);

        let data = [1; 8192];
        board.host.bulk_out(3, &command(1, Expects::Out(&data), &ten(0x2A, 0, 16))).unwrap();
        for packet in data.chunks(64).take(packets) {
            board.host.out_packet(3, packet).unwrap();
        }
        board.recover_disk();
        assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, PASSED, "behind {packets} packets written");
    }
}

#[test]
fn a_reset_of_the_bus_ends_the_command() {
    let mut board = Board::with_disk();
    board.card.inside().slowness = 40;
    let data = [1; 4096];
    board.host.bulk_out(3, &command(1, Expects::Out(&data), &ten(0x2A, 0, 8))).unwrap();
    board.host.bulk_out(3, &data[..2048 + 64]).unwrap();
    board.host.event(Event::Suspend);
    board.host.enumerate();
    assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, PASSED);
    assert_eq!(board.read_blocks(0, 8).status, PASSED);
}

#[test]
fn a_host_that_stops_sending_in_the_middle_is_told() {
    let mut board = Board::with_disk();
    board.host.bulk_out(3, &command(0x1234_5678, Expects::Out(&[0; 1024]), &ten(0x2A, 0, 2))).unwrap();
    board.host.out_packet(3, &[1; 64]).unwrap();
    board.host.out_packet(3, &[1; 10]).unwrap();
    let status = board.host.bulk_in(5, 13).unwrap();
    assert_eq!((status[12], status[8]), (PHASE_ERROR, (1024 - 74_u32) as u8));
    assert!(board.card.inside().operations.is_empty(), "half a block is not written");
    board.recover_disk();
    assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, PASSED);
}

#[test]
fn class_requests_that_are_none_are_refused() {
    let mut board = Board::with_disk();
    for request in [
        Request::new(0xA1, 0xFE, 0, 4, 2),
        Request::new(0xA1, 0xFE, 1, 4, 1),
        Request::new(0xA1, 0xFE, 0, 5, 1),
        Request::new(0xA1, 0xFF, 0, 4, 1),
    ] {
        assert_eq!(board.host.ask(request), Err(Failure::Stall), "{request:?}");
    }
    for request in [Request::new(0x21, 0xFF, 1, 4, 0), Request::new(0x21, 0xFE, 0, 4, 0)] {
        assert_eq!(board.host.out(request, &[]), Err(Failure::Stall), "{request:?}");
    }
    assert_eq!(board.disk(Expects::Nothing, &[0; 6]).status, PASSED);
}

prop_compose! {
    fn any_command()(
        operation in prop::sample::select(vec![
            0x00_u8, 0x03, 0x04, 0x12, 0x1A, 0x1B, 0x1E, 0x23, 0x25, 0x28, 0x2A, 0x2F, 0x35, 0x5A, 0x9E, 0xA0, 0xFF,
        ]),
        mut rest in prop::array::uniform15(prop_oneof![3 => Just(0_u8), 1 => any::<u8>()]),
        is_near in any::<bool>(),
    ) -> Vec<u8> {
        if is_near {
            // Restrict the command to existing blocks.
            rest[1..4].fill(0);
            rest[4] %= 40;
            rest[6] = 0;
            rest[7] %= 20;
        }
        [&[operation][..], &rest].concat()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_500, ..ProptestConfig::default() })]

    /// Every command has its status, and the disk goes on, for random commands and expectations.
    #[test]
    fn any_command_has_its_status(
        commands in prop::collection::vec(
            (any_command(), 0_u8..3, prop_oneof![Just(0_u32), 1_u32..100, (1_u32..20).prop_map(|blocks| blocks * 512)]),
            1..8,
        ),
    ) {
        let mut board = Board::with_disk();
        board.card.inside().slowness = 1;
        for (bytes, way, length) in commands {
            let data = vec![0xA5; length as usize];
            let expects = match way {
                0 => Expects::Nothing,
                1 => Expects::In(length),
                _ => Expects::Out(&data),
            };
            let ended = board.disk(expects, &bytes);
            prop_assert!(ended.status <= PHASE_ERROR);
            prop_assert!(ended.residue <= length);
            if ended.status == PHASE_ERROR {
                board.recover_disk();
            }
        }
        prop_assert_eq!(board.disk(Expects::In(36), &[0x12, 0, 0, 0, 36, 0]).data.len(), 36);
    }
}
