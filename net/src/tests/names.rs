//! The board's name in the local network.

use std::net::Ipv4Addr;

use smoltcp::iface::SocketHandle;

use crate::names::message::{A, ANY, IN, Message, PTR, Part, Record, SRV, TXT, Writer};
use crate::names::records::{Life, Own, Records, Set};
use crate::testing::{BOARD, Bench, DESK, MS, SECOND};
use crate::{HostName, News};

const GROUP: (Ipv4Addr, u16) = (Ipv4Addr::new(224, 0, 0, 251), 5353);
const AAAA: u16 = 28;
const UNICAST: u16 = 0x8000;

/// Name, kind and lifetime of records.
type Told = Vec<(String, u16, u32)>;

/// A bench whose board has its name, and a socket that hears mDNS.
fn named() -> (Bench, SocketHandle) {
    let mut bench = Bench::with_address();
    let desk = bench.desk.bind(5353);
    assert!(bench.until(10 * SECOND, |bench| bench.network.report().is_named));
    bench.run(3 * SECOND);
    while bench.desk.datagram(desk).is_some() {}
    (bench, desk)
}

fn question(name: &str, kind: u16, class: u16) -> Vec<u8> {
    questions(&[(name, kind, class)], |_| {})
}

fn questions(all: &[(&str, u16, u16)], more: impl FnOnce(&mut Writer<'_>)) -> Vec<u8> {
    let mut into = [0; 900];
    let mut writer = Writer::new(&mut into, 77, 0).unwrap();
    for (name, kind, class) in all {
        writer.add(Part::Questions, |writer| {
            writer.name(name)?;
            writer.word(*kind)?;
            writer.word(*class)
        });
    }
    more(&mut writer);
    let length = writer.len();
    into[..length].to_vec()
}

/// Returns records as another machine would have them.
fn others(host: &str, address: Ipv4Addr) -> Records {
    Records { host: HostName::new(host), address, telnet: Some(23), grbl: None }
}

fn host_only() -> Set {
    let mut set = Set::NONE;
    set.add(Own::Host);
    set
}

fn name(record: &Record<'_>) -> String {
    let labels: Vec<String> = record.name.labels().map(|label| String::from_utf8_lossy(label).into_owned()).collect();
    labels.join(".")
}

/// Returns names and kinds of the records of the next message, with its source and number.
fn next(bench: &mut Bench, desk: SocketHandle) -> Option<(Told, Vec<u8>)> {
    let (bytes, _) = bench.desk.datagram(desk)?;
    let message = Message::new(&bytes).unwrap();
    let records = message.records().map(|record| (name(&record), record.kind, record.ttl)).collect();
    Some((records, bytes.clone()))
}

fn answer(bench: &mut Bench, desk: SocketHandle, question: &[u8], time: u64) -> Told {
    bench.desk.tell(desk, GROUP, question);
    bench.run(time);
    next(bench, desk).map(|(records, _)| records).unwrap_or_default()
}

#[test]
fn a_name_is_probed_and_announced() {
    let mut bench = Bench::with_address();
    let desk = bench.desk.bind(5353);
    bench.run(5 * SECOND);
    let mut heard = Vec::new();
    while let Some((bytes, from)) = bench.desk.datagram(desk) {
        assert_eq!((from.addr, from.port), (BOARD.into(), 5353));
        let message = Message::new(&bytes).unwrap();
        heard.push((message.is_response(), message.questions().count(), message.records().count()));
    }
    let (probe, announcement) = ((false, 2, 3), (true, 0, 5));
    assert_eq!(heard, [probe, probe, probe, announcement, announcement]);
    assert!(bench.news.contains(&News::Named(HostName::new("velvet"))), "{:?}", bench.news);
}

#[test]
fn the_host_is_found_by_its_name_and_by_its_address() {
    let (mut bench, desk) = named();
    let host = ("velvet.local".to_owned(), A, 120);
    assert_eq!(answer(&mut bench, desk, &question("Velvet.LOCAL", A, IN), 100 * MS), [host]);
    let reverse = answer(&mut bench, desk, &question("42.0.0.10.in-addr.arpa", PTR, IN), 100 * MS);
    assert_eq!(reverse, [("42.0.0.10.in-addr.arpa".to_owned(), PTR, 120)]);
    let none = answer(&mut bench, desk, &question("velvet.local", AAAA, IN), 100 * MS);
    assert_eq!(none, [("velvet.local".to_owned(), 47, 120)], "there is no such address, and that is told");
    assert!(answer(&mut bench, desk, &question("other.local", A, IN), SECOND).is_empty());
}

#[test]
fn the_service_is_found_with_all_that_leads_to_it() {
    let (mut bench, desk) = named();
    let kinds = |records: Told| records.into_iter().map(|(_, kind, _)| kind).collect::<Vec<u16>>();
    assert_eq!(kinds(answer(&mut bench, desk, &question("_telnet._tcp.local", PTR, IN), 400 * MS)), [PTR, A, SRV, TXT]);
    let types = answer(&mut bench, desk, &question("_services._dns-sd._udp.local", PTR, IN), 400 * MS);
    assert_eq!(types, [("_services._dns-sd._udp.local".to_owned(), PTR, 4_500)]);
    bench.run(2 * SECOND);
    assert_eq!(
        kinds(answer(&mut bench, desk, &question("velvet._telnet._tcp.local", ANY, IN), 400 * MS)),
        [SRV, TXT, A]
    );
}

#[test]
fn what_an_asker_knows_is_not_told_and_nothing_is_told_twice_in_a_second() {
    let (mut bench, desk) = named();
    let knows = |ttl_of: Life| {
        questions(&[("velvet.local", A, IN)], |writer| {
            others("velvet", BOARD).write_set(host_only(), Part::Answers, ttl_of, writer);
        })
    };
    assert!(answer(&mut bench, desk, &knows(Life::Usual), SECOND).is_empty());
    assert_eq!(answer(&mut bench, desk, &knows(Life::Legacy), SECOND / 10).len(), 1, "known, and nearly forgotten");
    assert!(answer(&mut bench, desk, &question("velvet.local", A, IN), SECOND / 10).is_empty(), "told just now");
    bench.run(SECOND);
    assert_eq!(answer(&mut bench, desk, &question("velvet.local", A, IN), SECOND / 10).len(), 1);
}

#[test]
fn who_asks_for_himself_is_answered_alone() {
    let (mut bench, desk) = named();
    let other = bench.desk.bind(40_000);
    let asked = answer(&mut bench, desk, &question("velvet.local", A, IN | UNICAST), 100 * MS);
    assert_eq!(asked.len(), 1);
    bench.desk.tell(other, GROUP, &question("velvet.local", A, IN));
    bench.run(100 * MS);
    let (records, bytes) = next(&mut bench, other).expect("an answer to the port that asked");
    let message = Message::new(&bytes).unwrap();
    assert_eq!((message.id(), message.questions().count()), (77, 1), "as DNS would");
    assert_eq!(records, [("velvet.local".to_owned(), A, 10)]);
}

#[test]
fn a_name_that_another_machine_has_is_left_to_it() {
    let mut bench = Bench::with_address();
    let desk = bench.desk.bind(5353);
    let elsewhere = others("velvet", DESK);
    let named = bench.until(20 * SECOND, |bench| {
        while let Some((bytes, _)) = bench.desk.datagram(desk) {
            let message = Message::new(&bytes).unwrap();
            if message.questions().any(|question| question.name.is("velvet.local")) {
                let told = questions(&[], |writer| {
                    elsewhere.write_set(host_only(), Part::Answers, Life::Usual, writer);
                });
                let response = [&told[..2], &[0x84, 0], &told[4..]].concat();
                bench.desk.tell(desk, GROUP, &response);
            }
        }
        bench.network.report().is_named
    });
    assert!(named);
    assert_eq!(bench.network.report().name, "velvet-2");
    assert!(bench.news.contains(&News::NameTaken(HostName::new("velvet"))), "{:?}", bench.news);
    bench.run(3 * SECOND);
    while bench.desk.datagram(desk).is_some() {}
    assert_eq!(answer(&mut bench, desk, &question("velvet-2.local", A, IN), 100 * MS).len(), 1);
    assert!(answer(&mut bench, desk, &question("velvet.local", A, IN), 100 * MS).is_empty());
}

#[test]
fn of_two_that_want_a_name_the_greater_address_has_it() {
    for (address, waits) in [(Ipv4Addr::new(10, 0, 0, 200), true), (Ipv4Addr::new(10, 0, 0, 2), false)] {
        let mut bench = Bench::with_address();
        let desk = bench.desk.bind(5353);
        assert!(bench.until(SECOND, |bench| bench.desk.datagram(desk).is_some()), "a probe");
        let began = bench.now;
        let probe = questions(&[("velvet.local", ANY, IN)], |writer| others("velvet", address).write_probe(writer));
        bench.desk.tell(desk, GROUP, &probe);
        assert!(bench.until(5 * SECOND, |bench| bench.network.report().is_named));
        assert_eq!(bench.now - began > SECOND, waits);
    }
}

#[test]
fn a_name_is_made_sure_of_anew_when_another_machine_claims_it() {
    let (mut bench, desk) = named();
    let told =
        questions(&[], |writer| others("velvet", DESK).write_set(host_only(), Part::Answers, Life::Usual, writer));
    bench.desk.tell(desk, GROUP, &[&told[..2], &[0x84, 0], &told[4..]].concat());
    bench.run(100 * MS);
    assert!(!bench.network.report().is_named);
    bench.run(3 * SECOND);
    assert_eq!((bench.network.report().name, bench.network.report().is_named), ("velvet", true), "nobody defends it");
}

#[test]
fn a_board_that_goes_says_so_and_one_that_comes_back_announces_itself() {
    let (mut bench, desk) = named();
    bench.network.leave();
    bench.run(100 * MS);
    let (records, _) = next(&mut bench, desk).expect("a good-bye");
    assert!(records.len() == 5 && records.iter().all(|(_, _, ttl)| *ttl == 0), "{records:?}");
    bench.is_up = false;
    bench.run(SECOND);
    assert!(!bench.network.report().is_named);
    bench.is_up = true;
    assert!(bench.until(20 * SECOND, |bench| bench.network.report().is_named));
}

#[test]
fn switches_are_told_that_the_group_is_listened_to() {
    let mut bench = Bench::new(Bench::settings());
    bench.wire.listens = true;
    bench.get_address();
    bench.run(SECOND);
    // IGMP is protocol 2 of IP, a report of version 2 is of type 0x16.
    let is_report = |frame: &Vec<u8>| frame[12..14] == [8, 0] && frame[23] == 2 && frame[34] == 0x16;
    assert!(bench.wire.heard.iter().any(is_report));
}
