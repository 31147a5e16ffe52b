//! Requests on endpoint 0: valid, invalid, and random requests.

use proptest::prelude::*;

use super::bus::Event;
use super::{Board, Failure, Options, Request};

const GET_STATUS: u8 = 0;
const CLEAR_FEATURE: u8 = 1;
const SET_FEATURE: u8 = 3;
const SET_ADDRESS: u8 = 5;
const GET_DESCRIPTOR: u8 = 6;
const SET_DESCRIPTOR: u8 = 7;
const GET_CONFIGURATION: u8 = 8;
const SET_CONFIGURATION: u8 = 9;
const GET_INTERFACE: u8 = 10;
const SET_INTERFACE: u8 = 11;

#[test]
fn status_is_told_of_what_there_is() {
    let host = &mut Board::enumerated().host;
    assert_eq!(host.ask(Request::new(0x80, GET_STATUS, 0, 0, 2)).unwrap(), [1, 0], "self-powered");
    for interface in 0..6 {
        assert_eq!(host.ask(Request::new(0x81, GET_STATUS, 0, interface, 2)).unwrap(), [0, 0]);
    }
    assert_eq!(host.ask(Request::new(0x81, GET_STATUS, 0, 6, 2)), Err(Failure::Stall));
    for endpoint in [0x00, 0x80, 0x81, 0x01, 0x82, 0x83, 0x02, 0x84, 0x85, 0x03] {
        assert_eq!(host.ask(Request::new(0x82, GET_STATUS, 0, endpoint, 2)).unwrap(), [0, 0], "{endpoint:#x}");
    }
    for endpoint in [0x04, 0x86, 0x0F, 0x8F, 0x10, 0x101] {
        assert_eq!(host.ask(Request::new(0x82, GET_STATUS, 0, endpoint, 2)), Err(Failure::Stall), "{endpoint:#x}");
    }
}

#[test]
fn an_endpoint_is_halted_and_let_go() {
    let host = &mut Board::enumerated().host;
    for endpoint in [0x81, 0x01, 0x82, 0x83, 0x02, 0x84, 0x85, 0x03] {
        host.out(Request::new(0x02, SET_FEATURE, 0, endpoint, 0), &[]).unwrap();
        assert!(host.is_halted(endpoint as u8));
        host.clear_halt(endpoint as u8);
        assert!(!host.is_halted(endpoint as u8));
    }
    for (request, endpoint) in [(SET_FEATURE, 0x00), (SET_FEATURE, 0x80), (SET_FEATURE, 0x06), (CLEAR_FEATURE, 0x06)] {
        assert_eq!(host.out(Request::new(0x02, request, 0, endpoint, 0), &[]), Err(Failure::Stall));
    }
    host.out(Request::new(0x02, CLEAR_FEATURE, 0, 0x80, 0), &[]).unwrap();
    assert_eq!(host.out(Request::new(0x02, SET_FEATURE, 1, 0x81, 0), &[]), Err(Failure::Stall), "no such feature");
}

#[test]
fn the_host_cannot_have_itself_woken() {
    let host = &mut Board::enumerated().host;
    for request in [SET_FEATURE, CLEAR_FEATURE] {
        assert_eq!(host.out(Request::new(0x00, request, 1, 0, 0), &[]), Err(Failure::Stall));
        assert_eq!(host.out(Request::new(0x00, request, 2, 0x100, 0), &[]), Err(Failure::Stall), "test mode");
    }
}

#[test]
fn configurations_come_and_go() {
    let mut board = Board::new(Options::ALL);
    let host = &mut board.host;
    host.reset();
    let configuration = Request::new(0x80, GET_CONFIGURATION, 0, 0, 1);
    assert_eq!(host.ask(Request::new(0x81, GET_INTERFACE, 0, 0, 1)), Err(Failure::Stall), "not configured");
    assert_eq!(host.ask(Request::new(0x82, GET_STATUS, 0, 0x81, 2)), Err(Failure::Stall), "not configured");
    host.out(Request::new(0, SET_ADDRESS, 7, 0, 0), &[]).unwrap();
    assert_eq!(host.ask(configuration).unwrap(), [0]);
    assert_eq!(host.out(Request::new(0, SET_CONFIGURATION, 2, 0, 0), &[]), Err(Failure::Stall));
    host.out(Request::new(0, SET_CONFIGURATION, 1, 0, 0), &[]).unwrap();
    assert_eq!(host.ask(configuration).unwrap(), [1]);
    assert_eq!(host.ask(Request::new(0x81, GET_INTERFACE, 0, 4, 1)).unwrap(), [0]);
    host.out(Request::new(0x01, SET_INTERFACE, 0, 4, 0), &[]).unwrap();
    assert_eq!(host.out(Request::new(0x01, SET_INTERFACE, 1, 4, 0), &[]), Err(Failure::Stall));
    assert_eq!(host.out(Request::new(0x01, SET_INTERFACE, 0, 9, 0), &[]), Err(Failure::Stall));
    host.out(Request::new(0, SET_CONFIGURATION, 0, 0, 0), &[]).unwrap();
    assert_eq!(host.ask(configuration).unwrap(), [0]);
    assert_eq!(host.ask(Request::new(0x81, GET_INTERFACE, 0, 4, 1)), Err(Failure::Stall));
}

