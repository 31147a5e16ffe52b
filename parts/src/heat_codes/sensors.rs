//! M305: the thermistors of the heaters.

use core::fmt::{self, Write};

use base::CodeContext;
use base::failure::{Answer, Failure, Outcome};
use base::ports::HeatPort;
use base::sessions::Reply;
use base::tuning::Tuning;
use config::{SensorConfig, SensorKind, TemperatureConfig, ThermistorConfig};
use drivers::thermistor::BUILT_IN;
use program::Words;
use thermal::Sensor;
use units::{Celsius, HeaterId, Ohms};

use super::named::heater_of;

/// M305: reports the sensors, or changes that of heater S; S alone restores the configured one.
///
/// # Errors
/// When no heater has that id, the words make no thermistor, or the heater is on: its sensor must not change
/// meanwhile.
pub fn sensors(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl HeatPort>,
    tuning: &mut Tuning,
) -> Outcome {
    let Some(id) = heater_of(texts, config, words, 'S')? else {
        for (id, controller) in config.heaters() {
            describe(ports, id, controller, tuning, reply);
        }
        return Ok(Answer::Ok);
    };
    let Some(controller) = config.temperatures.get(id.index()) else { return Ok(Answer::Ok) };
    if controller.sensor.kind != SensorKind::Thermistor {
        return Err(Failure::refused(&"M305: its sensor is no thermistor"));
    }
    let (configured, now) = (controller.sensor.thermistor, thermistor_of(controller, id, tuning));
    let own = if words.count() == 1 { None } else { Some(changed(&configured, &now, words)?) };
    let described = SensorConfig { thermistor: own.unwrap_or(configured), ..controller.sensor };
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
    say_what_follows(&now, &described.thermistor, words, reply);
    Ok(Answer::Ok)
}

fn thermistor_of(controller: &TemperatureConfig, id: HeaterId, tuning: &Tuning) -> ThermistorConfig {
    tuning.thermistors.get(id.index()).copied().flatten().unwrap_or(controller.sensor.thermistor)
}

/// Returns the thermistor with the changes that the words make: a number of the table, with the resistors
/// that it is meant for; or a beta, or coefficients, in the configured divider.
fn changed(
    configured: &ThermistorConfig,
    now: &ThermistorConfig,
    words: &Words<'_>,
) -> Result<ThermistorConfig, Failure> {
    const MIXED: &str = "M305 takes P, or B R X, or I J K, and nothing of another kind";
    let any = |letters: &str| letters.chars().any(|letter| words.has(letter));
    let mut thermistor = ThermistorConfig { r1: configured.r1, r2: configured.r2, ..*now };
    (thermistor.table, thermistor.coefficients, thermistor.rt_curve) = (None, None, None);
    match (any("P"), any("BRX"), any("IJK")) {
        (true, false, false) => {
            let entry = BUILT_IN.iter().find(|entry| words.get('P') == Some(f64::from(entry.index)));
            let entry =
                entry.ok_or_else(|| Failure::refused(&"M305: P is the number of no sensor: see thermistors"))?;
            (thermistor.table, thermistor.use_beta_table) = (Some(entry.name), entry.is_beta());
            (thermistor.r0, thermistor.t0) = (entry.r0, Celsius(25.0));
            (thermistor.r1, thermistor.r2) = (entry.divider.parallel.unwrap_or_default(), entry.divider.pull_up);
        }
        (false, true, false) => {
            if is_steinhart_hart(now) && !words.has('B') {
                return Err(Failure::refused(
                    &"M305: R and X need B: it is described by coefficients, and has no beta",
                ));
            }
            let of_table = table_entry(now).and_then(|entry| entry.beta());
            thermistor.beta_k = words.get('B').or(of_table).unwrap_or(now.beta_k);
            thermistor.r0 = words.get('R').map_or(now.r0, |ohms| Ohms(ohms as f32));
            thermistor.t0 = words.get('X').map_or(now.t0, |celsius| Celsius(celsius as f32));
        }
        (false, false, true) => {
            let described = SensorConfig { thermistor: *now, ..SensorConfig::default() };
            let in_force = match Sensor::from(&described) {
                Sensor::Thermistor(thermistor) if is_steinhart_hart(now) => thermistor.curve.coefficients(),
                _ => [f64::NAN; 3],
            };
            let mut letters = ['I', 'J', 'K'].into_iter();
            let values = in_force.map(|value| letters.next().and_then(|letter| words.get(letter)).unwrap_or(value));
            if values.iter().any(|value| value.is_nan()) {
                return Err(Failure::refused(&"M305: it has a beta and no coefficients yet: I, J and K are needed"));
            }
            thermistor.coefficients = Some(values);
        }
        _ => return Err(Failure::refused(&MIXED)),
    }
    Ok(thermistor)
}

/// Returns whether the thermistor is described by coefficients; otherwise by a beta.
fn is_steinhart_hart(thermistor: &ThermistorConfig) -> bool {
    thermistor.rt_curve.is_some()
        || thermistor.coefficients.is_some()
        || table_entry(thermistor).is_some_and(|entry| !entry.is_beta())
}

/// Reports parameters that have changed without a word for them, and on which the reading depends.
fn say_what_follows(before: &ThermistorConfig, now: &ThermistorConfig, words: &Words<'_>, reply: &mut Reply<'_>) {
    if before.r1 != now.r1 || before.r2 != now.r2 {
        reply.say(format_args!("// NOTE its divider is now r1 = {:.0}, r2 = {:.0}\n", now.r1, now.r2));
    }
    if words.has('B') && is_steinhart_hart(before) && !(words.has('R') && words.has('X')) {
        reply.say(format_args!("// NOTE it has {:.0} at {:.1}\n", now.r0, now.t0));
    }
}

/// Reports a sensor's description and its reading.
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
        (true, thermal::LawSettings::Pid(_)) => "PID",
        (true, thermal::LawSettings::Model(_)) => "a model",
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

/// Returns the words of M305 that describe a thermistor.
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

/// Writes the line that M500 saves for a sensor that a code has changed.
///
/// # Errors
/// When the text is full.
pub fn write_sensor(
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
