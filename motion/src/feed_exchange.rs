//! Values that the step feed and the motion object exchange, under the lock.

use units::{MAX_ACTUATORS, PerActuator, StepCount};

use crate::{feed_schedule::Lead, motor::MotorSetup};

/// Report of the feed to the motion object at the end of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FeedReport {
    /// Steps played, as of the last look.
    pub played: PerActuator<StepCount>,
    /// Nothing is left to play or to write.
    pub drained: bool,
}

impl FeedReport {
    /// Report of a feed that has played nothing yet.
    pub const RESTING: Self = Self { played: PerActuator([0; MAX_ACTUATORS]), drained: true };
}

/// Answer of the motion object to the feed's request for a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Supply {
    /// A segment was handed out.
    Segment,
    /// Nothing yet: it must be asked again. So no lock is held for long where much trajectory must be settled
    /// at once.
    Later,
    /// Nothing that ends soon enough: the steps written already are enough.
    Enough,
    /// Nothing to execute at present.
    Nothing,
}

/// Orders of the motion object to the feed, taken at the beginning of each run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FeedOrders {
    /// Stop playing at once.
    pub cut: bool,
    /// The motors' positions were declared anew.
    pub rebase: Option<PerActuator<StepCount>>,
    /// The motors were configured anew.
    pub setup: Option<PerActuator<MotorSetup>>,
    /// A switch or the probe is being searched for: runs are by period.
    pub searching: bool,
    /// Lead over the motors when the feed runs on demand.
    pub lead: Lead,
}
