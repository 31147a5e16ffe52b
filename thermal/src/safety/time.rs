//! Law of time: limits on the time for which a heater is driven.

use units::Micros;

use super::look::{HeatCause, Look};

/// Share of the heater's greatest output that counts as full output.
const FULL: f32 = 0.98;
/// Number of looks in a row with a pin on and no target that is a fault: a target may end between two ticks.
const FOR_NOBODY: u8 = 2;

/// Limits on the time for which a heater is driven; 0: no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeLimits {
    /// Time at full output without a pause.
    pub full: Micros,
    /// Time on at a single target.
    pub hold: Micros,
}

/// Times for which a heater has been driven.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Time {
    full_since: Option<Micros>,
    held_since: Option<Micros>,
    target: f32,
    for_nobody: u8,
}

impl Time {
    pub(super) fn check(&mut self, limits: &TimeLimits, full_share: f32, look: &Look) -> Result<(), HeatCause> {
        let is_full = look.driven >= FULL * full_share;
        self.full_since = is_full.then(|| self.full_since.unwrap_or(look.now));
        let is_same = look.is_on() && look.target.0 == self.target;
        // A heater that cools to its target, or is to become colder than the room, is not driven yet.
        let begins = look.is_on() && look.driven > 0.0;
        self.held_since = self.held_since.filter(|_| is_same).or(begins.then_some(look.now));
        self.target = look.target.0;
        let for_nobody = !look.is_on() && look.driven > 0.0;
        self.for_nobody = if for_nobody { self.for_nobody.saturating_add(1) } else { 0 };
        let ran_out = |limit: Micros, since: Option<Micros>| {
            limit > Micros(0) && since.is_some_and(|since| look.now.since(since) > limit)
        };
        if self.for_nobody >= FOR_NOBODY {
            Err(HeatCause::DrivenWithoutTarget)
        } else if ran_out(limits.full, self.full_since) {
            Err(HeatCause::FullTooLong(limits.full))
        } else if ran_out(limits.hold, self.held_since) {
            Err(HeatCause::HeldTooLong(limits.hold))
        } else {
            Ok(())
        }
    }
}
