//! The console's log of a heater's tuning, M303 or M306, from any board.

use anyhow::{Result, bail};

/// Period of the board's temperature reports, s.
pub const PERIOD_S: f64 = 1.0;

/// Reading of the temperature, and the heater's output at that time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the heater was switched on, s.
    pub second: f64,
    pub celsius: f64,
    /// Output of the heater, 0 to 255.
    pub duty: f64,
}

/// Result of a tuning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// M303: P, I and D.
    Pid([f64; 3]),
    /// M306: W, J/K, W/K, W/K of the fan, s.
    Model([f64; 5]),
}

/// Tuning of a heater, as its log tells it.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Name of the heater; empty if the log does not say it.
    pub heater: String,
    pub target: f64,
    pub samples: Vec<Sample>,
    /// Swings counted and swings wanted, as reported last.
    pub swings: [u32; 2],
    pub found: Option<Found>,
    /// Rise in C/s at full output, lateness of the sensor in s, share of the output that holds the target:
    /// as reported.
    pub said: Option<[f64; 3]>,
    /// Reason for a tuning without a result.
    pub failed: Option<String>,
}

/// Reads the last tuning of a log. Other lines are passed over, and so is any text that a terminal writes
/// before a line.
///
/// # Errors
/// When there is none.
pub fn read(text: &str) -> Result<Log> {
    let mut log: Option<Log> = None;
    for line in text.lines().map(str::trim_end) {
        let begun = after(line, "// Running autopid on ").or_else(|| after(line, "// Finding the model of "));
        if let Some(rest) = begun {
            log = Some(begin(rest));
        } else if let Some(log) = &mut log {
            take(log, line);
        }
    }
    match log {
        Some(log) if log.samples.len() > 10 => Ok(log),
        Some(log) => bail!("the tuning has ended at once: {}", log.failed.unwrap_or_else(|| "nothing was read".into())),
        None => bail!("no M303 or M306 in it: it needs what the console says while one runs"),
    }
}

fn after<'l>(line: &'l str, words: &str) -> Option<&'l str> {
    line.split_once(words).map(|(_, rest)| rest)
}

/// Reads `(T) hotend, toolid 0, control X to abort`, or `hotend, control X to abort`.
fn begin(rest: &str) -> Log {
    let name = rest.split(',').next().unwrap_or("");
    let name = name.split_once(") ").map_or(name, |(_, name)| name);
    Log {
        heater: name.trim().to_owned(),
        target: 0.0,
        samples: Vec::new(),
        swings: [0, 0],
        found: None,
        said: None,
        failed: None,
    }
}

fn take(log: &mut Log, line: &str) {
    if let Some(rest) = after(line, "// Autopid Status - ") {
        sample(log, rest);
    } else if let Some(rest) = after(line, "Full output warms it by ") {
        let said: Vec<f64> = numbers(rest);
        // The fourth number is the target.
        log.said = said.first_chunk::<3>().map(|[rise, late, percent]| [*rise, *late, percent / 100.0]);
    } else if let Some(rest) = after(line, "PID tuned: ") {
        log.found = numbers(rest).first_chunk::<3>().copied().map(Found::Pid);
    } else if let Some(rest) = after(line, "Model found, of ") {
        log.found = numbers(rest).first_chunk::<5>().copied().map(Found::Model);
    } else if let Some(why) = after(line, "error:M303: ").or_else(|| after(line, "error:M306: ")) {
        log.failed = Some(why.to_owned());
    } else if line.contains("Autopid aborted") {
        log.failed = Some("it was ended by a halt".to_owned());
    }
}

/// Reads a line such as ` 22.8/200.0 @255 0/3`.
fn sample(log: &mut Log, rest: &str) {
    let [celsius, target, duty, counted, wanted] = numbers(rest)[..] else { return };
    // Without a target the heater only cools before the tuning begins.
    if target <= 0.0 {
        return;
    }
    log.target = target;
    log.swings = [counted as u32, wanted as u32];
    let second = PERIOD_S * (log.samples.len() + 1) as f64;
    log.samples.push(Sample { second, celsius, duty });
}

/// Returns the numbers in a text, whatever stands between them.
fn numbers(text: &str) -> Vec<f64> {
    let is_of_number = |letter: char| letter.is_ascii_digit() || letter == '.' || letter == '-';
    let words = text.split(|letter| !is_of_number(letter));
    words.filter_map(|word| word.trim_end_matches('.').parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    pub const HEAD: &str = "// Running autopid on (T) hotend, toolid 0, control X to abort\nTarget: 200.0\n";

    fn text(count: usize, end: &str) -> String {
        let mut text = format!("ok\n{HEAD}// Autopid Status -  90.0/  0.0 @0 0/3\n");
        for second in 0..count {
            text += &format!("// Autopid Status - {:5.1}/200.0 @255 0/3\nok T:22.0 /0.0\n", 22.0 + second as f64);
        }
        text + end
    }

    #[test]
    fn what_a_board_says_is_read_whatever_stands_between() {
        let end = "Full output warms it by 3.24 C/s less what it loses, its sensor tells 1.4 s late, 43 % of the output holds \
                   200 C\nPID tuned: p_factor = 26.2202 i_factor = 2.4252 d_factor = 17.7179\nok\n";
        let log = read(&text(20, end)).expect("a tuning");
        assert_eq!((log.heater.as_str(), log.target, log.samples.len(), log.swings), ("hotend", 200.0, 20, [0, 3]));
        assert_eq!(log.samples[0], Sample { second: 1.0, celsius: 22.0, duty: 255.0 });
        assert_eq!((log.found, log.said), (Some(Found::Pid([26.2202, 2.4252, 17.7179])), Some([3.24, 1.4, 0.43])));
        let stamped: String = text(20, end).lines().map(|line| format!("[12:00:01] < {line}\n")).collect();
        assert_eq!(read(&stamped).expect("a tuning"), log, "a terminal that writes the time before each line");
    }

    #[test]
    fn a_model_and_a_failure_are_read_and_nothing_is_refused() {
        let end = "Model found, of 40 W: model_capacity = 12.352 model_loss = 0.0964 model_fan_loss = 0.0100 model_late = 1.35\n";
        let model = read(&text(20, end).replace("Running autopid on (T)", "Finding the model of")).expect("a tuning");
        assert_eq!(model.found, Some(Found::Model([40.0, 12.352, 0.0964, 0.01, 1.35])));
        let failed = read(&text(20, "error:M303: the heater was switched off\n")).expect("a tuning");
        assert_eq!((failed.found, failed.failed.as_deref()), (None, Some("the heater was switched off")));
        assert!(read("ok\nT:200\n").is_err() && read(&text(2, "")).is_err());
    }
}
