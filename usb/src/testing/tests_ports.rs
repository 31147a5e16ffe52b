//! Serial ports: begin and end of visits, and flow control.

use proptest::prelude::*;

use super::bus::Event;
use super::{Board, Failure, Options, Request};

const SEND_ENCAPSULATED: u8 = 0x00;
const SET_LINE_CODING: u8 = 0x20;
const GET_LINE_CODING: u8 = 0x21;
const SET_CONTROL_LINE_STATE: u8 = 0x22;
const SEND_BREAK: u8 = 0x23;

/// Sets DTR and RTS of the port at this interface.
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
        // The host asks for more than there is, so a short packet ends the transfer, or an empty packet
        // behind a full one.
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
    assert_eq!(board.lines[0].state().received.len(), 256, "whole packets");
    assert_eq!(sent, 256 + 2 * 64, "two packets wait in the controller");
    // Other functions of the device still work.
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

/// A computer that gives up unsent data lets DTR fall first: until the computer has taken the data back, more
/// bytes may come.
#[test]
fn what_comes_behind_a_fallen_dtr_is_no_line_of_its_own_and_nobody_the_next_one_is_taken_for() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 3);
    board.host.bulk_out(1, b"G1 X2").unwrap();
    set_lines(&mut board, 0, 0);
    board.host.bulk_out(1, b"00\n").unwrap();
    assert_eq!(board.lines[0].state().come_back, 1, "in the middle of a line");
    assert_eq!(board.lines[0].state().received, b"G1 X200\n");
    set_lines(&mut board, 0, 3);
    assert_eq!(board.lines[0].state().visits, [true, false, true, false, true], "the next one is another one");
    // After a new plug-in, a host that never sets DTR continues nobody's line.
    board.host.enumerate();
    board.host.bulk_out(1, b"M115\n").unwrap();
    assert_eq!(board.lines[0].state().come_back, 1);
}

#[test]
fn a_silent_bus_is_an_unplugged_cable() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 1);
    set_lines(&mut board, 2, 1);
    board.host.event(Event::Suspend);
    assert!(!board.lines[0].is_open() && !board.lines[1].is_open());
    // The bus resumes without a reset, because the computer had slept.
    board.host.event(Event::Resume);
    assert!(board.lines[0].is_open() && board.lines[1].is_open());
    assert_eq!(board.lines[0].state().come_back, 1, "in the middle of a line perhaps");
    // The bus resumes with a reset, because the cable was plugged in again.
    board.host.event(Event::Suspend);
    board.host.enumerate();
    assert!(!board.lines[0].is_open() && !board.lines[1].is_open());
    set_lines(&mut board, 0, 1);
    board.lines[0].say(b"Welcome\n");
    board.host.device_runs();
    assert_eq!(board.host.bulk_in(1, 64).unwrap(), b"Welcome\n");
}

/// Ways to end a visit.
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
fn what_has_arrived_when_the_host_goes_reaches_the_line() {
    use Going::{Configuration, Dtr, Reset, Silence, SilenceAndReset};
    for going in [Silence, SilenceAndReset, Reset, Dtr, Configuration(0), Configuration(1)] {
        // Of two packets that wait, the line has room for none, one or both when the host goes.
        for room in [0, 64, 200] {
            let mut board = Board::enumerated();
            set_lines(&mut board, 0, 1);
            board.lines[0].state().room = 200;
            let text: Vec<u8> = (0..640).map(|at| at as u8).collect();
            let (sent, _) = board.host.bulk_out(1, &text).unwrap_err();
            assert_eq!(board.lines[0].state().received.len() + 2 * 64, sent, "{going:?}: two packets wait");
            board.lines[0].state().room = room;
            go(&mut board, going);
            let taken = sent - 2 * 64 + room.min(2 * 64);
            board.host.device_runs();
            assert_eq!(board.lines[0].state().received, text[..taken], "{going:?}");
            board.lines[0].say(b"ok\n");
            board.lines[0].state().room = 1_000;
            board.host.device_runs();
            let state = board.lines[0].state();
            assert_eq!(state.received, text[..sent], "{going:?}");
            assert_eq!((&state.visits[..], state.received_at.last()), (&[true, false][..], Some(&taken)), "{going:?}");
        }
    }
}

#[test]
fn a_line_of_whoever_opens_and_closes_quickly_stays_a_line() {
    let mut board = Board::enumerated();
    board.lines[0].state().room = 0;
    for visitor in [b"1\n", b"2\n"] {
        set_lines(&mut board, 0, 1);
        board.host.out_packet(1, visitor).unwrap();
        board.host.device_runs();
        set_lines(&mut board, 0, 0);
    }
    set_lines(&mut board, 0, 1);
    assert_eq!(board.host.out_packet(1, b"3\n"), Err(Failure::Timeout), "he is held back");
    board.lines[0].state().room = 64;
    board.host.device_runs();
    board.host.out_packet(1, b"3\n").unwrap();
    board.lines[0].state().room = 1_000;
    board.host.device_runs();
    let state = board.lines[0].state();
    assert_eq!(state.received, b"1\n2\n3\n");
    assert_eq!(state.visits, [true, false, true, false, true]);
    assert_eq!(state.received_at, [0, 0, 2, 4, 4], "each is met behind what the one before has sent");
}

