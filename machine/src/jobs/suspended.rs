//! What a suspended job goes on with: `suspend` and `resume`, M600 and M601.

use config::FilamentChangeConfig;
use program::Kept;
use units::{Celsius, MAX_HEATERS, PerAxis};

/// What `resume` restores.
#[derive(Clone, Debug)]
pub struct Suspended {
    /// Machine position where the job stopped, mm.
    pub position: PerAxis<f64>,
    /// Modes and E of the program.
    pub kept: Kept,
    /// Targets of the heaters, in the order of the configuration; 0 for those that were off.
    pub targets: [Celsius; MAX_HEATERS],
    /// How filament has been drawn back or taken out, if it has.
    pub change: Option<FilamentChangeConfig>,
}
