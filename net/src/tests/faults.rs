//! A bad wire, and bad company on it.

use std::net::Ipv4Addr;

use smoltcp::iface::SocketHandle;
use smoltcp::wire::{EthernetFrame, Icmpv4Message, Icmpv4Packet, Ipv4Packet};

use crate::random::Random;
use crate::testing::{BOARD, BOARD_MAC, Bench, DESK, DESK_MAC, Faults, MS, SECOND, arp, echo, syn};
use crate::wire::Arp;

/// Bytes of a stream, each of which tells its place.
fn stream(length: usize, seed: u64) -> Vec<u8> {
    let mut random = Random::new(seed);
    (0..length).map(|_| b"GMXYZEF0123456789. \n"[random.below(20) as usize]).collect()
}

/// Sends streams both ways at once, and reads them. Returns whether both came whole.
fn exchange(bench: &mut Bench, client: SocketHandle, length: usize, most: u64) {
    let (to_board, to_desk) = (stream(length, 1), stream(length, 2));
    let (mut sent, mut written, mut heard) = (0, 0, Vec::new());
    let whole = bench.until(most, |bench| {
        sent += bench.desk.send(client, &to_board[sent..]);
        written += bench.network.write(0, &to_desk[written..]);
        heard.extend(bench.desk.read(client));
        assert!(bench.lines[0].visitor.is_some(), "given up at {}", bench.now);
        let is_over = bench.lines[0].received.len() >= length && heard.len() >= length;
        assert!(!is_over || bench.lines[0].visits == 1, "one visit");
        is_over
    });
    assert!(whole, "{sent} {written} {} {}", bench.lines[0].received.len(), heard.len());
    assert!(bench.lines[0].received == to_board && heard == to_desk, "a byte is lost, doubled or another");
}

#[test]
fn no_byte_is_lost_or_doubled_on_a_bad_wire() {
    for seed in 0..8 {
        let mut bench = Bench::with_address();
        let client = bench.connect(23);
        bench.run(50 * MS);
        bench.wire.reseed(seed);
        bench.wire.faults = Faults { loss: 20, doubling: 5, reordering: 10, corruption: 0, delay: 300, jitter: 500 };
        (bench.lines[0].size, bench.reads) = (256, 40);
        exchange(&mut bench, client, 20_000, 3_600 * SECOND);
    }
}

#[test]
fn no_byte_is_lost_or_another_when_bits_turn_over() {
    let mut bench = Bench::with_address();
    let client = bench.connect(23);
    bench.run(50 * MS);
    bench.wire.faults = Faults { loss: 5, corruption: 10, ..Faults::default() };
    exchange(&mut bench, client, 20_000, 3_600 * SECOND);
}

#[test]
fn a_thousand_half_open_connections_do_not_keep_anybody_out() {
    let mut bench = Bench::with_address();
    for index in 0..1_000_u16 {
        let from = (Ipv4Addr::new(10, 0, 0, 2 + (index % 200) as u8), 1_024 + index);
        bench.port.inject(&syn(from, (BOARD, 23)));
        bench.run(2 * MS);
    }
    let began = bench.now;
    let client = bench.connect(23);
    assert!(bench.now - began < 3 * SECOND, "{}", bench.now - began);
    bench.desk.send(client, b"M115\n");
    assert!(bench.until(SECOND, |bench| bench.lines.iter().any(|line| line.text() == "M115\n")));
    let one = bench.lines.iter().filter(|line| line.visits > 0).count();
    assert_eq!(one, 1, "half a connection is no visit");
}

#[test]
fn a_dead_peer_frees_its_console() {
    let mut bench = Bench::with_address();
    let (first, second) = (bench.connect(23), bench.connect(23));
    bench.run(SECOND);
    bench.desk.sockets.remove(first);
    bench.desk.sockets.remove(second);
    bench.desk.is_deaf = true;
    bench.run(25 * SECOND);
    assert!(bench.lines.iter().all(|line| line.visitor.is_none()));
    bench.desk.is_deaf = false;
    let third = bench.connect(23);
    assert!(bench.desk.tcp(third).is_active());
}

#[test]
fn an_idle_visitor_stays() {
    let mut bench = Bench::with_address();
    let client = bench.connect(23);
    bench.wire.faults = Faults { loss: 10, ..Faults::default() };
    bench.run(600 * SECOND);
    assert!(bench.lines[0].visitor.is_some() && bench.desk.tcp(client).is_active());
}

#[test]
fn a_visitor_who_reads_nothing_holds_up_his_answers_alone() {
    let mut bench = Bench::with_address();
    let (silent, other) = (bench.connect(23), bench.connect(23));
    bench.run(50 * MS);
    let mut written = 0;
    for _ in 0..300 {
        written += bench.network.write(0, &[b'x'; 100]);
        bench.run(MS);
    }
    assert!((4_000..12_000).contains(&written), "{written}");
    bench.write(1, b"ok\n");
    assert_eq!(bench.hear(other, 50 * MS), "ok\n");
    bench.run(100 * SECOND);
    assert!(bench.lines[0].visitor.is_some(), "a closed window is a sign of life");
    let mut heard = 0;
    bench.until(200 * SECOND, |bench| {
        heard += bench.desk.read(silent).len();
        heard == written
    });
    assert_eq!(heard, written);
}

