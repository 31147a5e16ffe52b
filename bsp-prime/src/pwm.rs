//! Hardware PWM: TIM1 (`PWM1_1` to `PWM1_4`, PE9 PE11 PE13 PE14) and TIM8 (`PWM2_1` to `PWM2_4`, PI5 PI6 PI7
//! PI2).
//!
//! PWM mode 1, active high. The period has 1000 counts, so that a duty is a per-mille whatever the rate;
//! below 200 Hz it has as many as 16 bits hold, so that pulses of a servo are set to a fraction of a
//! microsecond.

use stm32h7xx_hal::pac;

use crate::clocks::TIMER_HZ;
use crate::laser::LaserTimer;
use crate::led_strip::LedTimer;
use crate::pins::{PinError, PinSpec, Pins, table};

/// Fewest counts of a period, used from [`FINE_BELOW_HZ`] on.
const LEAST_PERIOD: u32 = 1_000;
/// Rate below which periods have more counts, for servos, Hz.
const FINE_BELOW_HZ: u32 = 200;
/// Most counts of a period: the counters of both timers have 16 bits, and so has a compare value of a full
/// period (RM0399, TIMx_ARR and TIMx_CCRx of the advanced-control timers).
const MOST_PERIOD: u32 = 65_535;

/// The two PWM timers.
pub struct Pwm {
    /// Registers of each timer; `None` after it has been given away.
    timers: [Option<*const pac::tim1::RegisterBlock>; 2],
    /// Counts of the period of each timer.
    periods: [u32; 2],
}

// SAFETY: pointers to registers of timers whose tokens `new` consumed; this value is their only user.
unsafe impl Send for Pwm {}

/// Returns the divider of the timer's clock, and the counts of a period at this rate.
const fn divided(rate_hz: u32) -> (u32, u32) {
    let rate_hz = if rate_hz == 0 { 1 } else { rate_hz };
    if rate_hz >= FINE_BELOW_HZ {
        let divider = TIMER_HZ / LEAST_PERIOD / rate_hz;
        return (if divider == 0 { 1 } else { divider }, LEAST_PERIOD);
    }
    let counts = TIMER_HZ / rate_hz;
    let divider = counts.div_ceil(MOST_PERIOD);
    (divider, counts / divider)
}

// The slowest rate that the configuration takes, a servo, and a fan.
const _: () = {
    assert!(TIMER_HZ == 200_000_000, "the figures below are of this clock");
    let ((slow, slow_counts), (servo, servo_counts)) = (divided(1), divided(50));
    assert!(slow <= 65_536 && slow * slow_counts > 199_900_000 && servo * servo_counts > 3_999_900);
    let (fan, fan_counts) = divided(10_000);
    assert!(fan == 20 && fan_counts == LEAST_PERIOD);
};

impl Pwm {
    pub(crate) fn new(_tim1: pac::TIM1, _tim8: pac::TIM8) -> Self {
        Self { timers: [Some(pac::TIM1::ptr()), Some(pac::TIM8::ptr())], periods: [LEAST_PERIOD; 2] }
    }

    fn timer(&self, timer: usize) -> Option<&'static pac::tim1::RegisterBlock> {
        // SAFETY: the pointers are the PAC's, and this value is the registers' only user.
        self.timers.get(timer).copied().flatten().map(|registers| unsafe { &*registers })
    }

    /// Gives a timer (0 or 1) to the strips of lights: nothing here touches it any more. `None` when it has
    /// been given away.
    pub fn give_away(&mut self, timer: usize) -> Option<LedTimer> {
        self.timers.get_mut(timer)?.take().map(|_| LedTimer(timer))
    }

    /// Gives a timer (0 or 1) to the laser: nothing here touches it any more. `None` when it has been given
    /// away.
    pub fn give_to_laser(&mut self, timer: usize) -> Option<LaserTimer> {
        self.timers.get_mut(timer)?.take().map(|_| LaserTimer(timer))
    }

    /// Runs a timer (0 or 1) at `rate_hz`, 4 Hz to 200 kHz, with all channels off.
    pub fn start(&mut self, timer: usize, rate_hz: u32) {
        let (divider, period) = divided(rate_hz);
        if let Some(place) = self.periods.get_mut(timer) {
            *place = period;
        }
        let Some(timer) = self.timer(timer) else { return };
        timer.psc.write(|w| w.psc().bits((divider - 1) as u16));
        timer.arr.write(|w| w.arr().bits((period - 1) as u16));
        // RM0399 section 42.4.7: OCxM = 110 (PWM mode 1), buffered compare values, in both channels of both
        // registers.
        const BOTH_CHANNELS: u32 = 0x6868;
        // SAFETY: that is a valid pattern of the two mode registers; four channels enabled, active high.
        unsafe {
            timer.ccmr1_output().write(|w| w.bits(BOTH_CHANNELS));
            timer.ccmr2_output().write(|w| w.bits(BOTH_CHANNELS));
            timer.ccer.write(|w| w.bits(0x1111));
        }
        timer.egr.write(|w| w.ug().set_bit());
        timer.bdtr.write(|w| w.moe().set_bit());
        timer.cr1.write(|w| w.arpe().set_bit().cen().set_bit());
    }

    /// Gives a channel (0 to 3) its pin.
    ///
    /// # Errors
    /// [`PinError`] when the pin is taken.
    pub fn attach(&mut self, timer: usize, channel: usize, pins: &mut Pins, owner: &str) -> Result<(), PinError> {
        let function = if timer == 0 { 1 } else { 3 };
        match table::PWM.get(timer * 4 + channel) {
            Some((_, pin)) => {
                pins.alternate(PinSpec { pull: crate::pins::Pull::Floating, ..PinSpec::plain(*pin) }, function, owner)
            }
            None => Ok(()),
        }
    }

    /// Sets a channel's share of on, 0 to 1.
    pub fn set(&mut self, timer: usize, channel: usize, duty: f32) {
        let Some(period) = self.periods.get(timer) else { return };
        // Adding half a count and cutting the fraction rounds to the nearest count.
        let counts = (units::within(duty, 0.0, 1.0) * *period as f32 + 0.5) as u16;
        let Some(timer) = self.timer(timer) else { return };
        match channel {
            0 => timer.ccr1().write(|w| w.ccr().bits(counts)),
            1 => timer.ccr2().write(|w| w.ccr().bits(counts)),
            2 => timer.ccr3().write(|w| w.ccr().bits(counts)),
            3 => timer.ccr4().write(|w| w.ccr().bits(counts)),
            _ => {}
        }
    }
}
