//! Resets, station management, status and interrupt, counters.

use rigless::soc::stm32h743::generated::{ethernet_dma as dma, ethernet_mac as mac, ethernet_mtl as mtl};

use super::super::bits::{channel, dmamr, maccr, status};
use super::super::descriptor::{FIRST, LAST, OWN, receive};
use super::super::state::Surroundings;
use super::super::wire::Wire;
use super::bench::*;

#[test]
fn the_software_reset_waits_for_the_clock_and_resets_all_three_blocks() {
    let mut bench = Bench::running();
    bench.mac(mac::Register::Macecr, 0x1234);
    bench.look_around(Surroundings { clocked: false, ..bench.around });
    bench.dma(dma::Register::Dmamr, dmamr::SWR);
    bench.run(1_000_000);
    assert_eq!(bench.read_dma(dma::Register::Dmamr), dmamr::SWR);
    assert_eq!(bench.complaints().len(), 1);
    bench.look_around(Surroundings { clocked: true, ..bench.around });
    assert_eq!(bench.read_dma(dma::Register::Dmamr), dmamr::SWR);
    bench.run(2_000);
    assert_eq!(bench.read_dma(dma::Register::Dmamr), 0);
    assert_eq!(bench.read_mac(mac::Register::Macecr), 0);
    assert_eq!(bench.read_mac(mac::Register::Maca0hr), 0x8000_FFFF);
    assert_eq!(bench.read_mtl(mtl::Register::Mtlrxqomr), 0x0070_0000);
    assert_eq!(bench.read_dma(dma::Register::Dmacrxdlar), 0);
    // The first write after it is no longer held back.
    bench.mac(mac::Register::Macecr, 0x1234);
    assert_eq!(bench.read_mac(mac::Register::Macecr), 0x1234);
}

#[test]
fn a_clock_that_stops_holds_the_reset_and_the_transmitter() {
    let mut bench = Bench::running();
    bench.wire(|wire| wire.set_clock(false));
    assert_eq!(bench.send(0, &from_board(60), 0), None);
    bench.dma(dma::Register::Dmamr, dmamr::SWR);
    bench.run(1_000_000);
    assert_eq!(bench.read_dma(dma::Register::Dmamr), dmamr::SWR);
    bench.wire(|wire| wire.set_clock(true));
    bench.run(2_000);
    assert_eq!(bench.read_dma(dma::Register::Dmamr), 0);
}

#[test]
fn a_management_frame_takes_64_periods_of_mdc() {
    let mut bench = Bench::new();
    bench.mac(mac::Register::Macmdioar, 2 << 16 | 4 << 8 | 3 << 2 | 1);
    // 64 bits of 102 periods of 200 MHz.
    bench.run(32_639);
    assert_eq!(bench.read_mac(mac::Register::Macmdioar) & 1, 1);
    bench.run(1);
    assert_eq!(bench.read_mac(mac::Register::Macmdioar) & 1, 0);
    assert_eq!(bench.read_mac(mac::Register::Macmdiodr), 0x0007);
    // Nobody at address 1; and nobody at all when the PHY is broken.
    bench.mac(mac::Register::Macmdioar, 1 << 21 | 2 << 16 | 4 << 8 | 3 << 2 | 1);
    bench.run(40_000);
    assert_eq!(bench.read_mac(mac::Register::Macmdiodr), 0xFFFF);
    bench.wire(|wire| wire.set_phy(false));
    assert_eq!(bench.phy(2), 0xFFFF);
}

#[test]
fn a_management_clock_that_is_too_fast_is_a_complaint() {
    let mut bench = Bench::new();
    // CR = 0 divides by 42.
    bench.mac(mac::Register::Macmdioar, 2 << 16 | 3 << 2 | 1);
    bench.run(40_000);
    bench.phy(2);
    let complaints = bench.complaints();
    assert!(complaints.len() == 1 && complaints[0].contains("MDC"), "{complaints:?}");
}

#[test]
fn management_registers_keep_their_values_while_a_frame_is_under_way() {
    let mut bench = Bench::new();
    bench.mac(mac::Register::Macmdioar, 2 << 16 | 4 << 8 | 3 << 2 | 1);
    bench.mac(mac::Register::Macmdiodr, 0x5555);
    assert_eq!(bench.complaints().len(), 1);
    bench.run(40_000);
    assert_eq!(bench.read_mac(mac::Register::Macmdiodr), 0x0007);
}

