//! `tune_driver X chopper`: off time and hysteresis of spreadCycle, computed from the coil data of the
//! motor's data sheet, the supply voltage that the board measures, and the current that is set.
//!
//! No reading of these chips says how good a chopper is, so nothing can be measured by moving.

use base::failure::{Answer, Failure, Outcome};
use base::ports::{ChopperFit, Coil, MotorDrivers};
use units::{Actuator, Axis};

use super::strokes;
use crate::endstop_phase::PhaseHands;

/// # Errors
/// If a figure is missing, with the place to write it; when the supply does not drive the current through the
/// coil; when the driver does not take the settings.
pub fn tune<'c>(hands: &mut impl PhaseHands<'c>, letter: char) -> Outcome {
    let config = hands.config();
    let axis = Axis::from_letter(letter).ok_or_else(|| hands.texts().because(super::USAGE))?;
    let motor = Actuator::from_index(axis as usize).filter(|motor| config.actuators[*motor].present);
    let motor = motor.ok_or_else(|| Failure::refused(&"that axis has no motor"))?;
    let name = motor.name();
    let written = config.actuators[motor].coil;
    let (Some(resistance), Some(henries)) = (written.resistance, written.henries) else {
        return Err(hands.texts().refused(format_args!(
            "write [actuator] {name}.coil_resistance and {name}.coil_inductance, as the motor's data sheet has them"
        )));
    };
    let supply =
        hands.voltage("vmotor").ok_or_else(|| Failure::refused(&"the motor supply is not measured: vmotor"))?;
    let coil = Coil { resistance, henries };
    let (fit, current) = hands.drivers(|drivers| (drivers.fit_chopper(motor, coil, supply), drivers.current(motor)));
    let fit = fit.map_err(|fault| strokes::silent(hands.texts(), motor, fault))?;
    let amps = current.map_or(0.0, |current| current.0);
    let Some(fit) = fit else {
        return Err(hands
            .texts()
            .refused(format_args!("{:.1} V do not drive {amps:.2} A through {:.2} Ohm", supply.0, resistance.0)));
    };
    hands.tuning().choppers[motor] = Some(fit);
    explain(hands, (supply.0, resistance.0, henries * 1e3, amps), &fit);
    Ok(Answer::Ok)
}

fn explain<'c>(
    hands: &mut impl PhaseHands<'c>,
    (volts, ohms, millihenries, amps): (f32, f32, f32, f32),
    fit: &ChopperFit,
) {
    let (off_us, blank_us) = (fit.off_s * 1e6, fit.blank_s * 1e6);
    let (rise, fall) = (fit.rise.0 * 1e3, fit.fall.0 * 1e3);
    hands.say(format_args!("// {volts:.1} V, {amps:.2} A, {ohms:.2} Ohm, {millihenries:.2} mH\n"));
    hands.say(format_args!(
        "// off_time {}: {off_us:.1} us, twice in a cycle, for 25 kHz; the current falls by {fall:.0} mA meanwhile\n",
        fit.off_time
    ));
    hands.say(format_args!(
        "// blanking {} clocks: {blank_us:.1} us, as it was; the current rises by {rise:.0} mA unmeasured\n",
        fit.blank_clocks
    ));
    let (start, end) = (fit.hysteresis_start, fit.hysteresis_end);
    let total = i16::from(start) + i16::from(end);
    hands.say(format_args!("// hysteresis start {start}, end {end}: {total}, where {:.1} cover both\n", fit.needed));
    if f32::from(total) < fit.needed {
        hands.say(format_args!(
            "WARNING: that is the most there is: a shorter blanking time, less supply, or a motor of more inductance\n"
        ));
    }
    hands.say(format_args!("Computed, not measured: listen, and feel the motor. In use until reset: keep with M500\n"));
}
