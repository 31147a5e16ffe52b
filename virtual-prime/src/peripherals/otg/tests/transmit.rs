//! Bulk and interrupt IN, and the pace of the bus.

use super::*;

#[test]
fn a_transfer_of_several_packets_goes_out_as_they_are_written() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    let data: Vec<u8> = (0..150).collect();
    let id = bench.submit(BULK_IN, Request::In(4_096));
    bench.w(IN + STRIDE + TSIZ, 3 << 19 | 150);
    let control = bench.r(IN + STRIDE + CTL);
    bench.w(IN + STRIDE + CTL, control | epctl::EPENA | epctl::CNAK);
    bench.run(MS);
    assert_eq!(bench.outcome(id), None, "nothing in the FIFO yet");
    assert_ne!(bench.r(IN + STRIDE + INT) & epint::ITTXFE, 0);
    bench.fill(1, &data[..128]);
    // XFRSIZ falls as packets enter the FIFO, PKTCNT as they leave it.
    assert_eq!(bench.r(IN + STRIDE + TSIZ), 3 << 19 | 22);
    bench.run(MS);
    assert_eq!(bench.r(IN + STRIDE + TSIZ), 1 << 19 | 22);
    bench.fill(1, &data[128..]);
    bench.run(MS);
    assert_eq!(bench.expect(id, Outcome::Done), data);
    assert_ne!(bench.r(IN + STRIDE + INT) & epint::XFRC, 0);
    assert_eq!(bench.r(IN + STRIDE + CTL) & epctl::EPENA, 0);
    assert_ne!(bench.r(IN + STRIDE + CTL) & epctl::DPID, 0, "three packets: DATA1 is next");
    assert_ne!(bench.r(DAINT) & 1 << 1, 0);
    bench.w(IN + STRIDE + INT, epint::XFRC | epint::NAK | epint::ITTXFE);
    assert_eq!(bench.r(DAINT) & 1 << 1, 0);
}

#[test]
fn a_multiple_of_the_packet_size_may_end_with_a_packet_without_data() {
    for (packets, complete) in [(2, false), (3, true)] {
        let mut bench = Bench::ready();
        bench.open_bulk();
        let id = bench.submit(BULK_IN, Request::In(4_096));
        bench.send(1, &[7; 128], packets);
        bench.run(MS);
        assert_eq!(bench.outcome(id).map(|ended| ended.data.len()), complete.then_some(128));
    }
}

#[test]
fn room_in_the_fifo_and_its_emptiness_follow_its_filling() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(DIEPMSK, 0);
    assert_eq!(bench.r(IN + STRIDE + DTXFSTS), 32);
    bench.send(1, &[1; 100], 2);
    assert_eq!(bench.r(IN + STRIDE + DTXFSTS), 32 - 25);
    assert_eq!(bench.r(IN + STRIDE + INT) & epint::TXFE, 0, "more than half full");
    bench.w(DIEPEMPMSK, 1 << 1);
    assert_eq!(bench.r(GINTSTS) & gint::IEPINT, 0);
    bench.submit(BULK_IN, Request::In(64));
    bench.run(MS);
    assert_eq!(bench.r(IN + STRIDE + DTXFSTS), 32 - 9);
    assert_ne!(bench.r(IN + STRIDE + INT) & epint::TXFE, 0, "half empty");
    assert_ne!(bench.r(GINTSTS) & gint::IEPINT, 0, "without DIEPMSK");
    bench.w(GAHBCFG, gahbcfg::GINT | gahbcfg::TXFELVL);
    assert_eq!(bench.r(IN + STRIDE + INT) & epint::TXFE, 0, "not completely");
    // TXFE follows the FIFO and cannot be cleared.
    bench.submit(BULK_IN, Request::In(64));
    bench.run(MS);
    bench.w(IN + STRIDE + INT, epint::TXFE);
    assert_ne!(bench.r(IN + STRIDE + INT) & epint::TXFE, 0);
    assert!(bench.found().is_empty());
}

