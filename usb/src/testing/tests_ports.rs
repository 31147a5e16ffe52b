//! Serial ports: who comes and goes, and who holds whom back.

use proptest::prelude::*;

use super::bus::Event;
use super::{Board, Failure, Options, Request};

const SET_LINE_CODING: u8 = 0x20;
const GET_LINE_CODING: u8 = 0x21;
const SET_CONTROL_LINE_STATE: u8 = 0x22;
const SEND_BREAK: u8 = 0x23;

/// DTR and RTS of the port at this interface.
fn set_lines(board: &mut Board, interface: u16, lines: u16) {
    board.host.out(Request::new(0x21, SET_CONTROL_LINE_STATE, lines, interface, 0), &[]).unwrap();
}

#[test]
fn bytes_go_both_ways_on_both_ports() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 3);
    set_lines(&mut board, 2, 3);
    board.host.bulk_out(1, b"G28\n").unwrap();
    board.host.bulk_out(2, b"M114\n").unwrap();
    assert_eq!(board.lines[0].state().received, b"G28\n");
    assert_eq!(board.lines[1].state().received, b"M114\n");
    board.lines[0].say(b"ok\n");
    board.lines[1].say(b"ok C: X:0\n");
    board.host.device_runs();
    assert_eq!(board.host.bulk_in(3, 64).unwrap(), b"ok C: X:0\n");
    assert_eq!(board.host.bulk_in(1, 64).unwrap(), b"ok\n");
}

#[test]
fn every_length_arrives_and_ends() {
    for length in [1, 63, 64, 65, 127, 128, 129, 1000, 4096] {
        let mut board = Board::enumerated();
        set_lines(&mut board, 0, 1);
        let text: Vec<u8> = (0..length).map(|at| at as u8).collect();
        board.host.bulk_out(1, &text).unwrap();
        assert_eq!(board.lines[0].state().received, text);
        board.lines[0].say(&text);
        board.host.device_runs();
        // The host asks for more than there is: a short packet ends it, an empty one where the last was full.
        assert_eq!(board.host.bulk_in(1, 65_536).unwrap(), text, "{length} bytes");
        assert_eq!(board.host.try_in(1), Ok(None), "and nothing comes behind");
    }
}

#[test]
fn a_full_line_holds_the_host_back() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 1);
    board.lines[0].state().room = 258;
    let text: Vec<u8> = (0..640).map(|at| at as u8).collect();
    let (sent, failure) = board.host.bulk_out(1, &text).unwrap_err();
    assert_eq!(failure, Failure::Timeout);
    assert_eq!(board.lines[0].state().received.len(), 128, "room is left for what waits in the controller");
    assert_eq!(sent, 128 + 2 * 64, "two packets wait there");
    // The rest of the device goes on.
    assert!(board.host.descriptor(1, 0, 18).is_ok());
    board.host.bulk_out(2, b"M112\n").unwrap();
    assert_eq!(board.lines[1].state().received, b"M112\n");
    board.lines[0].state().room = 10_000;
    board.host.device_runs();
    board.host.bulk_out(1, &text[sent..]).unwrap();
    assert_eq!(board.lines[0].state().received, text, "nothing lost, nothing twice");
}

#[test]
fn a_slow_host_holds_the_line_back() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 1);
    board.lines[0].say(&[b'x'; 1000]);
    for _ in 0..20 {
        board.host.device_runs();
    }
    assert_eq!(board.lines[0].state().to_send.len(), 1000 - 64 - 64, "one packet at the controller, one behind it");
    assert_eq!(board.host.bulk_in(1, 1024).unwrap().len(), 1000);
}

#[test]
fn somebody_is_there_while_dtr_is_set() {
    let mut board = Board::enumerated();
    assert!(!board.lines[0].is_open());
    board.lines[0].say(b"nobody hears this");
    board.host.device_runs();
    assert_eq!(board.host.try_in(1), Ok(None));
    set_lines(&mut board, 0, 1);
    assert!(board.lines[0].is_open() && !board.lines[1].is_open());
    set_lines(&mut board, 0, 3);
    set_lines(&mut board, 0, 0);
    assert_eq!(board.lines[0].state().visits, [true, false], "once each");
}

