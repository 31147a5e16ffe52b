//! Hard limits: a move that hits an endstop with `limit_enable` halts the machine.
//!
//! A limit guards once it has been open for [`REARM_TIME`]; a limit that is still operated (after homing,
//! say) or bounces while it is left does not stop the move that leaves it. While armed, the input's interrupt
//! stops motion through the latch; the poll here notices and halts.
//!
//! A search with the probe has the latch to itself, and may end where a limit closes too: Z's switch beside
//! the bed it probes. So in a search a limit that closes halts only when the machine goes on past it.

use config::MachineConfig;
use motion::Latch;
use units::{Axis, Micros, PerAxis};

use crate::ports::{Input, InputLevels};

/// Greatest distance of a carriage at rest past the point where its switch closed, mm: the give of the levers
/// of common switches, with room to spare.
pub const OVERTRAVEL: f64 = 0.3;
/// Distance that a search may go on past a limit, mm, to the contact that ends it: as far as past any switch.
const PAST_A_LIMIT: f64 = OVERTRAVEL;
/// Time for which a limit must have been open before it guards again.
const REARM_TIME: Micros = Micros::from_millis(50);

/// State of the limits.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Inputs that are limits.
    mask: u32,
    /// Limits that guard now.
    guarding: u32,
    /// Time since which no limit has been seen to change.
    quiet_since: Micros,
    /// Levels at the last poll.
    levels: u32,
    /// Whether a search has the latch.
    searching: bool,
    /// Position of the machine when a limit closed during the search.
    closed_at: Option<PerAxis<f64>>,
    /// Whether a limit was hit, and not all guard again yet.
    was_hit: bool,
}

/// A limit that was hit: its place in the configuration's list of endstops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hit(pub usize);

impl Limits {
    /// Takes the limits from the configuration.
    pub fn configure(&mut self, config: &MachineConfig, now: Micros) {
        let limits = config.endstops.iter().enumerate().filter(|(_, stop)| stop.limit_enable && stop.pin.is_some());
        self.mask = limits.fold(0, |bits, (index, _)| bits | Input::Endstop(index as u8).bit());
        self.quiet_since = now;
    }

    /// Returns whether there are any limits.
    #[must_use]
    pub const fn exist(&self) -> bool {
        self.mask != 0
    }

    /// Returns whether a search has the latch.
    #[must_use]
    pub const fn is_searching(&self) -> bool {
        self.searching
    }

    /// Polls the limits. With `moving`, a hit must halt the machine; `here` is the position of the motors.
    pub fn poll(
        &mut self,
        levels: InputLevels,
        moving: bool,
        latch: &Latch,
        now: Micros,
        here: impl FnOnce() -> PerAxis<f64>,
    ) -> Option<Hit> {
        let hit = self.guarding & levels.mask();
        if hit != 0 && moving && self.counts(latch, here) {
            self.guarding = 0;
            self.was_hit = true;
            latch.disarm();
            return Some(Hit(hit.trailing_zeros() as usize));
        }
        if !self.searching
            && let Some(guarding) = self.update(levels.mask(), now)
        {
            self.guarding = guarding;
            latch.arm(guarding);
        }
        None
    }

    /// Returns true once when all limits guard again after a hit.
    pub const fn take_all_clear(&mut self) -> bool {
        let all_clear = self.was_hit && self.guarding == self.mask;
        self.was_hit &= !all_clear;
        all_clear
    }

    /// Returns the limits that should guard given these levels; `None` while they are unchanged.
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

    /// Returns whether a limit that closed must stop the machine: always, but for a search that ends there.
    fn counts(&mut self, latch: &Latch, here: impl FnOnce() -> PerAxis<f64>) -> bool {
        if !self.searching {
            return true;
        }
        // The contact has been found, so the machine brakes already.
        if latch.armed() == 0 {
            return false;
        }
        let here = here();
        let at = *self.closed_at.get_or_insert(here);
        Axis::PRIMARY.into_iter().any(|axis| libm::fabs(here[axis] - at[axis]) > PAST_A_LIMIT)
    }

    /// Suspends the limits, since homing takes the latch for itself.
    pub fn suspend(&mut self, latch: &Latch, now: Micros) {
        self.guarding = 0;
        self.quiet_since = now;
        latch.disarm();
    }

