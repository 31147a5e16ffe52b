//! Other people's Ethernet driver and stack on the board, with a computer at the other end of the cable.

use crate::common::{Bench, MS, boot};
use virtual_prime::net_desk::dhcp::DhcpKind;
use virtual_prime::net_desk::frames;
use virtual_prime::net_desk::impairment::Impairment;
use virtual_prime::net_desk::peer::{GIVEN, Peer};
use virtual_prime::vm::Span;

const SECOND: u64 = 1_000 * MS;
const ECHO: u16 = 7;

/// Starts the image, and waits until it has an address.
fn online(seed: u64) -> (Bench, Peer) {
    let mut bench = boot("ethernet_hal");
    let mut peer = Peer::new(seed);
    peer.plug(&mut bench.vm);
    assert!(peer.run_until(&mut bench.vm, 6 * SECOND, |peer| peer.board() == Some(GIVEN)), "no address");
    let kinds: Vec<DhcpKind> = peer.dhcp.heard.iter().map(|message| message.kind).collect();
    assert_eq!(kinds, [DhcpKind::Discover, DhcpKind::Request]);
    (bench, peer)
}

/// Echoes so many bytes. Returns the time that it took, ns.
fn echo(bench: &mut Bench, peer: &mut Peer, length: usize) -> u64 {
    let began_ns = bench.vm.now_ns();
    let connection = peer.connect(ECHO).expect("an address");
    assert!(peer.run_until(&mut bench.vm, 30 * SECOND, |peer| peer.is_connected(connection)), "no connection");
    let bytes: Vec<u8> = (0..length).map(|place| b'a' + (place * 7 % 26) as u8).collect();
    let (mut sent, mut back) = (0, Vec::new());
    let done = peer.run_until(&mut bench.vm, 60 * SECOND, |peer| {
        sent += peer.send(connection, &bytes[sent..]);
        back.extend(peer.receive(connection));
        back.len() >= bytes.len()
    });
    assert!(done, "{} of {length} bytes", back.len());
    assert_eq!(back, bytes);
    let took_ns = bench.vm.now_ns() - began_ns;
    // A reset, so that the image's one socket need not wait until the last duplicate is gone.
    peer.retire(connection);
    assert_eq!(peer.run(&mut bench.vm, 20 * MS), Span::Reached);
    took_ns
}

/// Pings with every 61st length up to the longest, one after the other.
fn ping(bench: &mut Bench, peer: &mut Peer) {
    let (own, board) = (peer.own_end(), peer.board_end().expect("a board that has sent"));
    peer.keep_frames();
    for length in (0..=1_472).step_by(61).chain([1_472]) {
        let payload: Vec<u8> = (0..length).map(|place| (place * 3 + length) as u8).collect();
        peer.take_seen();
        peer.put(&frames::ping(own, board, 7, length as u16, &payload));
        assert_eq!(peer.run(&mut bench.vm, MS), Span::Reached);
        let seen = peer.take_seen();
        let answers: Vec<_> = seen.iter().filter_map(|sent| frames::pong(&sent.bytes)).collect();
        assert_eq!(answers, [(7, length as u16, &payload[..])], "{length} bytes");
    }
}

#[test]
fn other_peoples_driver_and_stack_echo_over_a_good_line_and_a_bad_one() {
    let (mut bench, mut peer) = online(1);
    let good_ns = echo(&mut bench, &mut peer, 30_000);
    assert!(good_ns < SECOND, "{good_ns}");
    ping(&mut bench, &mut peer);
    peer.impair(&Impairment {
        loss: 50,
        doubling: 20,
        reordering: 30,
        corruption: 10,
        delay_ns: 100_000..1_000_000,
        overtaken_ns: 2_000_000,
    });
    let bad_ns = echo(&mut bench, &mut peer, 10_000);
    assert!(bad_ns > good_ns / 3, "{bad_ns}");
    assert!(peer.to_board.lost() + peer.from_board.lost() > 0);
    assert_eq!(bench.vm.complaints(), Vec::<String>::new());
}
