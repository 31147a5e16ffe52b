//! Motors, carriages and the switches they operate.

use units::{Actuator, Direction};

use super::config::{DriverConfig, Linkage, Operator, OutsidePort};
use super::parts::Motor;
use super::{SwitchChange, World};
use crate::models::rotor::{Drive, Rotor};
use crate::models::surface::Surface;
use crate::models::switch;
use crate::models::tmc_wire::Answer;
use crate::trace::StepEdge;

/// Least time of DIR before an active STEP edge (TMC2590 and TMC2660 datasheets, "STEP and DIR timing":
/// setup time 20 ns).
const DIRECTION_SETUP_NS: u64 = 20;

/// STEP of a chip outside must stay high or low this long ("STEP/DIR interface timing": 100 ns).
const PULSE_NS: u64 = 100;

/// Threshold with which a rotor's reading is its raw measurement, as stallGuard4's is: once a full step,
/// and not filtered (TMC2209 datasheet rev. 1.03, 5.5).
const UNSHIFTED: i32 = 10;

impl World {
    /// Sets the level of a motor's STEP pin.
    pub fn step_pin(&mut self, at_ns: u64, actuator: Actuator, high: bool) {
        let Some(motor) = &mut self.motors[actuator as usize] else { return };
        if motor.step_high == high {
            return;
        }
        motor.step_high = high;
        let stayed_ns = motor.step_changed_ns.replace(at_ns).map_or(u64::MAX, |before| at_ns.saturating_sub(before));
        let dir_high = motor.dir_high;
        let (moved, drives) = match motor.driver {
            DriverConfig::OnBoard => {
                let driver = &mut self.drivers[actuator as usize];
                (driver.step_edge(at_ns, high, dir_high), driver.drives())
            }
            DriverConfig::External { microsteps, pulse_ns, .. } => {
                self.timing_faults += u64::from(stayed_ns < pulse_ns);
                let size = 256 / microsteps.clamp(1, 256) as i32;
                (high.then_some(if dir_high { size } else { -size }), motor.enabled)
            }
            DriverConfig::Outside { .. } => {
                self.timing_faults += u64::from(stayed_ns < PULSE_NS);
                let Some(chip) = &mut self.outside[actuator as usize] else { return };
                (chip.step_edge(at_ns, high, dir_high), chip.drives())
            }
        };
        let Some(micropositions) = moved else { return };
        let forward = dir_high == motor.forward_high;
        if at_ns.saturating_sub(motor.dir_changed_ns) < DIRECTION_SETUP_NS && motor.dir_changed_ns != 0 {
            self.timing_faults += 1;
        }
        let direction = if forward { Direction::Forward } else { Direction::Backward };
        self.trace.push(StepEdge { time_ns: at_ns, actuator, direction });
        if drives {
            let size = i64::from(micropositions.abs());
            self.turn_motor(at_ns, actuator, if forward { size } else { -size });
            self.operate_switches(at_ns);
        }
    }

    /// Turns the field of a motor with current by so many 1/256 full steps.
    fn turn_motor(&mut self, at_ns: u64, actuator: Actuator, field: i64) {
        let Some(Motor { carriage, rotor, sense_ohms, .. }) = &mut self.motors[actuator as usize] else { return };
        let Some(rotor) = rotor else { return carriage.turn(field) };
        let (went, lost) = rotor.follow(field, |wanted| carriage.room(wanted));
        carriage.turn(went);
        carriage.lose(lost);
        if let Some(chip) = &mut self.outside[actuator as usize] {
            let (threshold, filter) = chip.stall_guard_2().unwrap_or((UNSHIFTED, false));
            let amps = chip.peak_current_amps(*sense_ohms);
            let drive = Drive { amps, supply_volts: self.config.vmotor_v, threshold, filter };
            if let Some(reading) = rotor.reading(at_ns, drive) {
                // stallGuard4 has half the range: 0 to 510.
                chip.load = if chip.stall_guard_2().is_some() { reading } else { (reading / 2).min(510) };
            }
            return;
        }
        let Some(driver) = self.drivers.get_mut(actuator as usize) else { return };
        let drive = Drive {
            amps: driver.peak_current_amps(driver.chip().sense_ohms()),
            supply_volts: driver.supply_volts(),
            threshold: driver.stall_guard_threshold(),
            filter: driver.filters_stall_guard(),
        };
        if let Some(reading) = rotor.reading(at_ns, drive) {
            driver.measure(reading);
        }
    }

