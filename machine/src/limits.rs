//! Hard limits: an endstop with `limit_enable` that is hit by a move halts.
//!
//! A limit guards once it has been open for [`REARM_TIME`]; one that is still operated (after homing, say) or bounces while
//! it is left does not stop the move that leaves it. While armed, the input's interrupt stops motion through the latch;
//! the poll here notices and halts.
//!
//! A search with the probe has the latch to itself, and may end where a limit closes too: Z's switch beside the bed it probes.
//! So in a search a limit that closes halts only when the machine goes on past it.

use config::MachineConfig;
use units::{Axis, Micros, PerAxis};

use crate::controller::Controller;
use crate::ports::{Input, Ports};
use crate::state::State;

/// A search may go on this far past a limit, mm, to the contact that ends it: as far as past any switch.
const PAST_A_LIMIT: f64 = crate::stopping::OVERTRAVEL;
/// A limit must have been open this long before it guards again.
const REARM_TIME: Micros = Micros::from_millis(50);

/// Which limits guard.
#[derive(Clone, Copy, Debug, Default)]
pub struct LimitWatch {
    /// Inputs that are limits.
    mask: u32,
    /// Limits that guard now.
    guarding: u32,
    /// Since when no limit has been seen to change.
    quiet_since: Micros,
    /// Levels at the last poll.
    levels: u32,
    /// A search has the latch.
    searching: bool,
    /// Where the machine was when a limit closed during the search.
    closed_at: Option<PerAxis<f64>>,
}

impl LimitWatch {
    /// Takes the limits from the configuration.
    pub fn configure(&mut self, config: &MachineConfig, now: Micros) {
        let limits = config.endstops.iter().enumerate().filter(|(_, stop)| stop.limit_enable && stop.pin.is_some());
        self.mask = limits.fold(0, |bits, (index, _)| bits | Input::Endstop(index as u8).bit());
        self.quiet_since = now;
    }

    /// The limits that should guard given these levels; `None` while that is unchanged.
    fn update(&mut self, levels: u32, now: Micros) -> Option<u32> {
        let levels = levels & self.mask;
        if levels != self.levels {
            self.levels = levels;
            self.quiet_since = now;
        }
        let open = self.mask & !levels;
        let wanted = if now.since(self.quiet_since) >= REARM_TIME { open } else { self.guarding & open };
        (wanted != self.guarding).then_some(wanted)
    }
}

impl<P: Ports> Controller<P> {
    /// One poll of the limits.
    pub(crate) fn watch_limits(&mut self) {
        if self.limits.mask == 0 || matches!(self.state, State::Home | State::Halt | State::Hold { homing: true }) {
            return;
        }
        let levels = self.ports.inputs();
        let hit = self.limits.guarding & levels.0;
        let moving = self.state != State::Idle;
        if hit != 0 && moving && self.is_hit(hit) {
            self.limit_hit(hit);
        }
        if self.limits.searching {
            return;
        }
        let now = self.ports.now();
        if let Some(guarding) = self.limits.update(levels.0, now) {
            self.limits.guarding = guarding;
            self.ports.latch().arm(guarding);
        }
    }

    /// Whether a limit that closed must stop the machine: always, but for a search that ends there.
    fn is_hit(&mut self, hit: u32) -> bool {
        if !self.limits.searching || hit == 0 {
            return true;
        }
        // The contact has been found: it brakes.
        if self.ports.latch().armed() == 0 {
            return false;
        }
        let here = self.live_position();
        let at = *self.limits.closed_at.get_or_insert(here);
        Axis::PRIMARY.into_iter().any(|axis| libm::fabs(here[axis] - at[axis]) > PAST_A_LIMIT)
    }

    fn limit_hit(&mut self, hit: u32) {
        let index = hit.trailing_zeros() as usize;
        let name = self.config.endstops.get(index).map(|stop| (stop.name.clone(), stop.axis));
        let (name, axis) = name.unwrap_or_default();
        let letter = axis.map_or('?', |axis| axis.letter());
        self.limits.guarding = 0;
        self.ports.latch().disarm();
        self.halt(format_args!("ALARM: Hard limit {letter} was hit ({name})\n// WARNING hard limits are disabled until all have been cleared\n"));
    }

    /// Homing takes the latch for itself.
    pub(crate) fn suspend_limits(&mut self) {
        self.limits.guarding = 0;
        self.limits.quiet_since = self.ports.now();
        self.ports.latch().disarm();
    }

    /// A search takes the latch. The limits that guard now still do, by the poll alone.
    pub(crate) fn search_takes_latch(&mut self) {
        self.limits.searching = true;
        self.limits.closed_at = None;
    }

    /// The search is over. Limits guard again once they are open.
    pub(crate) fn search_returns_latch(&mut self) {
        self.limits.searching = false;
        self.suspend_limits();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_guards_only_after_it_has_been_open_for_a_while() {
        let mut watch = LimitWatch { mask: 0b11, ..LimitWatch::default() };
        let course = [
            (0, 0b01, None),
            (100, 0b01, Some(0b10)),
            // Left, with a bounce.
            (110, 0b00, None),
            (120, 0b01, None),
            (130, 0b00, None),
            (170, 0b00, None),
            (181, 0b00, Some(0b11)),
        ];
        for (millis, levels, expected) in course {
            let update = watch.update(levels, Micros::from_millis(millis));
            assert_eq!(update, expected, "at {millis} ms");
            watch.guarding = update.unwrap_or(watch.guarding);
        }
    }
}
