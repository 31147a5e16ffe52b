//! Frames both ways through the rings, 61.9.2 and 61.10.

use rigless::soc::stm32h743::generated::{ethernet_dma as dma, ethernet_mac as mac};

use super::super::bits::{channel, maccr, status};
use super::super::checksum::frame_check;
use super::super::descriptor::{CONTEXT, FIRST, LAST, OWN, receive, transmit};
use super::super::wire::Wire;
use super::bench::*;

/// Time of a frame on the line at 100 Mbit/s, ns: preamble, bytes and check sequence.
const fn line_ns(length: u64) -> u64 {
    (8 + length + 4) * 80
}

#[test]
fn a_frame_goes_out_and_its_descriptor_comes_back() {
    let mut bench = Bench::running();
    bench.clear();
    let sent = bench.send(0, &from_board(100), 0).expect("a frame");
    assert_eq!(sent.bytes, from_board(100));
    assert_eq!(bench.peek(TX_RING + 12), FIRST | LAST, "OWN is gone, no error");
    assert_eq!(bench.peek(TX_RING), TX_BUFFERS, "the address of the buffer stays");
    assert_eq!(bench.status() & (status::TI | status::TBU | WRONG), status::TI | status::TBU);
    assert_eq!(bench.read_dma(dma::Register::Dmaccatxdr), TX_RING + 16);
    assert_eq!(bench.read_mac(mac::Register::TxPacketCountGood), 1);
    assert_eq!(bench.complaints(), Vec::<&str>::new());
}

#[test]
fn frames_take_their_time_on_the_line() {
    let mut bench = Bench::running();
    bench.clear();
    for place in 0..2 {
        bench.fill(place, &from_board(1_514), 0);
    }
    let began_ns = bench.now_ns;
    bench.dma(dma::Register::Dmactxdtpr, TX_RING);
    bench.run(1_000_000);
    let ends: Vec<u64> = bench.wire(Wire::take_all).iter().map(|sent| sent.at_ns - began_ns).collect();
    assert_eq!(ends, [line_ns(1_514), 2 * line_ns(1_514) + 960]);
}

#[test]
fn ten_megabits_take_ten_times_as_long() {
    let mut bench = Bench::new();
    bench.link(super::super::link::Partner::only(super::super::link::Link { is_fast: false, is_full: true }));
    bench.set_up();
    bench.start();
    bench.mac(mac::Register::Maccr, maccr::RE | maccr::TE | maccr::DM | maccr::CST);
    let began_ns = bench.now_ns;
    bench.fill(0, &from_board(60), 0);
    bench.dma(dma::Register::Dmactxdtpr, TX_RING);
    bench.run(1_000_000);
    assert_eq!(bench.wire(Wire::take).map(|sent| sent.at_ns - began_ns), Some(10 * line_ns(60)));
    bench.wire(|wire| wire.put(&to_board(60)));
    bench.clear();
    assert_eq!(bench.run_until(status::RI), 10 * line_ns(60));
}

#[test]
fn a_frame_comes_in_and_its_descriptor_says_so() {
    let mut bench = Bench::running();
    bench.clear();
    bench.wire(|wire| wire.put(&to_board(200)));
    assert_eq!(bench.run_until(status::RI), line_ns(200));
    assert_eq!(bench.received(0), Some(to_board(200)));
    let des3 = bench.peek(RX_RING + 12);
    assert_eq!(des3, FIRST | LAST | receive::RS1V | receive::LT_TYPE << 16 | 200);
    assert_eq!(bench.peek(RX_RING), 0, "write-back destroys the address of the buffer");
    assert_eq!(bench.read_dma(dma::Register::Dmaccarxdr), RX_RING + 16);
    assert_eq!(bench.read_mac(mac::Register::RxUnicastPacketsGood), 1);
    assert_eq!(bench.complaints(), Vec::<&str>::new());
}

#[test]
fn both_rings_wrap_after_their_length() {
    let mut bench = Bench::running();
    for round in 0..3 * RING {
        let length = 60 + round as usize * 11;
        assert_eq!(bench.send(round % RING, &from_board(length), 0).expect("a frame").bytes, from_board(length));
        bench.arrive(&to_board(length));
        assert_eq!(bench.received(round % RING), Some(to_board(length)), "round {round}");
        bench.release(round % RING);
        bench.dma(dma::Register::Dmacrxdtpr, RX_RING);
    }
    assert_eq!(bench.status() & WRONG, 0);
    assert_eq!(bench.complaints(), Vec::<&str>::new());
}

