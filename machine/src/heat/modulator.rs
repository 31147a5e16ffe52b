//! Sigma-delta modulation of slow outputs: heaters, fans, valves.
//!
//! First order: each tick adds the duty to an accumulator; an overflow is an on-tick. Over 255 ticks an
//! output is on for exactly `duty` of them, spread as evenly as can be, and the finest share still switches
//! only a few hundred times a second, which MOSFETs and fans take.

use units::Duty;

use crate::ports::{MAX_HEATERS, MAX_SWITCHES, heater_bit, switch_bit};

/// Modulation ticks per second.
pub const MODULATION_HZ: u32 = 2_000;

/// One accumulator.
#[derive(Clone, Copy, Debug, Default)]
struct Modulator {
    duty: u8,
    sum: u16,
}

impl Modulator {
    #[inline]
    fn tick(&mut self) -> bool {
        self.sum += self.duty as u16;
        let on = self.sum >= 255;
        if on {
            self.sum -= 255;
        }
        on
    }

    fn set(&mut self, duty: Duty) {
        self.duty = duty.0;
        if duty == Duty::OFF {
            self.sum = 0;
        }
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
    /// Everything off.
    #[must_use]
    pub const fn new() -> Self {
        const OFF: Modulator = Modulator { duty: 0, sum: 0 };
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

    /// A switch's duty.
    pub fn switch(&self, index: usize) -> Duty {
        self.switches.get(index).map_or(Duty::OFF, |modulator| Duty(modulator.duty))
    }

    /// All heaters off.
    pub fn heaters_off(&mut self) {
        for modulator in &mut self.heaters {
            modulator.set(Duty::OFF);
        }
    }

    /// One tick; the bits of the outputs that are on.
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
    fn off_and_full_never_switch() {
        let mut modulators = Modulators::new();
        modulators.set_heater(0, Duty::FULL);
        modulators.set_heater(1, Duty::OFF);
        assert!((0..1_000).all(|_| modulators.tick() == heater_bit(0)));
    }
}
