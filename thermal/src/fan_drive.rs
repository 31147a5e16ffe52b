//! Power of a fan: off where it would only hum, never less than turns it, never more than it bears, and full
//! power for a moment to get it going.

use config::FanDriveConfig;
use heapless::Vec;

/// Greatest number of fans.
const FANS: usize = config::MAX_FANS;
/// Control ticks per second.
const TICKS_PER_SECOND: f64 = 100.0;

/// Output of a single fan.
#[derive(Clone, Copy, Debug)]
struct FanDrive {
    /// The switch that drives the fan.
    switch: u8,
    settings: FanDriveConfig,
    /// Power asked for, as a share of full power.
    wanted: f32,
    /// Remaining control ticks of the kick start.
    kick: u16,
}

impl FanDrive {
    const fn new(switch: u8, settings: FanDriveConfig) -> Self {
        Self { switch, settings, wanted: 0.0, kick: 0 }
    }

    fn given(&self) -> f32 {
        if self.kick > 0 { self.settings.max_power } else { self.wanted }
    }

    /// Asks for this share from now on; returns the share that the fan is given.
    fn ask(&mut self, share: f32) -> f32 {
        let FanDriveConfig { off_below, min_power, max_power, kick_start, kick_start_step } = self.settings;
        let is_off = share <= 0.0 || share < off_below;
        let wanted = if is_off { 0.0 } else { share.max(min_power).min(max_power) };
        let was = core::mem::replace(&mut self.wanted, wanted);
        if wanted == 0.0 {
            self.kick = 0;
        } else if self.kick == 0 && (was == 0.0 || wanted - was >= kick_start_step.max(f32::EPSILON)) {
            self.kick = (kick_start.seconds() * TICKS_PER_SECOND) as u16;
        }
        self.given()
    }
}

/// The outputs that drive fans.
#[derive(Clone, Debug)]
pub struct FanDrives {
    drives: Vec<FanDrive, FANS>,
}

impl Default for FanDrives {
    fn default() -> Self {
        Self::new()
    }
}

impl FanDrives {
    /// Creates an empty list of fans.
    #[must_use]
    pub const fn new() -> Self {
        Self { drives: Vec::new() }
    }

    /// Declares that a switch drives a fan. Returns false when there is no room.
    #[must_use]
    pub fn add(&mut self, switch: usize, settings: FanDriveConfig) -> bool {
        u8::try_from(switch).is_ok_and(|switch| self.drives.push(FanDrive::new(switch, settings)).is_ok())
    }

    /// Asks a switch for this share of full power; returns the share that it is given.
    #[inline]
    pub fn ask(&mut self, switch: usize, share: f32) -> f32 {
        let drive = self.drives.iter_mut().find(|drive| usize::from(drive.switch) == switch);
        drive.map_or(share, |drive| drive.ask(share))
    }

    /// Runs a control tick, 10 ms; returns the switches whose kick start ends with it, and their new shares.
    pub fn tick(&mut self) -> Vec<(usize, f32), FANS> {
        let mut ended = Vec::new();
        for drive in self.drives.iter_mut().filter(|drive| drive.kick > 0) {
            drive.kick -= 1;
            if drive.kick == 0 {
                // The list holds a share for every fan.
                let _ = ended.push((usize::from(drive.switch), drive.wanted));
            }
        }
        ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::Micros;

    fn drives() -> FanDrives {
        let settings = FanDriveConfig {
            off_below: 0.1,
            min_power: 0.2,
            max_power: 0.9,
            kick_start: Micros::from_millis(50),
            kick_start_step: 0.5,
        };
        let mut drives = FanDrives::new();
        assert!(drives.add(3, settings));
        drives
    }

    /// Returns the shares of the fan in the ticks that follow.
    fn given(drives: &mut FanDrives, share: f32) -> std::vec::Vec<f32> {
        let mut now = drives.ask(3, share);
        let mut given = std::vec![now];
        for _ in 0..8 {
            for (switch, share) in drives.tick() {
                assert_eq!(switch, 3);
                now = share;
            }
            given.push(now);
        }
        given
    }

    #[test]
    fn it_starts_with_all_power_and_then_has_what_was_asked_for() {
        let mut drives = drives();
        assert_eq!(given(&mut drives, 0.3), [0.9, 0.9, 0.9, 0.9, 0.9, 0.3, 0.3, 0.3, 0.3]);
        assert_eq!(given(&mut drives, 0.6), [0.6; 9], "a small step needs no help");
        assert_eq!(given(&mut drives, 0.25), [0.25; 9]);
        assert_eq!(given(&mut drives, 0.8)[..6], [0.9, 0.9, 0.9, 0.9, 0.9, 0.8], "a big one does");
    }

    #[test]
    fn off_is_off_at_once_and_limits_hold() {
        let mut drives = drives();
        assert_eq!(drives.ask(3, 0.5), 0.9);
        assert_eq!(given(&mut drives, 0.0), [0.0; 9], "also while it is started");
        assert_eq!(given(&mut drives, 0.05), [0.0; 9]);
        assert_eq!(given(&mut drives, 0.1)[5..7], [0.2, 0.2]);
        assert_eq!(given(&mut drives, 1.0), [0.9; 9]);
        assert_eq!(drives.ask(2, 0.05), 0.05, "another switch drives no fan");
    }
}
