//! Filament whose thickness changes along it, and the sensor that it is pulled through.

use super::World;
use super::config::AnalogInput;
use crate::models::thermistor::REFERENCE_VOLTS;

/// Thickness of filament if nothing else is said, millimetres.
const USUAL_MM: f64 = 1.75;

impl World {
    /// Sets the filament's diameter from each of these places on, both in millimetres; 0 is the nozzle's
    /// place at power-on. Before the first the diameter is 1.75 mm.
    pub fn thread_filament(&mut self, pieces: &[(f64, f64)]) {
        self.filament.pieces = pieces.to_vec();
    }

    /// Pushes in or pulls the plug of the width sensor.
    pub const fn plug_filament_sensor(&mut self, plugged: bool) {
        self.filament.plugged = plugged;
    }

    /// Returns the thickness of the filament that was, or will be, at the nozzle when the extruder stands
    /// here, mm.
    #[must_use]
    pub fn filament_mm(&self, at_mm: f64) -> f64 {
        let piece = self.filament.pieces.iter().rev().find(|(from, _)| *from <= at_mm);
        piece.map_or(USUAL_MM, |(_, diameter)| *diameter)
    }

    /// Returns the voltage of the sensor on this input; `None` when there is none, or its plug is pulled.
    pub(super) fn filament_volts(&self, input: AnalogInput) -> Option<f64> {
        let sensor = self.config.filament_sensor.filter(|sensor| sensor.inputs.contains(&Some(input)))?;
        let pushed = self.carriage_mm(sensor.motor)?;
        let [at_nothing, per_mm] = sensor.volts;
        let volts = at_nothing + per_mm * self.filament_mm(pushed + sensor.to_nozzle_mm);
        self.filament.plugged.then_some(volts.clamp(0.0, REFERENCE_VOLTS))
    }
}
