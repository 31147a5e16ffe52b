//! Control transfers on endpoint 0.

use super::*;

const GET: [u8; 8] = [0x80, 6, 0, 1, 0, 0, 100, 0];
const SET: [u8; 8] = [0x21, 0x20, 0, 0, 0, 0, 7, 0];
const NO_DATA: [u8; 8] = [0, 9, 1, 0, 0, 0, 0, 0];

impl Bench {
    /// Takes a SETUP with the end of its stage, as firmware does.
    #[track_caller]
    fn take_setup(&mut self) -> Vec<u8> {
        self.run(MS);
        let (status, endpoint, bytes) = self.pop();
        assert_eq!((status, endpoint, bytes.len()), (rxsts::SETUP_DATA, 0, 8));
        assert_eq!(self.pop().0, rxsts::SETUP_DONE);
        assert_ne!(self.r(OUT + INT) & epint::STUP, 0);
        self.w(OUT + INT, epint::STUP);
        bytes
    }

    fn arm_control_out(&mut self, bytes: u32) {
        self.w(OUT + TSIZ, 3 << 29 | 1 << 19 | bytes);
        self.w(OUT + CTL, epctl::EPENA | epctl::CNAK);
    }
}

#[test]
fn a_setup_is_taken_at_once_and_its_stage_ends_with_the_next_token() {
    let mut bench = Bench::ready();
    bench.setup(GET, &[]);
    // The transfer takes 21 bytes on the bus, after the SOF at most.
    bench.run(17_000);
    let word = bench.r(GRXSTSR);
    assert_eq!(word >> rxsts::PKTSTS_SHIFT & 0xF, rxsts::SETUP_DATA);
    assert_eq!(word >> rxsts::BCNT_SHIFT & 0x7FF, 8);
    assert_ne!(bench.r(GINTSTS) & gint::RXFLVL, 0);
    assert!(bench.line());
    let (_, _, bytes) = bench.pop();
    assert_eq!(bytes, GET);
    // Reading the status has not popped it, the pop has; the end of the stage came with the IN token.
    bench.run(10_000);
    assert_eq!(bench.pop().0, rxsts::SETUP_DONE);
    assert_eq!(bench.r(GRXSTSP), 0, "an empty FIFO reads zero");
    assert_eq!(bench.r(GINTSTS) & gint::RXFLVL, 0);
    assert_ne!(bench.r(OUT + INT) & epint::STUP, 0);
    assert_ne!(bench.r(DAINT) & 1 << 16, 0);
    assert_ne!(bench.r(GINTSTS) & gint::OEPINT, 0);
    assert_eq!(bench.r(OUT + TSIZ) >> 29, 2, "STUPCNT");
    // NAK stays set both ways until firmware has cleared it.
    assert_ne!(bench.r(IN + CTL) & bench.r(OUT + CTL) & epctl::NAKSTS, 0);
    assert_ne!(bench.r(IN + INT) & epint::NAK, 0);
    assert_ne!(bench.r(IN + INT) & epint::ITTXFE, 0);
}

#[test]
fn a_control_read_sends_its_packets_and_takes_the_status() {
    let mut bench = Bench::ready();
    let id = bench.setup(GET, &[]);
    assert_eq!(bench.take_setup(), GET);
    bench.arm_control_out(0);
    let answer: Vec<u8> = (0..100).collect();
    // XFRSIZ of endpoint 0 is enough for a packet, so two transfers are needed.
    bench.send(0, &answer[..64], 1);
    bench.run(MS);
    assert_ne!(bench.r(IN + INT) & epint::XFRC, 0);
    assert_eq!(bench.r(IN + CTL) & epctl::EPENA, 0);
    bench.w(IN + INT, epint::XFRC);
    bench.send(0, &answer[64..], 1);
    bench.run(MS);
    assert_eq!(bench.expect(id, Outcome::Done), answer);
    let (status, _, bytes) = bench.pop();
    assert_eq!((status, bytes.len()), (rxsts::OUT_DATA, 0));
    assert_eq!(bench.pop().0, rxsts::OUT_DONE);
    assert_ne!(bench.r(OUT + INT) & epint::XFRC, 0);
}

