//! The laser, and strips of lights: what shines.

use base::ports::{LaserPort, LightPort};

use super::{BoardPorts, Locks};

impl<L: Locks> LaserPort for BoardPorts<L> {
    fn lock_laser(&mut self, is_locked: bool) {
        if let Some(laser) = &mut self.laser {
            laser.lock(is_locked);
        }
    }

    fn darken_laser(&mut self, is_dark: bool) {
        if let Some(laser) = &mut self.laser {
            laser.darken(is_dark);
        }
    }

    fn set_laser(&mut self, duty: u16) {
        if let Some(laser) = &mut self.laser {
            laser.set(duty);
        }
    }

    fn look_at_laser(&mut self) -> bool {
        self.laser.as_mut().is_some_and(bsp_prime::laser::Laser::look)
    }

    fn set_laser_frequency(&mut self, hertz: u32) {
        if let Some(laser) = &mut self.laser {
            laser.set_frequency(hertz);
        }
    }
}

impl<L: Locks> LightPort for BoardPorts<L> {
    fn send_to_strip(&mut self, strip: usize, bytes: &[u8]) -> bool {
        match self.strips.get(strip).copied().flatten() {
            Some((timer, channel)) => self.owned.led_sender.send(timer, channel, bytes),
            // A strip without wiring never sends, so nobody need ask again.
            None => true,
        }
    }
}
