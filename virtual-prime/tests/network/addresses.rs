//! Link, address, name and time.

use super::{Net, plan};
use crate::common::velvet::SECOND;

#[test]
fn an_address_comes_from_dhcp_and_goes_with_the_cable() {
    let mut net = Net::with_address(plan(&[]));
    let said = net.ask("net");
    assert!(said.contains("Link: 100 Mbit/s, full duplex\nIP Address: 10.0.2.15 (from DHCP)\n"), "{said}");
    assert!(said.contains("Name: velvet.local\nTelnet: port 23, 0 connected\n"), "{said}");
    net.peer.unplug(&mut net.velvet.bench.vm);
    net.hear_until("// network: no address any more", 5 * SECOND);
    net.peer.plug(&mut net.velvet.bench.vm);
    net.hear_until("// network: 10.0.2.15 (from DHCP)", 15 * SECOND);
    let complaints = net.velvet.bench.vm.complaints();
    assert!(complaints.is_empty(), "{complaints:?}");
}

#[test]
fn without_a_server_the_board_chooses_an_address() {
    let mut net = Net::start(plan(&[]));
    net.peer.dhcp.is_on = false;
    net.hear_until("// network: 169.254.", 30 * SECOND);
    // The server comes back, and its address is the better one.
    net.peer.dhcp.is_on = true;
    net.hear_until("// network: 10.0.2.15 (from DHCP)", 90 * SECOND);
}

#[test]
fn a_link_of_10_and_a_fixed_address_are_taken() {
    let fixed = ["[network] ip_address = 10.0.2.77", "[network] ip_gateway = 10.0.2.2", "[network] link = 10"];
    let mut net = Net::start(plan(&fixed));
    net.hear_until("// network: 10.0.2.77 (from config.ini), velvet.local", 15 * SECOND);
    let said = net.ask("net");
    assert!(said.contains("Link: 10 Mbit/s"), "{said}");
}

#[test]
fn the_clock_is_set_by_the_server_that_is_named_and_not_without() {
    for (lines, dated) in [
        (&["[network] timezone = 2"][..], "2026-11-29 14:00"),
        (&["[network] ntp_server = 10.0.2.2"][..], "2026-11-29 12:00"),
        (&["[network] ntp_enable = false"][..], "2000-01-01"),
    ] {
        let mut net = Net::with_address(plan(lines));
        net.run(3 * SECOND);
        let said = net.ask("date");
        assert!(said.contains(dated), "{lines:?}: {said}");
    }
}

/// Neighbours are not left to find out that the name answers no more.
#[test]
fn a_reset_is_told_to_who_knows_the_name() {
    const GROUP: [u8; 6] = [0x01, 0x00, 0x5E, 0x00, 0x00, 0xFB];
    let mut net = Net::with_address(plan(&[]));
    net.run(6 * SECOND);
    net.peer.keep_frames();
    net.run(SECOND / 2);
    let to_group = |net: &mut Net| net.peer.take_seen().iter().filter(|sent| sent.bytes.starts_with(&GROUP)).count();
    assert_eq!(to_group(&mut net), 0, "announcements are over");
    net.ask("reset");
    net.run(SECOND / 2);
    assert!(to_group(&mut net) > 0, "no farewell");
}
