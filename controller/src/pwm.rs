//! Hardware PWM as the host asks for it: pins of two timers, each with one period.

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

/// The timers, and the period of each that runs.
pub struct PwmPins {
    pwm: Pwm,
    cycles: [Option<u32>; 2],
}

impl PwmPins {
    /// Creates the pins, none of which is claimed.
    pub const fn new(pwm: Pwm) -> Self {
        Self { pwm, cycles: [None; 2] }
    }

    /// Claims a pin. The first one of a timer starts it.
    pub fn claim(&mut self, pin: u32, cycle_ticks: u32, value: u16, pins: &mut Pins) -> Result<Channel, Reason> {
        let pin = PinName::numbered(pin).ok_or(Reason::NotAPwmPin)?;
        let place = table::PWM.iter().position(|(_, known)| *known == pin).ok_or(Reason::NotAPwmPin)?;
        let (timer, channel) = (place / CHANNELS, place % CHANNELS);
        let rate_hz = (STEP_CLOCK_HZ + cycle_ticks / 2).checked_div(cycle_ticks).unwrap_or(0);
        if !RATES_HZ.contains(&rate_hz) {
            return Err(Reason::NotAPwmPin);
        }
        match self.cycles.get_mut(timer) {
            Some(Some(present)) if *present != cycle_ticks => return Err(Reason::PwmOtherSpeed),
            Some(cycle @ None) => {
                self.pwm.start(timer, rate_hz);
                *cycle = Some(cycle_ticks);
            }
            Some(Some(_)) | None => {}
        }
        let claimed = Channel { timer, channel };
        self.set(claimed, value);
        self.pwm.attach(timer, channel, pins, OWNER).map_err(|_| Reason::NotAPwmPin)?;
        Ok(claimed)
    }

    /// Sets a channel, 0 to [`PWM_MAX`].
    pub fn set(&mut self, channel: Channel, value: u16) {
        self.pwm.set(channel.timer, channel.channel, f32::from(value) / f32::from(PWM_MAX));
    }
}
