//! State that a suspended job goes on with: `suspend` and `resume`, M600 and M601.

use config::FilamentChangeConfig;
use program::Kept;
use units::{AxisSet, Celsius, MAX_HEATERS, PerAxis};

/// State that `resume` restores.
#[derive(Clone, Debug)]
pub struct Suspended {
    /// Machine position where the job stopped, mm.
    pub position: PerAxis<f64>,
    /// Modes and E of the program.
    pub kept: Kept,
    /// Targets of the heaters, in the order of the configuration; 0 for those that were off.
    pub targets: [Celsius; MAX_HEATERS],
    /// The lengths by which filament was drawn back or taken out (M600), `None` where it was not.
    pub change: Option<FilamentChangeConfig>,
    /// Stall that has stopped the job.
    pub stall: Option<StalledJob>,
}

/// A job that a stall has stopped in the middle of a line.
#[derive(Clone, Copy, Debug)]
pub struct StalledJob {
    /// Axes that are to be homed before the job goes on.
    pub lost: AxisSet,
    /// Place at which the stalled line begins: its relative words count from there.
    pub begins: PerAxis<f64>,
    /// Machine height clear of everything that was made, mm.
    pub above: f64,
}
