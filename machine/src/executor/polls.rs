//! What the looks at inputs and faults remember from one to the next.

use units::Micros;

use crate::failure::ShortText;
use crate::melt::Flow;
use crate::slow_turning::SlowTurning;
use crate::stall_watch::StallWatch;

/// When what is due, and what is remembered between two looks.
#[derive(Debug, Default)]
pub(super) struct Polls {
    pub due: Micros,
    pub kill_due: Micros,
    pub led_due: Micros,
    pub led_phase: u8,
    pub slow_turning: SlowTurning,
    pub flow: Flow,
    pub heat_due: Micros,
    /// When somebody may next be told what is told by itself.
    pub reports_due: Micros,
    pub stalls: StallWatch,
    /// A sequence makes drivers say stall.
    pub ignores_stalls: bool,
    /// What was wrong with the line of saved settings that just ended.
    pub settings_problem: Option<ShortText>,
}
