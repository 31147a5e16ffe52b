//! Rings without descriptors, addresses out of reach, queues that are full, and complaints.

use rigless::soc::stm32h743::generated::{ethernet_dma as dma, ethernet_mac as mac, ethernet_mtl as mtl};

use super::super::bits::{channel, maccr, status};
use super::super::descriptor::{FIRST, LAST, OWN, receive};
use super::super::link::{Link, Partner};
use super::super::wire::Wire;
use super::bench::*;

#[test]
fn a_ring_that_is_used_up_suspends_the_channel_until_the_tail_is_written() {
    let mut bench = Bench::running();
    bench.clear();
    for place in 0..RING as usize {
        bench.arrive(&to_board(60 + place));
    }
    assert_eq!(bench.status() & WRONG, status::RBU);
    assert_eq!(bench.read_dma(dma::Register::Dmadsr) >> 8 & 0xF, 4, "suspended");
    // One more waits in the queue.
    bench.arrive(&to_board(1_000));
    assert_eq!(bench.read_mtl(mtl::Register::Mtlrxqdr) >> 4 & 3, 1);
    bench.clear();
    bench.release(0);
    bench.run(100_000);
    assert_eq!(bench.status() & status::RI, 0);
    bench.dma(dma::Register::Dmacrxdtpr, RX_RING);
    assert_eq!(bench.status() & status::RI, status::RI);
    assert_eq!(bench.received(0), Some(to_board(1_000)));
    assert_eq!(bench.complaints(), Vec::<&str>::new());
}

#[test]
fn the_tail_that_is_not_written_after_rbu_is_a_complaint() {
    let mut bench = Bench::running();
    for place in 0..RING as usize {
        bench.arrive(&to_board(60 + place));
    }
    (0..RING).for_each(|place| bench.release(place));
    bench.arrive(&to_board(100));
    assert_eq!(bench.received(0), None);
    assert_eq!(bench.complaints().len(), 0, "the driver may be about to write it");
    bench.run(1_000_000);
    bench.arrive(&to_board(100));
    let complaints = bench.complaints();
    assert!(complaints.len() == 1 && complaints[0].contains("RBU"), "{complaints:?}");
}

#[test]
fn a_queue_that_is_full_loses_frames_and_counts_them() {
    let mut bench = Bench::running();
    (0..RING).for_each(|place| bench.poke(RX_RING + place * 16 + 12, 0));
    bench.dma(dma::Register::Dmacrxcr, STRIDE << 1);
    bench.dma(dma::Register::Dmacrxcr, channel::START | STRIDE << 1);
    for _ in 0..5 {
        bench.arrive(&to_board(900));
    }
    // Two of them fit in 2 KB.
    assert_eq!(bench.read_mtl(mtl::Register::Mtlrxqmpocr), 3);
    assert_eq!(bench.read_mtl(mtl::Register::Mtlrxqmpocr), 0, "cleared by the read");
    assert_eq!(bench.read_mtl(mtl::Register::Mtlqicsr) >> 16 & 1, 1);
    bench.mtl(mtl::Register::Mtlqicsr, 1 << 16);
    assert_eq!(bench.read_mtl(mtl::Register::Mtlqicsr) >> 16 & 1, 0);
    let counters = bench.wire(|wire| wire.counters());
    assert_eq!((counters.received, counters.overflowed), (2, 3));
    assert_eq!(bench.read_dma(dma::Register::Dmacmfcr), 0);
}

