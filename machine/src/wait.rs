//! The one primitive all waiting is made of: give the processor back once.

use core::future::poll_fn;
use core::task::Poll;

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
