//! Bulk OUT: packets accepted and refused, and their traces in the registers.

use super::*;
use usb_host::wire::Toggle;

fn out(data: &[u8]) -> Request {
    Request::Out { data: data.to_vec(), zero: false }
}

#[test]
fn packets_enter_the_fifo_until_the_count_is_used_up() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.arm_out(2, 128);
    let data: Vec<u8> = (0..=191).collect();
    let id = bench.submit(BULK_OUT, out(&data));
    bench.run(MS);
    assert_eq!(bench.r(OUT + STRIDE + TSIZ) >> 19 & 0x3FF, 0, "PKTCNT falls with each packet");
    assert_ne!(bench.r(OUT + STRIDE + CTL) & epctl::NAKSTS, 0);
    assert_ne!(bench.r(OUT + STRIDE + CTL) & epctl::EPENA, 0, "until the end is popped");
    assert_eq!(bench.outcome(id), None);
    assert_ne!(bench.r(OUT + STRIDE + INT) & epint::NAK, 0);
    let first = bench.r(GRXSTSR);
    assert_eq!(first >> rxsts::DPID_SHIFT & 3, 0, "DATA0");
    assert_eq!(bench.pop(), (rxsts::OUT_DATA, 1, data[..64].to_vec()));
    assert_eq!(bench.r(GRXSTSR) >> rxsts::DPID_SHIFT & 3, rxsts::DATA1);
    assert_eq!(bench.pop(), (rxsts::OUT_DATA, 1, data[64..128].to_vec()));
    assert_eq!(bench.r(OUT + STRIDE + TSIZ) & 0x7_FFFF, 0, "XFRSIZ falls as packets leave the FIFO");
    assert_eq!(bench.r(OUT + STRIDE + INT) & epint::XFRC, 0);
    assert_eq!(bench.pop().0, rxsts::OUT_DONE);
    assert_ne!(bench.r(OUT + STRIDE + INT) & epint::XFRC, 0);
    assert_eq!(bench.r(OUT + STRIDE + CTL) & epctl::EPENA, 0);
    bench.arm_out(1, 64);
    bench.run(MS);
    bench.expect(id, Outcome::Done);
    assert_eq!(bench.pop(), (rxsts::OUT_DATA, 1, data[128..].to_vec()));
}

#[test]
fn a_short_packet_ends_the_transfer_and_so_does_an_empty_one() {
    for data in [&[1_u8, 2, 3][..], &[]] {
        let mut bench = Bench::ready();
        bench.open_bulk();
        bench.arm_out(5, 320);
        let id = bench.submit(BULK_OUT, out(data));
        bench.run(MS);
        bench.expect(id, Outcome::Done);
        assert_eq!(bench.pop(), (rxsts::OUT_DATA, 1, data.to_vec()));
        assert_eq!(bench.pop().0, rxsts::OUT_DONE);
        assert_eq!(bench.r(OUT + STRIDE + TSIZ), 4 << 19 | (320 - data.len() as u32));
    }
}

#[test]
fn an_endpoint_that_is_disabled_refuses_and_says_so() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    let id = bench.submit(BULK_OUT, out(&[1]));
    bench.run(MS);
    assert_eq!(bench.outcome(id), None);
    assert_ne!(bench.r(OUT + STRIDE + INT) & epint::OTEPDIS, 0);
    assert!(bench.r(GRXSTSR) == 0 && bench.host.tally.naks > 0);
}

#[test]
fn an_endpoint_outside_the_configuration_answers_nothing() {
    let mut bench = Bench::ready();
    let id = bench.submit(BULK_OUT, out(&[1]));
    let other = bench.submit(BULK_IN, Request::In(64));
    bench.run(MS);
    bench.expect(id, Outcome::Failed);
    bench.expect(other, Outcome::Failed);
}

#[test]
fn a_stalled_endpoint_stalls_until_firmware_clears_it() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.arm_out(1, 64);
    let control = bench.r(OUT + STRIDE + CTL);
    bench.w(OUT + STRIDE + CTL, control | epctl::STALL);
    let id = bench.submit(BULK_OUT, out(&[1]));
    bench.run(MS);
    bench.expect(id, Outcome::Stalled);
    bench.w(OUT + STRIDE + CTL, control & !epctl::STALL | epctl::SD0PID);
    let id = bench.submit(BULK_OUT, out(&[1]));
    bench.run(MS);
    bench.expect(id, Outcome::Done);
}

#[test]
fn a_repeated_packet_is_acknowledged_and_dropped() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.arm_out(4, 256);
    let full = [1; 64];
    bench.submit(BULK_OUT, out(&full));
    bench.run(MS);
    // The host has not received the handshake, so it repeats the packet with the same toggle.
    bench.host.set_toggle(BULK_OUT, Toggle::Data0);
    let id = bench.submit(BULK_OUT, out(&full));
    bench.run(MS);
    bench.expect(id, Outcome::Done);
    assert_eq!(bench.pop().0, rxsts::OUT_DATA);
    assert_eq!(bench.r(GRXSTSR), 0);
    // The next packet is in sequence again.
    bench.submit(BULK_OUT, out(&[2; 64]));
    bench.run(MS);
    assert_eq!(bench.pop(), (rxsts::OUT_DATA, 1, vec![2; 64]));
}

