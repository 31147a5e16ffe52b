//! M305: the thermistors that heaters are measured by.

use core::fmt::{self, Write};

use config::{MachineConfig, SensorConfig, SensorKind, TemperatureConfig, ThermistorConfig};
use drivers::thermistor::BUILT_IN;
use program::Words;
use units::{Celsius, HeaterId, Ohms};

use super::heater_named;
use crate::failure::{Answer, Failure, Outcome, Texts};
use crate::heat::Sensor;
use crate::ports::HeatPort;
use crate::sessions::Reply;
use crate::tuning::Tuning;

/// M305: says what sensors are, or changes that of heater S; S alone has it as configured again.
///
/// # Errors
/// When nobody has that id, the words make no thermistor, or the heater is on: what it is measured by must
/// not change under it.
pub(crate) fn sensors(
    texts: &Texts,
    ports: &mut impl HeatPort,
    config: &MachineConfig,
    tuning: &mut Tuning,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Outcome {
    let Some(word) = words.get('S') else {
        for (id, controller) in config.heaters() {
            describe(ports, id, controller, tuning, reply);
        }
        return Ok(Answer::Ok);
    };
    let id = heater_named(texts, config, words.code().number, 'S', word)?;
    let Some(controller) = config.temperatures.get(id.index()) else { return Ok(Answer::Ok) };
    if controller.sensor.kind != SensorKind::Thermistor {
        return Err(Failure::refused(&"M305: its sensor is no thermistor"));
    }
    let own = if words.count() == 1 { None } else { Some(changed(&thermistor_of(controller, id, tuning), words)?) };
    let described = SensorConfig { thermistor: own.unwrap_or(controller.sensor.thermistor), ..controller.sensor };
    let sensor = Sensor::from(&described);
    if let Some(flaw) = sensor.flaw() {
        return Err(texts.because(flaw));
    }
    if !ports.heat(|heat| heat.set_sensor(id, sensor)) {
        return Err(Failure::refused(&"M305: the heater is on: switch it off first"));
    }
    if let Some(place) = tuning.thermistors.get_mut(id.index()) {
        *place = own;
    }
    Ok(Answer::Ok)
}

fn thermistor_of(controller: &TemperatureConfig, id: HeaterId, tuning: &Tuning) -> ThermistorConfig {
    tuning.thermistors.get(id.index()).copied().flatten().unwrap_or(controller.sensor.thermistor)
}

/// The thermistor with what the words say of it: a number of the table, or a beta, or all three coefficients.
fn changed(now: &ThermistorConfig, words: &Words<'_>) -> Result<ThermistorConfig, Failure> {
    const MIXED: &str = "M305 takes P, or B R X, or I J and K, and nothing of another kind";
    let any = |letters: &str| letters.chars().any(|letter| words.has(letter));
    let mut thermistor = *now;
    match (any("P"), any("BRX"), any("IJK")) {
        (true, false, false) => {
            let entry = BUILT_IN.iter().find(|entry| words.get('P') == Some(f64::from(entry.index)));
            let entry =
                entry.ok_or_else(|| Failure::refused(&"M305: P is the number of no sensor: see thermistors"))?;
            (thermistor.table, thermistor.use_beta_table) = (Some(entry.name), entry.is_beta());
            (thermistor.coefficients, thermistor.rt_curve, thermistor.r0) = (None, None, entry.r0);
        }
        (false, true, false) => {
            thermistor.beta_k = words.get('B').unwrap_or(thermistor.beta_k);
            thermistor.r0 = words.get('R').map_or(thermistor.r0, |ohms| Ohms(ohms as f32));
            thermistor.t0 = words.get('X').map_or(thermistor.t0, |celsius| Celsius(celsius as f32));
            (thermistor.table, thermistor.coefficients, thermistor.rt_curve) = (None, None, None);
        }
        (false, false, true) => {
            let mut values = now.coefficients.unwrap_or([f64::NAN; 3]);
            for (value, letter) in values.iter_mut().zip(['I', 'J', 'K']) {
                *value = words.get(letter).unwrap_or(*value);
            }
            if values.iter().any(|value| value.is_nan()) {
                return Err(Failure::refused(&"M305: I, J and K belong together"));
            }
            (thermistor.table, thermistor.coefficients, thermistor.rt_curve) = (None, Some(values), None);
        }
        _ => return Err(Failure::refused(&MIXED)),
    }
    Ok(thermistor)
}

/// What a sensor is and what it says.
fn describe(
    ports: &mut impl HeatPort,
    id: HeaterId,
    controller: &TemperatureConfig,
    tuning: &Tuning,
    reply: &mut Reply<'_>,
) {
    let Some((settings, reading, fault, target)) = ports.heat(|heat| {
        let heater = heat.heater(id)?;
        Some((heater.settings.clone(), heater.reading(), heater.fault(), heater.target()))
    }) else {
        return;
    };
    let (name, tool_id) = (&controller.designator, controller.tool_id);
    let how = match (settings.heats, settings.law) {
        (false, _) => "Readonly",
        (true, crate::heat::LawSettings::Pid(_)) => "PID",
        (true, crate::heat::LawSettings::Model(_)) => "a model",
        _ => "Bang bang",
    };
    reply.say(format_args!("{name}(S{tool_id}): using {how} - active: {}\n", u8::from(target.0 > 0.0)));
    if let (Sensor::Thermistor(thermistor), Some(celsius)) = (settings.sensor, reading) {
        let (code, ohms) = (thermistor.code(celsius).0, thermistor.curve.ohms(celsius).0);
        let [c1, c2, c3] = thermistor.curve.coefficients();
        if let Some(input) = controller.sensor.thermistor.input {
            reply.say(format_args!("ADC1_{}: ", input.0));
        }
        reply.say(format_args!("adc= {code}, resistance= {ohms:.6}, temp= {:.6}\n", celsius.0));
        reply.say(format_args!("S/H c1= {c1:.12}, c2= {c2:.12}, c3= {c3:.12}\n"));
    }
    if let Some(fault) = fault {
        reply.say(format_args!("{name}(S{tool_id}): {}\n", fault.message()));
    }
    if controller.sensor.kind != SensorKind::Thermistor {
        let celsius = reading.map_or(f32::NAN, |celsius| celsius.0);
        reply.say(format_args!("sensor= {}, temp= {celsius:.6}\n\n", controller.sensor.kind.word()));
        return;
    }
    let described = thermistor_of(controller, id, tuning);
    if let Some(entry) = table_entry(&described) {
        let table = if entry.is_beta() { "Beta" } else { "S/H" };
        reply.say(format_args!("Using predefined thermistor {} in {table} table: {}\n", entry.index, entry.name));
    }
    for (letter, value) in values(&described) {
        reply.say(format_args!("{name}(S{tool_id}): {letter} {value:.12}\n"));
    }
    reply.say(format_args!("\n"));
}

fn table_entry(thermistor: &ThermistorConfig) -> Option<&'static drivers::thermistor::BuiltIn> {
    let name = thermistor.table.filter(|_| thermistor.coefficients.is_none() && thermistor.rt_curve.is_none())?;
    drivers::thermistor::BuiltIn::named(name, thermistor.use_beta_table)
}

