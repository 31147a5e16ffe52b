//! The end of the line: what a panic, a hard fault or a board that will not come up do. Outputs off first,
//! then a report, then a reset.

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};

use bsp_prime::BoardError;
use bsp_prime::board::make_outputs_safe;
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};

/// A panic while reporting must not report again.
static REPORTED: AtomicBool = AtomicBool::new(false);

/// Time for a debug probe to drain the log before the reset clears it.
const REPORT_DRAIN_US: u32 = 100_000;

fn end(report: impl FnOnce()) -> ! {
    cortex_m::interrupt::disable();
    make_outputs_safe();
    if !REPORTED.swap(true, Ordering::Relaxed) {
        report();
        bsp_prime::wait::pause(REPORT_DRAIN_US);
    }
    SCB::sys_reset()
}

/// A reset that a person or a host asked for.
pub fn reset_as_asked() -> ! {
    end(|| defmt::info!("reset as asked"))
}

/// The board did not come up.
pub fn board_failed(error: BoardError) -> ! {
    end(|| defmt::error!("board: {}", defmt::Debug2Format(&error)))
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    end(|| defmt::error!("panic: {}", defmt::Display2Format(info)))
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    end(|| defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr()))
}
