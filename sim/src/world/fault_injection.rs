//! Faults as they happen to the machine, and their repair.

use units::Actuator;

use super::World;
use super::fault::Fault;
use super::parts::Seat;
use crate::models::converter::DataLine;
use crate::models::thermistor::Wiring;
use crate::models::tmc26x::{Condition, Tmc26x};
use crate::models::{fan, switch};

impl World {
    /// Has a fault happen now.
    ///
    /// # Errors
    /// When the machine has no such heater, switch or motor.
    pub fn inject(&mut self, fault: &Fault) -> Result<(), String> {
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
            heater.wiring = Wiring::Sound;
            heater.stuck = None;
            heater.strength = 1.0;
            heater.seat = Seat::default();
            if let Some(converter) = &mut heater.converter {
                converter.data = DataLine::Sound;
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
