//! Square roots by the double-precision FPU, which safe Rust without `std` does not offer.

/// Correctly rounded square roots, in one instruction.
pub static SQUARE_ROOT: fn(f64) -> f64 = square_root;

fn square_root(x: f64) -> f64 {
    let root: f64;
    // SAFETY: VSQRT.F64 (ARM DDI 0403E.b, A7.7.258) reads one register and writes another; its exceptions are
    // not trapped.
    unsafe {
        core::arch::asm!("vsqrt.f64 {root}, {x}", root = lateout(dreg_low16) root, x = in(dreg_low16) x, options(pure, nomem, nostack, preserves_flags));
    }
    root
}
