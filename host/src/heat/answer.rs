//! The values measured of a heater, and the model that follows from them, laid over the readings.

use super::log::{Found, Log, PERIOD_S, Sample};

/// Distance above its target at which the heater is switched off (`thermal/src/step_test.rs`), C.
const ABOVE: f64 = 4.0;
/// Distance below the end of a rise from which its slope is taken, C.
const RISE_WINDOW: f64 = 10.0;
/// Multiple of the sensor's lateness after which its effect has died away.
const DIED_AWAY: f64 = 2.5;
/// Greatest temperature of a heater that has been off for long, C; a warmer one's surroundings are taken to
/// be at [`ROOM`].
const COLD: f64 = 45.0;
const ROOM: f64 = 22.0;
/// Time step of the model, s.
const STEP: f64 = 0.05;
/// Number of moments between two readings tried as the time of switching on.
const MOMENTS: u32 = 20;

/// Heater model: dT/dt = rise u(t - late) - loss (T - air), u from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    pub rise: f64,
    pub loss: f64,
    pub late: f64,
    pub air: f64,
}

/// Straight line through readings, each end as time in s and temperature in C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub from: [f64; 2],
    pub to: [f64; 2],
    /// Slope of the line, C/s.
    pub slope: f64,
}

/// Swing of the temperature, from switching off to the point at which the lines of rise and fall meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Time of switching off, s.
    pub off: f64,
    pub meet: f64,
    pub celsius: f64,
    pub rise: Line,
    pub fall: Line,
}

/// Model laid over the readings.
#[derive(Clone, Debug)]
pub struct Laid {
    pub model: Model,
    /// Temperatures of the model at the readings, C.
    pub celsius: Vec<f64>,
    /// Differences from the readings, C: the greatest, and the mean.
    pub off_by: [f64; 2],
}

/// Returns the model that was found. PID gains hold it more exactly than the console's words do.
pub fn model(log: &Log) -> Option<Model> {
    let first = log.samples.first()?.celsius;
    let air = if first < COLD { first } else { ROOM };
    let most = most(log);
    let (rise, late, loss) = match (log.found?, log.said) {
        (Found::Pid([p, i, _]), Some([_, _, holds])) if p > 0.0 && i > 0.0 => {
            let late = p / (8.0 * i);
            let rise = 0.45 * most / (p * late);
            (rise, late, holds * rise / (log.target - air))
        }
        (Found::Model([watts, capacity, loss, _, late]), _) if capacity > 0.0 => {
            (watts * most / 255.0 / capacity, late, loss / capacity)
        }
        _ => return None,
    };
    Some(Model { rise, loss, late, air })
}

/// Returns the greatest output of the log, of 255.
pub fn most(log: &Log) -> f64 {
    log.samples.iter().map(|sample| sample.duty).fold(1.0, f64::max)
}

/// Returns the readings behind which the heater was switched, and whether on.
fn switches(log: &Log) -> Vec<(usize, bool)> {
    let pairs = log.samples.windows(2).enumerate();
    pairs
        .filter_map(|(index, pair)| {
            let [before, now] = [pair.first()?.duty > 0.0, pair.last()?.duty > 0.0];
            (before != now).then_some((index, now))
        })
        .collect()
}

/// Returns the time at which the heater passed its upper end, just behind reading number `index`.
fn off_at(log: &Log, index: usize) -> Option<f64> {
    let (before, at) = (log.samples.get(index.checked_sub(1)?)?, log.samples.get(index)?);
    let slope = (at.celsius - before.celsius).max(1e-3) / PERIOD_S;
    Some(at.second + ((log.target + ABOVE - at.celsius) / slope).clamp(0.0, PERIOD_S))
}

