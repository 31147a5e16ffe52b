//! A control law that knows its heater: heat in, heat to the air, to the part's fan and into filament, and a
//! sensor that tells late.
//!
//! C dT/dt = P u - (k + k_fan fan + h flow) (T - air) - C d, and L dT_s/dt = T - T_s. T is the body, T_s its
//! sensor, L the dead time and lag of the sensor as one. A Luenberger observer (D. G. Luenberger, IEEE Trans.
//! Automatic Control 16, 1971) runs the same equations with the output that was given, and moves its T, T_s
//! and d by what the sensor says: its three poles lie at 1/L. What the model does not know (drafts, the
//! supply's voltage, an air of another temperature) comes to lie in d, so there is no error at rest, and
//! nothing winds up while the output is at a limit, since the observer knows the limit. The output is what
//! brings T to the target within about 2 L and makes up for the losses of a body that is as warm as this one:
//! so a fan or a flow that is known is made up for before the sensor tells of it.

use units::{Celsius, Duty};

use super::law::Steps;

/// The temperature of the air that losses count from. Where it is another, the observer finds the difference.
pub const AIR_C: f32 = 25.0;
/// The body comes to the target within so many times the sensor's lag.
const CLOSED_LOOP: f32 = 2.0;
/// No sensor is told to be quicker, s.
const QUICKEST_S: f32 = 0.5;
/// The observer's poles stay this far within what the sample period allows.
const MOST_POLE: f32 = 0.3;

/// What is known of a heater.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelSettings {
    /// Of the heater at full output, W.
    pub power_w: f32,
    /// Heat capacity of what it heats, J/K.
    pub capacity: f32,
    /// To still air, W/K.
    pub loss: f32,
    /// More with the part's fan full on, W/K.
    pub fan_loss: f32,
    /// Dead time and lag of the sensor, s.
    pub late_s: f32,
    /// What filament takes, J/(mm3 K).
    pub filament_heat: f32,
}

impl ModelSettings {
    /// Whether a heater may be controlled by it: every figure that divides is above zero.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        [self.power_w, self.capacity, self.late_s].into_iter().all(|figure| figure.is_finite() && figure > 0.0)
            && [self.loss, self.fan_loss, self.filament_heat].into_iter().all(|figure| figure >= 0.0)
    }
}

/// What takes heat beside the air, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surroundings {
    /// Duty of the part's fan, 0 to 1.
    pub fan: f32,
    /// Filament that is melted, mm3/s.
    pub flow: f32,
}

/// The law and its memory.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    settings: ModelSettings,
    max: f32,
    /// Estimates: of the body, of what the sensor reads, degrees; of what the model does not know, degrees a
    /// second that it cools.
    body: f32,
    felt: f32,
    unknown: f32,
    output: f32,
    /// What the body loses as far as the model knows, W.
    lost_w: f32,
    steps: Steps,
}

/// Of so much of full output the model must know before what it does not know is compared with it.
const KNOWN: f32 = 0.05;

impl Model {
    pub(super) fn new(settings: ModelSettings, max: Duty) -> Self {
        let (body, felt) = (AIR_C, AIR_C);
        let steps = Steps::default();
        Self { settings, max: f32::from(max.0), body, felt, unknown: 0.0, output: 0.0, lost_w: 0.0, steps }
    }

    pub(super) fn start(&mut self, Celsius(reading): Celsius) {
        let (body, felt) = (reading, reading);
        *self = Self { body, felt, unknown: 0.0, output: 0.0, lost_w: 0.0, steps: Steps::default(), ..*self };
    }

    pub(super) fn update(&mut self, target: f32, reading: f32, dt: f32, around: Surroundings) -> Duty {
        let settings = self.settings;
        let loss = settings.loss + settings.fan_loss * around.fan + settings.filament_heat * around.flow;
        self.observe(reading, loss, dt);
        self.lost_w = loss * (self.body - AIR_C);
        let late = settings.late_s.max(QUICKEST_S);
        let missing = (target - self.body) / (CLOSED_LOOP * late);
        let watts = settings.capacity * (missing + self.unknown) + self.lost_w;
        let output = watts / settings.power_w.max(f32::MIN_POSITIVE) * f32::from(Duty::FULL.0);
        // Neither clamp nor cast lets a figure through that is none.
        self.output = if output.is_finite() { output.clamp(0.0, self.max) } else { 0.0 };
        self.steps.next(self.output)
    }

    /// What it takes beyond what the model explains, as a share of that; below zero: less. None where the
    /// model explains next to nothing.
    pub(super) fn surplus(&self) -> Option<f32> {
        let is_much = self.lost_w > KNOWN * self.settings.power_w;
        is_much.then(|| self.settings.capacity * self.unknown / self.lost_w)
    }

    /// One step of the observer, with the output that was given since the last one.
    fn observe(&mut self, reading: f32, loss: f32, dt: f32) {
        let ModelSettings { power_w, capacity, late_s, .. } = self.settings;
        let late = late_s.max(QUICKEST_S);
        let pole = (1.0 / late).min(MOST_POLE / dt);
        let error = reading - self.felt;
        let heat = power_w * self.output / f32::from(Duty::FULL.0) - loss * (self.body - AIR_C);
        let body = heat / capacity - self.unknown + 3.0 * pole * pole * late * error;
        let felt = (self.body - self.felt) / late + (3.0 * pole - 1.0 / late).max(0.0) * error;
        self.unknown -= pole * pole * pole * late * error * dt;
        self.body += body * dt;
        self.felt += felt * dt;
    }
}