#[test]
fn words_without_a_transfer_or_without_room_are_said() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(FIFO + FIFO_STRIDE, 1);
    assert_eq!(bench.found(), ["FIFO"]);
    bench.send(1, &[1; 192], 3);
    assert_eq!(bench.found(), ["FIFO"]);
    assert_eq!(bench.r(IN + STRIDE + DTXFSTS), 0);
}

#[test]
fn nak_is_set_cleared_and_announced() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.send(1, &[1; 4], 1);
    bench.w(IN + STRIDE + CTL, bench.core.peek(IN + STRIDE + CTL) | epctl::SNAK);
    assert_ne!(bench.r(IN + STRIDE + INT) & epint::INEPNE, 0);
    assert_ne!(bench.r(IN + STRIDE + CTL) & epctl::NAKSTS, 0);
    let id = bench.submit(BULK_IN, Request::In(64));
    bench.run(MS);
    assert_eq!(bench.outcome(id), None);
    bench.w(IN + STRIDE + CTL, bench.core.peek(IN + STRIDE + CTL) | epctl::CNAK);
    assert_eq!(bench.r(IN + STRIDE + INT) & epint::INEPNE, 0);
    bench.run(MS);
    assert_eq!(bench.expect(id, Outcome::Done), [1; 4]);
}

#[test]
fn the_global_in_nak_holds_every_endpoint() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.send(1, &[1; 4], 1);
    bench.w(DCTL, dctl::SGINAK);
    assert_eq!(bench.r(DCTL), dctl::GINSTS);
    assert_ne!(bench.r(GINTSTS) & gint::GINAKEFF, 0);
    let id = bench.submit(BULK_IN, Request::In(64));
    bench.run(MS);
    assert_eq!(bench.outcome(id), None);
    bench.w(DCTL, dctl::CGINAK);
    assert_eq!(bench.r(GINTSTS) & gint::GINAKEFF, 0);
    bench.run(MS);
    bench.expect(id, Outcome::Done);
}

#[test]
fn an_endpoint_is_disabled_and_its_fifo_flushed() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.send(1, &[1; 4], 1);
    bench.w(IN + STRIDE + CTL, bench.core.peek(IN + STRIDE + CTL) | epctl::SNAK | epctl::EPDIS);
    assert_ne!(bench.r(IN + STRIDE + INT) & epint::EPDISD, 0);
    assert_eq!(bench.r(IN + STRIDE + CTL) & (epctl::EPENA | epctl::EPDIS), 0);
    assert_eq!(bench.r(IN + STRIDE + DTXFSTS), 31);
    bench.w(GRSTCTL, grstctl::TXFFLSH | 1 << grstctl::TXFNUM_SHIFT);
    assert_eq!(bench.r(IN + STRIDE + DTXFSTS), 32);
    bench.send(1, &[1; 4], 1);
    bench.w(GRSTCTL, grstctl::TXFFLSH | grstctl::ALL << grstctl::TXFNUM_SHIFT);
    assert_eq!(bench.r(IN + STRIDE + DTXFSTS), 32);
}

#[test]
fn a_packet_that_is_not_acknowledged_goes_out_again() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.send(1, &[4; 10], 1);
    let lost = bench.submit(BULK_IN, Request::Garbled);
    bench.run(MS);
    assert_eq!(bench.expect(lost, Outcome::Done), [4; 10]);
    assert_eq!(bench.r(IN + STRIDE + INT) & epint::XFRC, 0);
    let id = bench.submit(BULK_IN, Request::In(64));
    bench.run(MS);
    assert_eq!(bench.expect(id, Outcome::Done), [4; 10]);
}

#[test]
fn a_toggle_that_starts_over_on_one_side_alone_loses_a_packet() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    let id = bench.submit(BULK_IN, Request::In(64));
    bench.send(1, &[1], 1);
    bench.run(MS);
    bench.expect(id, Outcome::Done);
    bench.host.clear_toggles();
    let id = bench.submit(BULK_IN, Request::In(64));
    bench.send(1, &[2], 1);
    bench.run(MS);
    assert_eq!((bench.outcome(id), bench.host.tally.repeated), (None, 1));
    bench.send(1, &[3], 1);
    bench.run(MS);
    assert_eq!(bench.expect(id, Outcome::Done), [3]);
}

