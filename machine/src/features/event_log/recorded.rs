//! Values that the ring of events was last told, of those looked at every few milliseconds.

use program::State;
use units::{AxisSet, MAX_HEATERS};

/// Values that were recorded last.
#[derive(Debug, Default)]
pub(crate) struct Recorded {
    pub state: State,
    pub homed: AxisSet,
    /// Targets in whole degrees Celsius: smaller changes by a law or a tower are no news.
    pub targets: [i16; MAX_HEATERS],
}