/// The words of M305 that describe a thermistor.
fn values(thermistor: &ThermistorConfig) -> heapless::Vec<(char, f64), 3> {
    let mut values = heapless::Vec::new();
    match (table_entry(thermistor), thermistor.coefficients) {
        (Some(entry), _) => values.extend([('P', f64::from(entry.index))]),
        (None, Some([c1, c2, c3])) => values.extend([('I', c1), ('J', c2), ('K', c3)]),
        (None, None) => values.extend([
            ('B', thermistor.beta_k),
            ('R', f64::from(thermistor.r0.0)),
            ('X', f64::from(thermistor.t0.0)),
        ]),
    }
    values
}

/// The line that M500 saves of a sensor that a code has changed.
///
/// # Errors
/// When the text is full.
pub(crate) fn write_sensor(
    text: &mut impl Write,
    controller: &TemperatureConfig,
    id: HeaterId,
    tuning: &Tuning,
) -> fmt::Result {
    let Some(thermistor) = tuning.thermistors.get(id.index()).copied().flatten() else { return Ok(()) };
    write!(text, ";Thermistor settings:\nM305 S{}", controller.tool_id)?;
    for (letter, value) in values(&thermistor) {
        write!(text, " {letter}{value:.12}")?;
    }
    writeln!(text)
}
