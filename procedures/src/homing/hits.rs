//! End of an approach: the positions of the axes, or the reason why homing failed.

use base::failure::{Failure, Texts};
use base::ports::Wake;
use base::reason::{Alarm, Reason};
use config::MachineConfig;
use motion::{Motion, Trigger};
use units::{Axis, AxisSet, PerAxis};

use super::switches::switch_of;
use crate::endstop_phase::PhaseHands;

/// Positions of axes when their switches closed, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hits {
    pub(super) at: PerAxis<f64>,
    /// Axes without a known position: a switch that another one's stop ran into has no tick of its own.
    pub(super) unsure: AxisSet,
    /// Whether the motors have been stopped at once, and may have lost steps.
    pub(super) was_cut: bool,
}

/// Waits until the move has ended, by itself or by a trigger.
///
/// # Errors
/// [`Failure::HALTED`].
pub fn wait_trigger<'c>(hands: &mut impl PhaseHands<'c>) -> Result<Option<Trigger>, Failure> {
    hands.standstill()?;
    // The feed sees an input that fires at the very last step only at its next run.
    while hands.latch().fired().is_some() {
        hands.wait(Wake::Any).unless_halted()?;
    }
    Ok(hands.motion(Motion::take_trigger))
}

/// Returns the failure of an axis' homing.
pub(super) fn alarm(texts: &Texts, config: &MachineConfig, axis: Axis, number: Alarm, what: &str) -> Failure {
    let name = switch_of(config, axis).map_or("?", |(_, stop)| stop.name.as_str());
    texts.alarm(format_args!("{} {name}: {what}", axis.letter())).with_reason(Reason::Locked).with_alarm(number)
}