#[test]
fn whoever_sleeps_while_the_line_is_full_goes_on_with_his_line() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 1);
    board.lines[0].state().room = 0;
    board.host.out_packet(1, b"G1 X").unwrap();
    board.host.device_runs();
    board.host.event(Event::Suspend);
    board.host.event(Event::Resume);
    board.host.out_packet(1, b"200\n").unwrap();
    set_lines(&mut board, 0, 0);
    assert_eq!(board.lines[0].state().come_back, 0, "what he had sent is not fetched yet");
    board.lines[0].state().room = 1_000;
    board.host.device_runs();
    let state = board.lines[0].state();
    assert_eq!((state.received.as_slice(), state.come_back), (&b"G1 X200\n"[..], 1));
    assert_eq!(state.received_at, [0, 0, 4, 8], "in the middle of it he is there again, not anew");
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
    // A packet is already in the controller, and cannot be taken back.
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
    for length in [1, 4, 8, 64] {
        let part = board.host.ask(Request::new(0xA1, GET_LINE_CODING, 0, 0, length)).unwrap();
        assert_eq!(part, set[..set.len().min(length.into())], "{length} bytes are asked for");
    }
    let wrong = [0, 0, 0, 0, 9, 9, 9];
    assert_eq!(board.host.out(Request::new(0x21, SET_LINE_CODING, 0, 0, 7), &wrong), Err(Failure::Stall));
    assert_eq!(board.host.out(Request::new(0x21, SET_LINE_CODING, 0, 0, 3), &wrong[..3]), Err(Failure::Stall));
    board.host.enumerate();
    assert_eq!(coding(&mut board, 0).unwrap(), set, "kept");
    assert_eq!(board.host.out(Request::new(0x21, SEND_BREAK, 100, 0, 0), &[]), Err(Failure::Stall));
    assert_eq!(board.host.out(Request::new(0x21, SEND_ENCAPSULATED, 0, 0, 3), b"ATZ"), Err(Failure::Stall));
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
    board.host.out(Request::new(0, 9, 1, 0, 0), &[]).unwrap();
    assert!(board.host.in_packet(2).is_ok() && board.host.in_packet(4).is_ok(), "both begin anew");
}

#[test]
fn an_interface_that_is_set_begins_anew() {
    let mut board = Board::enumerated();
    set_lines(&mut board, 0, 1);
    set_lines(&mut board, 2, 1);
    for (round, interface) in [1, 3, 0, 2, 1].into_iter().enumerate() {
        for (line, from_host, to_host) in [(0, 1, 1), (1, 2, 3)] {
            board.host.bulk_out(from_host, b"M105\n").unwrap();
            board.lines[line].say(b"ok\n");
            board.host.device_runs();
            assert_eq!(board.host.bulk_in(to_host, 64).unwrap(), b"ok\n");
            assert_eq!(board.lines[line].state().received.len(), 5 * (round + 1));
        }
        board.host.out(Request::new(0x01, 11, 0, interface, 0), &[]).unwrap();
    }
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

    /// Every byte arrives once and in order, at any speed of line and host.
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

    /// Through any sequence of visits, silences and delays, every acknowledged byte arrives in order, and no
    /// visit gets bytes of another.
    #[test]
    fn nobodys_bytes_are_lost_or_another_ones(
        steps in prop::collection::vec((0_usize..7, 0_usize..400), 1..60),
    ) {
        let mut board = Board::enumerated();
        board.lines[0].state().room = 0;
        let (mut who, mut sent) = (0_u8, Vec::new());
        set_lines(&mut board, 0, 1);
        for (what, amount) in steps {
            match what {
                0..=2 => {
                    let packet = vec![who; 1 + amount % 64];
                    if board.host.try_out(1, &packet).unwrap() {
                        sent.extend(packet);
                    }
                }
                3 => board.lines[0].state().room += amount,
                4 => {
                    board.host.event(Event::Suspend);
                    board.host.device_runs();
                    board.host.event(Event::Resume);
                }
                5 => {
                    set_lines(&mut board, 0, 0);
                    who += 1;
                    set_lines(&mut board, 0, 1);
                }
                _ => {
                    board.host.event(Event::Suspend);
                    board.host.enumerate();
                    who += 1;
                    set_lines(&mut board, 0, 1);
                }
            }
            board.host.device_runs();
        }
        board.lines[0].state().room = 1_000_000;
        board.host.device_runs();
        let state = board.lines[0].state();
        prop_assert_eq!(&state.received, &sent);
        let comings = state.visits.iter().zip(&state.received_at).filter(|(open, _)| **open).map(|(_, at)| *at);
        let ends = comings.clone().skip(1).chain([sent.len()]);
        for (from, to) in comings.zip(ends) {
            let of_one = sent[from..to].windows(2).all(|pair| pair[0] == pair[1]);
            prop_assert!(of_one, "from {} to {}: {:?}", from, to, &sent[from..to]);
        }
        prop_assert!(state.visits.last() == Some(&true), "whoever is there is met at last");
    }
}
