//! Heaters, fans and every other switched output.
//!
//! [`HeatControl`] is a pure object with two clocks: [`HeatControl::tick`] reads sensors and runs control
//! laws and guards; [`HeatControl::modulation_tick`] turns duties into on and off at 2 kHz. Both run in the
//! heat task, above planning, so no amount of motion can starve them.
//!
//! A heater is on only while everything that makes it safe has been seen to work: a believable reading this
//! sample, a guard that has not run out, a control tick within [`STALE_MODULATION_TICKS`], an executor that
//! reported within [`EXECUTOR_TIMEOUT`]. If any of them is missing, the output falls to off by itself; the
//! message follows later.

use config::{HeaterId, LawSettings};
use heapless::Vec;
use motion::Mark;
use units::{Celsius, Duty, Micros, ToolId};

use crate::chip_faults::ChipFaults;
use crate::combined::read as read_sensor;
use crate::effects::{Effects, Full, Output};
use crate::heater::{Heater, TargetRefused, Work};
use crate::heater_settings::HeaterSettings;
use crate::io::{MAX_HEATERS, OutputLevels, SensorReading, SensorReadings};
use crate::model::Surroundings;
use crate::modulator::{MODULATION_HZ, Modulators};
use crate::pulses::Pulses;
use crate::safety::{HeatCause, HeatFault, HeatSafety};
use crate::sensor::Sensor;
use crate::switch_outputs::SwitchOutputs;

/// Without a control tick for this many modulation ticks (one second), every heater output is off.
pub const STALE_MODULATION_TICKS: u32 = MODULATION_HZ;
/// Temperature above which a part is too hot to be touched.
const HOT: Celsius = Celsius(50.0);
/// An executor silent for this long can no longer be told to stop: heaters go off. Longer than any SD card
/// command.
pub const EXECUTOR_TIMEOUT: Micros = Micros::from_seconds(10);
/// Time for which a reported extrusion flow counts.
const FLOW_STALE: Micros = Micros::from_seconds(1);
/// All heaters and switched outputs of the machine.
#[derive(Debug)]
pub struct HeatControl {
    heaters: Vec<Heater, MAX_HEATERS>,
    safety: HeatSafety,
    modulators: Modulators,
    fets_enabled: bool,
    halted: bool,
    executor_seen: Micros,
    modulation_ticks_since_control: u32,
    fault: Option<HeatFault>,
    effects: Effects,
    /// A target that was refused when its place on the path was reached.
    refused: Option<(HeaterId, Celsius, TargetRefused)>,
    /// Values given to the outputs of switches.
    switches: SwitchOutputs,
    /// Pulse counts of the fans' tachometers.
    pulses: Pulses,
    /// Readings of the filament width sensor's inputs, of the same scan as the thermistors'.
    filament_width: [SensorReading; 2],
    /// Extrusion flow, mm3/s, the time of its report, and its tool.
    flow: (f32, Micros),
    flow_tool: Option<ToolId>,
    chip_faults: ChipFaults,
    /// Mark that the motors have reached.
    reached: Mark,
}

impl Default for HeatControl {
    fn default() -> Self {
        Self::new()
    }
}

