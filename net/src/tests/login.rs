//! Visitors who have to know the password.

use smoltcp::iface::SocketHandle;

use crate::testing::{Bench, MS, SECOND};
use std::net::Ipv4Addr;

use crate::{News, Record, Role, Settings, Verdict, Word};

const IAC: u8 = 0xFF;
const WILL_ECHO: [u8; 3] = [IAC, 0xFB, 1];
const WONT_ECHO: [u8; 3] = [IAC, 0xFC, 1];

fn bench() -> Bench {
    let mut bench = Bench::new(Settings { password_required: true, ..Bench::settings() });
    assert!(bench.network.set_password(b"open sesame", [7; 16]));
    bench.get_address();
    assert!(!bench.network.is_setting_password() && bench.network.password_record().is_some());
    bench
}

fn bytes(bench: &mut Bench, client: SocketHandle, duration: u64) -> Vec<u8> {
    let (end, mut heard) = (bench.now + duration, Vec::new());
    while bench.now < end {
        bench.step();
        heard.extend(bench.desk.read(client));
    }
    heard
}

#[test]
fn who_knows_the_password_is_the_owner() {
    let mut bench = bench();
    let client = bench.connect(23);
    assert_eq!(bench.hear(client, 500 * MS), "Password: ");
    assert!(bench.lines[0].visitor.is_none(), "not yet");
    bench.desk.send(client, b"open sesame\r\nM115\n");
    bench.run(SECOND);
    assert_eq!(bench.lines[0].visitor.map(|visitor| visitor.role), Some(Role::Own));
    assert_eq!(bench.lines[0].text(), "M115\n", "the line's end belongs to the password");
}

#[test]
fn a_script_may_send_all_at_once() {
    let mut bench = bench();
    let client = bench.connect(2323);
    bench.desk.send(client, b"open sesame\n$I\n");
    bench.desk.tcp(client).close();
    bench.run(900 * MS);
    assert_eq!(bench.lines[2].text(), "$I\n");
    bench.run(5 * SECOND);
    assert!(bench.lines[2].visitor.is_none());
}

#[test]
fn a_telnet_client_does_not_show_the_password() {
    let mut bench = bench();
    let client = bench.connect(23);
    bench.desk.send(client, &[IAC, 0xFD, 3, IAC, 0xFB, 24]);
    let heard = bytes(&mut bench, client, 100 * MS);
    let refused = [IAC, 0xFC, 3, IAC, 0xFE, 24];
    assert_eq!(heard, [&refused[..], &WILL_ECHO, b"Password: "].concat());
    bench.desk.send(client, &[IAC, 0xFD, 1]);
    bench.desk.send(client, b"open sesamee\x7F\r\0");
    let heard = bytes(&mut bench, client, 900 * MS);
    assert_eq!(heard, [b"\r\n", &WONT_ECHO[..]].concat());
    assert!(bench.lines[0].visitor.is_some());
    bench.write(0, b"\xFF\n");
    assert_eq!(bytes(&mut bench, client, 100 * MS), b"\xFF\xFF\r\n");
}

#[test]
fn three_wrong_passwords_end_a_connection_and_five_cost_time() {
    let mut bench = bench();
    let mut heard = Vec::new();
    for attempts in [3, 2] {
        let client = bench.connect(23);
        bench.run(500 * MS);
        for _ in 0..attempts {
            bench.desk.send(client, b"guess\n");
            heard.push(bench.hear(client, 500 * MS));
        }
    }
    assert!(heard[2].contains("Good-bye") && heard[4].contains("Try again later"), "{heard:?}");
    assert!(!bench.news.iter().any(|news| matches!(news, News::Came(_))));
    assert_eq!(bench.news.iter().filter(|news| matches!(news, News::WrongPassword { .. })).count(), 5);
    let client = bench.connect(2323);
    assert!(bench.hear(client, 500 * MS).contains("Try again later"));
    bench.run(10 * SECOND);
    let client = bench.connect(23);
    bench.run(500 * MS);
    bench.desk.send(client, b"open sesame\n");
    bench.run(SECOND);
    assert!(bench.lines[0].visitor.is_some() || bench.lines[1].visitor.is_some());
}

#[test]
fn without_a_password_nobody_comes_in_and_is_told_what_to_do() {
    let mut bench = Bench::new(Settings { password_required: true, ..Bench::settings() });
    bench.get_address();
    let client = bench.connect(23);
    let heard = bench.hear(client, SECOND);
    assert!(heard.contains(": password WORD"), "{heard}");
    assert!(!bench.desk.tcp(client).may_recv());
    let mut other = Bench::new(Settings { password_required: true, ..Bench::settings() });
    let record = self::bench().network.password_record().expect("a record").to_string();
    other.network.set_password_record(Record::read(record.as_bytes()));
    other.get_address();
    let client = other.connect(23);
    other.run(500 * MS);
    other.desk.send(client, b"open sesame\n");
    other.run(SECOND);
    assert!(other.lines[0].visitor.is_some());
}

#[test]
fn who_says_nothing_does_not_hold_the_console() {
    let mut bench = bench();
    let (first, second) = (bench.connect(23), bench.connect(23));
    bench.run(31 * SECOND);
    assert!(bench.desk.text(first).contains("in time") && bench.desk.text(second).contains("in time"));
    bench.run(10 * SECOND);
    let third = bench.connect(23);
    assert!(bench.hear(third, SECOND).ends_with("Password: "));
}

#[test]
fn a_word_that_is_longer_than_any_password_is_wrong() {
    let mut bench = bench();
    let client = bench.connect(23);
    bench.run(500 * MS);
    bench.desk.send(client, &[&[b'x'; 3_000][..], b"\n"].concat());
    assert!(bench.hear(client, 2 * SECOND).contains("Wrong password"));
}

/// Words of the web pass the same gate, and cost their address and all others the same time.
#[test]
fn web_connections_pass_the_gate_of_the_consoles() {
    let mut bench = bench();
    let word = |last, text: &[u8]| Word {
        from: Ipv4Addr::new(10, 0, 0, last),
        bytes: heapless::Vec::from_slice(text).expect("a short word"),
    };
    bench.streams.words.extend([word(5, b"open sesame"), word(5, b"open"), word(6, b"")]);
    bench.run(3 * SECOND);
    assert_eq!(bench.streams.verdicts, [Verdict::Right, Verdict::Wrong, Verdict::Wrong]);
    assert_eq!(bench.news.iter().filter(|news| matches!(news, News::WrongPassword { .. })).count(), 2);
    bench.streams.verdicts.clear();
    bench.streams.words.extend((0..6).map(|_| word(6, b"guess")));
    bench.streams.words.push_back(word(7, b"open sesame"));
    bench.run(3 * SECOND);
    let (last, rest) = bench.streams.verdicts.split_last().expect("verdicts");
    assert_eq!(*last, Verdict::Right, "another address need not wait");
    assert_eq!(rest[..4], [Verdict::Wrong; 4]);
    assert!(rest[4..].iter().all(|verdict| matches!(verdict, Verdict::Wait(1..=4))), "{rest:?}");
    bench.network.set_password_record(None);
    bench.streams.words.push_back(word(7, b"open sesame"));
    bench.run(SECOND);
    assert_eq!(bench.streams.verdicts.last(), Some(&Verdict::NoPassword));
}
