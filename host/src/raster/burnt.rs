//! A reading of raster files that shares nothing with their writing: what a machine would burn where, by the
//! text alone.

use anyhow::{Context, Result, bail};

/// Straight way of one power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    pub from: [f64; 2],
    pub to: [f64; 2],
    /// S of the way; zero where the beam is off.
    pub power: f64,
    /// The way has the speed of F rather than that of G0.
    pub is_feed: bool,
}

/// Reader's state between lines.
#[derive(Default)]
struct Modes {
    at: [f64; 2],
    power: f64,
    is_on: bool,
    is_feed: bool,
}

/// Returns the ways of a file of G0, G1, M3, M4 and M5 with absolute places in mm.
pub fn read(text: &str) -> Result<Vec<Pass>> {
    let (mut modes, mut passes) = (Modes::default(), Vec::new());
    for (index, line) in text.lines().enumerate() {
        let code = line.split(';').next().unwrap_or_default();
        modes.take(code, &mut passes).with_context(|| format!("line {}: {line}", index + 1))?;
    }
    Ok(passes)
}

impl Modes {
    fn take(&mut self, code: &str, passes: &mut Vec<Pass>) -> Result<()> {
        let mut to = self.at;
        let mut runs = Vec::new();
        for word in words(code) {
            let (letter, value) = word.split_at(1);
            match (letter, value) {
                ("G", "0") => self.is_feed = false,
                ("G", "1") => self.is_feed = true,
                ("M", "3" | "4") => self.is_on = true,
                ("M", "5") => self.is_on = false,
                ("G", "21" | "90" | "94") | ("M", "8" | "9") | ("F", _) => {}
                ("X", _) => to[0] = value.parse()?,
                ("Y", _) => to[1] = value.parse()?,
                ("S", _) => runs = value.split(':').map(run).collect::<Result<_>>()?,
                _ => bail!("{word} is none of its words"),
            }
        }
        if runs.is_empty() {
            runs.push((self.power, 1.0));
        }
        let from = self.at;
        let all: f64 = runs.iter().map(|(_, length)| length).sum();
        let mut passed = 0.0;
        for (power, length) in runs {
            self.power = power;
            passed += length;
            let end = [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * passed / all);
            if end != self.at {
                let power = if self.is_on && self.is_feed { power } else { 0.0 };
                passes.push(Pass { from: self.at, to: end, power, is_feed: self.is_feed });
                self.at = end;
            }
        }
        Ok(())
    }
}

/// Returns the words of a line, each with its letter.
fn words(code: &str) -> impl Iterator<Item = &str> {
    let begins: Vec<usize> =
        code.match_indices(|letter: char| letter.is_ascii_alphabetic()).map(|(at, _)| at).collect();
    let ends: Vec<usize> = begins.iter().copied().skip(1).chain([code.len()]).collect();
    begins.into_iter().zip(ends).map(|(begin, end)| code[begin..end].trim())
}

/// Reads a power and its number of pixels.
fn run(text: &str) -> Result<(f64, f64)> {
    let (power, length) = text.split_once('@').unwrap_or((text, "1"));
    Ok((power.parse()?, f64::from(length.parse::<u16>()?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_have_the_power_of_their_run() {
        let passes = read("; c\nM4 S0\nG0 X1 Y2\nG1 X2 S5@3:0:7@4 F600\nX3\nM5 S0\nG1 Y3 S9\n").expect("its words");
        let powers: Vec<_> = passes.iter().map(|pass| (pass.power, pass.is_feed)).collect();
        assert_eq!(powers, [(0.0, false), (5.0, true), (0.0, true), (7.0, true), (7.0, true), (0.0, true)]);
        assert_eq!((passes[1].from, passes[1].to, passes[2].to), ([1.0, 2.0], [1.375, 2.0], [1.5, 2.0]));
        assert_eq!((passes[4].to, passes[5].to), ([3.0, 2.0], [3.0, 3.0]));
        let error = read("G1 X1\nG2 X3\n").expect_err("an arc");
        assert!(format!("{error:#}").starts_with("line 2: G2 X3"));
    }
}