    /// Places obstacles in a carriage's way: its hard stops from now on, millimetres.
    pub fn obstruct(&mut self, actuator: Actuator, limits_mm: [f64; 2]) {
        if let Some(motor) = &mut self.motors[actuator as usize] {
            motor.carriage.limit(limits_mm);
        }
    }

    /// Fits another motor, or another load, from now on.
    pub fn fit_rotor(&mut self, actuator: Actuator, plant: crate::models::rotor::Plant) {
        if let Some(motor) = &mut self.motors[actuator as usize] {
            motor.rotor = Some(Rotor::new(plant));
        }
    }

    /// Makes a step as the board does: both edges of a pulse, or one edge if the driver takes both.
    pub fn step(&mut self, at_ns: u64, actuator: Actuator) {
        let Some(motor) = &self.motors[actuator as usize] else { return };
        let high = motor.step_high;
        let double_edge = motor.driver == DriverConfig::OnBoard && self.drivers[actuator as usize].double_edge();
        self.step_pin(at_ns, actuator, !high);
        if !double_edge {
            // The length of the pulse is not known here.
            if let Some(motor) = &mut self.motors[actuator as usize] {
                motor.step_changed_ns = None;
            }
            self.step_pin(at_ns, actuator, high);
            if let Some(motor) = &mut self.motors[actuator as usize] {
                motor.step_changed_ns = None;
            }
        }
    }

    /// Sets the level of a motor's DIR pin.
    pub fn direction_pin(&mut self, at_ns: u64, actuator: Actuator, high: bool) {
        let Some(motor) = &mut self.motors[actuator as usize] else { return };
        if motor.dir_high != high {
            motor.dir_high = high;
            motor.dir_changed_ns = at_ns;
        }
    }

    /// Sets the DIR pin to the level that moves this way, as the motor is wired.
    pub fn turn(&mut self, at_ns: u64, actuator: Actuator, direction: Direction) {
        let Some(motor) = &self.motors[actuator as usize] else { return };
        self.direction_pin(at_ns, actuator, (direction == Direction::Forward) == motor.forward_high);
    }

    /// Sets the level of the enable pin of an external driver.
    pub fn enable_pin(&mut self, _at_ns: u64, actuator: Actuator, high: bool) {
        let Some(motor) = &mut self.motors[actuator as usize] else { return };
        match (motor.driver, &mut self.outside[actuator as usize]) {
            (DriverConfig::External { enable_high: Some(active), .. }, _) => motor.enabled = high == active,
            // The chip's own input is low for on, whatever level the driver's board takes.
            (DriverConfig::Outside { enable_high: Some(active), .. }, Some(chip)) => chip.set_enn(high != active),
            _ => {}
        }
    }

    /// Sets the level of the ENN line all four on-board drivers share: high switches them off.
    pub fn motors_disable_pin(&mut self, _at_ns: u64, high: bool) {
        self.drivers.iter_mut().for_each(|driver| driver.set_enn(high));
    }

    /// Returns the bits that the chip of a driver outside shifts out after its select fell.
    pub fn outside_shown(&mut self, at_ns: u64, motor: Actuator) -> [u8; 5] {
        self.outside[motor as usize].as_mut().map_or([0xFF; 5], |chip| chip.shown(at_ns))
    }

    /// Hands a datagram to the chip of a driver outside as its select rises.
    pub fn outside_taken(&mut self, at_ns: u64, motor: Actuator, datagram: [u8; 5]) {
        if let Some(chip) = &mut self.outside[motor as usize] {
            chip.take(at_ns, datagram);
        }
    }

    /// Takes a byte on an auxiliary UART whose stop bit ends now; returns the answer of a driver's chip
    /// there.
    pub fn wire_byte(&mut self, at_ns: u64, channel: u8, byte: u8) -> Option<Answer> {
        let on_it = |motor: usize| {
            let mut motors = self.config.actuators.iter().filter(|entry| entry.actuator as usize == motor);
            motors.any(|entry| {
                matches!(entry.driver, DriverConfig::Outside { port: OutsidePort::Uart { channel: of, .. }, .. } if of == channel)
            })
        };
        let chips = self.outside.iter_mut().enumerate().filter(|(motor, _)| on_it(*motor));
        let mut chips: Vec<_> = chips.filter_map(|(_, chip)| chip.as_mut()).collect();
        self.wires.get_mut(usize::from(channel))?.hear(at_ns, byte, &mut chips)
    }

    /// Returns the position of a motor's carriage, millimetres; `None` when the machine has no such motor.
    #[must_use]
    pub fn carriage_mm(&self, actuator: Actuator) -> Option<f64> {
        self.motors[actuator as usize].as_ref().map(|motor| motor.carriage.position_mm())
    }

