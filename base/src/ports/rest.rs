//! Rest of the executor while it waits.

/// Event that ends a rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// Any event: bytes, an event of the card, a run of the step feed, so a millisecond at most.
    Any,
    /// Any event; and the awaited one comes with time alone (motion, heat, a moment), so that a world in
    /// which nothing else is new may let time pass at once.
    Time,
    /// No event is needed: there is more to do. Other tasks with work get a turn.
    AtOnce,
}

/// Access to rest, the one thing that takes time: every wait of the executor is made of calls of
/// [`Rest::rest`].
pub trait Rest {
    /// Gives the processor to everybody else, once. May come back earlier than that.
    fn rest(&mut self, wake: Wake);
}
