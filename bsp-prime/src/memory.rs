//! Memory before use: hot code into the ITCM with the vector table, clean AXI SRAM, a DMA arena no cache
//! touches, a guard under the stack.

use core::ptr::{addr_of, addr_of_mut};

use cortex_m::peripheral::{CPUID, MPU, SCB};

use crate::{kept, thread_stack};

unsafe extern "C" {
    static mut __sitcm: u32;
    static mut __eitcm: u32;
    static __siitcm: u32;
    static mut __sitcm_data: u32;
    static mut __eitcm_data: u32;
    static __saxizero: u32;
    static __eaxizero: u32;
    static mut __saxisram: u32;
    static mut __eaxisram: u32;
    static mut __sd2ram: u32;
    static mut __ed2ram: u32;
    static mut __sd2dma: u32;
    static mut __ed2dma: u32;
    static mut __sdma_arena: u32;
    static mut __edma_arena: u32;
    static __skept: u32;
    static __ekept: u32;
    static __euninit: u32;
    static __vector_table: u32;
}

/// Vectors of the core (16) and of the chip (150; RM0399 section 20.1.2), rounded up to the alignment VTOR
/// asks for.
const VECTORS: usize = 256;
/// Address of the copied vector table: the bottom of the ITCM, which `memory.x` leaves free.
const ITCM_VECTORS: usize = 0x0000_0000;
/// Size of the ITCM in bytes. Its first eighth is the code's, the rest holds data; `memory.x` says the same.
const ITCM_BYTES: u32 = 64 * 1024;
/// First address of the DMA arena; `memory.x` says the same and its size is asserted there.
pub const DMA_ARENA_START: u32 = 0x2406_C000;
/// Size of the DMA arena in bytes.
pub const DMA_ARENA_BYTES: u32 = 80 * 1024;
/// Size of the first of the arena's two MPU regions, whose sizes are powers of two and whose bases are
/// multiples of their sizes; the rest is the second region.
const DMA_ARENA_LOWER_BYTES: u32 = 16 * 1024;
/// First address of the memory for the DMAs of domain D2, SRAM3; `memory.x` says the same.
pub const D2_DMA_START: u32 = 0x3004_0000;
/// Size of that memory in bytes.
pub const D2_DMA_BYTES: u32 = 32 * 1024;
/// Size of the no-access strip below the stack, in bytes.
const STACK_GUARD_BYTES: u32 = 256;

/// User of the flash, which determines the writable sectors: never those that the code runs from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FlashUse {
    /// The application, which writes the log of updates in the last sector.
    Application,
    /// The boot stage in the first sector, which writes all others.
    BootStage,
}

/// Zeroes the statics in AXI SRAM, as `cortex-m-rt` does it for those in DTCM and just before it: so no code
/// has seen them without their first values. Assembly, because no Rust may run before its statics are what
/// they say.
#[unsafe(naked)]
// SAFETY: the name is the one that `cortex-m-rt`'s reset code calls; nobody else defines it.
#[unsafe(no_mangle)]
extern "C" fn __pre_init() {
    core::arch::naked_asm!(
        "ldr r0, =__saxizero",
        "ldr r1, =__eaxizero",
        "movs r2, #0",
        "0:",
        "cmp r1, r0",
        "beq 1f",
        "str r2, [r0], #4",
        "b 0b",
        "1:",
        "bx lr",
    )
}

