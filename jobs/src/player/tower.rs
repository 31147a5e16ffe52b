//! `TUNING_TOWER`: a setting that changes with the height of what is printed, to see which value prints best.

use core::fmt::{self, Write as _};

use base::failure::{Failure, Texts};
use config::Command;
use gcode::Extended;
use heapless::String;

use super::pauses::prints;

/// Dependence of the value on the height.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slope {
    /// Change per mm of height; constant within each band of this height, mm.
    Steady { factor: f64, band: f64 },
    /// Step of the value at every so many mm.
    Steps { delta: f64, height: f64 },
}

/// Setting that changes, and its law.
#[derive(Clone, Debug, PartialEq)]
pub struct Tower {
    command: Command,
    parameter: String<32>,
    start: f64,
    slope: Slope,
    /// Height below which nothing changes, mm.
    skip: f64,
    /// Height at which the setting was set last, mm.
    at: Option<f64>,
}

impl Tower {
    /// Reads `TUNING_TOWER COMMAND= PARAMETER= START= FACTOR= [BAND=] [SKIP=]`, or STEP_DELTA= and
    /// STEP_HEIGHT= instead of FACTOR=.
    ///
    /// # Errors
    /// When a word is missing or no number.
    pub fn new(texts: &Texts, command: &Extended<'_>) -> Result<Self, Failure> {
        let text = |key: &'static str| {
            let value = command.get(key).map(|value| value.trim_matches(['\'', '"']).trim());
            value.filter(|value| !value.is_empty()).ok_or_else(|| refused(texts, key))
        };
        let number = |key: &'static str| match command.get(key) {
            None => Ok(None),
            Some(value) => match gcode::read_f64(value.trim()) {
                Some(number) if number.is_finite() => Ok(Some(number)),
                _ => Err(texts.refused(format_args!("TUNING_TOWER: {key} is no number: {value}"))),
            },
        };
        let slope = match (number("FACTOR")?, number("STEP_DELTA")?, number("STEP_HEIGHT")?) {
            (Some(factor), None, None) => Slope::Steady { factor, band: number("BAND")?.unwrap_or(0.0).max(0.0) },
            (None, Some(delta), Some(height)) if height > 0.0 => Slope::Steps { delta, height },
            _ => return Err(refused(texts, "FACTOR, or STEP_DELTA and STEP_HEIGHT")),
        };
        let long = |_| Failure::refused(&"TUNING_TOWER: COMMAND or PARAMETER is too long");
        Ok(Self {
            command: Command::try_from(text("COMMAND")?).map_err(long)?,
            parameter: String::try_from(text("PARAMETER")?).map_err(long)?,
            start: number("START")?.ok_or_else(|| refused(texts, "START"))?,
            slope,
            skip: number("SKIP")?.unwrap_or(0.0),
            at: None,
        })
    }

    fn value(&self, height: f64) -> f64 {
        let above = height - self.skip;
        if above <= 0.0 {
            return self.start;
        }
        match self.slope {
            Slope::Steps { delta, height } => self.start + delta * libm::floor(above / height + 1e-9),
            Slope::Steady { factor, band: 0.0 } => self.start + factor * above,
            // The middle of the band counts.
            Slope::Steady { factor, band } => self.start + factor * (libm::floor(above / band + 1e-9) + 0.5) * band,
        }
    }

    /// Returns the command due before this line, if the line is the first that prints at its height.
    pub fn command_before(&mut self, line: &[u8], height: f64) -> Option<Command> {
        if self.at == Some(height) || !prints(line) {
            return None;
        }
        let before = self.at.replace(height).map(|height| self.value(height));
        let value = self.value(height);
        if before == Some(value) {
            return None;
        }
        let mut text = Command::new();
        let is_code = self.command.as_bytes().get(1).is_some_and(u8::is_ascii_digit);
        let sign = if is_code { "" } else { "=" };
        write!(text, "{} {}{sign}{}", self.command, self.parameter, Short(value)).is_ok().then_some(text)
    }
}

/// Number that is written without needless digits.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", libm::round(self.0 * 1e6) / 1e6)
    }
}

#[cold]
fn refused(texts: &Texts, what: &str) -> Failure {
    texts.refused(format_args!("TUNING_TOWER needs {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tower(text: &str) -> Tower {
        Tower::new(&Texts::new(), &Extended::new(text)).unwrap()
    }

    /// Returns the settings at each of these heights.
    fn set(text: &str, heights: &[f64]) -> std::vec::Vec<std::string::String> {
        let mut tower = tower(text);
        let lines = heights.iter().filter_map(|height| tower.command_before(b"G1 X1 Y2 E3", *height));
        lines.map(|line| line.as_str().into()).collect()
    }

    #[test]
    fn the_value_follows_the_height() {
        let steady = "TUNING_TOWER COMMAND=SET_PRESSURE_ADVANCE PARAMETER=ADVANCE START=0 FACTOR=0.005";
        let expected = ["SET_PRESSURE_ADVANCE ADVANCE=0.001", "SET_PRESSURE_ADVANCE ADVANCE=0.002"];
        assert_eq!(set(steady, &[0.2, 0.2, 0.4]), expected);
        let bands = "TUNING_TOWER COMMAND=M900 PARAMETER=K START=0.1 FACTOR=0.01 BAND=5";
        assert_eq!(set(bands, &[0.2, 2.0, 4.9, 5.1]), ["M900 K0.125", "M900 K0.175"]);
        let steps = "TUNING_TOWER COMMAND=\"M104\" PARAMETER='S' START=230 STEP_DELTA=-5 STEP_HEIGHT=8 SKIP=1";
        assert_eq!(set(steps, &[0.2, 1.2, 8.8, 9.0, 17.0]), ["M104 S230", "M104 S225", "M104 S220"]);
    }

    #[test]
    fn a_lift_is_no_height() {
        let mut tower = tower("TUNING_TOWER COMMAND=M900 PARAMETER=K START=0 FACTOR=1");
        assert_eq!(tower.command_before(b"G1 X5 Y5", 5.0), None);
        assert_eq!(tower.command_before(b"G1 E-2", 5.0), None);
        assert!(tower.command_before(b"G1 X5 E1", 1.0).is_some());
    }

    #[test]
    fn what_is_missing_is_named() {
        for (text, missing) in [
            ("PARAMETER=K START=0 FACTOR=1", "COMMAND"),
            ("COMMAND=M900 START=0 FACTOR=1", "PARAMETER"),
            ("COMMAND=M900 PARAMETER=K FACTOR=1", "START"),
            ("COMMAND=M900 PARAMETER=K START=0", "FACTOR, or STEP_DELTA"),
            ("COMMAND=M900 PARAMETER=K START=0 STEP_DELTA=1 STEP_HEIGHT=0", "FACTOR, or STEP_DELTA"),
            ("COMMAND=M900 PARAMETER=K START=x FACTOR=1", "no number"),
        ] {
            let line = std::format!("TUNING_TOWER {text}");
            let texts = Texts::new();
            let refused = Tower::new(&texts, &Extended::new(&line)).unwrap_err();
            let why = std::format!("{}", texts.of(refused));
            assert!(refused.is_refusal() && why.contains(missing), "{text}: {why}");
        }
    }
}
