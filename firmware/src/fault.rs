//! Fatal errors: a panic, a fault of the processor, a crystal that stops or a board that does not come up.
//! Outputs off first, then a report over RTT and for the next start, then a reset.
//!
//! The controller's image has this file as well: nothing here knows a machine.

use core::fmt::{Arguments, Write};
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};

use bsp_prime::BoardError;
use bsp_prime::board::make_outputs_safe;
use bsp_prime::last_words::{self, Text};
use bsp_prime::{kept, log, rtt, time};
use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;
use events::Event;
use units::Micros;

/// A panic while reporting must not report again.
static REPORTED: AtomicBool = AtomicBool::new(false);

/// Time for a debug probe to drain the log before the reset clears it.
const REPORT_DRAIN_US: u32 = 100_000;

fn end(report: impl FnOnce()) -> ! {
    cortex_m::interrupt::disable();
    make_outputs_safe();
    if !REPORTED.swap(true, Ordering::Relaxed) {
        // The log may have been in the middle of a line.
        log::take_over();
        report();
        bsp_prime::wait::pause(REPORT_DRAIN_US);
    }
    SCB::sys_reset()
}

/// Ends with this message, which the next start reports.
fn end_with(words: Arguments<'_>) -> ! {
    end_at(time::now(), words)
}

fn end_at(now: Micros, words: Arguments<'_>) -> ! {
    end(|| {
        let mut text = Text::new();
        // Text without room is cut.
        let _ = text.write_fmt(words);
        last_words::leave(&text);
        kept::events().record(now, &Event::Ended(events::Text::from(text.as_str())));
        defmt::error!("{=str}", text.as_str());
    })
}

/// Resets the board on request of a person or a host.
pub fn reset_as_asked() -> ! {
    end(|| defmt::info!("reset as asked"))
}

/// Ends at a fall of the chip's own supply: motors cannot be held by drivers that have no logic supply
/// either.
pub fn supply_falls() -> ! {
    end_with(format_args!("the 3.3 V supply fell below 2.8 V: check the 24 V and 5 V supply"))
}

/// Ends with a report that the board did not come up.
pub fn board_failed(error: BoardError) -> ! {
    if let Some(ends) = rtt::start() {
        log::start(ends.log);
    }
    // The clock of the events does not run yet.
    end_at(Micros(0), format_args!("board: {error:?}"))
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    match info.location() {
        // The file first: a text may lose its end.
        Some(place) => end_with(format_args!("panic at {}:{}", place.file(), place.line())),
        None => end_with(format_args!("panic")),
    }
}

/// Ends at an unexpected interrupt.
#[exception]
unsafe fn DefaultHandler(number: i16) {
    end_with(format_args!("unexpected interrupt {number}"));
}

/// The crystal has stopped (RM0399 rev 4 section 9.5.3); no other source of this interrupt is on.
#[exception]
unsafe fn NonMaskableInt() {
    end_with(format_args!("the 25 MHz crystal stopped"));
}

/// Hands over the place of the fault. The overflowed stack may be the one that this handler runs on, and then
/// the processor could not store the frame, and the first push would lock it up (ARMv7-M ARM B1.5.15): so the
/// main stack begins anew. Nothing returns to its old contents.
#[unsafe(naked)]
// SAFETY: the name is the one that the vector table of `cortex-m-rt` refers to; nobody else defines it.
#[unsafe(no_mangle)]
#[allow(non_snake_case, reason = "the vector table's name")]
extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        // Bit 2 of EXC_RETURN: the frame is on the process stack (B1.5.8).
        "tst lr, #4",
        "ite eq",
        "mrseq r3, msp",
        "mrsne r3, psp",
        // CFSR; MSTKERR and STKERR say that there is no frame (B3.2.15).
        "movw r2, #0xED28",
        "movt r2, #0xE000",
        "ldr r2, [r2]",
        "movs r0, #0",
        "movs r1, #0",
        "movw r12, #0x1010",
        "tst r2, r12",
        "bne 1f",
        // The frame's PC and LR (B1.5.6).
        "ldr r0, [r3, #24]",
        "ldr r1, [r3, #20]",
        "1:",
        "movw r3, #:lower16:_stack_start",
        "movt r3, #:upper16:_stack_start",
        "msr msp, r3",
        "b {report}",
        report = sym hard_fault,
    )
}

/// MemManage fault: MMARVALID of CFSR, MMFAR holds the address (ARMv7-M ARM B3.2.15, B3.2.17).
const ADDRESS_VALID: u32 = 1 << 7;
/// MSTKERR and STKERR of CFSR.
const NO_FRAME: u32 = 0x1010;

extern "C" fn hard_fault(pc: u32, lr: u32, status: u32) -> ! {
    // SAFETY: a read without side effects.
    let address = unsafe { (*SCB::PTR).mmfar.read() };
    let overflowed =
        status & NO_FRAME != 0 || status & ADDRESS_VALID != 0 && bsp_prime::memory::is_stack_guard(address);
    if overflowed {
        end_with(format_args!("stack overflow at {pc:#010x}"))
    }
    end_with(format_args!("hard fault at {pc:#010x}, called from {lr:#010x}, status {status:#x}"))
}
