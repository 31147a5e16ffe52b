//! Storms of broadcasts: more than the board takes of them are dropped, and hold up nothing else.

use virtual_prime::net_desk::frames::{self, EVERYBODY, End};

use super::{Net, plan};

/// Broadcasts of a millisecond, and for how many milliseconds: more than the 200 of a tenth of a second that
/// the board takes.
const AT_ONCE: usize = 10;
const ROUNDS: u16 = 60;
/// Rounds after which the board takes no more.
const FULL: u16 = 25;

#[test]
fn a_ping_in_a_storm_is_answered_at_once() {
    let mut net = Net::with_address(plan(&[]));
    let (own, board) = (net.peer.own_end(), net.peer.board_end().expect("a board that has sent"));
    let question = frames::arp(own, End { hardware: EVERYBODY, address: own.address }, false);
    // The board learns who asks.
    net.peer.put(&frames::ping(own, board, 1, 0, b"first"));
    net.run(1_000);
    net.peer.keep_frames();
    for number in 1..=ROUNDS {
        for _ in 0..AT_ONCE {
            net.peer.put(&question);
        }
        // The storm has passed when the ping comes.
        net.run(1);
        net.peer.put(&frames::ping(own, board, 1, number, b"storm"));
        net.run(1);
        let answered =
            net.peer.take_seen().iter().any(|sent| frames::pong(&sent.bytes).is_some_and(|pong| pong.1 == number));
        assert!(answered || number <= FULL, "ping {number} is not answered within a millisecond");
    }
    let said = net.ask("net");
    assert!(said.contains("too many"), "the storm was more than the board takes: {said}");
}
