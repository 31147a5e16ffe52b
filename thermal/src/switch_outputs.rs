//! Outputs of switches: modulated ones through the modulators, those on hardware timers through their timers,
//! and fans through [`FanDrives`].

use config::FanDriveConfig;
use units::Duty;

use crate::fan_drive::FanDrives;
use crate::io::MAX_SWITCHES;
use crate::modulator::Modulators;

/// Present outputs of all switches.
#[derive(Debug)]
pub struct SwitchOutputs {
    fans: FanDrives,
    /// Share of full power that each switch gives, 0 to 1; the set of switches on hardware timers, and of
    /// those the set that has changed.
    given: [f32; MAX_SWITCHES],
    on_timer: u16,
    changed: u16,
}

impl Default for SwitchOutputs {
    fn default() -> Self {
        Self::new()
    }
}

impl SwitchOutputs {
    /// Creates outputs that are all off.
    #[must_use]
    pub const fn new() -> Self {
        Self { fans: FanDrives::new(), given: [0.0; MAX_SWITCHES], on_timer: 0, changed: 0 }
    }

    /// Declares that a switch drives a fan with these settings. Returns false when there is no room.
    #[must_use]
    pub fn add_fan(&mut self, switch: usize, settings: FanDriveConfig) -> bool {
        self.fans.add(switch, settings)
    }

    /// Returns the share of full power that a switch gives, 0 to 1, whether or not its output has supply.
    #[must_use]
    pub fn given(&self, switch: usize) -> f32 {
        self.given.get(switch).copied().unwrap_or_default()
    }

    /// Asks a modulated switch for a duty.
    pub fn modulate(&mut self, modulators: &mut Modulators, switch: usize, duty: Duty) {
        let share = self.fans.ask(switch, f32::from(duty.0) / f32::from(Duty::FULL.0));
        self.give(modulators, switch, share);
    }

    /// Asks a switch on a hardware timer for a share, 0 to 1.
    pub fn set_pwm(&mut self, modulators: &mut Modulators, switch: usize, share: f32) {
        self.on_timer |= 1_u16.checked_shl(switch as u32).unwrap_or(0);
        let share = self.fans.ask(switch, share);
        self.give(modulators, switch, share);
    }

    /// Runs a control tick, in which kick starts of fans end.
    pub fn tick(&mut self, modulators: &mut Modulators) {
        for (switch, share) in self.fans.tick() {
            self.give(modulators, switch, share);
        }
    }

    /// Returns the next switch on a hardware timer that is to be set: its place, and its duty.
    #[inline]
    pub fn take_pwm_change(&mut self) -> Option<(usize, f32)> {
        if self.changed == 0 {
            return None;
        }
        let switch = self.changed.trailing_zeros() as usize;
        self.changed &= self.changed - 1;
        self.given.get(switch).map(|duty| (switch, *duty))
    }

    fn give(&mut self, modulators: &mut Modulators, switch: usize, share: f32) {
        let Some(given) = self.given.get_mut(switch) else { return };
        *given = share;
        if self.on_timer & 1 << switch != 0 {
            self.changed |= 1 << switch;
        } else {
            // Shares are rounded to whole duties: half a step is added, and the fraction is cut.
            modulators.set_switch(switch, Duty((share * f32::from(Duty::FULL.0) + 0.5) as u8));
        }
    }
}