#[test]
fn more_than_was_asked_for_is_babble() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    let id = bench.submit(BULK_IN, Request::In(10));
    bench.send(1, &[1; 64], 1);
    bench.run(MS);
    assert_eq!(bench.expect(id, Outcome::Babble), [1; 10]);
}

#[test]
fn nineteen_packets_of_64_bytes_go_into_a_frame() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(DIEPTXF1, 800 << 16 | 144);
    bench.run(MS);
    let began = bench.now - bench.now % MS;
    bench.now = began;
    bench.submit(BULK_IN, Request::In(64 * 100));
    bench.send(1, &[1; 64 * 40], 40);
    let mut counts = Vec::new();
    let mut before = bench.host.tally.packets;
    for _ in 0..3 {
        bench.run(MS);
        counts.push(bench.host.tally.packets - before);
        before = bench.host.tally.packets;
    }
    assert_eq!(counts, [19, 19, 2]);
}

#[test]
fn endpoints_take_turns() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(DIEPTXF1, 400 << 16 | 144);
    bench.w(GRXFSIZ, 144 - 16);
    bench.arm_out(4, 256);
    bench.send(1, &[1; 64 * 4], 4);
    let read = bench.submit(BULK_IN, Request::In(256));
    let write = bench.submit(BULK_OUT, Request::Out { data: vec![2; 256], zero: false });
    bench.run(MS);
    let ends: Vec<u64> = [read, write].map(|id| bench.outcome(id).expect("ended").at_ns).to_vec();
    // The ends are one packet of 77 bytes apart.
    assert_eq!(ends[1] - ends[0], 51_333, "{ends:?}");
}

#[test]
fn an_interrupt_endpoint_is_asked_at_its_interval() {
    let mut bench = Bench::ready();
    let interrupt = epctl::USBAEP | 0b11 << epctl::EPTYP_SHIFT | 2 << epctl::TXFNUM_SHIFT | epctl::SD0PID | 8;
    bench.w(IN + 2 * STRIDE + CTL, interrupt);
    bench
        .submit(Endpoint { number: 2, kind: Kind::Interrupt { frames: 16 }, max_packet: 8, ..BULK_IN }, Request::In(8));
    bench.run(160 * MS);
    assert!((9..=11).contains(&bench.host.tally.naks), "{}", bench.host.tally.naks);
}

#[test]
fn a_cancelled_transfer_ends_with_what_came() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    let id = bench.submit(BULK_IN, Request::In(256));
    bench.send(1, &[1; 64], 1);
    bench.run(MS);
    assert!(bench.host.cancel(bench.now, id));
    assert_eq!(bench.expect(id, Outcome::Cancelled), [1; 64]);
    assert!(!bench.host.cancel(bench.now, id));
}

#[test]
fn endpoint_1_has_lines_of_its_own() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(DEACHINTMSK, 1 << 1 | 1 << 17);
    bench.w(DIEPEACHMSK1, epint::XFRC);
    bench.w(DOEPEACHMSK1, epint::XFRC);
    bench.submit(BULK_IN, Request::In(64));
    bench.send(1, &[1], 1);
    bench.run(MS);
    assert_eq!(bench.core.lines()[..2], [false, true]);
    assert_eq!(bench.r(DEACHINT), 1 << 1);
    bench.arm_out(1, 64);
    bench.submit(BULK_OUT, Request::Out { data: vec![1], zero: false });
    bench.run(MS);
    bench.pop();
    bench.pop();
    assert_eq!(bench.core.lines()[..2], [true, true]);
}

#[test]
fn what_comes_too_late_for_a_frame_goes_into_the_next() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.submit(BULK_IN, Request::In(64));
    // The endpoint answers NAK, and then, at the end of the frame, has data.
    bench.run(MS - bench.now % MS - 30_000);
    bench.send(1, &[1; 64], 1);
    assert!(bench.host.next().is_some_and(|at| at > bench.now));
    bench.run(MS);
    assert_eq!(bench.host.tally.packets, 1);
}
