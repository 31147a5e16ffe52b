//! Idle: the machine's executor as the one future there is, asleep between polls.

use core::convert::Infallible;
use core::future::Future;
use core::pin::pin;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use core::task::{Context, RawWaker, RawWakerVTable, Waker};

use bsp_prime::thread_stack;
use machine::ports::Ports;
use motion::{Access, Motion};
use rtic::Mutex;

use crate::log::Told;
use crate::usb;

/// There may be something to do.
static AWAKE: AtomicBool = AtomicBool::new(true);

/// How often the executor was polled: for whoever measures what holds it up.
static TURNS: AtomicU32 = AtomicU32::new(0);

/// Has the executor polled once more. Called by whoever brings it bytes, and by the feed at each run; the
/// step interrupt does not, or every step would cost a poll.
pub fn wake() {
    AWAKE.store(true, Ordering::Release);
}

/// The motion object behind its RTIC lock, as the feed wants it.
pub struct Locked<'a, M>(pub &'a mut M);

impl<M: Mutex<T = &'static mut Motion>> Access for Locked<'_, M> {
    fn with<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        self.0.lock(|motion| f(motion))
    }
}

/// Runs the executor for ever, on the thread stack: its state is larger than DTCM.
pub fn run<P: Ports>(ports: impl FnOnce() -> P) -> ! {
    thread_stack::run(move || poll_for_ever(ports()))
}

/// A waker that calls [`wake`]: there is one executor, so it knows nothing.
const WAKER: RawWaker = RawWaker::new(core::ptr::null(), &WAKES);
static WAKES: RawWakerVTable = RawWakerVTable::new(|_| WAKER, |_| wake(), |_| wake(), |_| ());

fn poll_for_ever(ports: impl Ports) -> Infallible {
    let mut machine = pin!(machine::run(ports));
    // SAFETY: the functions of its table look at no data, so any pointer will do, in any thread.
    let waker = unsafe { Waker::from_raw(WAKER) };
    // What it waits for is announced by `wake`; it wakes itself where it has more to do than to wait.
    let mut context = Context::from_waker(&waker);
    let mut told = Told::from_here();
    loop {
        // It never ends, so there is nothing in the answer.
        let _pending = machine.as_mut().poll(&mut context).is_pending();
        told.tell();
        TURNS.store(TURNS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
        usb::look_for_room();
        while !AWAKE.swap(false, Ordering::Acquire) {
            // An interrupt that calls `wake` between the test and the sleep is seen half a millisecond later,
            // by the feed's.
            rtic::export::wfi();
        }
    }
}
