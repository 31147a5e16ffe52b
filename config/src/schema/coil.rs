//! `[actuator]`: what a motor's data sheet says of its coils.

use super::Setting;
use super::build::number;
use crate::machine::{CoilConfig, MachineConfig};
use units::Ohms;

fn of(config: &mut MachineConfig, place: usize) -> Option<&mut CoilConfig> {
    config.actuators.0.get_mut(place).map(|motor| &mut motor.coil)
}

pub(super) const RESISTANCE: Setting = number(
    "coil_resistance",
    "0",
    &(0.01, 1_000.0),
    |c, i, v| {
        if let Some(coil) = of(c, i) {
            coil.resistance = Some(Ohms(v as f32));
        }
    },
    "Resistance of one coil, from the motor's data sheet: tune_driver computes the chopper from it.",
)
.derived("not known")
.unit("Ohm")
.typical(&(0.3, 100.0))
.velvet();

pub(super) const INDUCTANCE: Setting = number(
    "coil_inductance",
    "0",
    &(0.01, 1_000.0),
    |c, i, v| {
        if let Some(coil) = of(c, i) {
            coil.henries = Some(v as f32 * 1e-3);
        }
    },
    "Inductance of one coil, from the motor's data sheet: tune_driver computes the chopper from it.",
)
.derived("not known")
.unit("mH")
.typical(&(0.3, 100.0))
.velvet();
