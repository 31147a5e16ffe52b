//! The way from the machine into the boot stage.

use core::sync::atomic::{AtomicBool, Ordering};

use bsp_prime::{boot_request, time};
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

/// Asks for the firmware download, from any task: the dispatcher does what the command `dfu` does, and the
/// board is reset into the boot stage. False, and nothing happens, while the machine works.
#[allow(dead_code, reason = "for the USB function that takes the host's word for it")]
pub fn ask_for_download() -> bool {
    if !MAY_LEAVE.load(Ordering::Relaxed) {
        return false;
    }
    ASKED.store(true, Ordering::Relaxed);
    dispatcher::wake();
    true
}

/// For the dispatcher, at each of its turns: whether somebody has asked; and says for the next one whether he
/// may.
pub fn take_request(may_leave: bool) -> bool {
    if !HAS_RUN.load(Ordering::Relaxed) && time::now() > SECOND_PRESS {
        HAS_RUN.store(true, Ordering::Relaxed);
        boot_request::forget_button();
    }
    MAY_LEAVE.store(may_leave, Ordering::Relaxed);
    ASKED.swap(false, Ordering::Relaxed)
}