#[test]
fn a_storm_of_broadcasts_leaves_the_visitor_alone() {
    let mut bench = Bench::with_address();
    let client = bench.connect(23);
    for turn in 0..2_000_u32 {
        for _ in 0..20 {
            bench.port.inject(&arp(true, DESK_MAC, DESK, Ipv4Addr::new(10, 0, 0, 200)));
        }
        if turn % 100 == 0 {
            bench.desk.send(client, b"?a\n");
        }
        bench.step();
        while bench.port.waits() {
            bench.step();
        }
    }
    bench.run(SECOND);
    assert!(bench.network.report().counts.received > 40_000, "{:?}", bench.network.report().counts);
    assert_eq!(bench.lines[0].text(), "a\n".repeat(20));
}

#[test]
fn echoes_of_every_length_are_answered_and_a_flood_leaves_the_visitor_alone() {
    let mut bench = Bench::with_address();
    let client = bench.connect(23);
    bench.wire.listens = true;
    for length in 0..=1_472 {
        bench.port.inject(&echo(DESK, BOARD, length));
        if length % 100 == 0 {
            bench.desk.send(client, b"a\n");
        }
        bench.step();
    }
    bench.run(SECOND);
    let lengths = bench.wire.heard.iter().filter_map(|frame| {
        let ethernet = EthernetFrame::new_checked(&frame[..]).ok()?;
        let ip = Ipv4Packet::new_checked(ethernet.payload()).ok()?;
        let icmp = Icmpv4Packet::new_checked(ip.payload()).ok()?;
        (icmp.msg_type() == Icmpv4Message::EchoReply).then_some(icmp.data().len())
    });
    let lengths: Vec<usize> = lengths.collect();
    let missing: Vec<usize> = (0..=1_472).filter(|length| !lengths.contains(length)).collect();
    assert_eq!(missing, []);
    assert_eq!(bench.lines[0].text(), "a\n".repeat(15));
}

#[test]
fn a_flood_of_echoes_does_not_keep_the_address_from_being_defended() {
    let mut bench = Bench::with_address();
    bench.run(10 * SECOND);
    bench.wire.listens = true;
    bench.port.inject(&arp(true, [2, 0, 0, 0, 0, 0x77], BOARD, BOARD));
    for _ in 0..20 {
        (0..8).for_each(|_| bench.port.inject(&echo(DESK, BOARD, 100)));
        bench.step();
    }
    let own = Arp::announcement(BOARD_MAC, BOARD);
    assert!(bench.wire.heard.iter().any(|frame| Arp::read(frame) == Some(own)));
}

#[test]
fn a_poll_reads_and_sends_at_most_four_frames() {
    let mut bench = Bench::with_address();
    let clients = [bench.connect(23), bench.connect(23), bench.connect(2323), bench.connect(2323)];
    bench.run(50 * MS);
    for _ in 0..100 {
        bench.port.inject(&echo(DESK, BOARD, 1_000));
    }
    let mut counts = bench.network.report().counts;
    bench.port.depth = 64;
    for _ in 0..200 {
        for line in 0..4 {
            bench.network.write(line, &[b'x'; 500]);
        }
        bench.step();
        let now = bench.network.report().counts;
        assert!(now.received - counts.received <= 4 && now.sent - counts.sent <= 4, "{counts:?} {now:?}");
        counts = now;
    }
    for client in clients {
        assert!(!bench.desk.read(client).is_empty(), "everybody has his turn");
    }
}

#[test]
fn a_cable_that_goes_in_and_out_all_the_time_leaves_nothing_behind() {
    let mut bench = Bench::with_address();
    for turn in 0..200 {
        let client = bench.connect(23);
        bench.desk.send(client, b"G1 X1\nG1 X");
        bench.run((turn % 7) * MS);
        bench.is_up = false;
        bench.run((turn % 5 + 1) * 10 * MS);
        assert!(bench.lines.iter().all(|line| line.visitor.is_none()));
        bench.desk.sockets.remove(client);
        bench.is_up = true;
        bench.get_address();
    }
    let clients = [bench.connect(23), bench.connect(23), bench.connect(2323), bench.connect(2323)];
    bench.run(50 * MS);
    assert!(bench.lines.iter().all(|line| line.visitor.is_some()) && clients.len() == 4);
}

#[test]
fn ports_that_no_service_has_are_closed() {
    let mut settings = Bench::settings();
    settings.grbl = None;
    let mut bench = Bench::new(settings);
    bench.get_address();
    for port in [0_u16, 1, 21, 22, 80, 2_323, 5_353, 65_535].into_iter().filter(|port| *port != 0) {
        let client = bench.desk.connect(BOARD, port);
        bench.run(SECOND);
        assert!(!bench.desk.tcp(client).is_active(), "{port}: refused at once");
    }
}
