//! Memory of the looks at inputs and faults, from one look to the next.

use base::failure::ShortText;
use base::slow_turning::SlowTurning;
use thermal::flow::Flow;
use units::Micros;

/// Due times of the looks, and memory between them.
#[derive(Debug, Default)]
pub(crate) struct Polls {
    pub due: Micros,
    pub kill_due: Micros,
    pub led_due: Micros,
    pub led_phase: u8,
    pub slow_turning: SlowTurning,
    pub flow: Flow,
    /// Earliest time of the next reports that nobody asks for.
    pub reports_due: Micros,
    /// A sequence makes drivers report stalls.
    pub ignores_stalls: bool,
    /// Fault of the line of saved settings that just ended.
    pub settings_problem: Option<ShortText>,
}
