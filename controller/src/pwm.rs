//! Hardware PWM as the host asks for it: pins of two timers, each with one period.

use bsp_prime::led_strip::LedSender;
use bsp_prime::pins::{PinName, Pins, table};
use bsp_prime::pwm::Pwm;
use klipper::Reason;
use klipper::board::PWM_MAX;
use units::STEP_CLOCK_HZ;

use crate::board::OWNER;

/// Rates that the timers make, Hz.
const RATES_HZ: core::ops::RangeInclusive<u32> = 4..=200_000;
/// Channels of a timer.
const CHANNELS: usize = 4;

/// A channel of one of the timers.
#[derive(Clone, Copy)]
pub struct Channel {
    timer: usize,
    channel: usize,
}

/// The channel that a pin is of.
fn channel_of(pin: u32) -> Result<Channel, Reason> {
    let pin = PinName::numbered(pin).ok_or(Reason::NotAPwmPin)?;
    let place = table::PWM.iter().position(|(_, known)| *known == pin).ok_or(Reason::NotAPwmPin)?;
    Ok(Channel { timer: place / CHANNELS, channel: place % CHANNELS })
}

/// Use of a timer.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Use {
    None,
    /// PWM with this period, ticks.
    Pwm(u32),
    /// Strips of lights on any of its channels.
    Lights,
}

/// The timers, and what each is for.
pub struct PwmPins {
    pwm: Pwm,
    lights: LedSender,
    uses: [Use; 2],
}

impl PwmPins {
    /// Creates the pins, none of which is claimed.
    pub const fn new(pwm: Pwm, lights: LedSender) -> Self {
        Self { pwm, lights, uses: [Use::None; 2] }
    }

    /// Claims a pin. The first one of a timer starts it.
    pub fn claim(&mut self, pin: u32, cycle_ticks: u32, value: u16, pins: &mut Pins) -> Result<Channel, Reason> {
        let claimed = channel_of(pin)?;
        let Channel { timer, channel } = claimed;
        let rate_hz = (STEP_CLOCK_HZ + cycle_ticks / 2).checked_div(cycle_ticks).unwrap_or(0);
        if !RATES_HZ.contains(&rate_hz) {
            return Err(Reason::NotAPwmPin);
        }
        match self.uses.get_mut(timer) {
            Some(Use::Pwm(present)) if *present == cycle_ticks => {}
            Some(free @ Use::None) => {
                self.pwm.start(timer, rate_hz);
                *free = Use::Pwm(cycle_ticks);
            }
            Some(Use::Pwm(_) | Use::Lights) | None => return Err(Reason::PwmOtherSpeed),
        }
        self.set(claimed, value);
        self.pwm.attach(timer, channel, pins, OWNER).map_err(|_| Reason::NotAPwmPin)?;
        Ok(claimed)
    }

    /// Claims a pin for a strip of lights. A timer that sends to strips does nothing else.
    pub fn claim_strip(&mut self, pin: u32, pins: &mut Pins) -> Result<Channel, Reason> {
        let claimed = channel_of(pin)?;
        match self.uses.get_mut(claimed.timer) {
            Some(Use::Lights) => {}
            Some(free @ Use::None) => {
                // The first strip on a timer sets it up, so that its lines are low before pins follow.
                self.lights.add(self.pwm.give_away(claimed.timer).ok_or(Reason::PwmOtherSpeed)?);
                *free = Use::Lights;
            }
            Some(Use::Pwm(_)) | None => return Err(Reason::PwmOtherSpeed),
        }
        self.pwm.attach(claimed.timer, claimed.channel, pins, OWNER).map_err(|_| Reason::NotAPwmPin)?;
        Ok(claimed)
    }

    /// Begins to send colours. False while others are on their way.
    pub fn send(&mut self, strip: Channel, bytes: &[u8]) -> bool {
        self.lights.send(strip.timer, strip.channel, bytes)
    }

    /// Sets a channel, 0 to [`PWM_MAX`].
    pub fn set(&mut self, channel: Channel, value: u16) {
        self.pwm.set(channel.timer, channel.channel, f32::from(value) / f32::from(PWM_MAX));
    }
}
