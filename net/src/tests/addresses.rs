//! Where the board's address comes from, and where it goes.

use std::net::Ipv4Addr;

use smoltcp::wire::DhcpMessageType;

use crate::testing::{BOARD, BOARD_MAC, Bench, DESK, MS, SECOND, arp};
use crate::wire::Arp;
use crate::{Addressing, Loss, News, Origin, Settings, StaticAddress};

const OTHER: [u8; 6] = [2, 0, 0, 0, 0, 0x77];
const ANY: Ipv4Addr = Ipv4Addr::UNSPECIFIED;

fn address(bench: &Bench) -> Option<(Ipv4Addr, Origin)> {
    bench.network.report().address.map(|address| (address.address, address.origin))
}

/// Has another machine answer probes for an address for so long. Returns how many there were.
fn occupy(bench: &mut Bench, address: Ipv4Addr, duration: u64) -> u32 {
    bench.wire.listens = true;
    let (end, mut probes) = (bench.now + duration, 0);
    while bench.now < end {
        bench.step();
        for frame in std::mem::take(&mut bench.wire.heard) {
            if Arp::read(&frame).is_some_and(|arp| arp.sender == ANY && arp.target == address) {
                probes += 1;
                bench.port.inject(&arp(false, OTHER, address, ANY));
            }
        }
    }
    probes
}

#[test]
fn a_server_gives_the_address_and_is_told_the_name() {
    let mut bench = Bench::with_address();
    let report = bench.network.report().address.unwrap();
    assert_eq!((report.address, report.prefix, report.origin), (BOARD, 24, Origin::Dhcp));
    assert_eq!((report.gateway, report.dns[0], report.server), (Some(DESK), Some(DESK), Some(DESK)));
    assert_eq!(bench.desk.dhcp.host.as_deref(), Some("velvet"));
    assert!(bench.now < 4 * SECOND, "{}", bench.now);
    bench.run(3_600 * SECOND);
    let addresses = bench.news.iter().filter(|news| !matches!(news, News::Named(_)));
    assert_eq!(addresses.count(), 1, "the lease is renewed: {:?}", bench.news);
}

#[test]
fn without_a_server_the_board_makes_an_address_up_until_there_is_one() {
    let mut bench = Bench::new(Bench::settings());
    bench.desk.dhcp.is_on = false;
    bench.run(30 * SECOND);
    let (made_up, origin) = address(&bench).expect("an address");
    assert_eq!((made_up.octets()[..2].to_vec(), origin), (vec![169, 254], Origin::LinkLocal));
    let client = bench.connect(23);
    bench.desk.dhcp.is_on = true;
    bench.run(30 * SECOND);
    assert_eq!(address(&bench), Some((BOARD, Origin::Dhcp)));
    assert!(bench.desk.tcp(client).is_active() && bench.lines[0].visitor.is_none(), "nobody can be told by then");
    assert!(bench.news.contains(&News::AddressLost { address: made_up, loss: Loss::Replaced }));
}

#[test]
fn an_address_is_kept_over_a_servers_absence_and_lost_with_the_lease() {
    let mut bench = Bench::new(Bench::settings());
    bench.desk.dhcp.lease = 300;
    bench.get_address();
    bench.desk.dhcp.is_on = false;
    let client = bench.connect(23);
    bench.run(200 * SECOND);
    assert_eq!(address(&bench), Some((BOARD, Origin::Dhcp)));
    assert!(bench.desk.tcp(client).is_active());
    bench.run(200 * SECOND);
    assert_eq!(address(&bench).map(|(_, origin)| origin), Some(Origin::LinkLocal));
    assert!(bench.news.contains(&News::AddressLost { address: BOARD, loss: Loss::LeaseOver }));
    assert!(bench.lines[0].visitor.is_none());
    bench.desk.dhcp.is_on = true;
    bench.run(60 * SECOND);
    assert_eq!(address(&bench), Some((BOARD, Origin::Dhcp)));
}

#[test]
fn a_server_that_gives_another_address_is_obeyed() {
    let mut bench = Bench::new(Bench::settings());
    bench.desk.dhcp.lease = 300;
    bench.get_address();
    let client = bench.connect(23);
    let other = Ipv4Addr::new(10, 0, 0, 50);
    bench.desk.dhcp.address = other;
    bench.run(300 * SECOND);
    assert_eq!(address(&bench), Some((other, Origin::Dhcp)));
    assert!(bench.lines[0].visitor.is_none() && bench.desk.tcp(client).may_send());
    let client = bench.connect(23);
    assert!(bench.desk.tcp(client).is_active());
}

#[test]
fn a_given_address_is_declined_when_another_machine_has_it() {
    let mut bench = Bench::new(Bench::settings());
    let probes = occupy(&mut bench, BOARD, 9 * SECOND);
    assert!(probes >= 1 && address(&bench).is_none(), "{probes}");
    assert!(bench.desk.dhcp.heard.contains(&DhcpMessageType::Decline), "{:?}", bench.desk.dhcp.heard);
    assert!(bench.news.contains(&News::AddressTaken { address: BOARD, by: OTHER }));
    bench.desk.dhcp.address = Ipv4Addr::new(10, 0, 0, 43);
    occupy(&mut bench, BOARD, 30 * SECOND);
    assert_eq!(address(&bench), Some((Ipv4Addr::new(10, 0, 0, 43), Origin::Dhcp)));
}

