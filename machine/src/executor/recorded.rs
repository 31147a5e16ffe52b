//! What the ring of events was last told of what is looked at every few milliseconds.

use program::State;
use units::{AxisSet, MAX_HEATERS};

/// What was last recorded.
#[derive(Debug, Default)]
pub(super) struct Recorded {
    pub state: State,
    pub homed: AxisSet,
    /// In degrees Celsius, whole: what a law or a tower changes by less is no news.
    pub targets: [i16; MAX_HEATERS],
}