#[test]
fn a_control_write_brings_its_data_and_is_told_of_its_status() {
    let mut bench = Bench::ready();
    let id = bench.setup(SET, &[1, 2, 3, 4, 5, 6, 7]);
    bench.take_setup();
    bench.arm_control_out(64);
    bench.run(MS);
    let (status, endpoint, bytes) = bench.pop();
    assert_eq!((status, endpoint, bytes), (rxsts::OUT_DATA, 0, vec![1, 2, 3, 4, 5, 6, 7]));
    assert_eq!(bench.pop().0, rxsts::OUT_DONE);
    bench.run(MS);
    assert_ne!(bench.r(OUT + INT) & epint::STSPHSRX, 0);
    assert_eq!(bench.outcome(id), None, "NAK until firmware has sent the status");
    bench.send(0, &[], 1);
    bench.run(MS);
    bench.expect(id, Outcome::Done);
}

#[test]
fn the_packet_size_of_endpoint_0_counts_for_both_directions() {
    for (bits, bytes) in [(0b11, 8_usize), (0b10, 16), (0b01, 32), (0b00, 64)] {
        let mut bench = Bench::ready();
        bench.w(IN + CTL, bits);
        assert_eq!(bench.r(OUT + CTL) & 0b11, bits);
        let small = Endpoint { max_packet: bytes as u16, ..CONTROL };
        let id = bench.submit(small, Request::Control { setup: [0x21, 9, 0, 0, 0, 0, 20, 0], data: vec![7; 20] });
        bench.take_setup();
        let mut came = Vec::new();
        while came.len() < 20 {
            bench.arm_control_out(64);
            bench.run(MS);
            let (status, _, data) = bench.pop();
            assert_eq!((status, data.len()), (rxsts::OUT_DATA, bytes.min(20 - came.len())));
            came.extend(data);
            assert_eq!(bench.pop().0, rxsts::OUT_DONE);
        }
        bench.send(0, &[], 1);
        bench.run(MS);
        bench.expect(id, Outcome::Done);
    }
}

#[test]
fn a_request_is_stalled_and_the_next_setup_ends_that() {
    let mut bench = Bench::ready();
    let id = bench.setup(GET, &[]);
    bench.take_setup();
    bench.w(IN + CTL, epctl::STALL);
    bench.w(OUT + CTL, epctl::STALL);
    bench.run(MS);
    bench.expect(id, Outcome::Stalled);
    // Firmware cannot clear STALL of endpoint 0.
    bench.w(IN + CTL, 0);
    assert_ne!(bench.r(IN + CTL) & epctl::STALL, 0);
    let id = bench.setup(NO_DATA, &[]);
    assert_eq!(bench.take_setup(), NO_DATA);
    assert_eq!((bench.r(IN + CTL) | bench.r(OUT + CTL)) & epctl::STALL, 0);
    bench.send(0, &[], 1);
    bench.run(MS);
    bench.expect(id, Outcome::Done);
}

#[test]
fn a_new_setup_in_the_middle_is_taken_whatever_was_under_way() {
    let mut bench = Bench::ready();
    let broken = Request::Abandoned { setup: SET, data: vec![9; 7], after: 2 };
    let first = bench.submit(CONTROL, broken);
    bench.take_setup();
    bench.arm_control_out(64);
    bench.run(MS);
    bench.expect(first, Outcome::Done);
    // Data are in the FIFO with their status unread; a read comes instead.
    let second = bench.setup(GET, &[]);
    bench.run(MS);
    let order: Vec<u32> = (0..4).map(|_| bench.pop().0).collect();
    assert_eq!(order, [rxsts::OUT_DATA, rxsts::OUT_DONE, rxsts::SETUP_DATA, rxsts::SETUP_DONE]);
    bench.arm_control_out(0);
    bench.send(0, &[5; 10], 1);
    bench.run(MS);
    assert_eq!(bench.expect(second, Outcome::Done), [5; 10]);
}