/// Fits the lines of rise and fall and finds the points at which they meet, as the board does, along the
/// curves of the model. A fall begins once the sensor's lateness has died away.
pub fn swings(log: &Log, model: Option<Model>) -> Vec<Swing> {
    let Model { loss, late, air, .. } = model.unwrap_or(Model { rise: 0.0, loss: 0.0, late: 0.0, air: ROOM });
    let switches = switches(log);
    let mut swings = Vec::new();
    let mut begins = 0;
    for (place, (index, on)) in switches.iter().enumerate() {
        if *on {
            begins = index + 1;
            continue;
        }
        let ends = switches.get(place + 1).map_or(log.samples.len(), |(next, _)| next + 1);
        let window = if begins == 0 { RISE_WINDOW } else { RISE_WINDOW / 2.0 };
        let end = log.target + ABOVE;
        let rising = log.samples.get(begins..=*index).unwrap_or_default();
        let rising = rising.iter().filter(|sample| sample.celsius > end - window);
        // Behind its highest reading the temperature has come back to its value at switching off.
        let falling = log.samples.get(index + 1..ends).unwrap_or_default();
        let highest = falling.iter().map(|sample| sample.celsius).fold(0.0, f64::max);
        let falling = falling.iter().skip_while(|sample| sample.celsius < highest);
        let Some(off) = off_at(log, *index) else { continue };
        let falling = falling.skip_while(|sample| sample.celsius > end - 0.5 || sample.second < off + DIED_AWAY * late);
        let (Some(rise), Some(fall)) = (line(rising), line(falling)) else { continue };
        let ended = rise.from[1] + rise.slope * (off - rise.from[0]);
        let middle = [0, 1].map(|axis: usize| (fall.from[axis] + fall.to[axis]) / 2.0);
        let fallen = |second: f64| match loss {
            0.0 => middle[1] + fall.slope * (second - middle[0]),
            loss => air + (middle[1] - air) * (loss * (middle[0] - second)).exp(),
        };
        let began = fallen(off);
        let cools = if loss > 0.0 { loss * (began - air) } else { -fall.slope };
        let meet = off + (began - ended) / (rise.slope + cools);
        let celsius = fallen(meet);
        if (0.0..60.0).contains(&(meet - off)) {
            swings.push(Swing { off, meet, celsius, rise, fall });
        }
    }
    swings
}

/// Fits a line by least squares.
fn line<'s>(samples: impl Iterator<Item = &'s Sample>) -> Option<Line> {
    let points: Vec<[f64; 2]> = samples.map(|sample| [sample.second, sample.celsius]).collect();
    let count = points.len() as f64;
    let mean = [0, 1].map(|axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count);
    let spread: f64 = points.iter().map(|point| (point[0] - mean[0]).powi(2)).sum();
    if points.len() < 2 || spread <= 0.0 {
        return None;
    }
    let slope = points.iter().map(|point| (point[0] - mean[0]) * (point[1] - mean[1])).sum::<f64>() / spread;
    let at = |second: f64| [second, mean[1] + slope * (second - mean[0])];
    Some(Line { from: at(points.first()?[0]), to: at(points.last()?[0]), slope })
}

/// Returns the model from the first reading on. Each time of switching on again lies somewhere between two
/// readings; the times that fit best are taken.
pub fn laid(log: &Log, model: Model) -> Laid {
    let mut turns = vec![0.0];
    let switches = switches(log);
    for (place, (index, on)) in switches.iter().enumerate() {
        let second = log.samples.get(*index).map_or(0.0, |sample| sample.second);
        if !on {
            turns.push(off_at(log, *index).unwrap_or(second));
            continue;
        }
        // The readings up to the next switching on decide which moment fits best.
        let until = switches.get(place + 2).map_or(log.samples.len(), |(next, _)| next + 1);
        let error = |moment: f64| {
            let tried: Vec<f64> = turns.iter().copied().chain([moment]).collect();
            let next = switches.get(place + 1).and_then(|(next, _)| off_at(log, *next));
            let tried: Vec<f64> = tried.into_iter().chain(next).collect();
            let run = run(log, model, &tried);
            let pairs = run.iter().zip(&log.samples).take(until).skip(*index);
            pairs.map(|(model, sample)| (model - sample.celsius).powi(2)).sum::<f64>()
        };
        let moments = (0..=MOMENTS).map(|part| second + PERIOD_S * f64::from(part) / f64::from(MOMENTS));
        let best = moments.map(|moment| (error(moment), moment)).min_by(|one, other| one.0.total_cmp(&other.0));
        turns.push(best.map_or(second, |(_, moment)| moment));
    }
    let celsius = run(log, model, &turns);
    let off: Vec<f64> =
        celsius.iter().zip(&log.samples).map(|(model, sample)| (model - sample.celsius).abs()).collect();
    let most = off.iter().copied().fold(0.0, f64::max);
    let mean = off.iter().sum::<f64>() / off.len().max(1) as f64;
    Laid { model, celsius, off_by: [most, mean] }
}

