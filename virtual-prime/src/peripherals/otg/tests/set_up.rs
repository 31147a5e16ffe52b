//! Reset values, resets, the FIFOs' RAM, and accesses that are not allowed.

use super::*;

#[test]
fn registers_come_out_of_reset_as_the_manual_has_them() {
    let core = Core::new();
    let table = [
        (GOTGCTL, 0x0001_0000),
        (GUSBCFG, 0x1400),
        (GRSTCTL, 0x8000_0000),
        (GINTSTS, 0x1400_0020),
        (GRXFSIZ, 0x200),
        (HNPTXFSIZ, 0x0200_0200),
        (DIEPTXF1, 0x0200_0400),
        (DIEPTXF1 + 28, 0x0200_1200),
        (CID, 0x2300),
        (DCFG, 0x0220_0000),
        (DCTL, 2),
        (DSTS, 6),
        (IN, 0x8000),
        (IN + INT, 0x80),
        (OUT, 0x8000),
        (OUT + INT, 0),
        (DVBUSDIS, 0x17D7),
        (IN + DTXFSTS, 0x200),
    ];
    for (offset, value) in table {
        assert_eq!(core.peek(offset), value, "{offset:#x}");
    }
}

#[test]
fn nine_endpoints_each_way_have_registers_and_there_is_no_tenth() {
    let mut bench = Bench::new();
    for base in [IN, OUT] {
        bench.w(base + 8 * STRIDE + TSIZ, 1 << 19 | 64);
        assert_eq!(bench.r(base + 8 * STRIDE + TSIZ), 1 << 19 | 64);
    }
    assert!(bench.found().is_empty());
    bench.r(IN + 9 * STRIDE + CTL);
    bench.w(OUT + 9 * STRIDE + CTL, 0);
    assert_eq!(bench.found(), ["block"]);
}

#[test]
fn a_soft_reset_keeps_the_transceiver_and_the_speed() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(GRSTCTL, grstctl::CSRST);
    assert_eq!(bench.r(GRSTCTL), grstctl::AHBIDL);
    assert_eq!((bench.r(GINTMSK), bench.r(DAINTMSK), bench.r(IN + STRIDE)), (0, 0, 0));
    assert_eq!(bench.r(GUSBCFG), 0x1400 | gusbcfg::PHYSEL);
    assert_eq!(bench.r(GCCFG), gccfg::PWRDWN);
    assert_eq!(bench.r(DCFG) & dcfg::DSPD, dcfg::FULL_SPEED);
    assert_eq!(bench.r(DCTL) & dctl::SDIS, 0);
}

#[test]
fn a_soft_reset_waits_for_the_transceivers_clock_and_says_so() {
    let mut bench = Bench::new();
    bench.w(GRSTCTL, grstctl::CSRST);
    assert_eq!(bench.r(GRSTCTL) & grstctl::CSRST, grstctl::CSRST, "PHYSEL is clear");
    assert_eq!(bench.found(), ["GRSTCTL"]);
    bench.w(GUSBCFG, gusbcfg::PHYSEL);
    assert_eq!(bench.r(GRSTCTL) & grstctl::CSRST, 0);

    bench.core.look_around(Surroundings { kernel_hz: 0, ..WIRED });
    bench.w(GRSTCTL, grstctl::CSRST);
    assert_eq!(bench.r(GRSTCTL) & grstctl::CSRST, grstctl::CSRST, "no kernel clock");
    bench.core.set_clock(48_000_000);
    assert_eq!(bench.r(GRSTCTL) & grstctl::CSRST, 0);

    bench.core.look_around(Surroundings { ulpi: true, ..WIRED });
    bench.w(GRSTCTL, grstctl::CSRST);
    assert_eq!(bench.r(GRSTCTL) & grstctl::CSRST, grstctl::CSRST, "the ULPI's clock is awaited");
}

