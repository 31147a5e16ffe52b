//! Data of atomics that tasks share without a lock.

use base::tasks::ReachedMark;
use base::watchdog::Reports;
use motion::Latch;

/// Ticks at which inputs stopped motion.
pub static LATCH: Latch = Latch::new();
/// Reached positions of the motors, from the feed to the heat task.
pub static REACHED: ReachedMark = ReachedMark::new();
/// Reports of live tasks since the watchdog was fed.
pub static REPORTS: Reports = Reports::new();
