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

use config::ModelSettings;
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
        self.output = if output.is_finite() { units::within(output, 0.0, self.max) } else { 0.0 };
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

#[cfg(test)]
mod tests {
    use super::*;

    const HOTEND: ModelSettings =
        ModelSettings { power_w: 40.0, capacity: 12.0, loss: 0.09, fan_loss: 0.05, late_s: 3.0, filament_heat: 0.0015 };

    /// Controls a heater that is as the model says for ten minutes, in these surroundings; returns the law,
    /// the last reading, and the furthest that it went beyond its target.
    fn controlled(around: Surroundings, unmodelled_w: f32) -> (Model, f32, f32) {
        let target = 200.0;
        let mut law = Model::new(HOTEND, Duty::FULL);
        let (mut body, mut felt, mut over) = (AIR_C, AIR_C, 0.0_f32);
        law.start(Celsius(felt));
        for _ in 0..600 * 20 {
            let duty = law.update(target, felt, 0.05, around);
            let loss = HOTEND.loss + HOTEND.fan_loss * around.fan + HOTEND.filament_heat * around.flow;
            let watts = f32::from(duty.0) / 255.0 * HOTEND.power_w - loss * (body - AIR_C) - unmodelled_w;
            body += watts / HOTEND.capacity * 0.05;
            felt += (body - felt) / HOTEND.late_s * 0.05;
            over = over.max(felt - target);
        }
        (law, felt, over)
    }

    #[test]
    fn a_heater_that_is_as_its_model_settles_without_overshoot_and_without_surplus() {
        for (fan, flow) in [(0.0, 0.0), (1.0, 0.0), (0.5, 8.0)] {
            let (law, felt, over) = controlled(Surroundings { fan, flow }, 0.0);
            assert!((felt - 200.0).abs() < 0.3 && over < 2.0, "settles at {felt}, {over} beyond");
            let surplus = law.surplus().expect("a loss that is known");
            assert!(surplus.abs() < 0.02, "{surplus} with fan {fan} and flow {flow}");
        }
    }

    #[test]
    fn heat_that_the_model_does_not_know_is_found_as_surplus() {
        let known_w = HOTEND.loss * (200.0 - AIR_C);
        for watts in [-3.0, 2.0, 6.0] {
            let (law, felt, _) = controlled(Surroundings::default(), watts);
            let surplus = law.surplus().expect("a loss that is known");
            assert!((felt - 200.0).abs() < 0.3 && (surplus - watts / known_w).abs() < 0.03, "{watts} W: {surplus}");
        }
    }

    #[test]
    fn a_model_that_divides_by_nothing_is_not_used() {
        assert!(HOTEND.is_usable());
        for wrong in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(!ModelSettings { power_w: wrong, ..HOTEND }.is_usable());
            assert!(!ModelSettings { capacity: wrong, ..HOTEND }.is_usable());
            assert!(!ModelSettings { late_s: wrong, ..HOTEND }.is_usable());
        }
        for wrong in [-0.1, f32::NAN] {
            assert!(!ModelSettings { loss: wrong, ..HOTEND }.is_usable());
            assert!(!ModelSettings { fan_loss: wrong, ..HOTEND }.is_usable());
            assert!(!ModelSettings { filament_heat: wrong, ..HOTEND }.is_usable());
        }
        assert!(ModelSettings { loss: 0.0, fan_loss: 0.0, filament_heat: 0.0, ..HOTEND }.is_usable());
    }
}
