//! Free space of the image's stacks: during every test they stay far away from their ends.

use std::sync::OnceLock;

use rigless::emulator::Host;
use rigless::soc::Width;
use virtual_prime::image::Symbols;

use super::velvet::image;

/// Fill word of the firmware's main stack, `bsp-prime/src/memory.rs`. The executor's stack is zero at the
/// start.
const PAINT: u64 = 0x5AFE_57AC;
/// Size of the guard strips below the stacks, in the same file and in `thread_stack.rs`.
const GUARD_BYTES: u64 = 256;
/// End of DTCM, where the main stack begins (RM0399 section 2.3.2).
const DTCM_END: u64 = 0x2002_0000;
/// Least free space of the executor's stack, which is its margin (`bsp-prime/src/thread_stack.rs`).
const LEAST_OF_EXECUTOR_BYTES: u64 = 12 * 1024;
/// Least free space of the interrupts' stack.
const LEAST_OF_INTERRUPTS_BYTES: u64 = 8 * 1024;

/// Ends down to which the stacks of the image under test may grow.
#[derive(Clone, Copy)]
struct Limits {
    executor: u64,
    executor_end: u64,
    interrupts: u64,
}

fn limits() -> Limits {
    static LIMITS: OnceLock<Limits> = OnceLock::new();
    *LIMITS.get_or_init(|| {
        let symbols = Symbols::read(&image()).expect("an ELF file");
        let stack = symbols.object("thread_stack5STACK").expect("the executor's stack");
        let statics_end = symbols.object("__euninit").expect("the end of the statics").address;
        Limits {
            executor: stack.address + GUARD_BYTES,
            executor_end: stack.address + stack.size,
            interrupts: statics_end.next_multiple_of(GUARD_BYTES) + GUARD_BYTES,
        }
    })
}

/// Returns the number of bytes from `from` on that still are as they were at the start.
fn unused(host: &mut dyn Host, from: u64, to: u64, fresh: u64) -> u64 {
    let is_fresh = |address: &u64| host.read(*address, Width::W32).ok() == Some(fresh);
    4 * (from..to).step_by(4).take_while(is_fresh).count() as u64
}

/// Returns the free bytes of the executor's stack, and of the interrupts'; `None` where the image is not up.
pub fn left(host: &mut dyn Host) -> Option<(u64, u64)> {
    let Limits { executor, executor_end, interrupts } = limits();
    let of_interrupts = unused(host, interrupts, DTCM_END, PAINT);
    (of_interrupts > 0).then(|| (unused(host, executor, executor_end, 0), of_interrupts))
}

/// Asserts that both stacks have enough free space.
#[track_caller]
pub fn assert_enough((executor, interrupts): (u64, u64)) {
    println!("left of the stacks: {executor} bytes of the executor's, {interrupts} of the interrupts'");
    assert!(executor >= LEAST_OF_EXECUTOR_BYTES, "the executor's stack has {executor} bytes left");
    assert!(interrupts >= LEAST_OF_INTERRUPTS_BYTES, "the interrupts' stack has {interrupts} bytes left");
}
