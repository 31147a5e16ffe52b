//! State of a laser along the trajectory: the law in force, the power that it gives, and what comes next.

use units::{TickTime, Ticks, tick_time, whole_ticks};

use crate::{LaserConfig, Law, Pending, PowerStore, levels::Entries};

/// Power steps of at most twice this share of the present power, where it changes with the speed...
const HALF_STEP: f32 = 0.01;
/// ...but no finer than twice this share of the power at the requested speed.
const LEAST_HALF_STEP: f32 = 0.003;
/// A change of power, relative to it, that is nothing but rounding.
const ROUNDING: f32 = 1e-4;
/// Steps of power on one stretch of trajectory, half a millisecond, at most.
const MOST_STEPS: u32 = 64;

/// A laser, if the machine has one. At the start all bits are zero.
#[derive(Debug)]
pub struct Laser {
    /// Properties of the laser.
    pub config: Option<LaserConfig>,
    /// Factor on every level, less one.
    factor_less_one: f32,
    /// Changes of level that the block in execution has not come to.
    entries: Entries,
    /// Level at the cursor.
    pub level: u16,
    /// Speed in mm/s below which constant power fades, as a hold is or was in force; zero: none.
    pub fade: f32,
    /// Seconds for which the machine has been as fast as before.
    pub faded: f64,
    /// Law that the filters' pending changes end with, unless it is not known.
    sent: Law,
    is_sent_known: bool,
    /// Law in force at the output.
    pub law: Law,
    /// Power at the output, before delays.
    shown: f32,
    /// Pulses and gaps that lost their beginning.
    pub swallowed: u32,
}

impl Laser {
    /// No laser.
    pub const NONE: Self = Self {
        config: None,
        factor_less_one: 0.0,
        entries: Entries { next: 0, end: 0 },
        level: 0,
        fade: 0.0,
        faded: 0.0,
        sent: Law::OFF,
        is_sent_known: false,
        law: Law::OFF,
        shown: 0.0,
        swallowed: 0,
    };

    /// Returns the factor on every level.
    #[must_use]
    pub const fn factor(&self) -> f32 {
        1.0 + self.factor_less_one
    }

    /// Sets the factor on every level.
    pub const fn set_factor(&mut self, factor: f32) {
        self.factor_less_one = factor - 1.0;
    }

    /// Returns the power at the output, a share of full power, before delays.
    #[must_use]
    pub const fn power(&self) -> f32 {
        self.shown
    }

    /// Takes up the levels of the block in execution, `level` being its first, from this distance on.
    #[inline(never)]
    pub fn run_block(&mut self, store: &PowerStore, block: u32, level: u16, travelled: f64) {
        (self.entries, self.level) = (store.levels.of(block), level);
        while let Some(step) = store.levels.first(self.entries).filter(|step| f64::from(step.distance) <= travelled) {
            self.entries.next = self.entries.next.wrapping_add(1);
            self.level = step.level;
        }
    }

    /// Takes the next change of level before this distance along the block in execution: the distance and how
    /// much the tag grows by there.
    #[inline(never)]
    pub fn next_step(&mut self, store: &PowerStore, before: f64) -> Option<(f64, u16)> {
        let step = store.levels.first(self.entries).filter(|step| f64::from(step.distance) < before)?;
        self.entries.next = self.entries.next.wrapping_add(1);
        self.level = step.level;
        Some((f64::from(step.distance), step.later))
    }

