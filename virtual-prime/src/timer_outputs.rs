//! Outputs of the PWM timers (TIM1, TIM8) as edges, for LED strips, which need each edge. The timer's place
//! on the bus is taken by [`TappedTimer`], which lets the timer do its work and then looks at its outputs.

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
}

impl TappedTimer {
    /// Creates TIM1 (0) or TIM8 (1).
    pub fn new(timer: usize, world: SharedWorld) -> Self {
        let strips = std::array::from_fn(|channel| world.lock().strip_at(timer, channel));
        let none = [false; PWM_CHANNELS];
        Self { inner: Tim::new(ADVANCED_TIMERS[timer]), world, strips, reaches_pin: none, levels: none }
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
