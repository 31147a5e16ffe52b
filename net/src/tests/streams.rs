//! Connections of the web.

use std::net::Ipv4Addr;

use smoltcp::iface::SocketHandle;

use crate::testing::{BOARD, Bench, DESK, Faults, MS, SECOND, syn};
use crate::{STREAMS, Settings};

const PORT: u16 = 80;

fn web() -> Bench {
    let mut bench = Bench::new(Settings { web: Some(PORT), ..Bench::settings() });
    bench.get_address();
    bench
}

/// Bytes of a connection, which differ from those of the others.
fn text(length: usize, seed: usize) -> Vec<u8> {
    (0..length).map(|place| (place * 7 + place / 251 + seed * 31) as u8).collect()
}

/// Sends on all connections at once, and reads until everything is said back.
fn echo(bench: &mut Bench, clients: &[SocketHandle], length: usize, most: u64) {
    let sent: Vec<_> = (0..clients.len()).map(|seed| text(length, seed)).collect();
    let (mut heard, mut given) = (vec![Vec::new(); clients.len()], vec![0; clients.len()]);
    let done = bench.until(most, |bench| {
        for (number, client) in clients.iter().enumerate() {
            given[number] += bench.desk.send(*client, &sent[number][given[number]..]);
            heard[number].extend(bench.desk.read(*client));
        }
        heard.iter().all(|heard| heard.len() >= length)
    });
    assert!(done, "{:?} of {length}", heard.iter().map(Vec::len).collect::<Vec<_>>());
    assert!(heard == sent, "what is said back is not what was said");
}

#[test]
fn as_many_as_there_are_places_are_served_at_once() {
    let mut bench = web();
    let clients: Vec<_> = (0..STREAMS).map(|_| bench.connect(PORT)).collect();
    bench.run(50 * MS);
    assert_eq!((bench.streams.opened, bench.network.report().web_peers), (STREAMS, STREAMS));
    assert!(bench.streams.from.iter().all(|from| *from == DESK), "{:?}", bench.streams.from);
    echo(&mut bench, &clients, 50_000, 60 * SECOND);
    // Who comes then is not refused, but waits until a place is free.
    let late = bench.desk.connect(BOARD, PORT);
    bench.run(SECOND);
    assert!(!bench.desk.tcp(late).may_send() && bench.desk.tcp(late).is_active());
    bench.desk.tcp(clients[3]).close();
    assert!(bench.until(30 * SECOND, |bench| bench.desk.tcp(late).may_send()), "the place is free again");
    echo(&mut bench, &[late], 1_000, 10 * SECOND);
}

#[test]
fn no_byte_is_lost_or_doubled_on_a_bad_wire() {
    for seed in 1..5 {
        let mut bench = web();
        let clients: Vec<_> = (0..3).map(|_| bench.connect(PORT)).collect();
        bench.wire.reseed(seed);
        bench.wire.faults = Faults { loss: 20, doubling: 5, reordering: 10, corruption: 0, delay: 300, jitter: 500 };
        echo(&mut bench, &clients, 10_000, 3_600 * SECOND);
    }
}

#[test]
fn all_who_are_let_go_at_once_are_told() {
    let mut bench = web();
    let clients: Vec<_> = (0..STREAMS).map(|_| bench.connect(PORT)).collect();
    for client in &clients {
        bench.desk.send(*client, b"bye\n");
    }
    // They do not close their side, so the board ends all connections in one turn, which has not as many
    // frames.
    bench.run(8 * SECOND);
    assert_eq!(bench.network.report().web_peers, 0);
    for client in clients {
        assert!(!bench.desk.tcp(client).is_active(), "{}", bench.desk.tcp(client).state());
    }
}

