//! Modulation of slow outputs: heaters, fans, valves, and solid-state relays.
//!
//! Sigma-delta of first order: each tick adds the duty to an accumulator; an overflow is an on-tick. Over 255
//! ticks an output is on for exactly `duty` of them, spread as evenly as can be, and the finest share still
//! switches only a few hundred times a second, which MOSFETs and fans take.
//!
//! Outputs that must not switch so often, as a relay that waits for mains to cross zero, have a cycle: they
//! are on once in each, and fractions of ticks are carried to the next.

use units::{Duty, Micros};

use crate::io::{MAX_HEATERS, MAX_SWITCHES, heater_bit, switch_bit};

/// Modulation ticks per second.
pub const MODULATION_HZ: u32 = 2_000;
const FULL: u32 = Duty::FULL.0 as u32;

/// Modulator of a single output.
#[derive(Clone, Copy, Debug, Default)]
struct Modulator {
    duty: u8,
    sum: u16,
    /// Ticks of a cycle; 0: as fine as can be.
    cycle: u16,
    /// Tick within the cycle, and number of ticks for which the output is on in it.
    place: u16,
    on: u16,
}

impl Modulator {
    #[inline]
    fn tick(&mut self) -> bool {
        if self.cycle > 0 {
            return self.cycle_tick();
        }
        self.sum += self.duty as u16;
        let on = self.sum >= 255;
        if on {
            self.sum -= 255;
        }
        on
    }

    fn cycle_tick(&mut self) -> bool {
        if self.place == 0 {
            let due = u32::from(self.duty) * u32::from(self.cycle) + u32::from(self.sum);
            (self.on, self.sum) = ((due / FULL) as u16, (due % FULL) as u16);
        }
        let on = self.place < self.on;
        self.place = if self.place + 1 < self.cycle { self.place + 1 } else { 0 };
        on
    }

    fn set(&mut self, duty: Duty) {
        self.duty = duty.0;
        if duty == Duty::OFF {
            // Off takes effect at once, in the middle of a cycle too.
            (self.sum, self.place, self.on) = (0, 0, 0);
        }
    }

    fn set_cycle(&mut self, cycle: Micros) {
        let ticks = cycle.0 * u64::from(MODULATION_HZ) / 1_000_000;
        (self.cycle, self.place) = (ticks.min(u64::from(u16::MAX)) as u16, 0);
    }
}

/// The modulators of all outputs.
#[derive(Debug)]
pub struct Modulators {
    heaters: [Modulator; MAX_HEATERS],
    switches: [Modulator; MAX_SWITCHES],
}

impl Default for Modulators {
    fn default() -> Self {
        Self::new()
    }
}

impl Modulators {
    /// Creates modulators with everything off.
    #[must_use]
    pub const fn new() -> Self {
        const OFF: Modulator = Modulator { duty: 0, sum: 0, cycle: 0, place: 0, on: 0 };
        Self { heaters: [OFF; MAX_HEATERS], switches: [OFF; MAX_SWITCHES] }
    }

    /// Sets a heater's duty.
    pub fn set_heater(&mut self, index: usize, duty: Duty) {
        if let Some(modulator) = self.heaters.get_mut(index) {
            modulator.set(duty);
        }
    }

    /// Sets a switch's duty.
    pub fn set_switch(&mut self, index: usize, duty: Duty) {
        if let Some(modulator) = self.switches.get_mut(index) {
            modulator.set(duty);
        }
    }

    /// Sets the cycle in which a heater is on once; 0: as often as can be.
    pub fn set_heater_cycle(&mut self, index: usize, cycle: Micros) {
        if let Some(modulator) = self.heaters.get_mut(index) {
            modulator.set_cycle(cycle);
        }
    }

    /// Sets the cycle in which a switch is on once; 0: as often as can be.
    pub fn set_switch_cycle(&mut self, index: usize, cycle: Micros) {
        if let Some(modulator) = self.switches.get_mut(index) {
            modulator.set_cycle(cycle);
        }
    }

    /// Returns a switch's duty.
    pub fn switch(&self, index: usize) -> Duty {
        self.switches.get(index).map_or(Duty::OFF, |modulator| Duty(modulator.duty))
    }

    /// Switches all heaters off.
    pub fn heaters_off(&mut self) {
        for modulator in &mut self.heaters {
            modulator.set(Duty::OFF);
        }
    }

    /// Runs a tick; returns the bits of the outputs that are on.
    #[inline]
    pub fn tick(&mut self) -> u32 {
        let mut on = 0;
        for (index, modulator) in self.heaters.iter_mut().enumerate() {
            if modulator.tick() {
                on |= heater_bit(index);
            }
        }
        for (index, modulator) in self.switches.iter_mut().enumerate() {
            if modulator.tick() {
                on |= switch_bit(index);
            }
        }
        on
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    #[test]
    fn an_output_is_on_for_exactly_its_share() {
        for duty in 0..=255_u8 {
            let mut modulators = Modulators::new();
            modulators.set_switch(3, Duty(duty));
            let on = (0..255 * 4).filter(|_| modulators.tick() == switch_bit(3)).count();
            assert_eq!(on, duty as usize * 4, "duty {duty}");
        }
    }

    #[test]
    fn one_with_a_cycle_is_on_once_in_it_for_its_share() {
        for duty in [1, 77, 128, 254_u8] {
            let mut modulators = Modulators::new();
            modulators.set_heater_cycle(1, Micros::from_millis(200));
            modulators.set_heater(1, Duty(duty));
            let levels: Vec<bool> = (0..255 * 400).map(|_| modulators.tick() != 0).collect();
            assert_eq!(levels.iter().filter(|on| **on).count(), usize::from(duty) * 400, "duty {duty}");
            let rises = levels.windows(2).filter(|two| !two[0] && two[1]).count();
            assert!(rises <= 255, "duty {duty}: {rises}");
            // Off takes effect in the middle of the cycle.
            modulators.tick();
            modulators.set_heater(1, Duty::OFF);
            assert!((0..1_000).all(|_| modulators.tick() == 0));
        }
        let mut modulators = Modulators::new();
        modulators.set_switch_cycle(0, Micros::from_seconds(1));
        modulators.set_switch(0, Duty::FULL);
        assert!((0..5_000).all(|_| modulators.tick() == switch_bit(0)));
    }

    #[test]
    fn off_and_full_never_switch() {
        let mut modulators = Modulators::new();
        modulators.set_heater(0, Duty::FULL);
        modulators.set_heater(1, Duty::OFF);
        assert!((0..1_000).all(|_| modulators.tick() == heater_bit(0)));
    }
}