    /// Returns the lowest and highest place of a motor's carriage since it was last put somewhere,
    /// millimetres.
    #[must_use]
    pub fn reached_mm(&self, actuator: Actuator) -> Option<[f64; 2]> {
        self.motors[actuator as usize].as_ref().map(|motor| motor.carriage.reached_mm())
    }

    /// Puts a carriage somewhere by hand.
    pub fn place_carriage(&mut self, at_ns: u64, actuator: Actuator, position_mm: f64) {
        if let Some(motor) = &mut self.motors[actuator as usize] {
            motor.carriage.place(position_mm);
            self.operate_switches(at_ns);
        }
    }

    /// Returns the position of a motor's carriage, millimetres, once its on-board driver has lost its
    /// supply and got it back: the chip's counter begins at zero, and the rotor goes to the nearest place
    /// that holds it so.
    #[must_use]
    pub fn carriage_after_power_up_mm(&self, actuator: Actuator) -> Option<f64> {
        let motor = self.motors[actuator as usize].as_ref()?;
        let Some(driver) = self.drivers.get(actuator as usize).filter(|_| motor.driver == DriverConfig::OnBoard) else {
            return Some(motor.carriage.position_mm());
        };
        let counter = i64::from(driver.microstep_counter());
        let back = if counter > 512 { counter - 1_024 } else { counter };
        let mut carriage = motor.carriage.clone();
        // DIR high counts down.
        carriage.turn(if motor.forward_high { back } else { -back });
        Some(carriage.position_mm())
    }

    /// Gives an axis backlash, millimetres.
    pub fn loosen(&mut self, actuator: Actuator, backlash_mm: f64) {
        if let Some(motor) = &mut self.motors[actuator as usize] {
            motor.carriage.loosen(backlash_mm);
        }
    }

    /// Returns the commanded travel that a motor lost at hard stops, millimetres.
    #[must_use]
    pub fn lost_mm(&self, actuator: Actuator) -> f64 {
        self.motors[actuator as usize].as_ref().map_or(0.0, |motor| motor.carriage.lost_mm())
    }

    /// Returns the number of step edges that came sooner after a change of DIR than the drivers allow.
    #[must_use]
    pub const fn timing_faults(&self) -> u64 {
        self.timing_faults
    }

    /// Returns the position of the tool, millimetres, X to Z.
    #[must_use]
    pub fn tool_mm(&self) -> [f64; 3] {
        self.tool_beside([0.0; 2])
    }

