//! Outputs of the PWM timers (TIM1, TIM8) as edges, for LED strips, which need each edge, and for a laser,
//! whose changes of power have places. The timer's place on the bus is taken by [`TappedTimer`], which lets
//! the timer do its work and then looks at its outputs.

use rigless::device::{Device, DeviceContext, Level, RegisterFile, RequestChange};
use rigless::soc::stm32h743::generated::tim1::Register;
use rigless::soc::stm32h743::peripherals::tim::{ADVANCED_TIMERS, Advanced, Channel, Tim};
use rigless::time::{EventId, VirtualNanos};
use sim::world::PWM_CHANNELS;

use crate::outputs::SharedWorld;

/// An advanced timer whose outputs are observed.
#[derive(Debug)]
pub struct TappedTimer {
    /// Timer model of the emulator.
    pub inner: Tim<Advanced>,
    world: SharedWorld,
    /// Index of the LED strip on each output.
    strips: [Option<usize>; PWM_CHANNELS],
    /// Whether each output's pin is set to the timer's alternate function.
    pub reaches_pin: [bool; PWM_CHANNELS],
    levels: [bool; PWM_CHANNELS],
    /// Laser on one of the outputs.
    laser: Option<LaserOutput>,
}

/// Output that drives a laser.
#[derive(Debug)]
struct LaserOutput {
    channel: usize,
    /// Level at which the laser burns.
    on_high: bool,
    /// Duty that the machine has been told, 1/65535.
    duty: u16,
}

impl TappedTimer {
    /// Creates TIM1 (0) or TIM8 (1).
    pub fn new(timer: usize, world: SharedWorld) -> Self {
        let strips = std::array::from_fn(|channel| world.lock().strip_at(timer, channel));
        let laser = world.lock().config().laser.filter(|laser| laser.output.0 == timer);
        let laser = laser.map(|laser| LaserOutput { channel: laser.output.1, on_high: laser.on_high, duty: 0 });
        let none = [false; PWM_CHANNELS];
        Self { inner: Tim::new(ADVANCED_TIMERS[timer]), world, strips, reaches_pin: none, levels: none, laser }
    }

    fn look(&mut self, file: &RegisterFile, now: VirtualNanos) {
        for channel in 0..PWM_CHANNELS {
            let (Some(strip), Some(output)) = (self.strips[channel], Channel::new(channel as u8 + 1)) else { continue };
            let driven = self.inner.output(output, file) == Some(Level::High);
            let high = self.reaches_pin[channel] && driven;
            if std::mem::replace(&mut self.levels[channel], high) != high {
                self.world.lock().strip_pin(now.0, strip, high);
            }
        }
        self.look_at_laser(file, now);
    }

    /// Tells the machine of a laser's new duty: of light when its pin has gone on, of dark when it has gone
    /// off for good.
    fn look_at_laser(&mut self, file: &RegisterFile, now: VirtualNanos) {
        let Some(laser) = &mut self.laser else { return };
        let Some(output) = Channel::new(laser.channel as u8 + 1) else { return };
        let level = self.inner.output(output, file).filter(|_| self.reaches_pin[laser.channel]);
        let is_on = level == Some(Level::from(laser.on_high));
        let pulse = self.inner.pulse(output, file).filter(|_| level.is_some());
        let high = pulse.map(|pulse| pulse.width.0 as f64 / pulse.period.0.max(1) as f64);
        let share = high.map_or(0.0, |high| if laser.on_high { high } else { 1.0 - high });
        let duty = (share * f64::from(u16::MAX)).round() as u16;
        let has_come = if duty == 0 { !is_on } else { is_on || laser.duty != 0 };
        if has_come && std::mem::replace(&mut laser.duty, duty) != duty {
            self.world.lock().laser_pin(now.0, duty);
        }
    }
}

impl Device for TappedTimer {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        let answer = self.inner.read(register, file, context);
        self.look(file, context.now());
        answer
    }

    fn peek(&self, register: Register, file: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        self.inner.peek(register, file, now)
    }

    fn steady(&self, register: Register, file: &RegisterFile) -> bool {
        self.inner.steady(register, file)
    }

    fn write(&mut self, register: Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.inner.write(register, value, file, context);
        self.look(file, context.now());
    }

    fn on_clock(&mut self, hz: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.inner.on_clock(hz, file, context);
    }

    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.inner.on_event(event, file, context);
        self.look(file, context.now());
    }

    fn on_request(&mut self, change: RequestChange, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.inner.on_request(change, file, context);
        self.look(file, context.now());
    }

    fn hears(&self, instance: &'static str, request: usize) -> bool {
        self.inner.hears(instance, request)
    }

    fn reset(&mut self) {
        Device::reset(&mut self.inner);
        self.levels = [false; PWM_CHANNELS];
    }
}
