//! The machine as the board's pins see it: pin levels and SPI frames in; switch levels, voltages and SPI
//! replies out.
//!
//! The caller hands every input with its time; times must not go backwards. Physics runs on a fixed grid of
//! [`GRID_NS`], so results depend only on the inputs and their times, never on how often [`World::advance`]
//! is called.

mod analog;
mod config;
mod converters;
mod delta;
mod electrics;
mod fault;
mod fault_injection;
mod filament;
mod from_machine;
mod heat;
mod laser;
mod lights;
mod motion;
mod parts;
mod pins;
mod time;

pub use analog::{VFET_INPUT, VMOTOR_INPUT};
pub use config::{
    ActuatorConfig, AnalogInput, ConverterConfig, DriverConfig, FanConfig, FilamentSensorConfig, GRID_NS, HeaterConfig,
    LaserConfig, Linkage, Operator, OutsidePort, Pin, StripConfig, SwitchConfig, WorldConfig,
};
pub use delta::DeltaFrame;
pub use fault::{Fault, SPELLING, TimedFault};
pub use laser::Laser;

use units::{Actuator, MAX_ACTUATORS};

use crate::models::led_strip::LedStrip;
use crate::models::surface::TouchNoise;
use crate::models::switch::Switch;
use crate::models::tmc_stealth::TmcStealth;
use crate::models::tmc_wire::Wire;
use crate::models::tmc26x::Tmc26x;
use crate::trace::Trace;
use parts::{FanState, Filament, HeaterState, Motor};

/// Timers with outputs on the headers: PWM1 (TIM1) and PWM2 (TIM8).
pub const PWM_TIMERS: usize = 2;
/// Number of outputs of each timer.
pub const PWM_CHANNELS: usize = 4;
/// Number of driver chips on the board.
pub const ON_BOARD_DRIVERS: usize = 4;

/// Change of a switch's level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SwitchChange {
    /// Time of the change, nanoseconds since power-on.
    pub at_ns: u64,
    /// Index in [`WorldConfig::switches`].
    pub switch: usize,
    /// The new level of its pin.
    pub high: bool,
}

/// Simulated machine with all its parts.
#[derive(Clone, Debug)]
pub struct World {
    config: WorldConfig,
    now_ns: u64,
    /// Next point of the physics grid.
    grid_ns: u64,
    motors: [Option<Motor>; MAX_ACTUATORS],
    drivers: [Tmc26x; ON_BOARD_DRIVERS],
    /// Chips of drivers on headers, by motor.
    outside: [Option<TmcStealth>; MAX_ACTUATORS],
    /// Listening state of the chips on each UART.
    wires: [Wire; 2],
    switches: Vec<(Switch, bool)>,
    switch_changes: Vec<SwitchChange>,
    /// Contacts that bounce: time, index of the switch, and whether it closes. In order of time.
    bounces: Vec<(u64, usize, bool)>,
    heaters: Vec<HeaterState>,
    fans: Vec<FanState>,
    laser: Laser,
    /// Strips of lights on the timers.
    strips: Vec<LedStrip>,
    filament: Filament,
    vmotor_v: f64,
    vfet_v: f64,
    /// Frequency of each timer, hertz; zero while it stands.
    pwm_hz: [f64; PWM_TIMERS],
    /// Duty of each timer output, by timer and channel.
    pwm: [[f64; PWM_CHANNELS]; PWM_TIMERS],
    fet_buffer_on: bool,
    fet_power_on: bool,
    fet_switch_stuck_on: bool,
    /// Two heaters whose sensors are in each other's plugs.
    swapped: Option<[usize; 2]>,
    /// Time at which the converter came to stand, and the voltages that it holds.
    adc_stands: Option<(u64, Vec<f64>)>,
    pending_faults: Vec<TimedFault>,
    trace: Trace,
    timing_faults: u64,
    touch_noise: TouchNoise,
}

impl World {
    /// Returns the parts of the machine.
    #[must_use]
    pub const fn config(&self) -> &WorldConfig {
        &self.config
    }

    /// Returns the present time, nanoseconds since power-on.
    #[must_use]
    pub const fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Returns the trace of every step edge so far.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Returns the trace, to take edges out of it.
    pub const fn trace_mut(&mut self) -> &mut Trace {
        &mut self.trace
    }

    /// Returns a driver chip of the four on the board.
    #[must_use]
    pub const fn driver(&self, index: usize) -> &Tmc26x {
        &self.drivers[index]
    }

    /// Returns a driver chip, as [`Self::driver`] does.
    pub const fn driver_mut(&mut self, index: usize) -> &mut Tmc26x {
        &mut self.drivers[index]
    }

    /// Returns the chip of a motor's driver outside the board; `None` when it has none.
    #[must_use]
    pub const fn outside_driver(&self, motor: Actuator) -> Option<&TmcStealth> {
        self.outside[motor as usize].as_ref()
    }
}

#[cfg(test)]
mod tests;
