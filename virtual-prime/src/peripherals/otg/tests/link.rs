//! Connection, reset, suspend and resume.

use super::*;
use usb_host::controller::PortEvent;

/// Connects a core that `spoil` has changed. Returns the registers of its findings 20 ms after the cable was
/// plugged in.
fn connected_but(spoil: impl FnOnce(&mut Bench)) -> Vec<&'static str> {
    let mut bench = Bench::new();
    bench.connect();
    spoil(&mut bench);
    bench.host.plug(bench.now, &mut bench.core);
    bench.run(20 * MS);
    assert_eq!(bench.host.port(), Port::Empty, "no pull-up");
    bench.found()
}

#[test]
fn the_pull_up_needs_everything_and_what_lacks_is_said() {
    let around = |around| move |bench: &mut Bench| bench.core.look_around(around);
    assert_eq!(connected_but(around(Surroundings { pins: false, ..WIRED })), ["GCCFG"]);
    assert_eq!(connected_but(around(Surroundings { supply: false, ..WIRED })), ["GCCFG"]);
    assert_eq!(connected_but(around(Surroundings { kernel_hz: 0, ..WIRED })), ["GRSTCTL"]);
    assert_eq!(connected_but(around(Surroundings { ulpi: true, ..WIRED })), ["GRSTCTL"]);
    assert_eq!(connected_but(|bench| bench.w(GUSBCFG, 0x1400)), ["GUSBCFG"]);
    assert_eq!(connected_but(|bench| bench.w(GCCFG, 0)), ["GCCFG"]);
    assert_eq!(connected_but(|bench| bench.w(GOTGCTL, 0)), ["GOTGCTL"]);
    assert_eq!(
        connected_but(|bench| {
            bench.w(GCCFG, gccfg::PWRDWN | gccfg::VBDEN);
            bench.w(GOTGCTL, 0);
        }),
        ["GCCFG"],
        "VBUS sensing"
    );
    // A core that does not connect is no mistake.
    assert!(connected_but(|bench| bench.w(DCTL, dctl::SDIS)).is_empty());
}

#[test]
fn the_steps_of_a_connection_may_come_in_any_order_within_ten_milliseconds() {
    let mut bench = Bench::new();
    bench.host.plug(0, &mut bench.core);
    bench.core.look_around(Surroundings { pins: false, ..WIRED });
    bench.connect();
    bench.run(9 * MS);
    bench.core.look_around(WIRED);
    bench.run(20 * MS);
    assert_eq!(bench.host.port(), Port::Connected);
    assert!(bench.found().is_empty());
}

#[test]
fn nothing_is_said_without_a_cable() {
    let mut bench = Bench::new();
    bench.core.look_around(Surroundings { pins: false, supply: false, ..WIRED });
    bench.connect();
    bench.run(100 * MS);
    assert!(bench.found().is_empty());
    assert_eq!(bench.core.next_change(), None, "and nothing is left to do");
}

#[test]
fn a_wrong_kernel_clock_answers_nothing() {
    for (hz, heard) in [(44_444_444, false), (47_880_000, true), (47_800_000, false), (48_120_000, true)] {
        let mut bench = Bench::ready();
        bench.core.set_clock(hz);
        let id = bench.setup([0x80, 6, 0, 1, 0, 0, 18, 0], &[]);
        bench.run(2 * MS);
        if heard {
            assert_eq!(bench.pop().0, rxsts::SETUP_DATA, "{hz}");
        } else {
            bench.expect(id, Outcome::Failed);
            assert_eq!(bench.found(), ["GRSTCTL"], "{hz}");
        }
    }
}

#[test]
fn a_bus_reset_is_announced_at_its_beginning_and_the_speed_at_its_end() {
    let mut bench = Bench::ready();
    bench.open_bulk();
    bench.w(DCFG, 0x0220_0003 | 5 << dcfg::DAD_SHIFT);
    bench.arm_out(1, 64);
    bench.host.reset(bench.now, 10 * MS, &mut bench.core);
    bench.run(MS);
    let flags = bench.r(GINTSTS);
    assert_eq!(flags & (gint::USBRST | gint::ENUMDNE), gint::USBRST);
    assert!(bench.line());
    bench.run(10 * MS);
    assert_ne!(bench.r(GINTSTS) & gint::ENUMDNE, 0);
    assert_eq!(bench.r(DSTS) & dsts::FULL_SPEED, dsts::FULL_SPEED);
    // The reset takes the endpoints out of the configuration, and changes nothing else.
    assert_eq!(bench.r(OUT + STRIDE + CTL) & epctl::USBAEP, 0);
    assert_ne!(bench.r(OUT + STRIDE + CTL) & epctl::EPENA, 0);
    assert_ne!(bench.r(OUT + CTL) & epctl::USBAEP, 0);
    assert_eq!(bench.r(DCFG) >> dcfg::DAD_SHIFT & 0x7F, 5);
}

#[test]
fn frames_count_and_are_announced() {
    let mut bench = Bench::ready();
    bench.w(GINTSTS, gint::SOF);
    let before = bench.r(DSTS) >> dsts::FNSOF_SHIFT;
    bench.run(10 * MS);
    assert_eq!(bench.r(DSTS) >> dsts::FNSOF_SHIFT, before + 10);
    assert_ne!(bench.r(GINTSTS) & gint::SOF, 0);
    // The frame number has 11 bits.
    bench.run(2_048 * MS);
    assert_eq!(bench.r(DSTS) >> dsts::FNSOF_SHIFT, before + 10);
}