#[test]
fn an_address_in_use_is_defended_once_and_then_given_up() {
    let mut bench = Bench::with_address();
    bench.run(10 * SECOND);
    bench.wire.listens = true;
    bench.port.inject(&arp(true, OTHER, BOARD, BOARD));
    bench.run(10 * MS);
    let own = Arp::announcement(BOARD_MAC, BOARD);
    assert!(bench.wire.heard.iter().any(|frame| Arp::read(frame) == Some(own)), "it is told off");
    assert!(address(&bench).is_some());
    bench.port.inject(&arp(true, OTHER, BOARD, BOARD));
    bench.run(10 * MS);
    assert!(address(&bench).is_none());
    assert!(bench.news.contains(&News::AddressLost { address: BOARD, loss: Loss::Taken }));
    bench.run(60 * SECOND);
    assert_eq!(address(&bench), Some((BOARD, Origin::Dhcp)), "the other one has gone");
}

#[test]
fn who_asks_whether_the_address_is_free_is_told() {
    let mut bench = Bench::with_address();
    bench.wire.listens = true;
    bench.port.inject(&arp(true, OTHER, ANY, BOARD));
    bench.run(10 * MS);
    let answers = bench.wire.heard.iter().filter_map(|frame| Arp::read(frame)).filter(|arp| !arp.is_request);
    assert_eq!(answers.map(|arp| (arp.sender, arp.target_mac)).collect::<Vec<_>>(), [(BOARD, OTHER)]);
}

#[test]
fn made_up_addresses_avoid_those_that_others_have() {
    let mut bench = Bench::new(Bench::settings());
    bench.desk.dhcp.is_on = false;
    bench.run(9 * SECOND);
    let first = bench.network.report().candidate.expect("a candidate");
    assert!(occupy(&mut bench, first, 20 * SECOND) >= 1);
    let (second, _) = address(&bench).expect("another");
    assert!(second != first && second.octets()[..2] == [169, 254]);
    let mut again = Bench::new(Bench::settings());
    again.desk.dhcp.is_on = false;
    again.run(9 * SECOND);
    assert_eq!(again.network.report().candidate, Some(first), "the same at each start");
}

#[test]
fn a_fixed_address_is_used_and_kept_whoever_claims_it() {
    let fixed = StaticAddress {
        address: Ipv4Addr::new(10, 0, 0, 99),
        mask: Ipv4Addr::new(255, 255, 255, 0),
        gateway: Some(DESK),
        dns: None,
    };
    let settings = Settings { addressing: Addressing::Static(fixed), ..Bench::settings() };
    let mut bench = Bench::new(settings);
    assert_eq!(occupy(&mut bench, fixed.address, 5 * SECOND), 1);
    assert!(address(&bench).is_none(), "it is another's yet");
    bench.run(20 * SECOND);
    assert_eq!(address(&bench), Some((fixed.address, Origin::Static)));
    assert!(bench.desk.dhcp.heard.is_empty());
    for _ in 0..5 {
        bench.port.inject(&arp(true, OTHER, fixed.address, fixed.address));
        bench.run(SECOND);
    }
    assert!(address(&bench).is_some());
    let client = bench.connect(23);
    assert!(bench.desk.tcp(client).is_active());
}

#[test]
fn an_address_that_is_none_is_not_used() {
    let fixed = StaticAddress { address: Ipv4Addr::BROADCAST, mask: ANY, gateway: None, dns: None };
    let mut bench = Bench::new(Settings { addressing: Addressing::Static(fixed), ..Bench::settings() });
    bench.get_address();
    assert_eq!(address(&bench), Some((BOARD, Origin::Dhcp)));
}

#[test]
fn without_a_cable_there_is_no_address_and_with_it_soon_one_again() {
    let mut bench = Bench::with_address();
    let client = bench.connect(23);
    bench.is_up = false;
    bench.run(SECOND);
    assert!(address(&bench).is_none() && bench.lines[0].visitor.is_none());
    assert!(bench.news.contains(&News::AddressLost { address: BOARD, loss: Loss::LinkDown }));
    bench.is_up = true;
    let began = bench.now;
    bench.get_address();
    assert!(bench.now - began < 4 * SECOND, "{}", bench.now - began);
    let another = bench.connect(23);
    bench.run(SECOND);
    assert!(bench.lines[0].visitor.is_some() && bench.desk.tcp(another).is_active());
    assert!(bench.desk.send(client, b"?") == 1 && bench.desk.tcp(client).is_active());
    bench.run(SECOND);
    assert!(!bench.desk.tcp(client).is_active(), "the connection of before is nobody's");
}
