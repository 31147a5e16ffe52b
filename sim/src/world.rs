//! The machine as the board's pins see it: pin levels and SPI frames in; switch levels, voltages and SPI
//! replies out.
//!
//! The caller hands every input with its time; times must not go backwards. Physics runs on a fixed grid of
//! [`GRID_NS`], so results depend only on the inputs and their times, never on how often [`World::advance`]
//! is called.

mod config;
mod converters;
mod delta;
mod electrics;
mod fault;
mod filament;
mod from_machine;
mod heat;
mod lights;
mod motion;

pub use config::{
    ActuatorConfig, AnalogInput, ConverterConfig, DriverConfig, FanConfig, FilamentSensorConfig, HeaterConfig, Linkage,
    Operator, OutsidePort, Pin, StripConfig, SwitchConfig, WorldConfig,
};
pub use delta::DeltaFrame;
pub use electrics::{VFET_INPUT, VMOTOR_INPUT};
pub use fault::{Fault, SPELLING, TimedFault};

use units::{Actuator, MAX_ACTUATORS};

use crate::models::fan;
use crate::models::led_strip::LedStrip;
use crate::models::surface::TouchNoise;
use crate::models::switch::{self, Switch};
use crate::models::tmc_stealth::TmcStealth;
use crate::models::tmc_wire::Wire;
use crate::models::tmc26x::{Condition, Tmc26x};
use crate::trace::Trace;
use heat::{FanState, HeaterState};
use motion::Motor;