#[test]
fn idle_is_early_suspend_after_3_ms_and_suspend_after_6() {
    let mut bench = Bench::ready();
    bench.host.suspend(bench.now, &mut bench.core);
    bench.run(3 * MS - 1);
    assert_eq!(bench.r(GINTSTS) & (gint::ESUSP | gint::USBSUSP), 0);
    bench.run(1);
    assert_eq!(bench.r(GINTSTS) & (gint::ESUSP | gint::USBSUSP), gint::ESUSP);
    bench.run(3 * MS - 1);
    assert_eq!(bench.r(DSTS) & dsts::SUSPSTS, 0);
    bench.run(1);
    assert_ne!(bench.r(GINTSTS) & gint::USBSUSP, 0);
    assert_eq!(bench.r(DSTS) & dsts::SUSPSTS, dsts::SUSPSTS);
    assert_ne!(bench.r(PCGCCTL) & pcgcctl::PHYSUSP, 0);
    // The interrupt comes only once.
    bench.clear_all();
    bench.run(100 * MS);
    assert_eq!(bench.r(GINTSTS) & (gint::ESUSP | gint::USBSUSP), 0);
    bench.host.resume(bench.now, &mut bench.core);
    bench.run(MS);
    assert_ne!(bench.r(GINTSTS) & gint::WKUPINT, 0);
    assert_eq!(bench.r(DSTS) & dsts::SUSPSTS, 0);
    bench.run(25 * MS);
    assert_eq!(bench.host.port(), Port::Enabled);
}

#[test]
fn a_cable_that_is_pulled_out_is_a_line_that_falls_idle() {
    let mut bench = Bench::ready();
    bench.host.unplug(bench.now, &mut bench.core);
    bench.run(6 * MS);
    assert_ne!(bench.r(GINTSTS) & gint::USBSUSP, 0);
    bench.clear_all();
    // After plugging in again nothing but the reset is to be noticed.
    bench.host.plug(bench.now, &mut bench.core);
    bench.run(100 * MS);
    assert_eq!(bench.r(GINTSTS) & gint::LATCHED, 0);
    bench.host.reset(bench.now, 10 * MS, &mut bench.core);
    bench.run(MS);
    assert_ne!(bench.r(GINTSTS) & gint::USBRST, 0);
    assert_eq!(bench.r(DSTS) & dsts::SUSPSTS, 0);
}

#[test]
fn a_device_wakes_its_host() {
    let mut bench = Bench::ready();
    bench.host.suspend(bench.now, &mut bench.core);
    bench.run(10 * MS);
    bench.w(DCTL, dctl::RWUSIG);
    bench.run(5 * MS);
    bench.w(DCTL, 0);
    assert_eq!(bench.host.take_events(), [PortEvent::Connected, PortEvent::Woken(5 * MS)]);
    bench.run(16 * MS);
    assert_eq!(bench.host.port(), Port::Enabled);
    assert_eq!(bench.r(DSTS) & dsts::SUSPSTS, 0);
}

#[test]
fn with_its_clock_stopped_the_core_asks_for_it_and_is_deaf_until_then() {
    let mut bench = Bench::ready();
    bench.host.suspend(bench.now, &mut bench.core);
    bench.run(10 * MS);
    bench.clear_all();
    bench.w(PCGCCTL, pcgcctl::STPPCLK);
    bench.host.reset(bench.now, 10 * MS, &mut bench.core);
    bench.run(MS);
    assert_eq!(bench.r(GINTSTS) & (gint::WKUPINT | gint::USBRST), gint::WKUPINT);
    bench.w(PCGCCTL, 0);
    assert_ne!(bench.r(GINTSTS) & gint::USBRST, 0);
    bench.run(10 * MS);
    assert_ne!(bench.r(GINTSTS) & gint::ENUMDNE, 0);
    assert!(bench.found().is_empty());

    bench.w(PCGCCTL, pcgcctl::STPPCLK);
    let id = bench.setup([0x80, 6, 0, 1, 0, 0, 18, 0], &[]);
    bench.run(2 * MS);
    bench.expect(id, Outcome::Failed);
    assert_eq!(bench.found(), ["PCGCCTL"]);
}

#[test]
fn a_soft_disconnect_is_noticed_at_once_and_ends_every_transfer() {
    let mut bench = Bench::ready();
    let id = bench.setup([0x80, 6, 0, 1, 0, 0, 18, 0], &[]);
    bench.w(DCTL, dctl::SDIS);
    assert_eq!(bench.host.port(), Port::Empty);
    bench.expect(id, Outcome::Gone);
    bench.w(DCTL, 0);
    assert_eq!(bench.host.port(), Port::Connected);
    assert_eq!(bench.host.take_events(), [PortEvent::Connected, PortEvent::Disconnected, PortEvent::Connected]);
}

#[test]
fn a_reset_of_the_block_lets_go_of_the_line() {
    let mut bench = Bench::ready();
    bench.core.reset();
    bench.run(MS);
    assert_eq!(bench.host.port(), Port::Empty);
    assert_eq!(bench.r(GINTMSK), 0);
}

#[test]
fn a_sleeping_processor_with_the_ulpis_clock_enabled_for_sleep_makes_the_core_deaf() {
    let mut bench = Bench::ready();
    bench.core.processor_slept(bench.now);
    assert!(bench.found().is_empty());
    bench.core.look_around(Surroundings { ulpi_asleep: true, ..WIRED });
    bench.core.processor_slept(bench.now);
    assert_eq!(bench.found(), ["GRSTCTL"]);
    let id = bench.setup([0x80, 6, 0, 1, 0, 0, 18, 0], &[]);
    bench.run(MS);
    bench.expect(id, Outcome::Failed);
}
