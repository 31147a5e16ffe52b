//! How the executor rests while it waits.

/// What ends a rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// Whatever comes: bytes, an event of the card, a run of the step feed, so half a millisecond at most.
    Any,
    /// The same; and what is waited for comes with time alone (motion, heat, a moment), so that a world in
    /// which nothing else is new may let time pass at once.
    Time,
    /// Nothing need come: there is more to do. Whoever else has work gets a turn.
    AtOnce,
}

/// Rest. The one thing that takes time: every wait of the executor is made of calls of this.
pub trait Rest {
    /// Gives the processor to everybody else, once. May come back earlier than that.
    fn rest(&mut self, wake: Wake);
}