    /// Returns the position of a tip that hangs beside the tool by this much along X and Y: at the tool's X
    /// and Y, but as high as the gantry is over the tip.
    fn tool_beside(&self, [dx, dy]: [f64; 2]) -> [f64; 3] {
        let [a, b, c] = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma].map(|n| self.carriage_mm(n).unwrap_or(0.0));
        let [x, y] = match self.config.linkage {
            Linkage::Direct => [a, b],
            Linkage::CoreXy => [(a + b) / 2.0, (a - b) / 2.0],
            Linkage::LinearDelta(frame) => return frame.tool([a, b, c]),
        };
        if self.config.gantry.pivots.len() < 2 {
            return [x, y, c];
        }
        [x, y, self.config.gantry.height([x + dx, y + dy], |motor| self.carriage_mm(motor).unwrap_or(0.0))]
    }

    /// Returns the level of a switch's pin.
    #[must_use]
    pub fn switch_high(&self, index: usize) -> bool {
        self.switches[index].1 == self.config.switches[index].operated_high
    }

    /// Returns whether [`Self::take_switch_changes`] has something to give.
    #[must_use]
    pub const fn has_switch_changes(&self) -> bool {
        !self.switch_changes.is_empty()
    }

    /// Returns the level changes since the last call, oldest first.
    pub fn take_switch_changes(&mut self) -> Vec<SwitchChange> {
        std::mem::take(&mut self.switch_changes)
    }

    /// Presses or releases a switch by hand (buttons, a probe touching).
    ///
    /// # Errors
    /// When there is no switch of this name.
    pub fn press(&mut self, at_ns: u64, name: &str, pressed: bool) -> Result<(), String> {
        self.now_ns = self.now_ns.max(at_ns);
        self.set_switch_fault(name, if pressed { switch::Fault::AlwaysOperated } else { switch::Fault::Sound })
    }

    /// Makes a switch operate at another place each time from its next opening on, with this standard
    /// deviation in millimetres.
    ///
    /// # Errors
    /// When there is no switch of this name.
    pub fn make_switch_noisy(&mut self, name: &str, deviation_mm: f64) -> Result<(), String> {
        let index = self.switch_named(name)?;
        self.switches[index].0.noise_mm = deviation_mm;
        Ok(())
    }

    /// Moves a switch, millimetres.
    ///
    /// # Errors
    /// When there is no switch of this name.
    pub fn move_switch(&mut self, name: &str, by_mm: f64) -> Result<(), String> {
        let index = self.switch_named(name)?;
        self.switches[index].0.position_mm += by_mm;
        self.operate_switches(self.now_ns);
        Ok(())
    }

    fn switch_named(&self, name: &str) -> Result<usize, String> {
        self.config.switches.iter().position(|switch| switch.name == name).ok_or_else(|| {
            let known: Vec<_> = self.config.switches.iter().map(|switch| switch.name.as_str()).collect();
            format!("no switch `{name}`; there are: {}", known.join(" "))
        })
    }

    /// Gives a switch a fault, or repairs it.
    pub(super) fn set_switch_fault(&mut self, name: &str, fault: switch::Fault) -> Result<(), String> {
        let index = self.switch_named(name)?;
        self.switches[index].0.fault = fault;
        self.operate_switches(self.now_ns);
        Ok(())
    }

    /// Brings every switch in line with the carriages, and notes every change.
    pub(super) fn operate_switches(&mut self, at_ns: u64) {
        let tool = if self.config.linkage == Linkage::Direct { None } else { Some(self.tool_mm()) };
        for index in 0..self.switches.len() {
            let config = &self.config.switches[index];
            let place = match config.operator {
                Some((Operator::Carriage(actuator), ..)) => self.carriage_mm(actuator).unwrap_or(0.0),
                Some((Operator::Tool(axis), ..)) => match (tool, Actuator::from_index(axis)) {
                    (Some(tool), _) => tool[axis],
                    (None, Some(actuator)) => self.carriage_mm(actuator).unwrap_or(0.0),
                    (None, None) => 0.0,
                },
                Some((Operator::Surface, ..)) => {
                    let [dx, dy, _] = self.config.surface.tip_mm;
                    self.config.surface.gap(self.tool_beside([dx, dy])) - self.touch_noise.now_mm()
                }
                Some((Operator::Stall(motor), ..)) => {
                    // The switch is operated below 0.
                    let stalls = match &self.outside[motor as usize] {
                        Some(chip) => chip.stall_output(at_ns),
                        None => self.drivers.get(motor as usize).is_some_and(|driver| driver.stall_output()),
                    };
                    if stalls { -1.0 } else { 1.0 }
                }
                None => 0.0,
            };
            let operated = self.switches[index].0.operated(place);
            if operated == self.switches[index].1 || self.bounces.iter().any(|(_, switch, _)| *switch == index) {
                continue;
            }
            if operated && self.switches[index].0.fault == switch::Fault::Bounces {
                let bounce = switch::BOUNCES_NS.iter().enumerate();
                self.bounces.extend(bounce.map(|(n, after)| (at_ns + after, index, n % 2 == 1)));
            }
            self.change_switch(at_ns, index, operated);
        }
    }

    fn change_switch(&mut self, at_ns: u64, index: usize, operated: bool) {
        self.switches[index].1 = operated;
        if !operated && matches!(self.config.switches[index].operator, Some((Operator::Surface, ..))) {
            self.touch_noise.next(self.config.surface.noise_mm);
        }
        let switch = &mut self.switches[index].0;
        if !operated && switch.noise_mm > 0.0 {
            switch.noise.next(switch.noise_mm);
        }
        let high = operated == self.config.switches[index].operated_high;
        self.switch_changes.push(SwitchChange { at_ns, switch: index, high });
    }

    /// Applies the changes of bouncing contacts up to `to_ns`.
    pub(super) fn bounce(&mut self, to_ns: u64) {
        while let Some(due) = self.bounces.iter().position(|(at_ns, ..)| *at_ns <= to_ns) {
            let (at_ns, index, operated) = self.bounces.remove(due);
            self.change_switch(at_ns, index, operated);
            // The switch may have been released meanwhile.
            self.operate_switches(at_ns);
        }
    }

    /// Puts another surface under the tool.
    pub fn lay(&mut self, at_ns: u64, surface: Surface) {
        self.now_ns = self.now_ns.max(at_ns);
        self.config.surface = surface;
        self.operate_switches(self.now_ns);
    }
}