/// Copies code and vectors to the ITCM, zeroes the three regions that `cortex-m-rt` does not know, sets the
/// MPU and the caches.
///
/// Call once, before any interrupt is enabled and before anything in those regions is used.
pub(crate) fn prepare(scb: &mut SCB, mpu: &mut MPU, cpuid: &mut CPUID, flash: FlashUse) {
    // SAFETY: the linker script gives these symbols to exactly these regions and aligns them to words;
    // nothing has run from or looked at them yet, since this is the first thing the board does and interrupts
    // are off.
    unsafe {
        copy_words(addr_of!(__siitcm), addr_of_mut!(__sitcm), addr_of_mut!(__eitcm));
        zero_words(addr_of_mut!(__sitcm_data), addr_of_mut!(__eitcm_data));
        zero_words(addr_of_mut!(__saxisram), addr_of_mut!(__eaxisram));
        zero_words(addr_of_mut!(__sdma_arena), addr_of_mut!(__edma_arena));
        copy_vectors();
        // The table is copied whole and aligned to its size rounded up to a power of two (ARMv7-M ARM
        // B3.2.5).
        scb.vtor.write(ITCM_VECTORS as u32);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    protect(mpu, flash);
    scb.enable_icache();
    scb.enable_dcache(cpuid);
}

/// Zeroes the statics in SRAM1, SRAM2 and SRAM3. Call once, when their clocks are on (RM0399 section 2.3:
/// without them an access is a bus error) and before anything in them is used.
pub(crate) fn prepare_d2() {
    // SAFETY: the linker script gives these symbols to exactly these regions and aligns them to words;
    // interrupts are off, and nobody has a reference to what lies there.
    unsafe {
        zero_words(addr_of_mut!(__sd2ram), addr_of_mut!(__ed2ram));
        zero_words(addr_of_mut!(__sd2dma), addr_of_mut!(__ed2dma));
    }
    cortex_m::asm::dsb();
}

/// # Safety
/// `from` and `to..end` must be word-aligned memory that nothing else refers to.
unsafe fn copy_words(mut from: *const u32, mut to: *mut u32, end: *mut u32) {
    while to < end {
        // SAFETY: the caller vouches for both ranges; `to` is below `end`. Volatile, because the ITCM starts
        // near address zero and the compiler must not turn the loop into a library call that may itself live
        // there.
        unsafe {
            to.write_volatile(from.read_volatile());
            from = from.add(1);
            to = to.add(1);
        }
    }
}

/// # Safety
/// `to..end` must be word-aligned memory that nothing else refers to.
unsafe fn zero_words(mut to: *mut u32, end: *mut u32) {
    while to < end {
        // SAFETY: the caller vouches for the range; `to` is below `end`.
        unsafe {
            to.write_volatile(0);
            to = to.add(1);
        }
    }
}

/// Copies the vector table to address zero, which Rust's pointers may not name: hence two lines of assembly
/// per word.
fn copy_vectors() {
    let table = addr_of!(__vector_table);
    for index in 0..VECTORS {
        // SAFETY: reads within the image (the table is followed by more flash than 1 KiB) and writes the
        // first KiB of the ITCM, which the linker script leaves free.
        unsafe {
            let entry = table.add(index).read_volatile();
            core::arch::asm!("str {entry}, [{at}]", entry = in(reg) entry, at = in(reg) ITCM_VECTORS + index * 4,
                options(nostack, preserves_flags));
        }
    }
}

/// Puts a handler into the table in ITCM. The interrupt must not be active.
pub(crate) fn set_vector(interrupt: stm32h7xx_hal::pac::Interrupt, handler: extern "C" fn()) {
    /// The core's own vectors come first (ARMv7-M ARM B1.5.2).
    const CORE_VECTORS: usize = 16;
    let at = ITCM_VECTORS + 4 * (CORE_VECTORS + interrupt as usize);
    // SAFETY: the entry lies in the table's KiB, which `copy_vectors` filled; a function's address has the
    // bit for Thumb code. The new vector is seen by every exception entry after the barrier (ARMv7-M ARM
    // B2.5).
    unsafe {
        core::arch::asm!("str {handler}, [{at}]", "dsb", handler = in(reg) handler, at = in(reg) at,
            options(nostack, preserves_flags));
    }
}

/// Attributes and size of an MPU region (RASR, ARMv7-M ARM B3.5.9).
mod rasr {
    pub const ENABLE: u32 = 1;
    pub const FULL_ACCESS: u32 = 0b011 << 24;
    pub const READ_ONLY: u32 = 0b111 << 24;
    pub const NO_ACCESS: u32 = 0;
    pub const EXECUTE_NEVER: u32 = 1 << 28;
    // TEX = 001, C = 0, B = 0: normal, non-cacheable; shareable.
    pub const NORMAL_NON_CACHEABLE: u32 = (0b001 << 19) | (1 << 18);
    // TEX = 000, C = 1, B = 0: normal, write-through; TEX = 001, C = 1, B = 1: normal, write-back,
    // write-allocate.
    pub const WRITE_THROUGH: u32 = 1 << 17;
    pub const WRITE_BACK: u32 = (0b001 << 19) | (1 << 17) | (1 << 16);

    // SRD, a bit for each eighth of the region.
    pub const FIRST_EIGHTH_LEFT_OUT: u32 = 1 << 8;

    pub const fn size(bytes: u32) -> u32 {
        (bytes.trailing_zeros() - 1) << 1
    }
}

/// Returns base, attributes and size of each MPU region, over the default map (ARMv7-M ARM B3.5): the DMA
/// arena becomes normal non-cacheable memory, the strips below the stacks' limits become untouchable, so that
/// an overflow is a fault and not a corrupted plan.
fn regions(flash: FlashUse) -> [(u32, u32); 13] {
    use rasr::{
        EXECUTE_NEVER, FIRST_EIGHTH_LEFT_OUT, FULL_ACCESS, NO_ACCESS, NORMAL_NON_CACHEABLE, READ_ONLY, WRITE_BACK,
        WRITE_THROUGH, size,
    };
    const SECTOR_BYTES: u32 = 128 * 1024;
    let guard = (addr_of!(__euninit) as u32).next_multiple_of(STACK_GUARD_BYTES);
    let (whole_flash, (sector, of_sector)) = match flash {
        FlashUse::Application => (READ_ONLY, (0x081E_0000, EXECUTE_NEVER | FULL_ACCESS)),
        FlashUse::BootStage => (FULL_ACCESS, (0x0800_0000, READ_ONLY)),
    };
    const DATA: u32 = EXECUTE_NEVER | FULL_ACCESS | WRITE_BACK;
    const SHARED: u32 = EXECUTE_NEVER | FULL_ACCESS | NORMAL_NON_CACHEABLE;
    const GUARD: u32 = EXECUTE_NEVER | NO_ACCESS | NORMAL_NON_CACHEABLE;
    [
        // The default map's attributes, with what it does not say: code is not written, data is not
        // executed.
        (0x0000_0000, FULL_ACCESS | WRITE_THROUGH | size(ITCM_BYTES)),
        (0x0800_0000, whole_flash | WRITE_THROUGH | size(2 * 1024 * 1024)),
        (0x2000_0000, DATA | size(128 * 1024)),
        (0x2400_0000, DATA | size(512 * 1024)),
        (DMA_ARENA_START, SHARED | size(DMA_ARENA_LOWER_BYTES)),
        (DMA_ARENA_START + DMA_ARENA_LOWER_BYTES, SHARED | size(DMA_ARENA_BYTES - DMA_ARENA_LOWER_BYTES)),
        (guard, GUARD | size(STACK_GUARD_BYTES)),
        (thread_stack::guard(), GUARD | size(thread_stack::GUARD_BYTES as u32)),
        // SRAM1 and SRAM2. No DMA uses them; a DMA there would need a region like the arena's.
        (0x3000_0000, DATA | size(256 * 1024)),
        // No event may wait in the cache when a reset comes.
        (kept::START, SHARED | size(kept::BYTES)),
        // The sector of the log, or that of the boot stage, has its own access rights.
        (sector, of_sector | WRITE_THROUGH | size(SECTOR_BYTES)),
        // SRAM3, for the DMAs of its domain.
        (D2_DMA_START, SHARED | size(D2_DMA_BYTES)),
        // The ITCM but for its first eighth, the code; where regions overlap, the greater number counts.
        (0x0000_0000, EXECUTE_NEVER | FULL_ACCESS | WRITE_THROUGH | FIRST_EIGHTH_LEFT_OUT | size(ITCM_BYTES)),
    ]
}

/// Sets the MPU's regions up and turns it on.
fn protect(mpu: &mut MPU, flash: FlashUse) {
    let regions = regions(flash);
    cortex_m::asm::dmb();
    // SAFETY: nothing runs from, has cached or keeps data in these regions yet: the arena was zeroed with the
    // caches still off, and the strip lies in the free part of the DTCM.
    unsafe {
        mpu.ctrl.write(0);
        for (number, (base, attributes)) in regions.into_iter().enumerate() {
            mpu.rnr.write(number as u32);
            mpu.rbar.write(base);
            mpu.rasr.write(attributes | rasr::ENABLE);
        }
        // PRIVDEFENA: everything else keeps the architecture's default attributes. HFNMIENA stays off.
        mpu.ctrl.write(0b101);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Returns base and RASR (attributes and size, ARMv7-M ARM B3.5.9) of an MPU region. For tests: nothing else
/// has to ask.
#[must_use]
pub fn protection(region: u8) -> (u32, u32) {
    cortex_m::interrupt::free(|_| {
        // SAFETY: selecting a region for reading changes none of them; interrupts are masked, so that nobody
        // selects another between.
        let mpu = unsafe { &*MPU::PTR };
        // SAFETY: as above; a number beyond the last region reads as zeros.
        unsafe { mpu.rnr.write(u32::from(region)) };
        (mpu.rbar.read() & !0x1F, mpu.rasr.read())
    })
}

/// The MPU's control register (ARMv7-M ARM B3.5.5).
#[must_use]
pub fn protection_control() -> u32 {
    // SAFETY: a read without side effects.
    unsafe { (*MPU::PTR).ctrl.read() }
}

const DTCM_END: u32 = 0x2002_0000;
/// Pattern that fills unused stack.
const PAINT: u32 = 0x5AFE_57AC;
/// Bytes left unpainted below the painting function's frame, for its own calls.
const PAINT_MARGIN_BYTES: u32 = 512;

fn stack_limit() -> u32 {
    (addr_of!(__euninit) as u32).next_multiple_of(STACK_GUARD_BYTES) + STACK_GUARD_BYTES
}

/// Whether this address lies in the guard of a stack.
#[must_use]
pub fn is_stack_guard(address: u32) -> bool {
    let below_main = (addr_of!(__euninit) as u32).next_multiple_of(STACK_GUARD_BYTES);
    [(below_main, STACK_GUARD_BYTES), (thread_stack::guard(), thread_stack::GUARD_BYTES as u32)]
        .iter()
        .any(|(guard, bytes)| (*guard..guard + bytes).contains(&address))
}

/// Returns the number of bytes to which the stack may grow before it meets the guard.
#[must_use]
pub fn stack_room_bytes() -> u32 {
    DTCM_END.saturating_sub(stack_limit())
}

/// Fills the free part of the main stack with a pattern, for [`main_stack_unused_bytes`]. Called when all is
/// up: from then on the stack is the interrupts' alone. Interrupts may come meanwhile, and have left the
/// stack again before painting goes on.
pub fn paint_main_stack() {
    let top = cortex_m::register::msp::read().saturating_sub(PAINT_MARGIN_BYTES);
    for address in (stack_limit()..top).step_by(4) {
        // SAFETY: between the statics' end and well below the present stack pointer, in DTCM: nothing lives
        // there.
        unsafe { (address as *mut u32).write_volatile(PAINT) };
    }
}

/// Returns the number of bytes of the main stack never touched since [`paint_main_stack`].
#[must_use]
pub fn main_stack_unused_bytes() -> u32 {
    // SAFETY: reads of DTCM words between the statics' end and its end.
    let untouched = |address: &u32| unsafe { (*address as *const u32).read_volatile() == PAINT };
    4 * (stack_limit()..DTCM_END).step_by(4).take_while(untouched).count() as u32
}

/// Returns the size of the statics in bytes, in DTCM, ITCM, AXI SRAM, SRAM1, SRAM2, SRAM4 and the DMA arena
/// together.
#[must_use]
pub fn static_bytes() -> u32 {
    const DTCM_START: u32 = 0x2000_0000;
    let length = |from: *const u32, to: *const u32| to as u32 - from as u32;
    (addr_of!(__euninit) as u32 - DTCM_START)
        + length(addr_of!(__saxizero), addr_of!(__eaxizero))
        + length(addr_of!(__saxisram), addr_of!(__eaxisram))
        + length(addr_of!(__sd2ram), addr_of!(__ed2ram))
        + length(addr_of!(__sdma_arena), addr_of!(__edma_arena))
        + length(addr_of!(__sitcm_data), addr_of!(__eitcm_data))
        + length(addr_of!(__skept), addr_of!(__ekept))
}