#[test]
fn a_connection_ends_when_both_have_said_all() {
    let mut bench = web();
    let client = bench.connect(PORT);
    let sent = text(4_000, 1);
    let (mut given, mut heard) = (0, Vec::new());
    bench.until(SECOND, |bench| {
        given += bench.desk.send(client, &sent[given..]);
        heard.extend(bench.desk.read(client));
        given == sent.len()
    });
    bench.desk.tcp(client).close();
    let is_over = bench.until(10 * SECOND, |bench| {
        heard.extend(bench.desk.read(client));
        bench.streams.closed == 1
    });
    assert!(is_over && heard == sent, "what was owed came before the end: {} bytes", heard.len());
}

#[test]
fn a_server_may_end_a_connection_at_once() {
    let mut bench = web();
    let client = bench.connect(PORT);
    bench.desk.send(client, b"die\n");
    assert!(bench.until(SECOND, |bench| !bench.desk.tcp(client).is_active()));
    assert_eq!((bench.streams.opened, bench.streams.closed), (1, 1));
    let next = bench.connect(PORT);
    echo(&mut bench, &[next], 100, SECOND);
}

#[test]
fn who_does_not_go_makes_room_for_who_waits() {
    let mut bench = web();
    let clients: Vec<_> = (0..STREAMS).map(|_| bench.connect(PORT)).collect();
    // The board closes its side; the peers acknowledge that and never close theirs.
    bench.desk.send(clients[0], b"bye\n");
    bench.run(2 * SECOND);
    assert_eq!(bench.streams.closed, 1, "nobody listened, so its place is free at once");
    for client in &clients[1..] {
        bench.desk.send(*client, b"bye\n");
    }
    bench.run(2 * SECOND);
    assert_eq!(bench.streams.closed, 1, "the others get the usual time, as there is room");
    assert!(bench.until(10 * SECOND, |bench| bench.streams.closed == STREAMS));
}

#[test]
fn dead_peers_free_their_places() {
    let mut bench = web();
    let clients: Vec<_> = (0..STREAMS).map(|_| bench.connect(PORT)).collect();
    bench.run(50 * MS);
    clients.into_iter().for_each(|client| drop(bench.desk.sockets.remove(client)));
    bench.desk.is_deaf = true;
    assert!(bench.until(40 * SECOND, |bench| bench.streams.closed == STREAMS), "{}", bench.streams.closed);
}

#[test]
fn idle_peers_stay() {
    let mut bench = web();
    let client = bench.connect(PORT);
    bench.run(600 * SECOND);
    assert_eq!(bench.streams.closed, 0);
    echo(&mut bench, &[client], 100, SECOND);
}

#[test]
fn half_open_connections_do_not_keep_anybody_out() {
    let mut bench = web();
    for index in 0..1_000_u16 {
        let from = (Ipv4Addr::new(10, 0, 0, 2 + (index % 200) as u8), 1_024 + index);
        bench.port.inject(&syn(from, (BOARD, PORT)));
        bench.run(2 * MS);
    }
    let began = bench.now;
    let client = bench.connect(PORT);
    assert!(bench.now - began < 3 * SECOND, "{}", bench.now - began);
    echo(&mut bench, &[client], 1_000, 10 * SECOND);
    assert_eq!(bench.streams.opened, 1, "half a connection is none");
}

#[test]
fn a_cable_that_is_out_ends_all_connections() {
    let mut bench = web();
    for turn in 0..50 {
        let client = bench.connect(PORT);
        bench.desk.send(client, &text(500, turn));
        bench.run(turn as u64 % 7 * MS);
        bench.is_up = false;
        bench.run(30 * MS);
        assert_eq!(bench.streams.opened, bench.streams.closed);
        bench.desk.sockets.remove(client);
        bench.is_up = true;
        bench.get_address();
    }
    assert!(bench.streams.opened > 40, "{}", bench.streams.opened);
}

#[test]
fn without_a_port_nobody_listens() {
    let mut bench = Bench::with_address();
    let client = bench.desk.connect(BOARD, PORT);
    bench.run(SECOND);
    assert!(!bench.desk.tcp(client).is_active() && bench.streams.opened == 0);
}
