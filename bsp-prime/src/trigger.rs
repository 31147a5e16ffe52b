//! Inputs that stop motion: limit switches, probe, stall outputs. An edge is stamped with the step clock in
//! its interrupt.
//!
//! The chip has one edge detector (EXTI line) per pin *number*, shared by all ports: PD0 and PI0 cannot both
//! be watched. Asking for a taken line is an error that names the pin that has it.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use stm32h7xx_hal::pac;

use crate::pins::{PinName, PinSpec};
use crate::time::step_ticks;

const LINES: usize = 16;
const FREE: u8 = 0xFF;

/// Reported input number and watched port of each line.
static INPUT: [AtomicU8; LINES] = [const { AtomicU8::new(FREE) }; LINES];
static PORT: [AtomicU8; LINES] = [const { AtomicU8::new(0) }; LINES];
/// Edges seen since boot, for the statistics.
static EDGES: AtomicU32 = AtomicU32::new(0);

/// Refusal to watch a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WatchError {
    /// The pin of this name has the same number and is watched already.
    LineTaken(PinName),
}

fn exti() -> &'static pac::exti::RegisterBlock {
    // SAFETY: only this module uses EXTI; its enable bits change in `watch` and `unwatch`, from one task,
    // with interrupts masked.
    unsafe { &*pac::EXTI::ptr() }
}

/// Enables the interrupt of an event other than a pin's, at its rising edge (RM0399 section 21.6). Called
/// once, before interrupts are enabled.
pub(crate) fn listen_for_rise(event: u32) {
    let (exti, bit) = (exti(), 1 << event);
    // SAFETY: every pattern of these registers is valid; nobody else has changed them yet.
    unsafe {
        exti.rtsr1.modify(|r, w| w.bits(r.bits() | bit));
        exti.c1imr1.modify(|r, w| w.bits(r.bits() | bit));
    }
}

/// Reports the moment `spec` becomes active as `input`. The pin must have been claimed as an input before.
///
/// # Errors
/// [`WatchError::LineTaken`].
pub fn watch(spec: PinSpec, input: u8) -> Result<(), WatchError> {
    let line = usize::from(spec.pin.number());
    if INPUT[line].load(Ordering::Relaxed) != FREE {
        let port = (b'A' + PORT[line].load(Ordering::Relaxed)) as char;
        return Err(WatchError::LineTaken(PinName::new(port, spec.pin.number())));
    }
    PORT[line].store(spec.pin.port() as u8, Ordering::Relaxed);
    let bit = spec.pin.bit();
    cortex_m::interrupt::free(|_| {
        route(line, spec.pin.port() as u32);
        let exti = exti();
        // SAFETY: every pattern of these registers is valid; only this line's bit changes, with interrupts
        // masked.
        unsafe {
            // RM0399 section 21.6: the active edge is rising, or falling for an inverted input.
            exti.rtsr1.modify(|r, w| w.bits(if spec.inverted { r.bits() & !bit } else { r.bits() | bit }));
            exti.ftsr1.modify(|r, w| w.bits(if spec.inverted { r.bits() | bit } else { r.bits() & !bit }));
            exti.c1pr1.write(|w| w.bits(bit));
            exti.c1imr1.modify(|r, w| w.bits(r.bits() | bit));
        }
        INPUT[line].store(input, Ordering::Release);
    });
    Ok(())
}

/// Stops watching the pin that reports as `input`.
pub fn unwatch(input: u8) {
    for (line, watched) in INPUT.iter().enumerate() {
        if watched.load(Ordering::Relaxed) == input {
            cortex_m::interrupt::free(|_| {
                // SAFETY: only this line's bit changes, with interrupts masked.
                exti().c1imr1.modify(|r, w| unsafe { w.bits(r.bits() & !(1 << line)) });
                watched.store(FREE, Ordering::Release);
            });
        }
    }
}

/// RM0399 section 13.3.4, SYSCFG_EXTICR1 to 4: four bits per line say which port it listens to.
fn route(line: usize, port: u32) {
    // SAFETY: SYSCFG's EXTICR registers are used here alone, with interrupts masked.
    let syscfg = unsafe { &*pac::SYSCFG::ptr() };
    let shift = 4 * (line as u32 & 3);
    let (clear, set) = (!(0xF << shift), port << shift);
    // SAFETY: port codes 0 to 10 are valid, and only this line's field changes.
    unsafe {
        match line / 4 {
            0 => syscfg.exticr1.modify(|r, w| w.bits(r.bits() & clear | set)),
            1 => syscfg.exticr2.modify(|r, w| w.bits(r.bits() & clear | set)),
            2 => syscfg.exticr3.modify(|r, w| w.bits(r.bits() & clear | set)),
            _ => syscfg.exticr4.modify(|r, w| w.bits(r.bits() & clear | set)),
        }
    }
}

/// Interrupt of any EXTI line: reports every edge that is pending as `(input, low half of the step clock)`.
///
/// The clock is read first: one stamp serves all lines of this interrupt, at most a microsecond late.
#[inline]
pub fn on_interrupt(report: impl Fn(u8, u32)) {
    let tick = step_ticks();
    let exti = exti();
    let mut pending = exti.c1pr1.read().bits() & exti.c1imr1.read().bits() & 0xFFFF;
    // SAFETY: writing a one clears that flag and nothing else.
    exti.c1pr1.write(|w| unsafe { w.bits(pending) });
    while pending != 0 {
        let line = pending.trailing_zeros() as usize;
        pending &= pending - 1;
        let input = INPUT.get(line).map_or(FREE, |input| input.load(Ordering::Acquire));
        if input != FREE {
            EDGES.store(EDGES.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
            report(input, tick);
        }
    }
}