#[test]
fn rings_and_buffers_in_the_tcm_are_fatal_bus_errors() {
    let error = |bench: &mut Bench, place: u32| bench.status() >> place & 7;
    let mut bench = Bench::new();
    bench.link(Partner::default());
    bench.set_up();
    bench.dma(dma::Register::Dmactxdlar, 0x2000_0000);
    bench.dma(dma::Register::Dmacrxdlar, 0x2000_0100);
    bench.start();
    assert_eq!(bench.status() & status::FBE, status::FBE);
    assert_eq!((error(&mut bench, status::TEB), error(&mut bench, status::REB)), (3, 3), "at descriptors, in reads");
    assert!(bench.complaints()[0].contains("reach the ring"));

    let mut bench = Bench::running();
    bench.clear();
    bench.fill(0, &from_board(60), 0);
    bench.poke(TX_RING, 0x2000_0000);
    bench.dma(dma::Register::Dmactxdtpr, TX_RING);
    assert_eq!(error(&mut bench, status::TEB), 5, "in data, in a read");
    assert_eq!(bench.read_dma(dma::Register::Dmadsr) >> 12 & 0xF, 0, "stopped");
    let mut bench = Bench::running();
    (0..RING).for_each(|place| bench.poke(RX_RING + place * 16, 0x2000_0000));
    bench.dma(dma::Register::Dmacrxcr, STRIDE << 1);
    bench.dma(dma::Register::Dmacrxcr, channel::START | channel::RPF | STRIDE << 1);
    bench.arrive(&to_board(60));
    assert_eq!(error(&mut bench, status::REB), 4, "in data, in a write");
    bench.arrive(&to_board(60));
    assert_eq!(bench.read_dma(dma::Register::Dmacmfcr), 2, "the one that failed, and one flushed by RPF");
    assert_eq!(bench.read_dma(dma::Register::Dmacmfcr), 0, "cleared by the read");
}

#[test]
fn memory_that_does_not_answer_is_a_fatal_bus_error() {
    let mut bench = Bench::running();
    bench.clear();
    // The DMA reaches external memories, of which the board has none.
    bench.fill(0, &from_board(60), 0);
    bench.poke(TX_RING, 0xC000_0000);
    bench.dma(dma::Register::Dmactxdtpr, TX_RING);
    assert_eq!(bench.status() & status::FBE, status::FBE);
}

#[test]
fn a_buffer_whose_address_was_not_restored_is_a_complaint() {
    let mut bench = Bench::running();
    for place in 0..RING {
        bench.arrive(&to_board(60));
        bench.poke(RX_RING + place * 16 + 12, OWN | receive::IOC | receive::BUF1V);
        bench.dma(dma::Register::Dmacrxdtpr, RX_RING);
    }
    let complaints = bench.complaints();
    assert!(complaints.iter().any(|reason| reason.contains("RDES0")), "{complaints:?}");
    bench.arrive(&to_board(60));
    assert_eq!(bench.status() & status::FBE, status::FBE);
}

#[test]
fn a_wrong_speed_loses_everything_both_ways() {
    let mut bench = Bench::new();
    bench.link(Partner::only(Link { is_fast: false, is_full: true }));
    bench.set_up();
    bench.start();
    assert_eq!(bench.send(0, &from_board(60), 0), None);
    assert_eq!(bench.peek(TX_RING + 12), FIRST | LAST, "the transmitter notices nothing");
    bench.arrive(&to_board(60));
    assert_eq!(bench.received(0), None);
    assert_eq!(bench.wire(|wire| wire.counters().at_wrong_speed), 2);
    let complaints = bench.complaints();
    assert!(complaints.len() == 1 && complaints[0].contains("FES"), "{complaints:?}");
}

#[test]
fn a_wrong_duplex_is_a_complaint() {
    let mut bench = Bench::new();
    bench.link(Partner::forced(Link { is_fast: true, is_full: true }));
    bench.set_up();
    bench.start();
    assert!(bench.send(0, &from_board(60), 0).is_some());
    let complaints = bench.complaints();
    assert!(complaints.len() == 1 && complaints[0].contains("DM"), "{complaints:?}");
}

#[test]
fn outputs_at_low_speed_are_a_complaint() {
    let mut bench = Bench::running();
    bench.look_around(super::super::state::Surroundings { speaks_fast: false, ..bench.around });
    assert!(bench.send(0, &from_board(60), 0).is_some());
    let complaints = bench.complaints();
    assert!(complaints.len() == 1 && complaints[0].contains("OSPEEDR"), "{complaints:?}");
}

