//! A day in virtual time, with visitors who come, go and die.

use crate::Settings;
use crate::random::Random;
use crate::testing::{BOARD, BOARD_MAC, Bench, DESK, DESK_MAC, MS, SECOND, arp, time_server};
use crate::wire::Arp;

/// Asks who has the board's address. Returns whether that was answered.
fn answers(bench: &mut Bench) -> bool {
    bench.wire.heard.clear();
    bench.wire.listens = true;
    bench.port.inject(&arp(true, DESK_MAC, DESK, BOARD));
    bench.run(10 * MS);
    bench.wire.listens = false;
    let own = |frame: &Vec<u8>| Arp::read(frame).is_some_and(|arp| !arp.is_request && arp.mac == BOARD_MAC);
    bench.wire.heard.iter().any(own)
}

/// Lets visitors come and go for so many hours.
fn pass(hours: u64) {
    let settings = Settings { time_server: time_server("10.0.0.1"), ..Bench::settings() };
    let mut bench = Bench::new(settings);
    bench.get_address();
    let mut random = Random::new(hours);
    let end = bench.now + hours * 3_600 * SECOND;
    let mut visits = 0;
    while bench.now < end {
        bench.run(u64::from(random.below(1_200)) * SECOND);
        assert!(answers(&mut bench), "after {} s", bench.now / SECOND);
        let client = bench.connect(if random.below(2) == 0 { 23 } else { 2323 });
        bench.run(SECOND);
        let line = bench.lines.iter().position(|line| line.visitor.is_some()).expect("a console");
        bench.lines[line].received.clear();
        bench.desk.send(client, b"M115\n");
        bench.run(SECOND);
        assert_eq!(bench.lines[line].text(), "M115\n");
        bench.write(line, b"ok\n");
        assert_eq!(bench.hear(client, SECOND), "ok\n");
        visits += 1;
        match random.below(4) {
            0 => bench.desk.tcp(client).abort(),
            1 => bench.run(u64::from(random.below(300)) * SECOND),
            2 => {
                // The peer's machine is switched off.
                bench.desk.is_deaf = true;
                bench.run(25 * SECOND);
                bench.desk.is_deaf = false;
            }
            _ => {}
        }
        bench.desk.tcp(client).close();
        bench.run(10 * SECOND);
        bench.desk.sockets.remove(client);
        assert!(bench.lines.iter().all(|line| line.visitor.is_none()), "everybody has gone");
    }
    assert!(visits >= hours, "{visits}");
    assert_eq!(bench.network.report().address.map(|address| address.address), Some(BOARD));
}

#[test]
fn an_hour_passes() {
    pass(1);
}

#[test]
#[ignore = "a virtual day takes a while: make net runs it"]
fn a_day_passes() {
    pass(26);
}