#[test]
fn what_nobody_knows_is_refused() {
    let host = &mut Board::enumerated().host;
    for kind in [0x80, 0x81, 0x82, 0x83, 0xA0, 0xA1, 0xA2, 0xC0, 0xC1, 0xE0, 0xFF] {
        assert_eq!(host.ask(Request::new(kind, 0x77, 0, 0, 8)), Err(Failure::Stall), "{kind:#x}");
    }
    for kind in [0x00, 0x01, 0x02, 0x20, 0x21, 0x22, 0x40, 0x41, 0x60] {
        assert_eq!(host.out(Request::new(kind, 0x77, 0, 0, 0), &[]), Err(Failure::Stall), "{kind:#x}");
        assert_eq!(host.out(Request::new(kind, 0x77, 0, 0, 9), &[1; 9]), Err(Failure::Stall), "{kind:#x} with data");
    }
    assert_eq!(host.out(Request::new(0x00, SET_DESCRIPTOR, 0x100, 0, 18), &[0; 18]), Err(Failure::Stall));
}

#[test]
fn data_that_do_not_fit_are_refused_at_once() {
    let host = &mut Board::enumerated().host;
    for length in [257, 1024, 0xFFFF] {
        let request = Request::new(0x21, 0x20, 0, 0, length);
        assert_eq!(host.out(request, &[0; 300]), Err(Failure::Stall), "{length} bytes");
    }
    let host = &mut Board::enumerated().host;
    // The host sends more data than announced.
    let request = Request::new(0x21, 0x20, 0, 0, 7);
    let sent = host.out(request, &[0; 64]);
    assert!(sent.is_err() || host.ask(Request::new(0xA1, 0x21, 0, 0, 7)).is_ok());
    assert_eq!(host.ask(Request::new(0x80, GET_CONFIGURATION, 0, 0, 1)).unwrap(), [1], "and it goes on");
}

#[test]
fn a_request_breaks_off_the_one_before() {
    let host = &mut Board::enumerated().host;
    // The host aborts a long answer in its middle.
    host.bus.wire().setup(Request::new(0x80, GET_DESCRIPTOR, 0x0200, 0, 200).bytes());
    host.device_runs();
    assert_eq!(host.in_packet(0).unwrap().len(), 64);
    // The answer is exactly a packet: the empty packet behind it must not remain for the next request.
    assert_eq!(host.descriptor(2, 0, 64).unwrap().len(), 64);
    assert_eq!(host.descriptor(1, 0, 18).unwrap().len(), 18);
    // The host announces data and does not send any.
    host.bus.wire().setup(Request::new(0x21, 0x20, 0, 0, 7).bytes());
    host.device_runs();
    assert_eq!(host.descriptor(1, 0, 18).unwrap().len(), 18);
}

#[test]
fn a_reset_may_come_at_any_moment() {
    let mut board = Board::enumerated();
    let host = &mut board.host;
    host.bus.wire().setup(Request::new(0x80, GET_DESCRIPTOR, 0x0200, 0, 200).bytes());
    host.device_runs();
    host.enumerate();
    host.event(Event::Suspend);
    host.enumerate();
    host.event(Event::Suspend);
    host.event(Event::Resume);
    assert_eq!(host.ask(Request::new(0x80, GET_CONFIGURATION, 0, 0, 1)).unwrap(), [1]);
}

prop_compose! {
    fn any_request()(
        // Request types with a meaning occur more often than others.
        kind in prop_oneof![
            4 => prop::sample::select(vec![0x00_u8, 0x01, 0x02, 0x21, 0x80, 0x81, 0x82, 0xA1, 0xC0]),
            1 => any::<u8>(),
        ],
        request in prop_oneof![4 => 0_u8..13, 2 => 0x20_u8..0x24, 1 => 0xFE_u8..=0xFF, 1 => any::<u8>()],
        value in prop_oneof![3 => 0_u16..3, 2 => (0_u16..16).prop_map(|kind| kind << 8), 1 => any::<u16>()],
        index in prop_oneof![3 => 0_u16..7, 2 => 0x80_u16..0x88, 1 => any::<u16>()],
        length in prop_oneof![2 => Just(0_u16), 3 => 1_u16..70, 1 => 250_u16..260, 1 => any::<u16>()],
    ) -> Request {
        Request { kind, request, value, index, length }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    /// Random requests cause no panic and are answered or stalled at once; afterwards the device can be
    /// enumerated and its ports carry bytes.
    #[test]
    fn any_requests_are_answered_or_refused(requests in prop::collection::vec(any_request(), 1..12), fill in any::<u8>()) {
        let mut board = Board::enumerated();
        for request in requests {
            let data = vec![fill; request.length.into()];
            let failed = if request.is_in() {
                board.host.ask(request).err()
            } else {
                board.host.out(request, &data).err()
            };
            prop_assert_ne!(failed, Some(Failure::Timeout), "{:?} is never answered", request);
        }
        board.host.enumerate();
        board.host.out(Request::new(0x21, 0x22, 1, 0, 0), &[]).unwrap();
        board.host.bulk_out(1, b"M105\n").unwrap();
        prop_assert!(board.lines[0].state().received.ends_with(b"M105\n"));
        board.lines[0].say(b"ok\n");
        board.host.device_runs();
        prop_assert_eq!(board.host.bulk_in(1, 64).unwrap(), b"ok\n");
    }
}
