//! Sensors behind a converter chip on SPI: what each kind needs, and what it cannot mean.

use super::findings::Checks;
use crate::machine::{SensorKind, TemperatureConfig};
use crate::pin::Pin;
use units::{Celsius, Ohms};

const SECTION: &str = "temperature control";

/// Settings that mean something for some kinds of sensors only.
const ONLY_FOR: &[(&str, &[SensorKind])] = {
    use SensorKind::{Max31855, Max31856, Max31865};
    &[
        ("spi_channel", &[Max31855, Max31856, Max31865]),
        ("spi_select_pin", &[Max31855, Max31856, Max31865]),
        ("tc_type", &[Max31856]),
        ("tc_averaging", &[Max31855, Max31856]),
        ("mains_frequency", &[Max31856, Max31865]),
        ("rtd_wires", &[Max31865]),
        ("rtd_nominal", &[Max31865]),
        ("rtd_reference", &[Max31865]),
    ]
};
/// A reference resistor is so many times the sensor's nominal resistance, at least and at most.
const USUAL_RATIO: core::ops::RangeInclusive<f32> = 2.0..=8.0;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, heater) in config.temperatures.iter().enumerate().filter(|(_, heater)| heater.enable) {
        strangers(checks, place, heater);
        if heater.sensor.kind.is_on_spi() {
            connection(checks, place, heater);
        }
        match heater.sensor.kind {
            SensorKind::Max31856 => thermocouple(checks, place, heater),
            SensorKind::Max31865 => platinum(checks, place, heater),
            _ => {}
        }
    }
}

/// Reports settings that mean nothing for this kind of sensor.
fn strangers(checks: &mut Checks<'_, '_>, place: usize, heater: &TemperatureConfig) {
    let kind = heater.sensor.kind;
    for (key, kinds) in ONLY_FOR.iter().filter(|(_, kinds)| !kinds.contains(&kind)) {
        let path = crate::ledger::Path::named(SECTION, place, key);
        let is_written = path.is_some_and(|path| checks.ledger.span(path).is_some());
        let means_nothing = match *key {
            "spi_channel" => heater.sensor.spi.channel.is_none(),
            "spi_select_pin" => heater.sensor.spi.select_pin.is_none(),
            _ => false,
        };
        if is_written && !means_nothing {
            let reason = format_args!("a sensor of the kind {} has no such setting", kind.word());
            let [first, ..] = kinds else { continue };
            checks.error(
                (SECTION, place, key),
                reason,
                format_args!("write sensor = {} or what is connected, or delete it", first.word()),
            );
        }
    }
}

fn connection(checks: &mut Checks<'_, '_>, place: usize, heater: &TemperatureConfig) {
    let (kind, spi) = (heater.sensor.kind.word(), &heater.sensor.spi);
    if spi.channel.is_none() {
        let reason = format_args!("there is none, so nobody knows where the {kind} is");
        let fix = format_args!("write 0 (SPI1: SCK PA5, MISO PA6, MOSI PB5) or 1 (SPI4: SCK PE12, MISO PE5, MOSI PE6)");
        checks.error((SECTION, place, "spi_channel"), reason, fix);
    }
    if spi.select_pin.is_none() {
        let reason = format_args!("there is none, so the {kind} is never read");
        let fix = format_args!("write the pin that its CS is connected to, as in PD10");
        checks.error((SECTION, place, "spi_select_pin"), reason, fix);
    }
    if let Some(Pin { open_drain: true, .. }) = spi.select_pin {
        let reason = format_args!("an open drain rises too slowly for a chip select");
        checks.error((SECTION, place, "spi_select_pin"), reason, format_args!("delete the o"));
    }
}

fn thermocouple(checks: &mut Checks<'_, '_>, place: usize, heater: &TemperatureConfig) {
    let kind = heater.sensor.spi.thermocouple;
    if heater.max_temp > kind.highest() {
        let reason = format_args!("a thermocouple of type {kind:?} is read up to {} only", kind.highest());
        checks.error((SECTION, place, "max_temp"), reason, format_args!("write less, or the tc_type that it is"));
    }
}

/// Resistance of platinum at a temperature above zero (IEC 60751).
fn resistance(nominal: Ohms, celsius: Celsius) -> Ohms {
    let celsius = celsius.0.max(0.0);
    Ohms(nominal.0 * (1.0 + celsius * (3.9083e-3 - 5.775e-7 * celsius)))
}

fn platinum(checks: &mut Checks<'_, '_>, place: usize, heater: &TemperatureConfig) {
    let (nominal, reference) = (heater.sensor.spi.rtd_nominal, heater.sensor.spi.rtd_reference);
    let hottest = resistance(nominal, heater.max_temp);
    let at = (SECTION, place, "rtd_reference");
    if hottest >= reference {
        let reason = format_args!(
            "at max_temp {} the sensor has {:.0} Ohm, and what is above the reference of {reference} reads as open",
            heater.max_temp, hottest.0
        );
        checks.error(
            at,
            reason,
            format_args!("write the resistor that is on the board: 430 for a PT100, 4300 for a PT1000"),
        );
    } else if !USUAL_RATIO.contains(&(reference.0 / nominal.0)) {
        let reason =
            format_args!("it is {:.1} times rtd_nominal, where most boards have 4.3 times", reference.0 / nominal.0);
        checks.warn(at, reason, format_args!("write what is printed on the resistor beside the chip: 430 is 4300"));
    }
}