#[test]
fn the_interrupt_is_gated_twice_and_held_until_both_flags_are_cleared() {
    let mut bench = Bench::running();
    bench.clear();
    bench.arrive(&to_board(60));
    assert_eq!(bench.status() & (status::RI | status::NIS), status::RI, "not enabled: no summary");
    assert!(!bench.interrupt);
    bench.enable(status::RI);
    assert_eq!(bench.status() & status::NIS, status::NIS);
    assert!(!bench.interrupt, "NIE is missing");
    bench.enable(status::RI | status::NIS);
    assert!(bench.interrupt);
    assert_eq!(bench.read_dma(dma::Register::Dmaisr), 1);
    bench.dma(dma::Register::Dmacsr, status::RI);
    assert!(bench.interrupt, "NIS is sticky");
    bench.dma(dma::Register::Dmacsr, status::NIS);
    assert!(!bench.interrupt);
    bench.arrive(&to_board(60));
    assert!(bench.interrupt, "from an event at the line");
    bench.dma(dma::Register::Dmacsr, status::NIS);
    assert!(bench.interrupt, "the cause stands");
    bench.dma(dma::Register::Dmacsr, status::NIS | status::RI);
    assert!(!bench.interrupt);
}

#[test]
fn abnormal_causes_have_their_own_gate() {
    let mut bench = Bench::running();
    bench.clear();
    bench.enable(status::RBU | status::NIS);
    (0..RING).for_each(|_| bench.arrive(&to_board(60)));
    assert_eq!(bench.status() & (status::RBU | status::AIS), status::RBU | status::AIS);
    assert!(!bench.interrupt);
    bench.enable(status::RBU | status::AIS);
    assert!(bench.interrupt);
    bench.dma(dma::Register::Dmamr, dmamr::SWR);
    assert!(!bench.interrupt);
}

#[test]
fn descriptors_without_ioc_raise_no_interrupt_but_by_the_watchdog() {
    let mut bench = Bench::running();
    bench.dma(dma::Register::Dmacrxcr, STRIDE << 1);
    for place in 0..RING {
        bench.poke(RX_RING + place * 16 + 12, OWN | receive::BUF1V);
    }
    bench.dma(dma::Register::Dmacrxcr, channel::START | STRIDE << 1);
    bench.clear();
    bench.arrive(&to_board(60));
    assert!(bench.received(0).is_some());
    assert_eq!(bench.status() & status::RI, 0);
    // The watchdog counts 256 periods of HCLK.
    bench.dma(dma::Register::Dmacrxiwtr, 10);
    bench.wire(|wire| wire.put(&to_board(60)));
    assert_eq!(bench.run_until(status::RI), 72 * 80 + 10 * 256 * 5);
    bench.clear();
    bench.fill(0, &from_board(60), 0);
    bench.poke(TX_RING + 8, 60);
    bench.dma(dma::Register::Dmactxdtpr, TX_RING);
    bench.run(100_000);
    assert_eq!(bench.peek(TX_RING + 12), FIRST | LAST);
    assert_eq!(bench.status() & status::TI, 0);
}

#[test]
fn counters_that_are_half_full_interrupt_unless_masked() {
    let mut bench = Bench::running();
    // CNTPRST: almost half.
    bench.mac(mac::Register::MmcControl, 1 << 4);
    bench.mac(mac::Register::MmcTxInterruptMask, u32::MAX);
    for round in 0..16 {
        assert!(!bench.interrupt, "round {round}");
        bench.release(round % RING);
        bench.dma(dma::Register::Dmacrxdtpr, RX_RING);
        bench.arrive(&to_board(60));
        bench.send(round % RING, &from_board(60), 0);
    }
    assert!(bench.interrupt);
    assert_eq!(bench.read_mac(mac::Register::MmcRxInterrupt), 1 << 17);
    assert_eq!(bench.read_mac(mac::Register::Macisr) >> 8 & 7, 3);
    bench.mac(mac::Register::MmcRxInterruptMask, u32::MAX);
    assert_eq!(bench.read_mac(mac::Register::MmcRxInterruptMask), 1 << 27 | 1 << 26 | 1 << 17 | 1 << 6 | 1 << 5);
    assert!(!bench.interrupt);
    bench.mac(mac::Register::MmcRxInterruptMask, 0);
    assert!(bench.interrupt);
    assert_eq!(bench.read_mac(mac::Register::RxUnicastPacketsGood), 0x8000_0000);
    assert!(!bench.interrupt, "cleared by the read of the counter");
    bench.mac(mac::Register::MmcControl, 1);
    assert_eq!(bench.read_mac(mac::Register::RxUnicastPacketsGood), 0);
}

#[test]
fn a_receiver_that_is_off_hears_nothing() {
    let mut bench = Bench::running();
    bench.mac(mac::Register::Maccr, maccr::TE | maccr::FES | maccr::DM);
    bench.arrive(&to_board(60));
    assert_eq!(bench.received(0), None);
    assert_eq!(bench.wire(|wire| wire.counters().unheard), 1);
    assert!(bench.send(0, &from_board(60), 0).is_some());
    assert_eq!(bench.wire(Wire::take), None);
}