#[test]
fn a_host_without_dtr_is_there_from_its_first_byte_on() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 2);
    assert!(!board.lines[0].is_open());
    board.host.bulk_out(1, b"M115\n").unwrap();
    assert!(board.lines[0].is_open());
    set_lines(&mut board, 0, 0);
    assert!(board.lines[0].is_open(), "what was never set does not fall");
    assert_eq!(board.lines[0].state().received, b"M115\n");
    board.host.enumerate();
    assert_eq!(board.lines[0].state().visits, [true, false]);
}

#[test]
fn a_silent_bus_is_an_unplugged_cable() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 1);
    set_lines(&mut board, 2, 1);
    board.host.event(Event::Suspend);
    assert!(!board.lines[0].is_open() && !board.lines[1].is_open());
    // The computer had slept.
    board.host.event(Event::Resume);
    assert!(board.lines[0].is_open() && board.lines[1].is_open());
    assert_eq!(board.lines[0].state().come_back, 1, "in the middle of a line perhaps");
    // Plugged in again.
    board.host.event(Event::Suspend);
    board.host.enumerate();
    assert!(!board.lines[0].is_open() && !board.lines[1].is_open());
    set_lines(&mut board, 0, 1);
    board.lines[0].say(b"Welcome\n");
    board.host.device_runs();
    assert_eq!(board.host.bulk_in(1, 64).unwrap(), b"Welcome\n");
}

/// Ways to go.
#[derive(Clone, Copy, Debug)]
enum Going {
    Silence,
    SilenceAndReset,
    Reset,
    Dtr,
    Configuration(u16),
}

fn go(board: &mut Board, going: Going) {
    match going {
        Going::Silence => board.host.event(Event::Suspend),
        Going::SilenceAndReset => {
            board.host.event(Event::Suspend);
            board.host.reset();
        }
        Going::Reset => board.host.reset(),
        Going::Dtr => set_lines(board, 0, 0),
        Going::Configuration(number) => board.host.out(Request::new(0, 9, number, 0, 0), &[]).unwrap(),
    }
}

#[test]
fn what_has_arrived_when_the_host_goes_reaches_the_line_first() {
    use Going::{Configuration, Dtr, Reset, Silence, SilenceAndReset};
    for going in [Silence, SilenceAndReset, Reset, Dtr, Configuration(0), Configuration(1)] {
        let mut board = Board::enumerated();
        set_lines(&mut board, 0, 1);
        board.lines[0].state().room = 200;
        let text: Vec<u8> = (0..640).map(|at| at as u8).collect();
        let (sent, _) = board.host.bulk_out(1, &text).unwrap_err();
        assert_eq!(board.lines[0].state().received.len() + 2 * 64, sent, "{going:?}: two packets wait");
        go(&mut board, going);
        board.host.device_runs();
        let state = board.lines[0].state();
        assert_eq!(state.received, text[..sent], "{going:?}");
        assert_eq!((&state.visits[..], state.received_at.last()), (&[true, false][..], Some(&sent)), "{going:?}");
    }
}

#[test]
fn whoever_comes_next_does_not_get_what_waited_for_the_one_before() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 1);
    board.lines[0].say(&[b'o'; 500]);
    board.host.device_runs();
    set_lines(&mut board, 0, 0);
    set_lines(&mut board, 0, 1);
    board.lines[0].say(b"Welcome\n");
    board.host.device_runs();
    // One packet had left for the controller, which nothing can take back.
    assert_eq!(board.host.in_packet(1).unwrap(), [b'o'; 64]);
    assert_eq!(board.host.bulk_in(1, 64).unwrap(), b"Welcome\n");
}