#[test]
fn an_answer_that_nobody_fetched_is_still_in_the_fifo_until_it_is_flushed() {
    for flushes in [false, true] {
        let mut bench = Bench::ready();
        let broken = Request::Abandoned { setup: GET, data: Vec::new(), after: 1 };
        bench.submit(CONTROL, broken);
        bench.run(MS);
        // The host gave up after the SETUP; the next SETUP ends its stage.
        bench.pop();
        bench.send(0, &[1; 8], 1);
        let id = bench.setup(GET, &[]);
        bench.run(MS);
        assert_eq!((bench.pop().0, bench.pop().0), (rxsts::SETUP_DATA, rxsts::SETUP_DONE));
        if flushes {
            bench.w(GRSTCTL, grstctl::TXFFLSH);
        }
        bench.arm_control_out(0);
        bench.send(0, &[2; 8], 1);
        bench.run(MS);
        assert_eq!(bench.expect(id, Outcome::Done), if flushes { [2; 8] } else { [1; 8] });
    }
}

#[test]
fn three_setups_in_a_row_are_kept_and_a_fourth_is_said() {
    let mut bench = Bench::ready();
    for number in 1..=4 {
        bench.submit(CONTROL, Request::Abandoned { setup: GET, data: Vec::new(), after: 1 });
        bench.run(MS);
        assert_eq!(bench.r(OUT + INT) & epint::B2BSTUP != 0, number == 4);
    }
    bench.setup(NO_DATA, &[]);
    bench.run(MS);
    let entries: Vec<u32> = (0..6).map(|_| bench.pop().0).collect();
    assert_eq!(entries[..5], [rxsts::SETUP_DATA; 5]);
    assert_eq!(entries[5], rxsts::SETUP_DONE, "one end for all of them");
}

#[test]
fn the_status_of_a_read_with_data_in_it_is_stalled_if_asked_for() {
    let mut bench = Bench::ready();
    bench.w(DCFG, 0x0220_0003 | dcfg::NZLSOHSK);
    bench.submit(CONTROL, Request::Abandoned { setup: GET, data: Vec::new(), after: 1 });
    bench.run(MS);
    bench.pop();
    bench.arm_control_out(64);
    let out = Endpoint { kind: Kind::Bulk, ..CONTROL };
    let id = bench.submit(out, Request::Out { data: vec![1], zero: false });
    bench.run(MS);
    bench.expect(id, Outcome::Stalled);
}

#[test]
fn an_endpoint_that_was_enabled_again_early_stays_enabled() {
    // Firmware answers at the SETUP's data, before it pops the end of the SETUP stage.
    let mut bench = Bench::ready();
    let id = bench.setup(GET, &[]);
    bench.run(MS);
    bench.pop();
    bench.arm_control_out(0);
    assert_eq!(bench.pop().0, rxsts::SETUP_DONE);
    assert_ne!(bench.r(OUT + CTL) & epctl::EPENA, 0);
    bench.send(0, &[3; 5], 1);
    bench.run(MS);
    assert_eq!(bench.expect(id, Outcome::Done), [3; 5]);
}

#[test]
fn another_address_is_not_for_us() {
    let mut bench = Bench::ready();
    bench.w(DCFG, 0x0220_0003 | 9 << dcfg::DAD_SHIFT);
    let id = bench.setup(GET, &[]);
    bench.run(MS);
    bench.expect(id, Outcome::Failed);
    let ours = Endpoint { device: 9, ..CONTROL };
    bench.submit(ours, Request::Control { setup: GET, data: Vec::new() });
    assert_eq!(bench.take_setup(), GET);
}

#[test]
fn a_new_address_counts_after_the_status_stage() {
    let mut bench = Bench::ready();
    let id = bench.setup([0, 5, 9, 0, 0, 0, 0, 0], &[]);
    bench.take_setup();
    bench.w(DCFG, 0x0220_0003 | 9 << dcfg::DAD_SHIFT);
    bench.send(0, &[], 1);
    bench.run(MS);
    bench.expect(id, Outcome::Done);
    let ours = Endpoint { device: 9, ..CONTROL };
    bench.submit(ours, Request::Control { setup: GET, data: Vec::new() });
    assert_eq!(bench.take_setup(), GET);
}
