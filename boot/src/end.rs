//! When the boot stage cannot go on: outputs off, and from the beginning. Whatever it was about is finished
//! then, as after a power failure.

use core::panic::PanicInfo;

use bsp_prime::board::make_outputs_safe;
use bsp_prime::boot_stage;
use cortex_m_rt::exception;

/// Begins again.
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