/// Returns the model's temperature at each reading, switched on at the first of `turns`, off at the second,
/// and so on.
fn run(log: &Log, model: Model, turns: &[f64]) -> Vec<f64> {
    let (mut second, mut celsius) = (0.0, log.samples.first().map_or(model.air, |sample| sample.celsius));
    let is_on = |at: f64| turns.iter().filter(|turn| **turn <= at).count() % 2 == 1;
    let mut all = Vec::with_capacity(log.samples.len());
    for sample in &log.samples {
        while second < sample.second {
            let drive = if is_on(second - model.late) { model.rise } else { 0.0 };
            celsius += STEP * (drive - model.loss * (celsius - model.air));
            second += STEP;
        }
        all.push(celsius);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the log that a board would write of a heater that follows this model.
    fn tuned(model: Model) -> Log {
        let (mut celsius, mut on, mut pipe) = (model.air, true, std::collections::VecDeque::new());
        (0..(model.late / STEP) as usize).for_each(|_| pipe.push_back(false));
        let (mut samples, mut counted) = (Vec::new(), 0);
        for step in 1.. {
            pipe.push_back(on);
            let drive = if pipe.pop_front() == Some(true) { model.rise } else { 0.0 };
            celsius += STEP * (drive - model.loss * (celsius - model.air));
            if on && celsius >= 204.0 {
                on = false;
            } else if !on && celsius < 193.0 {
                (on, counted) = (true, counted + 1);
            }
            if step % (PERIOD_S / STEP) as u32 == 0 {
                let second = f64::from(step) * STEP;
                samples.push(Sample { second, celsius, duty: if on { 255.0 } else { 0.0 } });
            }
            if counted == 3 {
                break;
            }
        }
        let late = model.late;
        let p = 0.45 / (model.rise / 255.0 * late);
        let holds = model.loss * (200.0 - model.air) / model.rise;
        Log {
            heater: "hotend".into(),
            target: 200.0,
            samples,
            swings: [3, 3],
            found: Some(Found::Pid([p, p / (8.0 * late), p * late / 2.0])),
            said: Some([model.rise, late, holds]),
            failed: None,
        }
    }

    #[test]
    fn the_model_is_found_again_and_lies_over_what_was_read() {
        let made = Model { rise: 3.2, loss: 0.0075, late: 1.4, air: 22.0 };
        let log = tuned(made);
        let found = model(&log).expect("a model");
        assert!(
            (found.rise - 3.2).abs() < 1e-6 && (found.late - 1.4).abs() < 1e-6 && (found.loss - 0.0075).abs() < 1e-4
        );
        let laid = laid(&log, found);
        assert!(laid.off_by[0] < 1.0 && laid.off_by[1] < 0.4, "{:?}", laid.off_by);
        let wrong = super::laid(&log, Model { rise: 3.6, ..found });
        assert!(wrong.off_by[0] > 5.0, "{:?}", wrong.off_by);
        let swings = swings(&log, Some(found));
        assert!(swings.len() >= 2, "{swings:?}");
        for swing in swings {
            assert!((swing.meet - swing.off - 1.4).abs() < 0.5, "{swing:?}");
            assert!(swing.rise.slope > 1.5 && swing.fall.slope < -0.8, "{swing:?}");
        }
    }

    #[test]
    fn a_tuning_that_found_nothing_has_no_model() {
        let mut log = tuned(Model { rise: 3.2, loss: 0.0075, late: 1.4, air: 22.0 });
        log.found = None;
        assert_eq!(model(&log), None);
    }
}