#[test]
fn flags_that_are_latched_clear_by_writing_one_and_the_others_do_not() {
    let mut bench = Bench::ready();
    bench.run(MS);
    assert_ne!(bench.r(GINTSTS) & gint::SOF, 0);
    bench.w(GINTSTS, gint::SOF);
    assert_eq!(bench.r(GINTSTS) & gint::SOF, 0);
    bench.w(DCTL, dctl::SGINAK);
    bench.w(GINTSTS, !0);
    assert_ne!(bench.r(GINTSTS) & gint::GINAKEFF, 0);
}

#[test]
fn the_line_needs_a_cause_its_mask_and_the_global_one() {
    let mut bench = Bench::ready();
    assert!(!bench.line());
    bench.w(GINTMSK, gint::SOF);
    bench.run(2 * MS);
    assert!(bench.line());
    bench.w(GAHBCFG, 0);
    assert!(!bench.line());
    bench.w(GAHBCFG, gahbcfg::GINT);
    bench.w(GINTMSK, 0);
    assert!(!bench.line());
}

#[test]
fn a_fifo_must_fit_into_the_ram_and_share_it_with_nobody() {
    let enable = |bench: &mut Bench| {
        bench.w(IN + STRIDE + CTL, epctl::USBAEP | 1 << epctl::TXFNUM_SHIFT | 64 | epctl::EPENA);
        bench.found()
    };
    let try_with = |txf1: u32| {
        let mut bench = Bench::ready();
        bench.w(DIEPTXF1, txf1);
        enable(&mut bench)
    };
    assert!(try_with(32 << 16 | 144).is_empty());
    assert!(try_with(16 << 16 | 1008).is_empty(), "the last 16 of 1024 words");
    assert_eq!(try_with(17 << 16 | 1008), ["DIEPTXFx"]);
    assert_eq!(try_with(32 << 16 | 143), ["DIEPTXFx"], "overlaps FIFO 0");
    assert_eq!(try_with(32 << 16 | 100), ["DIEPTXFx"], "overlaps the receive FIFO");
    assert_eq!(try_with(15 << 16 | 144), ["DIEPTXFx"], "less than 16 words");
}

#[test]
fn accesses_that_have_no_model_are_said() {
    let mut bench = Bench::ready();
    bench.w(GAHBCFG, gahbcfg::DMAEN | gahbcfg::GINT);
    bench.w(0x440, 1);
    bench.w(GUSBCFG, gusbcfg::FHMOD | gusbcfg::PHYSEL);
    bench.w(IN + STRIDE + CTL, epctl::USBAEP | 1 << epctl::EPTYP_SHIFT | 1 << 22 | 64 | epctl::EPENA);
    bench.w(DCFG, 0);
    assert_eq!(bench.found(), ["GAHBCFG", "host registers", "GUSBCFG", "DIEPCTLx", "DCFG"]);
    // Each finding is reported once.
    bench.w(DCFG, 0);
    assert!(bench.found().is_empty());
}

#[test]
fn a_packet_written_into_a_fifo_is_not_to_be_interrupted() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(IN + STRIDE + TSIZ, 1 << 19 | 8);
    bench.w(FIFO + FIFO_STRIDE, 1);
    bench.r(GINTSTS);
    assert!(bench.found().is_empty());
    bench.r(IN + CTL);
    assert_eq!(bench.found(), ["FIFO"]);
}

#[test]
fn the_session_override_makes_a_session_and_ends_it() {
    let mut bench = Bench::new();
    bench.w(GINTSTS, !0);
    bench.w(GOTGCTL, gotgctl::BVALOEN | gotgctl::BVALOVAL);
    assert_ne!(bench.r(GOTGCTL) & gotgctl::BSVLD, 0);
    assert_ne!(bench.r(GINTSTS) & gint::SRQINT, 0);
    bench.w(GOTGCTL, gotgctl::BVALOEN);
    assert_eq!(bench.r(GOTGCTL) & gotgctl::BSVLD, 0);
    assert_eq!(bench.r(GOTGINT), gotgint::SEDET);
    assert_ne!(bench.r(GINTSTS) & gint::OTGINT, 0);
    bench.w(GOTGINT, gotgint::SEDET);
    assert_eq!(bench.r(GINTSTS) & gint::OTGINT, 0);
}
