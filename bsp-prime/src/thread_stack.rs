//! A stack of its own for idle, in AXI SRAM.
//!
//! The executor's state lives on its stack and is large; DTCM is small and belongs to interrupts. So idle
//! runs in thread mode on the process stack (PSP), all interrupts on the main stack (MSP) in DTCM (ARMv7-M
//! ARM B1.4.1). An overflow of either meets a guard and ends in a hard fault, which runs on the main stack.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

/// Size of the stack in bytes: the deepest path that `xtask sizes stack` finds in the image, and a margin of
/// at least 12 KiB for what it does not see: the guard, an interrupt's entry, and a panic at the deepest
/// place (8 KiB). `bench/budget.toml` holds both.
pub const THREAD_STACK_BYTES: usize = 168 * 1024;
/// The lowest bytes are untouchable; see the memory module's MPU regions.
pub(crate) const GUARD_BYTES: usize = 256;

#[repr(C, align(256))]
struct Stack(UnsafeCell<MaybeUninit<[u8; THREAD_STACK_BYTES]>>);

// SAFETY: nobody refers to the contents but the stack pointer.
unsafe impl Sync for Stack {}

#[unsafe(link_section = ".axisram")]
static STACK: Stack = Stack(UnsafeCell::new(MaybeUninit::uninit()));

/// Returns the lowest address of the guard.
pub(crate) fn guard() -> u32 {
    STACK.0.get() as u32
}

/// Returns the number of bytes never touched since the start, at which the region was zeroed.
#[must_use]
pub fn unused_bytes() -> u32 {
    let bottom = guard() + GUARD_BYTES as u32;
    let top = guard() + THREAD_STACK_BYTES as u32;
    // SAFETY: reads of initialised (zeroed) words of the stack's own static.
    let untouched = |address: &u32| unsafe { (*address as *const u32).read_volatile() == 0 };
    4 * (bottom..top).step_by(4).take_while(untouched).count() as u32
}

/// Calls `body` on the thread stack, for ever. Once, from thread mode, after the board is up.
pub fn run<F: FnOnce() -> core::convert::Infallible>(body: F) -> ! {
    let mut body = Some(body);
    let slot = &raw mut body;
    let top = guard() + THREAD_STACK_BYTES as u32;
    // SAFETY: the new stack is used by nobody else, since this function never returns and is called once.
    // `slot` stays valid: it lies on the main stack, whose pointer is not moved up again. Setting SPSEL is
    // privileged thread mode's to do, ISB makes it effective (ARMv7-M ARM B1.4.4).
    unsafe {
        core::arch::asm!(
            "msr psp, {top}",
            "mrs {top}, control",
            "orr {top}, {top}, #2",
            "msr control, {top}",
            "isb",
            "bx {entry}",
            top = in(reg) top,
            entry = in(reg) enter::<F> as extern "C" fn(*mut Option<F>) -> ! as usize,
            in("r0") slot,
            options(noreturn)
        )
    }
}

extern "C" fn enter<F: FnOnce() -> core::convert::Infallible>(slot: *mut Option<F>) -> ! {
    // SAFETY: `run` passes a pointer to its own live variable, and nobody else has it.
    if let Some(body) = unsafe { (*slot).take() } {
        match body() {}
    }
    // Not reached: `run` filled the slot.
    loop {
        cortex_m::asm::wfi();
    }
}
