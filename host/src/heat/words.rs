//! The findings of a tuning in sentences.

use super::Tuning;
use super::answer::{Model, most};
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
    match found {
        Found::Pid(factors) => gains_of_pid(factors, most(&tuning.log)).into(),
        Found::Model(figures) => gains_of_model(figures, &laid.model, tuning.log.target),
    }
}

const fn gain(name: &'static str, value: f64, unit: &'static str, means: String) -> Gain {
    Gain { name, value, unit, means }
}

fn gains_of_pid([p, i, d]: [f64; 3], most: f64) -> [Gain; 3] {
    let means_p = format!(
        "a degree too cold adds {p:.0} of 255, {:.0} % of the output; all of it from {:.1} C on. \
         It is 0.45 / (rise × lateness): a heater that is fast, or late, gets less.",
        100.0 * p / most,
        most / p
    );
    let means_i = format!(
        "a degree too cold that stays adds the same once more every {:.0} s, eight times the lateness: \
         what is left over goes, and it does not swing.",
        p / i
    );
    let means_d = format!(
        "while it warms by a degree a second {d:.0} of 255 are taken away: it looks {:.1} s ahead, half the \
         lateness, and does not overshoot.",
        d / p
    );
    [gain("p_factor", p, "", means_p), gain("i_factor", i, "", means_i), gain("d_factor", d, "", means_d)]
}

fn gains_of_model([watts, capacity, loss, fan, late]: [f64; 5], model: &Model, target: f64) -> Vec<Gain> {
    let above_air = target - model.air;
    let means_power =
        "what config.ini says; where it is wrong, capacity and losses are wrong by as much, and control is not.";
    let means_capacity = format!("so much heat warms it by a degree: at full output {:.2} C/s.", model.rise);
    let means_loss =
        format!("so much it loses for each degree above the air: {:.1} W at {target:.0} C.", loss * above_air);
    let means_late = "so much later the sensor tells: the model is compared with what was so long ago.";
    let mut all = vec![
        gain("heater_power", watts, "W", means_power.to_owned()),
        gain("model_capacity", capacity, "J/K", means_capacity),
        gain("model_loss", loss, "W/K", means_loss),
    ];
    if fan > 0.0 {
        let means =
            format!("so much more with the fan full on, {:.1} W: added before the sensor tells.", fan * above_air);
        all.push(gain("model_fan_loss", fan, "W/K", means));
    }
    all.push(gain("model_late", late, "s", means_late.to_owned()));
    all
}
