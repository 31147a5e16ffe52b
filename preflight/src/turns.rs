//! Turns of a look ahead: it stops inside a line now and then, so that its caller gets on with other work.

use core::future::poll_fn;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

/// Ends a turn. No waker is kept: the polling caller knows when the next turn may be.
pub async fn end_turn() {
    let mut ended = false;
    poll_fn(|_| {
        if ended {
            return Poll::Ready(());
        }
        ended = true;
        Poll::Pending
    })
    .await;
}

/// Runs all turns, one after the other, where there is no other work.
pub(super) fn run_to_end<F: Future>(work: F) -> F::Output {
    let mut work = pin!(work);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(output) = work.as_mut().poll(&mut context) {
            return output;
        }
    }
}