#[test]
fn words_between_descriptors_are_skipped() {
    let mut bench = Bench::new();
    bench.link(super::super::link::Partner::default());
    bench.set_up();
    // DSL = 2: two words.
    bench.dma(dma::Register::Dmaccr, 2 << 18);
    for place in 0..RING {
        bench.poke(RX_RING + place * 24, RX_BUFFERS + place * STRIDE);
        bench.poke(RX_RING + place * 24 + 12, OWN | receive::IOC | receive::BUF1V);
    }
    bench.start();
    for place in 0..RING {
        bench.arrive(&to_board(70));
        assert_eq!(bench.peek(RX_RING + place * 24 + 12) & OWN, 0);
    }
    assert_eq!(bench.read_dma(dma::Register::Dmaccarxdr), RX_RING);
}

#[test]
fn a_long_frame_spills_into_the_next_buffers() {
    let mut bench = Bench::running();
    bench.dma(dma::Register::Dmacrxcr, 0);
    for place in 0..RING {
        let at = RX_RING + place * 16;
        bench.poke(at + 8, RX_BUFFERS + place * STRIDE + 256);
        bench.poke(at + 12, OWN | receive::IOC | receive::BUF1V | receive::BUF2V);
    }
    bench.dma(dma::Register::Dmacrxcr, channel::START | 256 << 1);
    bench.clear();
    bench.wire(|wire| wire.put(&to_board(1_000)));
    bench.run_until(status::RI);
    let [first, last] = [0, 16].map(|at| bench.peek(RX_RING + at + 12));
    assert_eq!(first & (OWN | FIRST | LAST), FIRST);
    assert_eq!(last & (OWN | FIRST | LAST), LAST);
    assert_eq!(last & 0x7FFF, 1_000, "the length is of the whole frame");
    let bytes = [bench.peek_bytes(RX_BUFFERS, 512), bench.peek_bytes(RX_BUFFERS + STRIDE, 488)].concat();
    assert_eq!(bytes, to_board(1_000));
}

#[test]
fn a_frame_is_gathered_from_several_buffers() {
    let mut bench = Bench::running();
    bench.clear();
    let whole = from_board(301);
    // The second buffer begins at an odd address.
    bench.poke_bytes(TX_BUFFERS, &whole[..100]);
    bench.poke_bytes(TX_BUFFERS + 501, &whole[100..150]);
    bench.poke_bytes(TX_BUFFERS + 1_000, &whole[150..]);
    bench.poke(TX_RING, TX_BUFFERS);
    bench.poke(TX_RING + 4, TX_BUFFERS + 501);
    bench.poke(TX_RING + 8, 50 << 16 | 100);
    bench.poke(TX_RING + 16, TX_BUFFERS + 1_000);
    bench.poke(TX_RING + 24, transmit::IOC | 151);
    bench.poke(TX_RING + 28, OWN | LAST);
    bench.poke(TX_RING + 12, OWN | FIRST);
    bench.dma(dma::Register::Dmactxdtpr, TX_RING);
    bench.run_until(status::TI);
    assert_eq!(bench.wire(Wire::take).expect("a frame").bytes, whole);
    assert_eq!([bench.peek(TX_RING + 12), bench.peek(TX_RING + 28)], [FIRST, LAST]);
}

#[test]
fn context_descriptors_are_given_back() {
    let mut bench = Bench::running();
    bench.poke(TX_RING + 12, OWN | CONTEXT);
    assert!(bench.send(1, &from_board(60), 0).is_some());
    assert_eq!(bench.peek(TX_RING + 12) & OWN, 0);
}

#[test]
fn short_frames_are_filled_up_as_cpc_says() {
    let mut bench = Bench::running();
    let short = from_board(30);
    let sent = bench.send(0, &short, 0).expect("a frame").bytes;
    assert_eq!(sent.len(), 60);
    assert_eq!((&sent[..30], &sent[30..]), (&short[..], &[0; 30][..]));
    // CPC = 1: a check sequence, but no filling: too short for any partner.
    assert_eq!(bench.send(1, &short, 1 << 26), None);
    // CPC = 2: the frame brings its check sequence; 3: one is there to be replaced.
    let mut complete = from_board(80);
    let check = frame_check(&complete);
    complete.extend(check.to_le_bytes());
    assert_eq!(bench.send(2, &complete, 2 << 26).expect("a frame").bytes, from_board(80));
    complete[83] ^= 1;
    assert_eq!(bench.send(3, &complete, 2 << 26), None);
    assert_eq!(bench.send(0, &complete, 3 << 26).expect("a frame").bytes, from_board(80));
    assert_eq!(bench.wire(|wire| wire.counters().malformed), 2);
}