/// Step of the thermal physics, nanoseconds.
pub const GRID_NS: u64 = 1_000_000;
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
    /// Strips of lights on the timers.
    strips: Vec<LedStrip>,
    filament: filament::Filament,
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
    /// Makes the machine at power-on: everything cold, outputs off, motors without current.
    #[must_use]
    pub fn new(config: WorldConfig) -> Self {
        let mut motors = [const { None }; MAX_ACTUATORS];
        let mut outside = [const { None }; MAX_ACTUATORS];
        for actuator in &config.actuators {
            motors[actuator.actuator as usize] = Some(Motor::new(actuator));
            if let DriverConfig::Outside { kind, enable_high, port } = actuator.driver {
                let address = if let OutsidePort::Uart { address, .. } = port { address } else { 0 };
                let chip = TmcStealth::on_wire(kind, address, enable_high.is_some());
                outside[actuator.actuator as usize] = Some(chip);
            }
        }
        let mut drivers = std::array::from_fn(|_| Tmc26x::new(config.chip));
        drivers.iter_mut().for_each(|driver: &mut Tmc26x| driver.set_supply(config.vmotor_v));
        let mut world = Self {
            now_ns: 0,
            grid_ns: GRID_NS,
            motors,
            drivers,
            outside,
            wires: Default::default(),
            switches: config.switches.iter().map(|switch| (motion::switch_of(switch), false)).collect(),
            switch_changes: Vec::new(),
            bounces: Vec::new(),
            heaters: config.heaters.iter().map(|heater| HeaterState::new(heater, config.air_c)).collect(),
            fans: config.fans.iter().map(FanState::new).collect(),
            strips: config.strips.iter().map(|strip| LedStrip::new(strip.lights, strip.bytes_each)).collect(),
            filament: filament::Filament::default(),
            vmotor_v: config.vmotor_v,
            vfet_v: config.vfet_v,
            pwm: [[0.0; PWM_CHANNELS]; PWM_TIMERS],
            pwm_hz: [0.0; PWM_TIMERS],
            fet_buffer_on: false,
            fet_power_on: false,
            fet_switch_stuck_on: false,
            swapped: None,
            adc_stands: None,
            pending_faults: Vec::new(),
            trace: Trace::default(),
            timing_faults: 0,
            touch_noise: TouchNoise::default(),
            config,
        };
        world.operate_switches(0);
        world.switch_changes.clear();
        world
    }

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

    /// Lets time pass up to `to_ns`. Inputs do this themselves; call it before reading outputs.
    pub fn advance(&mut self, to_ns: u64) {
        while self.grid_ns <= to_ns {
            let at_ns = self.grid_ns;
            while let Some(due) = self.pending_faults.iter().position(|fault| fault.at_ns <= at_ns) {
                let fault = self.pending_faults.remove(due).fault;
                self.now_ns = at_ns;
                if let Err(reason) = self.inject(&fault) {
                    unreachable!("checked when scheduled: {reason}");
                }
            }
            self.pass_heat(at_ns);
            self.grid_ns += GRID_NS;
        }
        self.bounce(to_ns);
        self.now_ns = self.now_ns.max(to_ns);
    }

    /// Schedules a fault. Faults take effect on the physics grid.
    ///
    /// # Errors
    /// When the machine has no such heater, switch or motor.
    pub fn schedule(&mut self, fault: TimedFault) -> Result<(), String> {
        self.clone_for_check().inject(&fault.fault)?;
        self.pending_faults.push(fault);
        Ok(())
    }

    fn clone_for_check(&self) -> Self {
        Self::new(self.config.clone())
    }

    /// Has a fault happen now.
    ///
    /// # Errors
    /// When the machine has no such heater, switch or motor.
    pub fn inject(&mut self, fault: &Fault) -> Result<(), String> {
        use crate::models::converter::DataLine;
        use crate::models::thermistor::Wiring;
        let now_ns = self.now_ns;
        match fault {
            Fault::ThermistorOpen(name) => self.heater_named(name)?.wiring = Wiring::Open,
            Fault::ThermistorShort(name) => self.heater_named(name)?.wiring = Wiring::Shorted,
            Fault::SensorToSupply(name) => self.heater_named(name)?.wiring = Wiring::ToSupply,
            Fault::SensorLead(name, leads) => self.heater_named(name)?.leads = *leads,
            Fault::ConverterSilent(name) => self.converter_of(name)?.data = DataLine::Silent,
            Fault::ConverterLow(name) => self.converter_of(name)?.data = DataLine::Low,
            Fault::ConverterReset(name) => self.converter_of(name)?.reset(now_ns),
            Fault::HeaterStuckOn(name) => self.heater_named(name)?.stuck = Some(true),
            Fault::ThermistorSlips(name) => self.heater_named(name)?.seat.slips = true,
            Fault::ThermistorLoose(name) => self.heater_named(name)?.seat.loose = true,
            Fault::ThermistorNoisy(name, kelvin) => self.heater_named(name)?.seat.noise_k = *kelvin,
            Fault::ThermistorDrifts(name, kelvin_per_s) => self.heater_named(name)?.seat.drift_k_per_s = *kelvin_per_s,
            Fault::HeaterWeak(name, share) => self.heater_named(name)?.strength = *share,
            Fault::ThermistorsSwapped(one, other) => {
                let place = |name: &str| self.heater_index(name).ok_or_else(|| format!("no heater `{name}`"));
                self.swapped = Some([place(one)?, place(other)?]);
            }
            Fault::AdcStands => {
                let volts = (0..self.heaters.len()).map(|heater| self.sensor_volts(heater)).collect();
                self.adc_stands = Some((self.now_ns, volts));
            }
            Fault::HeaterDead(name) => self.heater_named(name)?.stuck = Some(false),
            Fault::FanStopped(name) => self.set_fan_condition(name, fan::Condition::Stopped)?,
            Fault::FanSlow(name) => self.set_fan_condition(name, fan::Condition::Slow)?,
            Fault::SwitchNeverOperates(name) => self.set_switch_fault(name, switch::Fault::NeverOperates)?,
            Fault::SwitchAlwaysOperated(name) => self.set_switch_fault(name, switch::Fault::AlwaysOperated)?,
            Fault::SwitchBounces(name) => self.set_switch_fault(name, switch::Fault::Bounces)?,
            Fault::DriverSilent(motor) => self.driver_condition(*motor)?.silent = true,
            Fault::DriverBitErrors(motor, every) => self.driver_condition(*motor)?.bit_error_every = *every,
            Fault::DriverTemperature(motor, celsius) => self.driver_condition(*motor)?.temperature_c = *celsius,
            Fault::DriverOpenLoad(motor) => self.driver_condition(*motor)?.open_load[0] = true,
            Fault::DriverShort(motor) => self.driver_condition(*motor)?.short_to_ground[0] = true,
            Fault::DriverShortToSupply(motor) => self.driver_condition(*motor)?.short_to_supply[0] = true,
            Fault::DriverReset(motor) => match &mut self.outside[*motor as usize] {
                Some(chip) => chip.reset(),
                None => on_board(&mut self.drivers, *motor)?.reset(),
            },
            Fault::MotorSupply(volts) => self.set_motor_supply(*volts),
            Fault::FetSupply(volts) => self.vfet_v = *volts,
            Fault::FetSwitchStuckOn => self.fet_switch_stuck_on = true,
            Fault::Repaired => self.repair(),
        }
        Ok(())
    }

    fn repair(&mut self) {
        for heater in &mut self.heaters {
            heater.wiring = crate::models::thermistor::Wiring::Sound;
            heater.stuck = None;
            heater.strength = 1.0;
            heater.seat = heat::Seat::default();
            if let Some(converter) = &mut heater.converter {
                converter.data = crate::models::converter::DataLine::Sound;
            }
        }
        for fan in &mut self.fans {
            fan.fan.condition = fan::Condition::Sound;
        }
        for (switch, _) in &mut self.switches {
            switch.fault = switch::Fault::Sound;
        }
        let sound = Condition { temperature_c: 40, ..Condition::default() };
        self.drivers.iter_mut().for_each(|driver| driver.condition = sound);
        self.outside.iter_mut().flatten().for_each(|driver| driver.condition = sound);
        self.set_motor_supply(self.config.vmotor_v);
        self.vfet_v = self.config.vfet_v;
        self.fet_switch_stuck_on = false;
        self.swapped = None;
        self.adc_stands = None;
        self.operate_switches(self.now_ns);
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

    fn driver_condition(&mut self, actuator: Actuator) -> Result<&mut Condition, String> {
        match &mut self.outside[actuator as usize] {
            Some(chip) => Ok(&mut chip.condition),
            None => Ok(&mut on_board(&mut self.drivers, actuator)?.condition),
        }
    }
}

fn on_board(drivers: &mut [Tmc26x], actuator: Actuator) -> Result<&mut Tmc26x, String> {
    let chip = drivers.get_mut(actuator as usize);
    chip.ok_or_else(|| format!("{} has no driver that can be asked", actuator.name()))
}

#[cfg(test)]
mod tests;