#[test]
fn the_line_coding_reads_back() {
    let mut board = Board::enumerated();
    let coding = |board: &mut Board, port: u16| board.host.ask(Request::new(0xA1, GET_LINE_CODING, 0, port, 7));
    let default = [0x00, 0xC2, 0x01, 0x00, 0, 0, 8];
    assert_eq!(coding(&mut board, 0).unwrap(), default);
    let set = [0x90, 0xD0, 0x03, 0x00, 2, 1, 7];
    board.host.out(Request::new(0x21, SET_LINE_CODING, 0, 0, 7), &set).unwrap();
    assert_eq!(coding(&mut board, 0).unwrap(), set);
    assert_eq!(coding(&mut board, 2).unwrap(), default, "each port its own");
    let wrong = [0, 0, 0, 0, 9, 9, 9];
    assert_eq!(board.host.out(Request::new(0x21, SET_LINE_CODING, 0, 0, 7), &wrong), Err(Failure::Stall));
    assert_eq!(board.host.out(Request::new(0x21, SET_LINE_CODING, 0, 0, 3), &wrong[..3]), Err(Failure::Stall));
    board.host.enumerate();
    assert_eq!(coding(&mut board, 0).unwrap(), set, "kept");
    assert_eq!(board.host.out(Request::new(0x21, SEND_BREAK, 100, 0, 0), &[]), Err(Failure::Stall));
    assert_eq!(coding(&mut board, 1), Err(Failure::Stall), "the data interface has none");
}

#[test]
fn carrier_is_told_once_at_each_coming() {
    let mut board = Board::enumerated();
    assert_eq!(board.host.in_packet(2).unwrap(), [0xA1, 0x20, 0, 0, 0, 0, 2, 0, 3, 0]);
    assert_eq!(board.host.in_packet(4).unwrap(), [0xA1, 0x20, 0, 0, 2, 0, 2, 0, 3, 0]);
    assert_eq!(board.host.try_in(2), Ok(None));
    set_lines(&mut board, 0, 1);
    assert!(board.host.in_packet(2).is_ok());
    assert_eq!(board.host.try_in(2), Ok(None));
}

#[test]
fn nothing_is_taken_before_the_device_is_configured() {
    let mut board = Board::new(Options::ALL);
    board.host.reset();
    board.host.out_packet(1, b"G28\n").unwrap();
    assert!(board.lines[0].state().received.is_empty());
    board.lines[0].say(b"ok\n");
    board.host.device_runs();
    assert_eq!(board.host.try_in(1), Ok(None));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// However fast the line is emptied and the host reads: every byte arrives, in order, once.
    #[test]
    fn every_byte_arrives_once(
        steps in prop::collection::vec((0_usize..200, 0_usize..300, 0_usize..6, 0_usize..400), 1..60),
    ) {
        let mut board = Board::enumerated();
        set_lines(&mut board, 0, 1);
        board.lines[0].state().room = 0;
        let (mut to_send, mut expected, mut sent_back, mut heard) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut next = 0_u8;
        for (host_bytes, room, tokens, machine_bytes) in steps {
            for _ in 0..host_bytes {
                next = next.wrapping_add(1);
                to_send.push(next);
                expected.push(next);
            }
            board.lines[0].state().room += room;
            while !to_send.is_empty() {
                let packet: Vec<u8> = to_send.iter().copied().take(64).collect();
                if !board.host.try_out(1, &packet).unwrap() {
                    break;
                }
                to_send.drain(..packet.len());
            }
            let text: Vec<u8> = (0..machine_bytes).map(|at| at as u8).collect();
            board.lines[0].say(&text);
            sent_back.extend(text);
            for _ in 0..tokens {
                heard.extend(board.host.try_in(1).unwrap().unwrap_or_default());
            }
        }
        board.lines[0].state().room = 1_000_000;
        board.host.device_runs();
        board.host.bulk_out(1, &to_send).unwrap();
        board.host.device_runs();
        for _ in 0..3_000 {
            heard.extend(board.host.try_in(1).unwrap().unwrap_or_default());
        }
        prop_assert_eq!(&board.lines[0].state().received, &expected);
        prop_assert_eq!(heard, sent_back);
    }
}
