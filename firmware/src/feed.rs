//! The motion object as the step feed has it.

use motion::{Access, Motion};
use rtic::Mutex;

/// Motion object behind its RTIC lock.
pub struct Locked<'a, M>(pub &'a mut M);

impl<M: Mutex<T = &'static mut Motion>> Access for Locked<'_, M> {
    fn with<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        self.0.lock(|motion| f(motion))
    }
}
