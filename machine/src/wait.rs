//! The one primitive all waiting is made of: give the processor back once.

use core::future::poll_fn;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

/// Returns control to whoever polls, once. No waker is kept: the executor is polled again after every
/// interrupt.
pub async fn yield_once() {
    let mut yielded = false;
    poll_fn(|_| {
        if yielded {
            return Poll::Ready(());
        }
        yielded = true;
        Poll::Pending
    })
    .await;
}

/// Does something to its end that only waits so that others get their turns: where there are no others.
pub fn run_to_end<F: Future>(work: F) -> F::Output {
    let mut work = pin!(work);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(output) = work.as_mut().poll(&mut context) {
            return output;
        }
    }
}