    /// The law in force holds for `seconds` from `from` on, while the speed changes evenly from `entry` to
    /// `exit`, mm/s.
    #[inline(never)]
    pub fn along(&mut self, store: &mut PowerStore, from: TickTime, seconds: f64, [entry, exit]: [f64; 2]) {
        let bounded = |power: f32| if power < 1.0 { power } else { 1.0 };
        let [mut first, mut last] = [entry, exit].map(|speed| bounded(self.law.power(speed) * self.factor()));
        if entry == 0.0 && exit == 0.0 {
            // Shapers may stand still between two pulses.
            (first, last) = (0.0, 0.0);
        }
        let finest = LEAST_HALF_STEP * f32::from(self.law.level) * self.factor() * (1.0 / 65_535.0);
        let band = |power: f32| if HALF_STEP * power > finest { HALF_STEP * power } else { finest };
        let off_by = |power: f32, shown: f32| if power > shown { power - shown } else { shown - power };
        if first == last || self.law.level == 0 {
            if off_by(first, self.shown) > ROUNDING * first || (first == 0.0) != (self.shown == 0.0) {
                self.show(store, from, first, true);
            }
            return;
        }
        let step = if last > first { 1.0 } else { -1.0 };
        let next = |power: f32| {
            let next = power + step * band(power);
            // Only an edge goes to zero.
            if next < 0.5 * finest { 0.5 * finest } else { bounded(next) }
        };
        if off_by(first, self.shown) > 1.001 * band(self.shown) {
            self.show(store, from, next(first), true);
        }
        for _ in 0..MOST_STEPS {
            let reached = self.shown + step * band(self.shown);
            let left = (last - reached) * step;
            if left.is_nan() || left <= 0.0 {
                break;
            }
            let share = (reached - first) / (last - first);
            let share = if share > 0.0 { f64::from(share) } else { 0.0 };
            self.show(store, from + tick_time(share * seconds), next(reached), false);
        }
    }

    /// The power is this from then on, before delays. An edge goes up or down with its own delay; what
    /// follows the speed keeps one delay, or its steps would change places.
    #[inline(never)]
    fn show(&mut self, store: &mut PowerStore, at: TickTime, power: f32, is_edge: bool) {
        let Some(config) = &self.config else { return };
        let delay = if is_edge && power < self.shown { config.off_delay } else { config.on_delay };
        let at = Ticks(whole_ticks(at).0.saturating_add_signed(i64::from(delay)));
        self.shown = power;
        self.swallowed = self.swallowed.saturating_add(store.changes.push(at, config.duty(power)));
    }

    /// The laser is off from then on, before delays.
    pub fn rest(&mut self, store: &mut PowerStore, at: TickTime) {
        self.law = Law::OFF;
        if self.shown != 0.0 {
            self.show(store, at, 0.0, true);
        }
    }

    /// This law holds from a time of the trajectory on.
    #[inline(never)]
    pub fn send(&mut self, store: &mut PowerStore, time: u64, law: Law) {
        if self.is_sent_known && self.sent == law {
            return;
        }
        if !store.pending.push(Pending { time, law })
            && let Some(last) = store.pending.last_mut()
        {
            // No room: what comes last counts, from the place of the one before on.
            last.law = law;
            self.swallowed = self.swallowed.saturating_add(1);
        }
        (self.sent, self.is_sent_known) = (law, true);
    }

    /// Forgets the laws that hold from this time of the trajectory on.
    #[inline(never)]
    pub fn take_back(&mut self, store: &mut PowerStore, time: u64) {
        while store.pending.last_mut().is_some_and(|last| last.time.wrapping_sub(time) as i64 >= 0) {
            store.pending.drop_last();
        }
        self.is_sent_known = false;
    }

    /// Forgets all power that is to come, as nothing of it is played.
    #[inline(never)]
    pub fn clear(&mut self, store: &mut PowerStore) {
        store.pending.clear();
        store.changes.clear();
        (self.entries, self.level, self.fade) = (Entries::default(), 0, 0.0);
        (self.law, self.sent, self.is_sent_known, self.shown) = (Law::OFF, Law::OFF, false, 0.0);
    }
}

impl PowerStore {
    /// Blocks from `first` up to that of count `behind`, which waits, have been put in front of it: the level
    /// does not change within them.
    #[inline(never)]
    pub fn skip_levels(&mut self, first: u32, behind: u32) {
        for n in 0..behind.wrapping_sub(first) {
            self.levels.skip(first.wrapping_add(n), behind);
        }
    }

    /// Shifts the laws to come in time.
    #[inline(never)]
    pub fn shift(&mut self, by: TickTime) {
        for index in 0..self.pending.len() {
            if let Some(pending) = self.pending.get_mut(index) {
                pending.time = pending.time.wrapping_add(by.to_bits() as u64);
            }
        }
    }
}
