//! The PHY's registers, the link and its negotiation.

use super::super::link::{Link, Partner};
use super::super::state::Ethernet;
use super::super::wire::Wire;
use super::bench::*;

const LINK: u16 = 1 << 2;
const DONE: u16 = 1 << 5;

/// Returns the registers that tell of the link: 1, 5, 31.
fn told(bench: &mut Bench) -> [u16; 3] {
    // The first read of register 1 may tell of the past.
    bench.phy(1);
    [1, 5, 31].map(|register| bench.phy(register))
}

#[test]
fn without_a_cable_there_is_no_link() {
    let mut bench = Bench::new();
    bench.run(10_000_000_000);
    assert_eq!(told(&mut bench), [0x7809, 0x0001, 0x0040]);
    assert_eq!([0, 2, 3, 4, 18].map(|register| bench.phy(register)), [0x3000, 0x0007, 0xC0F1, 0x01E1, 0x00E0]);
    assert_eq!(bench.phy(17) & 2, 0, "no energy");
}

#[test]
fn a_link_comes_up_after_the_negotiation() {
    let mut bench = Bench::new();
    bench.wire(|wire| wire.plug(Partner::default()));
    bench.run(1_500_000_000);
    assert_eq!(bench.phy(1) & (LINK | DONE), 0);
    bench.run(1_500_000_000);
    assert_eq!(told(&mut bench), [0x782D, 0x45E1, 0x1058]);
    assert_eq!(bench.phy(17) & 2, 2, "energy");
    assert_eq!([bench.phy(6), bench.phy(6)], [3, 1], "the page received is told once");
    // Energy, negotiation done, partner's acknowledge, page; cleared by the read.
    assert_eq!([bench.phy(29), bench.phy(29)], [0xCA, 0]);
}

#[test]
fn a_loss_of_the_link_is_told_once_even_if_it_is_over() {
    let mut bench = Bench::new();
    bench.link(Partner::default());
    assert_eq!([bench.phy(1) & LINK, bench.phy(1) & LINK], [0, LINK], "it was down before");
    bench.wire(Wire::unplug);
    bench.link(Partner::default());
    assert_eq!([bench.phy(1) & LINK, bench.phy(1) & LINK], [0, LINK]);
    bench.phy(29);
    bench.wire(Wire::unplug);
    assert_eq!(bench.phy(29), 0x90, "link down, energy changed");
    assert_eq!(told(&mut bench), [0x7809, 0x0001, 0x0040]);
}

#[test]
fn both_ends_agree_on_the_best_they_have() {
    let links = [(true, true), (true, false), (false, true), (false, false)];
    for ((is_fast, is_full), special) in links.into_iter().zip([0b110, 0b010, 0b101, 0b001]) {
        let mut bench = Bench::new();
        bench.link(Partner::only(Link { is_fast, is_full }));
        let [status, partner, shown] = told(&mut bench);
        assert_eq!(status & (LINK | DONE), LINK | DONE);
        assert_ne!(partner & 0x01E0, 0);
        assert_eq!(shown >> 2 & 7, special);
    }
}

#[test]
fn a_partner_that_does_not_negotiate_is_heard_and_taken_for_half_duplex() {
    let mut bench = Bench::new();
    bench.link(Partner::forced(FULL));
    assert_eq!(told(&mut bench), [0x782D, 0x0080, 0x1048]);
    assert_eq!(bench.phy(6) & 1, 0);
}

#[test]
fn a_restart_takes_the_link_down_and_the_advertisement_counts() {
    let mut bench = Bench::new();
    bench.link(Partner::default());
    // 10 Mbit/s alone, then restart.
    bench.set_phy(4, 0x0061);
    assert_eq!(told(&mut bench)[0] & LINK, LINK);
    bench.set_phy(0, 0x3200);
    assert_eq!(bench.phy(0), 0x3000, "the bit clears itself");
    assert_eq!(told(&mut bench)[0] & LINK, 0);
    bench.run(NEGOTIATION_NS);
    assert_eq!(told(&mut bench)[2] >> 2 & 7, 0b101);
    // Software reset of the PHY, which clears itself.
    bench.set_phy(0, 0x8000);
    assert_eq!([bench.phy(0), bench.phy(4)], [0x3000, 0x01E1]);
    bench.run(NEGOTIATION_NS);
    assert_eq!(told(&mut bench)[2] >> 2 & 7, 0b110);
}

#[test]
fn a_speed_that_is_set_by_hand_needs_no_negotiation() {
    let mut bench = Bench::new();
    bench.link(Partner::default());
    bench.set_phy(0, 0x2100);
    bench.run(300_000_000);
    let [status, _, special] = told(&mut bench);
    assert_eq!((status & (LINK | DONE), special), (LINK, 0x0058));
    bench.set_phy(0, 0x0100);
    bench.run(300_000_000);
    assert_eq!(told(&mut bench)[2], 0x0054);
}

#[test]
fn a_phy_that_is_powered_down_has_no_link() {
    let mut bench = Bench::new();
    bench.link(Partner::default());
    bench.set_phy(0, 0x3800);
    bench.run(NEGOTIATION_NS);
    assert_eq!(told(&mut bench)[0] & LINK, 0);
    bench.set_phy(0, 0x3000);
    bench.run(NEGOTIATION_NS);
    assert_eq!(told(&mut bench)[0] & LINK, LINK);
}

#[test]
fn a_reset_of_the_controller_leaves_the_phy_alone_and_one_of_the_part_does_not() {
    let mut bench = Bench::running();
    bench.set_phy(4, 0x0061);
    bench.reset_controller();
    assert_eq!(bench.phy(4), 0x0061);
    assert_eq!(told(&mut bench)[0] & LINK, LINK);
    bench.with(Ethernet::restarted);
    assert_eq!(bench.phy(4), 0x01E1);
    assert_eq!(told(&mut bench)[0] & LINK, 0);
    bench.run(NEGOTIATION_NS);
    assert_eq!(told(&mut bench)[0] & LINK, LINK);
    bench.set_up();
    bench.start();
    assert!(bench.send(0, &from_board(60), 0).is_some());
}

#[test]
fn negotiations_take_different_times() {
    let mut bench = Bench::new();
    let mut times = Vec::new();
    for _ in 0..4 {
        bench.wire(|wire| wire.plug(Partner::default()));
        let began_ns = bench.now_ns;
        while bench.phy(1) & LINK == 0 {
            bench.run(1_000_000);
        }
        times.push((bench.now_ns - began_ns) / 10_000_000);
        bench.wire(Wire::unplug);
    }
    assert!(times.iter().all(|time| (150..=302).contains(time)), "{times:?}");
    times.sort_unstable();
    times.dedup();
    assert_eq!(times.len(), 4);
}
