//! The findings of a tuning in sentences.

use super::Tuning;
use super::answer::most;
use super::log::Found;

/// Differences between readings and model up to which the model describes the heater, C.
const CLOSE: [f64; 2] = [3.0, 1.0];

/// Figure that a tuning found, and its meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Gain {
    pub name: &'static str,
    pub value: f64,
    pub unit: &'static str,
    pub means: String,
}

impl Gain {
    /// Returns the gain in one line.
    pub fn line(&self) -> String {
        let Self { name, value, unit, means } = self;
        format!("{name} = {value}{}{unit}: {means}", if unit.is_empty() { "" } else { " " })
    }
}

/// Returns sentences about the measured values.
pub fn facts(tuning: &Tuning) -> Vec<String> {
    let log = &tuning.log;
    let [counted, wanted] = log.swings;
    if let Some(why) = &log.failed {
        return vec![format!("It found nothing: {why}."), format!("{counted} of {wanted} swings were counted.")];
    }
    let Some(laid) = &tuning.laid else {
        return vec![format!("It has not ended: {counted} of {wanted} swings were counted.")];
    };
    let (model, [most, mean]) = (laid.model, laid.off_by);
    let target = log.target;
    let holds = 100.0 * model.loss * (target - model.air) / model.rise;
    let mut facts = vec![
        format!(
            "Full output warms it by {:.2} C/s less what it loses: the slope at the end of the first rise, and the loss there.",
            model.rise
        ),
        format!(
            "In a second it loses {:.2} % of what it is above the air ({:.0} C): the slope of the falls.",
            100.0 * model.loss,
            model.air
        ),
        format!(
            "What is done to it shows {:.1} s later: so long after it was switched off the line of the rise and that of the \
             fall meet.",
            model.late
        ),
        format!("{holds:.0} % of its output holds {target:.0} C{}", reserve(holds)),
    ];
    let is_close = most < CLOSE[0] && mean < CLOSE[1];
    facts.push(format!(
        "The model lies within {most:.1} C of every reading, {mean:.1} C in the mean: {}",
        if is_close {
            "it describes this heater."
        } else {
            "it describes this heater roughly; look where it parts from the readings."
        }
    ));
    facts
}

fn reserve(holds: f64) -> &'static str {
    match holds {
        ..60.0 => ": it has enough to spare for filament and the fan.",
        ..75.0 => ": little is left for much flow with the fan on.",
        _ => ": it is weak for this temperature.",
    }
}

/// Returns the gains that were found, each with a sentence.
pub fn gains(tuning: &Tuning) -> Vec<Gain> {
    let (Some(found), Some(laid)) = (tuning.log.found, &tuning.laid) else { return Vec::new() };
    let (model, most) = (laid.model, most(&tuning.log));
    let gain = |name, value, unit, means| Gain { name, value, unit, means };
    match found {
        Found::Pid([p, i, d]) => vec![
            gain(
                "p_factor",
                p,
                "",
                format!(
                    "a degree too cold adds {p:.0} of 255, {:.0} % of the output; all of it from {:.1} C on. \
                     It is 0.45 / (rise × lateness): a heater that is fast, or late, gets less.",
                    100.0 * p / most,
                    most / p
                ),
            ),
            gain(
                "i_factor",
                i,
                "",
                format!(
                    "a degree too cold that stays adds the same once more every {:.0} s, eight times the lateness: \
                     what is left over goes, and it does not swing.",
                    p / i
                ),
            ),
            gain(
                "d_factor",
                d,
                "",
                format!(
                    "while it warms by a degree a second {d:.0} of 255 are taken away: it looks {:.1} s ahead, half the \
                     lateness, and does not overshoot.",
                    d / p
                ),
            ),
        ],
        Found::Model([watts, capacity, loss, fan, late]) => {
            let mut all = vec![
                gain(
                    "heater_power",
                    watts,
                    "W",
                    "what config.ini says; where it is wrong, capacity and losses are wrong by as much, and control is not."
                        .to_owned(),
                ),
                gain(
                    "model_capacity",
                    capacity,
                    "J/K",
                    format!("so much heat warms it by a degree: at full output {:.2} C/s.", model.rise),
                ),
                gain(
                    "model_loss",
                    loss,
                    "W/K",
                    format!(
                        "so much it loses for each degree above the air: {:.1} W at {:.0} C.",
                        loss * (tuning.log.target - model.air),
                        tuning.log.target
                    ),
                ),
            ];
            if fan > 0.0 {
                let watts = fan * (tuning.log.target - model.air);
                all.push(gain(
                    "model_fan_loss",
                    fan,
                    "W/K",
                    format!("so much more with the fan full on, {watts:.1} W: added before the sensor tells."),
                ));
            }
            all.push(gain(
                "model_late",
                late,
                "s",
                "so much later the sensor tells: the model is compared with what was so long ago.".to_owned(),
            ));
            all
        }
    }
}