#[test]
fn babble_gets_no_answer() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.arm_out(4, 256);
    let babbling = Endpoint { max_packet: 80, ..BULK_OUT };
    let id = bench.submit(babbling, out(&[0; 80]));
    bench.run(MS);
    bench.expect(id, Outcome::Failed);
    assert_ne!(bench.r(OUT + STRIDE + INT) & epint::BERR, 0);
    assert_eq!(bench.r(GRXSTSR), 0);
}

#[test]
fn a_full_fifo_refuses_and_a_setup_still_fits() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    // 18 words are kept free: 13 for SETUP packets, two for each of two OUT endpoints, one more. 34 words are
    // two packets of 64 bytes with their status.
    bench.w(GRXFSIZ, 18 + 34);
    bench.arm_out(10, 640);
    let id = bench.submit(BULK_OUT, out(&[3; 192]));
    bench.run(2 * MS);
    assert_eq!(bench.outcome(id), None);
    assert_eq!(bench.r(OUT + STRIDE + TSIZ) >> 19 & 0x3FF, 8);
    let setup = bench.setup([0x80, 6, 0, 1, 0, 0, 8, 0], &[]);
    bench.run(MS);
    assert_eq!(bench.outcome(setup), None);
    let first = bench.pop();
    assert_eq!(first.2.len(), 64);
    bench.run(MS);
    bench.expect(id, Outcome::Done);
    let order: Vec<u32> = (0..4).map(|_| bench.pop().0).collect();
    assert_eq!(order, [rxsts::OUT_DATA, rxsts::SETUP_DATA, rxsts::SETUP_DONE, rxsts::OUT_DATA]);
    assert!(bench.found().is_empty());
}

#[test]
fn a_fifo_too_small_for_one_packet_is_said() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(GRXFSIZ, 18 + 16);
    bench.arm_out(1, 64);
    bench.submit(BULK_OUT, out(&[3; 64]));
    bench.run(MS);
    assert_eq!(bench.found(), ["GRXFSIZ"]);
}

#[test]
fn an_image_that_never_writes_the_count_gets_packet_by_packet() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    let id = bench.submit(BULK_OUT, out(&[8; 128]));
    for _ in 0..2 {
        // The endpoint is enabled again before the end is popped.
        bench.w(OUT + STRIDE + CTL, bench.core.peek(OUT + STRIDE + CTL) | epctl::EPENA | epctl::CNAK);
        bench.run(MS);
        assert_eq!(bench.pop().0, rxsts::OUT_DATA);
        assert_eq!(bench.pop().0, rxsts::OUT_DONE);
    }
    bench.expect(id, Outcome::Done);
}

#[test]
fn the_global_out_nak_takes_effect_when_it_is_popped_and_lets_endpoints_be_disabled() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.arm_out(1, 64);
    let control = bench.r(OUT + STRIDE + CTL);
    bench.w(OUT + STRIDE + CTL, control | epctl::EPDIS | epctl::SNAK);
    assert_ne!(bench.r(OUT + STRIDE + CTL) & epctl::EPENA, 0, "not without the global NAK");
    bench.w(OUT + STRIDE + CTL, control | epctl::CNAK);

    bench.w(DCTL, dctl::SGONAK);
    assert_eq!(bench.r(DCTL) & dctl::GONSTS, dctl::GONSTS);
    assert_eq!(bench.r(GINTSTS) & gint::GONAKEFF, 0);
    let id = bench.submit(BULK_OUT, out(&[1]));
    bench.run(MS);
    assert_eq!(bench.outcome(id), None);
    assert_eq!(bench.pop().0, rxsts::GLOBAL_OUT_NAK);
    assert_ne!(bench.r(GINTSTS) & gint::GONAKEFF, 0);
    bench.w(OUT + STRIDE + CTL, control | epctl::EPDIS | epctl::SNAK);
    assert_ne!(bench.r(OUT + STRIDE + INT) & epint::EPDISD, 0);
    assert_eq!(bench.r(OUT + STRIDE + CTL) & epctl::EPENA, 0);
    bench.w(DCTL, dctl::CGONAK);
    assert_eq!(bench.r(GINTSTS) & gint::GONAKEFF, 0);
    bench.arm_out(1, 64);
    bench.run(MS);
    bench.expect(id, Outcome::Done);
}

#[test]
fn data_that_are_not_read_are_lost_and_reading_on_is_said() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.arm_out(2, 128);
    bench.submit(BULK_OUT, out(&[1; 68]));
    bench.run(MS);
    bench.r(GRXSTSP);
    bench.r(FIFO);
    bench.r(GRXSTSP);
    assert_eq!(bench.found(), ["GRXSTSP"]);
    // The second packet has four bytes, and any window reads the receive FIFO.
    assert_eq!(bench.r(FIFO + 3 * FIFO_STRIDE), 0x0101_0101);
    assert_eq!(bench.r(FIFO), 0);
    assert_eq!(bench.found(), ["FIFO"]);
}

#[test]
fn a_flush_empties_the_receive_fifo() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.arm_out(2, 128);
    bench.submit(BULK_OUT, out(&[1; 3]));
    bench.run(MS);
    bench.w(GRSTCTL, grstctl::RXFFLSH);
    assert_eq!((bench.r(GRXSTSR), bench.r(GRSTCTL)), (0, grstctl::AHBIDL));
}
