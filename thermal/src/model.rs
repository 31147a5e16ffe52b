//! Model-based control law: heat in, heat to the air, to the part's fan and into filament, and a sensor that
//! tells late.
//!
//! C dT/dt = P u - (k + k_fan fan + h flow) (T - air) - C d, and L dT_s/dt = T - T_s. T is the body, T_s its
//! sensor, L the dead time and lag of the sensor as one. A Luenberger observer (D. G. Luenberger, IEEE Trans.
//! Automatic Control 16, 1971) runs the same equations with the output that was given, and moves its T, T_s
//! and d by what the sensor says: its three poles lie at 1/L. Influences that the model does not know
//! (drafts, the supply's voltage, an air of another temperature) come to lie in d, so there is no error at
//! rest, and nothing winds up while the output is at a limit, since the observer knows the limit. The output
//! brings T to the target within about 2 L and makes up for the losses of a body that is as warm as this: so
//! a fan or a flow that is known is made up for before the sensor tells of it.

use units::{Celsius, Duty};

use crate::law::Steps;

/// Temperature of the air from which losses count. The observer finds the difference to the real air.
pub const AIR_C: f32 = 25.0;
/// Time in which the body comes to the target, as a multiple of the sensor's lag.
const CLOSED_LOOP: f32 = 2.0;
/// Least lag of a sensor that the law assumes, s.
const QUICKEST_S: f32 = 0.5;
/// Greatest rate of the observer's poles, as a share of what the sample period allows.
const MOST_POLE: f32 = 0.3;

/// Parameters of a heater.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelSettings {
    /// Power of the heater at full output, W.
    pub power_w: f32,
    /// Heat capacity of the heated body, J/K.
    pub capacity: f32,
    /// Loss to still air, W/K.
    pub loss: f32,
    /// Additional loss with the part's fan full on, W/K.
    pub fan_loss: f32,
    /// Dead time and lag of the sensor, s.
    pub late_s: f32,
    /// Heat that filament takes, J/(mm3 K).
    pub filament_heat: f32,
}

impl ModelSettings {
    /// Returns whether a heater may be controlled by the model: every figure that divides is above zero.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        [self.power_w, self.capacity, self.late_s].into_iter().all(|figure| figure.is_finite() && figure > 0.0)
            && [self.loss, self.fan_loss, self.filament_heat].into_iter().all(|figure| figure >= 0.0)
    }
}

/// Known heat losses beside that to the air.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surroundings {
    /// Duty of the part's fan, 0 to 1.
    pub fan: f32,
    /// Filament that is melted, mm3/s.
    pub flow: f32,
}

/// The law with its memory.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    settings: ModelSettings,
    max: f32,
    /// Estimates: temperatures of the body and of the sensor, degrees; unmodelled cooling, degrees a second.
    body: f32,
    felt: f32,
    unknown: f32,
    output: f32,
    /// Modelled heat loss of the body, W.
    lost_w: f32,
    steps: Steps,
}

/// Least modelled loss, as a share of full power, with which the unmodelled is compared.
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
        // Neither clamp nor cast keeps a NaN out.
        self.output = if output.is_finite() { output.clamp(0.0, self.max) } else { 0.0 };
        self.steps.next(self.output)
    }

    /// Returns the power beyond what the model explains, as a share of the explained; below zero: less.
    /// `None` if the model explains next to nothing.
    pub(super) fn surplus(&self) -> Option<f32> {
        let is_much = self.lost_w > KNOWN * self.settings.power_w;
        is_much.then(|| self.settings.capacity * self.unknown / self.lost_w)
    }

    /// Advances the observer a step, with the output that was given since the last.
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
