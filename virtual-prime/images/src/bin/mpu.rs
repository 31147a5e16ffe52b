//! Switches the MPU on with one region and the default map behind it, as firmware does that keeps its DMA
//! buffers out of the cache, then polls a timer. Region and map still protect: a store to read-only memory
//! faults, and so does an unprivileged load from memory that no region opens.
#![no_std]
#![no_main]

use core::arch::asm;
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::{DWT, MPU, SCB};
use cortex_m_rt::{entry, exception};
use images::{pac, pass, start_clocks, wait_for};

/// Address of SRAM2, 128 KiB, in the region: normal memory, not cached, read only for everybody.
const GUARDED: *mut u32 = 0x3002_0000 as *mut u32;
/// Address of SRAM1, in no region.
const OPEN: *mut u32 = 0x3000_0000 as *mut u32;
const ENABLE: u32 = 1;
const PRIVDEFENA: u32 = 1 << 2;
/// MPU_RASR: read only (AP = 110), TEX 1, 2^17 bytes, enabled.
const REGION: u32 = 6 << 24 | 1 << 19 | 16 << 1 | 1;
const ROUNDS: u32 = 100;
/// A round of the timer, in cycles of the core at 400 MHz: 1 ms.
const ROUND_CYCLES: u32 = 400_000;

static FAULTS: AtomicU32 = AtomicU32::new(0);

/// Counts the fault, and opens everything: the access is made again and goes through.
#[exception]
fn MemoryManagement() {
    FAULTS.fetch_add(1, Ordering::Relaxed);
    // SAFETY: MPU_CTRL off, the fault's status cleared.
    unsafe {
        (*MPU::PTR).ctrl.write(0);
        (*SCB::PTR).cfsr.write(0xFF);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

fn guard(mpu: &MPU) {
    // SAFETY: one region, the default map for the rest.
    unsafe {
        mpu.rnr.write(0);
        mpu.rbar.write(GUARDED as u32);
        mpu.rasr.write(REGION);
        mpu.ctrl.write(ENABLE | PRIVDEFENA);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Counts in memory while it polls a timer. Returns the cycles taken.
fn poll(timer: &pac::TIM2) -> u32 {
    let start = DWT::cycle_count();
    for _ in 0..ROUNDS {
        wait_for("the timer", || timer.sr.read().uif().bit());
        timer.sr.write(|w| w.uif().clear_bit());
        // SAFETY: SRAM1, of which nothing else is in use.
        unsafe { write_volatile(OPEN, read_volatile(OPEN) + 1 + read_volatile(GUARDED)) };
    }
    DWT::cycle_count().wrapping_sub(start)
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    let mut core = cortex_m::Peripherals::take().unwrap();
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    core.SCB.enable(cortex_m::peripheral::scb::Exception::MemoryManagement);
    start_clocks(&dp);
    dp.RCC.ahb2enr.modify(|_, w| w.sram1en().set_bit().sram2en().set_bit());
    dp.RCC.apb1lenr.modify(|_, w| w.tim2en().set_bit());
    // SAFETY: 200 MHz over 200 over 1000; the memories are switched on and unused.
    unsafe {
        write_volatile(OPEN, 0);
        write_volatile(GUARDED, 0);
        dp.TIM2.psc.write(|w| w.bits(199));
        dp.TIM2.arr.write(|w| w.bits(999));
    }
    dp.TIM2.egr.write(|w| w.ug().set_bit());
    dp.TIM2.sr.write(|w| w.uif().clear_bit());
    dp.TIM2.cr1.write(|w| w.cen().set_bit());

    guard(&core.MPU);
    let took = poll(&dp.TIM2);
    assert!(took.abs_diff(ROUNDS * ROUND_CYCLES) < 1_000, "{ROUNDS} rounds took {took} cycles");
    // SAFETY: SRAM1 as above.
    assert_eq!(unsafe { read_volatile(OPEN) }, ROUNDS);
    assert_eq!(FAULTS.load(Ordering::Relaxed), 0);

    // SAFETY: read only, so that it faults.
    unsafe { write_volatile(GUARDED, 7) };
    assert_eq!(FAULTS.load(Ordering::Relaxed), 1, "a store into the region");
    guard(&core.MPU);
    let word: u32;
    // SAFETY: an aligned load as if unprivileged, for which the default map is closed.
    unsafe { asm!("ldrt {0}, [{1}]", out(reg) word, in(reg) OPEN) };
    assert_eq!((FAULTS.load(Ordering::Relaxed), word), (2, ROUNDS), "an unprivileged load outside of the region");
    pass()
}
