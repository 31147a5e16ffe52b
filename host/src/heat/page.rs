//! The page of a tuning, which needs no network.

use serde_json::json;

use super::answer::{Line, Swing};
use super::{Tuning, words};
use crate::page::fill;

const TEMPLATE: &str = include_str!("../../assets/heat.html");

/// Returns the whole HTML page of a tuning.
pub fn page(tuning: &Tuning) -> String {
    let log = &tuning.log;
    let gains = words::gains(tuning);
    let data = json!({
        "heater": log.heater, "target": log.target, "failed": log.failed,
        "is_model": matches!(log.found, Some(super::log::Found::Model(_))),
        "time": log.samples.iter().map(|sample| sample.second).collect::<Vec<_>>(),
        "celsius": log.samples.iter().map(|sample| sample.celsius).collect::<Vec<_>>(),
        "output": log.samples.iter().map(|sample| rounded(sample.duty / 2.55, 10.0)).collect::<Vec<_>>(),
        "model": tuning.laid.as_ref().map(|laid| laid.celsius.iter().map(|c| rounded(*c, 100.0)).collect::<Vec<_>>()),
        "swings": tuning.swings.iter().map(swing).collect::<Vec<_>>(),
        "facts": words::facts(tuning),
        "gains": gains.iter().map(|gain| json!([gain.name, gain.value, gain.unit, gain.means])).collect::<Vec<_>>(),
    });
    fill(TEMPLATE, &log.heater, &data)
}

fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}

fn swing(swing: &Swing) -> serde_json::Value {
    let line = |line: &Line| json!({ "from": line.from, "to": line.to, "slope": rounded(line.slope, 1e3) });
    json!({
        "off": swing.off, "meet": swing.meet, "celsius": swing.celsius, "rise": line(&swing.rise), "fall": line(&swing.fall),
    })
}
