//! M404 to M407 and M412: the filament detector with Smoothieware v2's codes, and the filament width sensor
//! with Marlin's and Klipper's.

use base::CodeContext;
use base::failure::{Answer, Failure, Outcome};
use base::ports::HeatPort;
use base::sessions::Reply;
use base::tuning::Tuning;
use config::MachineConfig;
use program::Words;
use units::{Micros, Mm};

use super::Filament;
use super::width::{Width, raw_of};

/// Runs M404 to M407 and M412, which the detector and the width sensor share. Each part answers for itself;
/// without either the codes are unknown.
///
/// # Errors
/// For words of a part that is not there.
pub fn told(
    CodeContext { config, words, reply, .. }: CodeContext<'_, impl HeatPort>,
    (filament, width): (&mut Filament, &mut Width),
    tuning: &mut Tuning,
) -> Outcome {
    if !(config.filament_detector.enable || config.filament_width.enable) {
        return Ok(Answer::Unknown);
    }
    let mut switch = |on: bool, tuning: &Tuning| {
        filament.switch(on);
        width.switch(&tuning.filament_width, on);
    };
    match words.code().number {
        404 => tell_settings(config, tuning, words, reply)?,
        405 => switch(false, tuning),
        406 => {
            if let Some(cm) = words.get('D') {
                needs_sensor(config)?;
                tuning.filament_width.delay = Mm(cm * 10.0);
            }
            switch(true, tuning);
        }
        412 if words.has('S') => switch(words.get('S') != Some(0.0), tuning),
        _ => {
            filament.report(config, tuning, reply);
            if config.filament_width.enable {
                report(width, tuning, reply);
            }
        }
    }
    Ok(Answer::Ok)
}

/// Runs M404.1 to M407.2, which are Klipper's commands of the width sensor alone.
///
/// # Errors
/// When there is no width sensor.
pub fn told_of_width(
    CodeContext { ports, config, words, reply, .. }: CodeContext<'_, impl HeatPort>,
    width: &mut Width,
    tuning: &mut Tuning,
) -> Outcome {
    needs_sensor(config)?;
    let readings = ports.heat(|heat| heat.filament_width());
    let sensor = &mut tuning.filament_width;
    let code = words.code();
    match (code.number, code.subcode) {
        (404, _) => {
            width.forget(sensor);
            reply.say(format_args!("// What was measured of the filament is forgotten\n"));
        }
        (405, _) => width.switch(sensor, false),
        (406, _) => width.switch(sensor, true),
        (_, 1) => {
            let mut sum = 0.0;
            for (place, input) in sensor.live_inputs() {
                let raw = readings.get(place).copied().map_or(0.0, raw_of);
                sum += raw;
                reply.say(format_args!("ADC1_{}={raw:.0} ", input.0));
            }
            reply.say(format_args!("RAW={sum:.0}\n"));
        }
        _ => {
            sensor.log = words.get('S').map_or(sensor.log, |on| on != 0.0);
            reply.say(format_args!("// The filament's width is {}said\n", if sensor.log { "" } else { "not " }));
        }
    }
    Ok(Answer::Ok)
}

fn needs_sensor(config: &MachineConfig) -> Result<(), Failure> {
    match config.filament_width.enable {
        true => Ok(()),
        false => Err(Failure::refused(&"there is no sensor of the filament's width: [filament width sensor] enable")),
    }
}

fn tell_settings(
    config: &MachineConfig,
    tuning: &mut Tuning,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Result<(), Failure> {
    if let Some(nominal) = words.get('W') {
        needs_sensor(config)?;
        tuning.filament_width.nominal = Mm(nominal);
    }
    let detector = &mut tuning.filament;
    detector.leave_heaters_on = words.get('H').map_or(detector.leave_heaters_on, |on| on != 0.0);
    if config.filament_detector.enable {
        if let Some(seconds) = words.get('S') {
            detector.check_every = Micros::from_millis((seconds * 1000.0) as u64);
        }
        detector.pulses_per_mm = words.get('P').unwrap_or(detector.pulses_per_mm);
        reply.say(format_args!(
            "// pulses per mm: {:.6}, seconds per check: {}, heaters: {}\n",
            detector.pulses_per_mm,
            detector.check_every.0 as f64 / 1e6,
            if detector.leave_heaters_on { "on" } else { "off" }
        ));
    } else if words.has('S') || words.has('P') {
        return Err(Failure::refused(&"M404 S and P: there is no [filament detector]"));
    }
    if config.filament_width.enable {
        let sensor = &tuning.filament_width;
        let (nominal, delay) = (sensor.nominal.0, sensor.delay.0);
        reply.say(format_args!("// Filament dia (nominal mm): {nominal:.3}, {delay} mm from the nozzle\n"));
    }
    Ok(())
}

/// Answers M407 with the words that hosts look for.
fn report(width: &Width, tuning: &Tuning, reply: &mut Reply<'_>) {
    match width.measured() {
        Ok(diameter) => reply.say(format_args!("Filament dia (measured mm): {:.3}\n", diameter.0)),
        Err(why) => reply.say(format_args!("Filament dia: ADC1_{} gives no signal, {:.0}\n", why.input.0, why.raw)),
    }
    let corrects = if tuning.filament_width.correct_flow { ", and corrects the flow" } else { "" };
    let state = if width.is_on() { "en" } else { "dis" };
    reply.say(format_args!("Filament width sensor is {state}abled{corrects}\n"));
}
