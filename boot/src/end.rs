//! End of a boot stage that cannot go on: outputs off, then a restart. An interrupted update is finished
//! after it, as after a power failure.

use core::panic::PanicInfo;

use bsp_prime::board::make_outputs_safe;
use bsp_prime::boot_stage;
use cortex_m_rt::exception;

/// Resets the board, outputs off.
pub fn again() -> ! {
    cortex_m::interrupt::disable();
    make_outputs_safe();
    boot_stage::reset()
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    again()
}

#[exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    again()
}

#[exception]
unsafe fn DefaultHandler(_: i16) {
    again()
}
