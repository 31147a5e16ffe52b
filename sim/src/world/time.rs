//! The machine at power-on, and time that passes.

use units::MAX_ACTUATORS;

use super::config::{DriverConfig, GRID_NS, OutsidePort, WorldConfig};
use super::fault::TimedFault;
use super::parts::{FanState, Filament, HeaterState, Motor, switch_of};
use super::{PWM_CHANNELS, PWM_TIMERS, World};
use crate::models::led_strip::LedStrip;
use crate::models::surface::TouchNoise;
use crate::models::tmc_stealth::TmcStealth;
use crate::models::tmc26x::Tmc26x;
use crate::trace::Trace;

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
            switches: config.switches.iter().map(|switch| (switch_of(switch), false)).collect(),
            switch_changes: Vec::new(),
            bounces: Vec::new(),
            heaters: config.heaters.iter().map(|heater| HeaterState::new(heater, config.air_c)).collect(),
            fans: config.fans.iter().map(FanState::new).collect(),
            strips: config.strips.iter().map(|strip| LedStrip::new(strip.lights, strip.bytes_each)).collect(),
            filament: Filament::default(),
            vmotor_v: config.vmotor_v,
            vfet_v: config.vfet_v,
            pwm: [[0.0; PWM_CHANNELS]; PWM_TIMERS],
            pwm_hz: [0.0; PWM_TIMERS],
            laser: super::Laser::default(),
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Fault;

    fn fault(at_ns: u64, fault: Fault) -> TimedFault {
        TimedFault { at_ns, fault }
    }

    #[test]
    fn a_fault_comes_with_the_grid_and_not_before_its_time() {
        let mut world = World::new(WorldConfig::default());
        let nominal = world.vmotor_v();
        world.schedule(fault(5 * GRID_NS + 1, Fault::MotorSupply(5.0))).expect("every machine has one");
        world.schedule(fault(2 * GRID_NS, Fault::MotorSupply(7.0))).expect("every machine has one");
        let seen = [1, 2, 5, 6].map(|ms| {
            world.advance(ms * GRID_NS);
            world.vmotor_v()
        });
        assert_eq!(seen, [nominal, 7.0, 7.0, 5.0], "in the order of their times");
    }

    #[test]
    fn a_fault_of_a_part_that_is_not_there_is_refused_at_once() {
        let mut world = World::new(WorldConfig::default());
        assert!(world.schedule(fault(0, Fault::HeaterDead("chamber".into()))).is_err());
        assert!(world.schedule(fault(0, Fault::SwitchNeverOperates("door".into()))).is_err());
        world.advance(GRID_NS);
    }

    #[test]
    fn time_does_not_go_back() {
        let mut world = World::new(WorldConfig::default());
        world.advance(3 * GRID_NS + 5);
        world.advance(GRID_NS);
        assert_eq!(world.now_ns(), 3 * GRID_NS + 5);
    }
}
