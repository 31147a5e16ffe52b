//! A single heater, or a sensor without one: its control law, target and duty.

use units::{Celsius, Duty, Micros};

use super::{HeaterSettings, Law, LawSettings, OFF_BELOW, Sensor, SensorFault, StepTest, Surroundings};
use crate::filter::Filter;

/// Distance from the target, C, within which a heater counts as holding it.
const HOLDS_WITHIN: f32 = 5.0;

/// Reason why a target was not set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TargetRefused {
    /// The target is above `max_temp`, which is this.
    AboveMaximum(Celsius),
    /// The temperature control only reads.
    HasNoHeater,
}

/// Work of a heater since it was asked last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Time with a target.
    pub on: Micros,
    /// Time at full power that gives the same heat, s.
    pub full_s: f32,
}

impl Work {
    /// Work of a heater that was off.
    pub const NONE: Self = Self { on: Micros(0), full_s: 0.0 };
}

/// A single temperature controller or read-only sensor.
#[derive(Clone, Debug)]
pub struct Heater {
    /// Settings, of which M-codes may change gains and limits at run time.
    pub settings: HeaterSettings,
    law: Law,
    reading: Result<Celsius, SensorFault>,
    filter: Filter,
    target: Celsius,
    duty: Duty,
    due: Micros,
    work: Work,
}

impl Heater {
    pub(super) fn new(settings: HeaterSettings) -> Self {
        let law = Law::new(&settings.law, settings.max_duty);
        let (reading, target, duty) = (Err(SensorFault::SILENT), Celsius(0.0), Duty::OFF);
        let filter = Filter::new(settings.filter_s, settings.period);
        Self { settings, law, reading, filter, target, duty, due: Micros(0), work: Work::NONE }
    }

    /// Latest temperature, filtered; `None` when the sensor gives none.
    #[must_use]
    pub fn reading(&self) -> Option<Celsius> {
        self.reading.ok()
    }

    /// Returns the reason why there is no temperature.
    #[must_use]
    pub fn fault(&self) -> Option<SensorFault> {
        self.reading.err()
    }

    /// Returns the target; 0 is off.
    #[must_use]
    pub const fn target(&self) -> Celsius {
        self.target
    }

    /// Returns the output's duty.
    #[must_use]
    pub const fn duty(&self) -> Duty {
        self.duty
    }

    /// Returns whether the heater is asked to heat.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.target > OFF_BELOW
    }

    /// Returns the power for holding the target beyond what the model explains, as a share of the explained;
    /// below zero: less. `None` off the target, or without a model.
    #[must_use]
    pub fn surplus(&self) -> Option<f32> {
        let holds = self.is_on() && (self.reading()?.0 - self.target.0).abs() < HOLDS_WITHIN;
        self.law.surplus().filter(|_| holds)
    }

    /// Returns whether the next sample is due.
    pub(super) fn is_due(&self, now: Micros) -> bool {
        now >= self.due
    }

    /// Returns whether the control law uses the flow of the tool that it heats.
    pub(super) const fn reckons_with_flow(&self) -> bool {
        matches!(self.law, Law::Model(_)) && self.settings.melts_for.is_some()
    }

    /// Returns the heater's work since the last call.
    pub(super) const fn take_work(&mut self) -> Work {
        core::mem::replace(&mut self.work, Work::NONE)
    }

    /// Clears the target and the duty.
    pub(super) const fn off(&mut self) {
        (self.target, self.duty) = (Celsius(0.0), Duty::OFF);
    }

    /// Takes another sensor, whose readings are not known yet.
    pub(super) fn set_sensor(&mut self, sensor: Sensor) {
        self.settings.sensor = sensor;
        self.filter.restart();
    }

    /// Exchanges the control law's settings.
    pub(super) fn set_law(&mut self, law: LawSettings, max_duty: Duty) {
        self.settings.law = law;
        self.settings.max_duty = max_duty;
        self.go_on_with(law, max_duty);
    }

    /// Exchanges the control law, which goes on from the present reading and output.
    pub(super) fn go_on_with(&mut self, law: LawSettings, max_duty: Duty) {
        self.law = Law::new(&law, max_duty);
        self.law.start(self.reading().unwrap_or_default(), self.duty);
    }

    /// Swings around the target to find the heater's response, in air of this temperature, until
    /// [`HeatControl::set_law`](crate::HeatControl::set_law).
    pub fn start_tuning(&mut self, swings: u8, air: Celsius) {
        self.law = Law::Tuning(StepTest::new(self.settings.max_duty, swings, air));
    }

    /// Returns the tuning under way, with its findings so far.
    #[must_use]
    pub const fn tuning(&self) -> Option<&StepTest> {
        match &self.law {
            Law::Tuning(test) => Some(test),
            _ => None,
        }
    }

    pub(super) fn set_target(&mut self, target: Celsius) -> Result<(), TargetRefused> {
        let wanted = if target.0.is_finite() && target > OFF_BELOW { target } else { Celsius(0.0) };
        if wanted > Celsius(0.0) && !self.settings.heats {
            return Err(TargetRefused::HasNoHeater);
        }
        if wanted > self.settings.max {
            return Err(TargetRefused::AboveMaximum(self.settings.max));
        }
        if !self.is_on() {
            self.law.start(self.reading().unwrap_or_default(), self.duty);
        }
        self.target = wanted;
        if !self.is_on() {
            self.duty = Duty::OFF;
        }
        Ok(())
    }

    /// Takes a sample and computes the duty. Without a believable reading the heater is off;
    /// [`HeatSafety`](crate::safety::HeatSafety) decides whether the reading is a fault.
    pub(super) fn sample(&mut self, now: Micros, read: Result<Celsius, SensorFault>, around: Surroundings) {
        self.due = now.plus(self.settings.period);
        if self.is_on() {
            self.work.on = self.work.on.plus(self.settings.period);
            self.work.full_s += f32::from(self.duty.0) / f32::from(Duty::FULL.0) * self.settings.period.0 as f32 / 1e6;
        }
        self.reading = self.filter.pass(read);
        let allowed = self.settings.min..=self.settings.max;
        let believable = read.is_ok_and(|read| allowed.contains(&read));
        self.duty = match self.reading().filter(|_| self.is_on() && believable) {
            Some(reading) => self.law.update(self.target, reading, self.settings.period, around),
            None => Duty::OFF,
        };
    }
}
