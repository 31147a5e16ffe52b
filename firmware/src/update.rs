//! The way from the machine into the boot stage.

use core::sync::atomic::{AtomicBool, Ordering};

use bsp_prime::boot_request;
use units::Micros;

use crate::dispatcher;

/// Until then a second press of RESET is a request for the download.
const SECOND_PRESS: Micros = Micros::from_seconds(1);

/// A host has asked for the firmware download.
static ASKED: AtomicBool = AtomicBool::new(false);
/// The machine could be left now: nothing moves, heats or plays.
static MAY_LEAVE: AtomicBool = AtomicBool::new(false);
/// The button's mark is taken away.
static HAS_RUN: AtomicBool = AtomicBool::new(false);

/// A host asks for the firmware download, from any task: the machine does what its command `dfu` does, and
/// the board is reset into the boot stage. False, and nothing happens, while the machine works.
pub fn ask_for_download() -> bool {
    if !MAY_LEAVE.load(Ordering::Relaxed) {
        return false;
    }
    ASKED.store(true, Ordering::Relaxed);
    dispatcher::wake();
    true
}

/// Whether the machine could be left now.
pub fn set_may_leave(may_leave: bool) {
    MAY_LEAVE.store(may_leave, Ordering::Relaxed);
}

/// Whether a host has asked; once.
pub fn take_request() -> bool {
    ASKED.swap(false, Ordering::Relaxed)
}

/// The application runs, for so long: the next press of RESET is a first one again.
pub fn has_run(since_start: Micros) {
    if !HAS_RUN.load(Ordering::Relaxed) && since_start > SECOND_PRESS {
        HAS_RUN.store(true, Ordering::Relaxed);
        boot_request::forget_button();
    }
}