impl HeatControl {
    /// Starts with nothing configured and everything off.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            heaters: Vec::new(),
            safety: HeatSafety::new(),
            modulators: Modulators::new(),
            fets_enabled: false,
            halted: false,
            executor_seen: Micros(0),
            modulation_ticks_since_control: 0,
            fault: None,
            effects: Effects::new(),
            refused: None,
            switches: SwitchOutputs::new(),
            pulses: Pulses::new(),
            filament_width: [SensorReading::Missing; 2],
            flow: (0.0, Micros(0)),
            flow_tool: None,
            chip_faults: ChipFaults::new(),
            reached: Mark(0),
        }
    }

    /// Adds the next temperature controller, in the configuration's order, under the id it has there. None
    /// when there is no room.
    #[must_use]
    pub fn add(&mut self, settings: HeaterSettings) -> Option<HeaterId> {
        let id = HeaterId::all().nth(self.heaters.len())?;
        let watched = self.safety.add(settings.sensor, settings.safety_limits());
        self.modulators.set_heater_cycle(id.index(), settings.cycle);
        self.heaters.push(Heater::new(settings)).ok()?;
        watched.then_some(id)
    }

    /// Gives a controller another sensor. False, and nothing changes, while the heater is on.
    pub fn set_sensor(&mut self, id: HeaterId, sensor: Sensor) -> bool {
        let Some(heater) = self.heaters.get_mut(id.index()).filter(|heater| !heater.is_on()) else { return false };
        heater.set_sensor(sensor);
        self.safety.set_sensor(id, sensor);
        true
    }

    /// Sets a controller's highest target, which is also the highest believable reading. False when there is
    /// no such controller.
    pub fn set_maximum(&mut self, id: HeaterId, max: Celsius) -> bool {
        let Some(heater) = self.heaters.get_mut(id.index()) else { return false };
        heater.settings.max = max;
        self.safety.set_maximum(id, max);
        true
    }

    /// Opens the output stage. To be called once wiring is done.
    pub fn enable_outputs(&mut self) {
        self.fets_enabled = true;
    }

    /// Returns the controllers, in the configuration's order.
    pub fn heaters(&self) -> impl Iterator<Item = (HeaterId, &Heater)> {
        HeaterId::all().zip(&self.heaters)
    }

    /// Returns a controller by its id.
    #[must_use]
    pub fn heater(&self, id: HeaterId) -> Option<&Heater> {
        self.heaters.get(id.index())
    }

    /// Returns a controller to change.
    pub fn heater_mut(&mut self, id: HeaterId) -> Option<&mut Heater> {
        self.heaters.get_mut(id.index())
    }

    /// Exchanges the control law's settings and the ceiling of the output; control goes on from the present
    /// output. False when there is no such controller.
    pub fn set_law(&mut self, id: HeaterId, law: LawSettings, max_duty: Duty) -> bool {
        let Some(heater) = self.heaters.get_mut(id.index()) else { return false };
        heater.set_law(law, max_duty);
        self.safety.set_full_share(id, heater.settings.safety_limits().full_share);
        true
    }

    /// Puts another law in force until the next [`Self::set_law`]; the settings stay.
    pub fn set_trial_law(&mut self, id: HeaterId, law: LawSettings, max_duty: Duty) {
        if let Some(heater) = self.heaters.get_mut(id.index()) {
            heater.go_on_with(law, max_duty);
        }
    }

    /// Returns the duty of a switch, 0 to 1, by its place in the configuration's list.
    #[must_use]
    pub fn switch_duty(&self, switch: u8) -> f32 {
        self.switches.given(usize::from(switch))
    }

    /// Asks for a temperature, 0 for off. A refused target changes nothing; while halted every target counts
    /// as off.
    ///
    /// # Errors
    /// When the controller does not allow that temperature, or has nothing to heat with.
    pub fn set_target(&mut self, id: HeaterId, target: Celsius) -> Result<(), TargetRefused> {
        let target = if self.halted { Celsius(0.0) } else { target };
        let heater = self.heaters.get_mut(id.index()).ok_or(TargetRefused::HasNoHeater)?;
        heater.set_target(target)?;
        self.drive_heater(id.index());
        Ok(())
    }

    /// Returns whether any heater is asked to heat.
    #[must_use]
    pub fn any_on(&self) -> bool {
        self.heaters.iter().any(Heater::is_on)
    }

    /// Returns whether any heater is asked to heat, or too hot to be touched.
    #[must_use]
    pub fn any_hot(&self) -> bool {
        let is_hot = |heater: &Heater| heater.reading().is_some_and(|reading| reading > HOT);
        self.heaters.iter().any(|heater| heater.settings.heats && (heater.is_on() || is_hot(heater)))
    }

    /// Has a switch drive a fan with these settings. False when there is no room.
    #[must_use]
    pub fn add_fan(&mut self, switch: usize, settings: config::FanDriveConfig) -> bool {
        self.switches.add_fan(switch, settings)
    }

    /// Sets the period in which a switch's output is on once; 0: as often as can be.
    pub fn set_switch_cycle(&mut self, switch: usize, cycle: Micros) {
        self.modulators.set_switch_cycle(switch, cycle);
    }

    /// Counts pulses at the inputs of tachometers, a bit for each fan.
    #[inline]
    pub fn count_pulses(&mut self, levels: u8) {
        self.pulses.look(levels);
    }

    /// Returns the pulses of tachometers since boot, by fan, modulo 2^16.
    #[must_use]
    pub const fn pulses(&self) -> [u16; config::MAX_FANS] {
        self.pulses.counts()
    }

    /// Returns the share of full power that a switch gives, 0 to 1. Whether its output has supply is another
    /// matter.
    #[must_use]
    pub fn given(&self, switch: usize) -> f32 {
        self.switches.given(switch)
    }

    /// Sets a digital or sigma-delta switch output; a digital one is [`Duty::OFF`] or [`Duty::FULL`].
    pub fn set_switch(&mut self, switch: usize, duty: Duty) {
        self.switches.modulate(&mut self.modulators, switch, duty);
    }

    /// Sets a switch on a hardware timer, 0 to 1.
    pub fn set_pwm(&mut self, switch: usize, duty: f32) {
        self.switches.set_pwm(&mut self.modulators, switch, duty);
    }

    /// Takes the next switch on a hardware timer that is to be set: its place, and its duty.
    #[inline]
    pub fn take_pwm_change(&mut self) -> Option<(usize, f32)> {
        self.switches.take_pwm_change()
    }

    /// Changes an output at once.
    ///
    /// # Errors
    /// When a target is refused; see [`Self::set_target`].
    pub fn apply(&mut self, output: Output) -> Result<(), TargetRefused> {
        match output {
            Output::Target(heater, target) => self.set_target(heater, target)?,
            Output::Switch(switch, duty) => self.set_switch(usize::from(switch), duty),
            Output::Pwm(switch, duty) => self.set_pwm(usize::from(switch), duty),
        }
        Ok(())
    }

    /// Has an output change when the motors reach a mark.
    ///
    /// # Errors
    /// When too many changes wait: ask again later.
    pub fn ride(&mut self, mark: Mark, output: Output) -> Result<(), Full> {
        self.effects.wait(mark, output)
    }

    /// Changes the outputs that wait for this mark, as the motors have reached it.
    #[inline]
    pub fn reach(&mut self, mark: Mark) {
        self.reached = mark;
        while let Some(output) = self.effects.reached(mark) {
            if let (Err(why), Output::Target(heater, target)) = (self.apply(output), output) {
                self.refused = Some((heater, target, why));
            }
        }
    }

    /// Returns the mark that the motors have reached, as of the last look.
    #[must_use]
    pub const fn reached(&self) -> Mark {
        self.reached
    }

    /// Returns whether changes wait for their places on the path.
    #[must_use]
    pub fn has_effects(&self) -> bool {
        !self.effects.is_empty()
    }

    /// Drops the changes that wait for marks: the path that they belong to was dropped.
    pub fn drop_effects(&mut self) {
        self.effects.clear();
    }

    /// Takes a target that was refused when its place on the path was reached.
    pub fn take_refusal(&mut self) -> Option<(HeaterId, Celsius, TargetRefused)> {
        self.refused.take()
    }

    /// Switches off everything that heats, at once, and drops changes that wait for their places on the path;
    /// the output stage is closed until [`Self::release`].
    pub fn halt(&mut self) {
        self.effects.clear();
        self.halted = true;
        self.fets_enabled = false;
        for heater in &mut self.heaters {
            heater.off();
        }
        self.modulators.heaters_off();
    }

    /// Ends a halt: the output stage opens, targets stay off.
    pub fn release(&mut self) {
        self.halted = false;
        self.fets_enabled = true;
        self.safety.release();
        self.fault = None;
    }

    /// Returns whether a halt has closed the output stage.
    #[must_use]
    pub const fn is_halted(&self) -> bool {
        self.halted
    }

    /// Notes that the executor is alive.
    pub fn executor_alive(&mut self, now: Micros) {
        self.executor_seen = now;
    }

    /// Takes the fault that a sensor's chip reports, in words.
    pub const fn take_chip_fault(&mut self) -> Option<(HeaterId, &'static str)> {
        self.chip_faults.take()
    }

    /// Takes the fault that stopped heating.
    pub fn take_fault(&mut self) -> Option<HeatFault> {
        self.fault.take()
    }

    /// Keeps the readings of the filament width sensor's inputs.
    pub const fn set_filament_width(&mut self, readings: [SensorReading; 2]) {
        self.filament_width = readings;
    }

    /// Returns the last readings of the filament width sensor's inputs.
    #[must_use]
    pub const fn filament_width(&self) -> [SensorReading; 2] {
        self.filament_width
    }

    /// Returns a heater's work since the last call.
    pub fn take_work(&mut self, id: HeaterId) -> Work {
        self.heaters.get_mut(id.index()).map_or(Work::NONE, Heater::take_work)
    }

    /// Reports a tool's extrusion flow, mm3/s. The value counts until the next report, or for a second.
    pub const fn set_flow(&mut self, tool: ToolId, mm3_per_s: f32, now: Micros) {
        (self.flow, self.flow_tool) = ((mm3_per_s, now), Some(tool));
    }

    /// Returns whether some heater's control takes the extrusion flow into account.
    #[must_use]
    pub fn wants_flow(&self) -> bool {
        self.heaters.iter().any(Heater::reckons_with_flow)
    }

    /// Samples every controller that is due. To be called at 100 Hz or more with the latest readings.
    pub fn tick(&mut self, now: Micros, readings: &SensorReadings) {
        self.modulation_ticks_since_control = 0;
        self.chip_faults.look(now, readings);
        if self.any_on() && now.since(self.executor_seen) > EXECUTOR_TIMEOUT {
            let on = self.heaters().find(|(_, heater)| heater.is_on()).map(|(id, _)| id);
            if let Some(heater) = on {
                self.fail(HeatFault { heater, cause: HeatCause::ExecutorSilent });
            }
        }
        for id in HeaterId::all().take(self.heaters.len()) {
            if self.heaters.get(id.index()).is_none_or(|heater| !heater.is_due(now)) {
                continue;
            }
            let read = read_sensor(&self.heaters, |heater| &heater.settings.sensor, readings, id);
            let Some(heater) = self.heaters.get_mut(id.index()) else { break };
            let fan = heater.settings.fan.map_or(0.0, |switch| self.switches.given(usize::from(switch)));
            let (flow, as_of) = self.flow;
            let melts = heater.settings.melts_for.is_some_and(|tool| Some(tool) == self.flow_tool);
            let flow = if melts && now.since(as_of) <= FLOW_STALE { flow } else { 0.0 };
            heater.sample(now, read, Surroundings { fan, flow });
            self.drive_heater(id.index());
        }
        self.switches.tick(&mut self.modulators);
        let heaters = &self.heaters;
        let target = |index: usize| heaters.get(index).map_or(Celsius(0.0), Heater::target);
        if let Some(fault) = self.safety.look(now, readings, target) {
            self.fail(fault);
        }
    }

    /// Does one tick of the sigma-delta modulators, [`MODULATION_HZ`] times a second.
    #[inline]
    pub fn modulation_tick(&mut self) -> OutputLevels {
        self.modulation_ticks_since_control = self.modulation_ticks_since_control.saturating_add(1);
        if self.modulation_ticks_since_control > STALE_MODULATION_TICKS {
            self.modulators.heaters_off();
        }
        self.safety.pass(OutputLevels { on: self.modulators.tick(), fets_enabled: self.fets_enabled })
    }

    fn drive_heater(&mut self, index: usize) {
        let duty = self.heaters.get(index).map_or(Duty::OFF, Heater::duty);
        self.modulators.set_heater(index, duty);
    }

    fn fail(&mut self, fault: HeatFault) {
        self.safety.trip();
        self.halt();
        self.fault.get_or_insert(fault);
    }
}

#[cfg(test)]
mod tests;