    /// Gives the latch to a search. The limits that guard now still do, by the poll alone.
    pub const fn search_begins(&mut self) {
        self.searching = true;
        self.closed_at = None;
    }

    /// Ends the search. Limits guard again once they are open.
    pub fn search_ends(&mut self, latch: &Latch, now: Micros) {
        self.searching = false;
        self.suspend(latch, now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_guards_only_after_it_has_been_open_for_a_while() {
        let mut watch = Limits { mask: 0b11, ..Limits::default() };
        let course = [
            (0, 0b01, None),
            (100, 0b01, Some(0b10)),
            // The limit is left, with a bounce.
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

    fn closed() -> InputLevels {
        InputLevels::default().with(Input::Endstop(2))
    }

    /// Limits of X and Y that guard, and the latch.
    fn guarding() -> (Limits, Latch) {
        let text = "[endstops]\nx.enable = true\nx.pin = PD0\nx.axis = X\nx.limit_enable = true\n\
                    y.enable = true\ny.pin = PD1\ny.axis = Y\ny.limit_enable = true\n\
                    z.enable = true\nz.pin = PI0\nz.axis = Z\n\
                    a.enable = true\na.pin = nc\na.axis = A\na.limit_enable = true\n";
        let (config, _) = config::parse(text.as_bytes(), config::BoardId::Prime2590, &mut ());
        assert_eq!(config.endstops.len(), 4);
        let (mut limits, latch) = (Limits::default(), Latch::new());
        limits.configure(&config, Micros(0));
        let now = REARM_TIME;
        assert_eq!(limits.poll(InputLevels::default(), false, &latch, now, PerAxis::default), None);
        (limits, latch)
    }

    #[test]
    fn only_switches_with_a_pin_that_are_limits_guard() {
        let (limits, latch) = guarding();
        assert!(limits.exist() && latch.armed() == 0b110, "{:#b}", latch.armed());
        assert!(!Limits::default().exist());
    }

    #[test]
    fn a_limit_that_closes_in_motion_is_a_hit_once() {
        let (mut limits, latch) = guarding();
        let now = Micros::from_millis(100);
        assert_eq!(limits.poll(closed(), true, &latch, now, || unreachable!()), Some(Hit(2)));
        assert_eq!((latch.armed(), limits.poll(closed(), true, &latch, now, || unreachable!())), (0, None));
        assert!(!limits.take_all_clear());
        let open = InputLevels::default();
        limits.poll(open, false, &latch, now, || unreachable!());
        limits.poll(open, false, &latch, now.plus(REARM_TIME), || unreachable!());
        assert!(limits.take_all_clear() && !limits.take_all_clear(), "told once");
    }

    #[test]
    fn a_limit_that_closes_at_standstill_is_no_hit_and_guards_no_more() {
        let (mut limits, latch) = guarding();
        assert_eq!(limits.poll(closed(), false, &latch, Micros::from_millis(100), || unreachable!()), None);
        assert_eq!(latch.armed(), 0b010);
    }

    #[test]
    fn a_search_may_go_a_little_past_a_limit_to_its_contact() {
        let place = |mm: f64| {
            let mut place = PerAxis::default();
            place[Axis::Z] = mm;
            place
        };
        let now = Micros::from_millis(100);
        for (way, is_hit) in [(0.29, false), (-0.29, false), (0.31, true), (-0.31, true)] {
            let (mut limits, latch) = guarding();
            limits.search_begins();
            latch.arm(Input::Probe.bit());
            assert_eq!(limits.poll(closed(), true, &latch, now, || place(5.0)), None, "it has just closed");
            assert_eq!(limits.poll(closed(), true, &latch, now, || place(5.0 + way)).is_some(), is_hit, "{way} mm");
        }
        let (mut limits, latch) = guarding();
        limits.search_begins();
        latch.disarm();
        assert_eq!(limits.poll(closed(), true, &latch, now, || unreachable!()), None, "the contact has been found");
        limits.search_ends(&latch, now);
        assert_eq!((limits.is_searching(), latch.armed()), (false, 0));
    }
}