#[test]
fn registers_of_a_running_channel_are_not_to_be_written() {
    let mut bench = Bench::running();
    bench.dma(dma::Register::Dmacrxdlar, RX_RING);
    bench.dma(dma::Register::Dmactxrlr, 1);
    bench.dma(dma::Register::Dmacrxcr, channel::START | 512 << 1);
    let complaints = bench.complaints();
    let expected = ["DMACRXDLAR", "DMACTXRLR", "RBSZ"];
    assert!(expected.iter().zip(&complaints).all(|(name, reason)| reason.contains(name)), "{complaints:?}");
    assert_eq!(complaints.len(), 3);
}

#[test]
fn frames_without_a_link_or_a_line_are_lost() {
    let mut bench = Bench::running();
    bench.wire(Wire::unplug);
    assert_eq!(bench.send(0, &from_board(60), 0), None);
    assert_eq!(bench.peek(TX_RING + 12), FIRST | LAST);
    bench.arrive(&to_board(60));
    bench.link(Partner::default());
    bench.look_around(super::super::state::Surroundings { hears: false, speaks: false, ..bench.around });
    assert_eq!(bench.send(1, &from_board(60), 0), None);
    bench.arrive(&to_board(60));
    assert_eq!(bench.wire(|wire| wire.counters().without_link), 4);
    assert_eq!(bench.received(0), None);
}

#[test]
fn damaged_short_and_long_frames_are_dropped_or_marked() {
    let trouble: [(Vec<u8>, bool); 3] = [(to_board(100), false), (to_board(40), true), (to_board(3_000), true)];
    let mut bench = Bench::running();
    for (bytes, is_intact) in trouble.clone() {
        bench.wire(|wire| wire.put_as_it_is(bytes, is_intact));
        bench.run(400_000);
    }
    assert_eq!(bench.wire(|wire| wire.counters().damaged), 3);
    assert_eq!(bench.read_mac(mac::Register::RxCrcErrorPackets), 1);
    assert_eq!(bench.status() & status::RWT, status::RWT);
    // With FEP and FUP they come through, marked.
    bench.mtl(mtl::Register::Mtlrxqomr, 1 << 5 | 1 << 4 | 1 << 3);
    for (bytes, is_intact) in trouble {
        bench.wire(|wire| wire.put_as_it_is(bytes, is_intact));
        bench.run(400_000);
    }
    let [damaged, short, first, last] = [0, 16, 32, 48].map(|at| bench.peek(RX_RING + at + 12));
    assert_eq!(damaged & (receive::ES | receive::CE), receive::ES | receive::CE);
    assert_eq!(short & (receive::ES | 0x7FFF), 40);
    assert_eq!(first & (OWN | FIRST | LAST), FIRST);
    assert_eq!(last & (LAST | receive::RWT | receive::GP | 0x7FFF), LAST | receive::RWT | receive::GP | 2_048);
}

#[test]
fn a_babbling_transmitter_is_cut_off() {
    let mut bench = Bench::running();
    assert_eq!(bench.send(0, &from_board(2_100), 0), None);
    bench.run(400_000);
    assert_ne!(bench.peek(TX_RING + 12) & 1 << 14, 0, "jabber");
    bench.mac(mac::Register::Maccr, maccr::RE | maccr::TE | maccr::FES | maccr::DM | maccr::JD);
    assert_eq!(bench.send(1, &from_board(2_100), 0).expect("a frame").bytes.len(), 2_100);
}

#[test]
fn the_transmit_queue_can_be_flushed() {
    let mut bench = Bench::running();
    bench.dma(dma::Register::Dmactxcr, channel::START | channel::OSF);
    for place in 0..2 {
        bench.fill(place, &from_board(500), 0);
    }
    bench.dma(dma::Register::Dmactxdtpr, TX_RING);
    bench.mtl(mtl::Register::Mtltxqomr, 1);
    assert_eq!(bench.read_mtl(mtl::Register::Mtltxqomr) & 1, 0);
    bench.run(200_000);
    assert_eq!(bench.wire(Wire::take_all).len(), 1, "the one on the line goes on");
}
