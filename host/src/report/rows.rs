//! The rows of `steps.csv`: `time_ns,actuator,direction`.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use anyhow::{Context, Result, anyhow};
use sim::trace::StepEdge;
use units::{Actuator, Direction};

/// Opens a file of step edges.
pub fn open(path: &Path) -> Result<BufReader<File>> {
    let file = File::open(path).with_context(|| format!("cannot open {}", path.display()))?;
    Ok(BufReader::with_capacity(1 << 20, file))
}

/// Step edges in order; a malformed row is an error with its line.
#[derive(Debug)]
pub struct Rows<R> {
    csv: R,
    line: Vec<u8>,
    number: u64,
}

impl<R: BufRead> Rows<R> {
    /// Reads rows from a text.
    pub const fn of(csv: R) -> Self {
        Self { csv, line: Vec::new(), number: 0 }
    }
}

impl<R: BufRead> Iterator for Rows<R> {
    type Item = Result<StepEdge>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            self.line.clear();
            self.number += 1;
            match self.csv.read_until(b'\n', &mut self.line) {
                Ok(0) => return None,
                Ok(_) if self.number == 1 && self.line.starts_with(b"time_ns") => {}
                Ok(_) => {
                    let text = || String::from_utf8_lossy(&self.line).trim_end().to_owned();
                    let wrong = || anyhow!("line {} is not time_ns,actuator,direction: {}", self.number, text());
                    return Some(parse_row(&self.line).ok_or_else(wrong));
                }
                Err(error) => return Some(Err(error.into())),
            }
        }
    }
}

fn parse_row(line: &[u8]) -> Option<StepEdge> {
    let text = std::str::from_utf8(line).ok()?.trim_end();
    let mut fields = text.split(',');
    let time_ns = fields.next()?.parse().ok()?;
    let motor = fields.next()?;
    let actuator = match motor.parse::<usize>() {
        Ok(index) => Actuator::from_index(index)?,
        Err(_) => Actuator::from_name(motor)?,
    };
    let direction = match fields.next()? {
        "1" => Direction::Forward,
        "-1" => Direction::Backward,
        _ => return None,
    };
    fields.next().is_none().then_some(StepEdge { time_ns, actuator, direction })
}