#[test]
fn the_check_sequence_is_stripped_as_acs_and_cst_say() {
    let typed = to_board(64);
    let length = frame(BOARD, PARTNER, 20, &[7; 20]);
    for (options, typed_bytes, length_bytes) in
        [(0, 68, 64), (maccr::ACS, 68, 34), (maccr::CST, 64, 64), (maccr::ACS | maccr::CST, 64, 34)]
    {
        let mut bench = Bench::running();
        bench.mac(mac::Register::Maccr, maccr::RE | maccr::TE | maccr::FES | maccr::DM | options);
        bench.arrive(&typed);
        bench.arrive(&length);
        let lengths = [0, 16].map(|at| bench.peek(RX_RING + at + 12) & 0x7FFF);
        assert_eq!(lengths, [typed_bytes, length_bytes], "{options:#x}");
        if options == 0 {
            let check = bench.peek_bytes(RX_BUFFERS + 64, 4);
            assert_eq!(check, frame_check(&typed).to_le_bytes());
        }
    }
}

#[test]
fn the_second_frame_is_read_before_the_first_is_out_with_osf_alone() {
    for (options, read) in [(0, 1), (channel::OSF, 2)] {
        let mut bench = Bench::running();
        bench.dma(dma::Register::Dmactxcr, channel::START | options);
        for place in 0..3 {
            bench.fill(place, &from_board(1_000), 0);
        }
        bench.dma(dma::Register::Dmactxdtpr, TX_RING);
        assert_eq!(bench.read_dma(dma::Register::Dmaccatxdr), TX_RING + read * 16);
        bench.run(1_000_000);
        assert_eq!(bench.wire(Wire::take_all).len(), 3);
    }
}

#[test]
fn nothing_is_sent_before_the_transmitter_is_on() {
    let mut bench = Bench::running();
    bench.mac(mac::Register::Maccr, maccr::RE | maccr::FES | maccr::DM);
    assert_eq!(bench.send(0, &from_board(60), 0), None);
    assert_eq!(bench.peek(TX_RING + 12) & OWN, OWN);
    bench.mac(mac::Register::Maccr, maccr::RE | maccr::TE | maccr::FES | maccr::DM);
    bench.run(10_000);
    assert!(bench.wire(Wire::take).is_some());
}

#[test]
fn a_stopped_channel_goes_on_where_it_was() {
    let mut bench = Bench::running();
    bench.send(0, &from_board(60), 0);
    bench.arrive(&to_board(60));
    bench.clear();
    bench.dma(dma::Register::Dmactxcr, 0);
    bench.dma(dma::Register::Dmacrxcr, STRIDE << 1);
    assert_eq!(bench.status() & (status::TPS | status::RPS), status::TPS | status::RPS);
    assert_eq!(bench.read_dma(dma::Register::Dmadsr), 0);
    bench.start();
    assert!(bench.send(1, &from_board(61), 0).is_some());
    bench.arrive(&to_board(61));
    assert_eq!(bench.received(1), Some(to_board(61)));
    // A list that was written meanwhile counts at the next start.
    bench.dma(dma::Register::Dmactxcr, 0);
    bench.dma(dma::Register::Dmactxdlar, TX_RING);
    bench.dma(dma::Register::Dmactxcr, channel::START);
    assert!(bench.send(0, &from_board(62), 0).is_some());
    assert_eq!(bench.complaints(), Vec::<&str>::new());
}

#[test]
fn frames_come_back_in_loopback() {
    for in_phy in [false, true] {
        let mut bench = Bench::running();
        if in_phy {
            bench.set_phy(0, 0x3000 | 1 << 14);
        } else {
            let loops = maccr::RE | maccr::TE | maccr::FES | maccr::DM | maccr::CST | maccr::LM;
            bench.mac(mac::Register::Maccr, loops);
        }
        assert_eq!(bench.send(0, &to_board(90), 0), None);
        assert_eq!(bench.received(0), Some(to_board(90)));
    }
}
