//! The files a run leaves in its folder, as data.

use anyhow::{Context, Result, bail};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

use super::power::{self, Change};

/// Contents of `summary.json`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Summary {
    /// Length of the job on the machine's own clock, seconds.
    pub virtual_seconds: f64,
    /// Lines of G-code executed.
    pub lines: u64,
    /// Reason for a halt, if the machine halted.
    pub halted: Option<String>,
    /// Everything that went wrong.
    pub errors: Vec<String>,
    /// Motors by their names.
    pub actuators: BTreeMap<String, ActuatorSummary>,
    /// Heaters by their controllers' names.
    pub heaters: BTreeMap<String, HeaterSummary>,
    /// Hash over every step edge.
    pub edge_hash: Value,
    /// Comparison of step times with the ideal ones, when asked for.
    pub step_error_ns: Option<StepError>,
    /// Steps too close to a change of direction for the driver chips.
    pub timing_faults: Option<u64>,
    /// Times at which the planner had to release a move with too little look-ahead behind it, seconds; none
    /// if the run could not look into the planner.
    pub starved_at_s: Option<Vec<f64>>,
    /// Complaints of the emulator.
    pub board: Option<Vec<Value>>,
}

/// Motor in `summary.json`.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub struct ActuatorSummary {
    /// Number of step edges.
    pub steps: u64,
    /// Position at the end, mm.
    pub position_mm: f64,
    /// Highest step rate, steps/s.
    pub max_steps_per_s: f64,
    /// Motion that went into an end of the axis or into a motor without current, mm.
    pub lost_mm: f64,
}

/// Heater in `summary.json`.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub struct HeaterSummary {
    /// Temperature at the end, C.
    pub final_c: f64,
    /// Highest temperature of the run, C.
    pub max_c: f64,
}

/// Step time errors of `summary.json`.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub struct StepError {
    /// Worst error of a step, ns.
    pub max: f64,
    /// Root mean square of the errors, ns.
    pub rms: f64,
}

impl Summary {
    /// Returns the hash as a number, however it is written: 16 hex digits with or without 0x, or a JSON
    /// number.
    pub fn edge_hash(&self) -> Option<u64> {
        match &self.edge_hash {
            Value::String(text) => u64::from_str_radix(text.trim_start_matches("0x"), 16).ok(),
            number => number.as_u64(),
        }
    }
}

/// Contents of `telemetry.csv`: a table of numbers by column name; an empty field is a missing number.
#[derive(Clone, Debug, Default)]
pub struct Telemetry {
    /// Column names, time excepted.
    pub names: Vec<String>,
    /// Times of the rows, seconds since power-on.
    pub time_s: Vec<f64>,
    /// Columns, each under its name in `names`.
    pub columns: Vec<Vec<Option<f64>>>,
}

impl Telemetry {
    fn parse(text: &str) -> Result<Self> {
        let mut lines = text.lines();
        let header = lines.next().context("telemetry.csv is empty")?;
        let mut names = header.split(',').map(str::trim);
        if names.next() != Some("time_s") {
            bail!("telemetry.csv must begin with a column time_s, not: {header}");
        }
        let names: Vec<String> = names.map(str::to_owned).collect();
        let mut table = Self { columns: vec![Vec::new(); names.len()], names, time_s: Vec::new() };
        for (number, line) in lines.enumerate() {
            let mut fields = line.split(',').map(|field| field.trim().parse::<f64>().ok());
            let time_s = fields.next().flatten();
            table.time_s.push(time_s.with_context(|| format!("telemetry.csv line {}: no time: {line}", number + 2))?);
            for column in &mut table.columns {
                column.push(fields.next().flatten().filter(|value| value.is_finite()));
            }
        }
        Ok(table)
    }

    /// Returns the columns whose name ends with `suffix`, with the name's beginning.
    pub fn ending<'a>(&'a self, suffix: &'a str) -> impl Iterator<Item = (&'a str, &'a [Option<f64>])> {
        let columns = self.names.iter().zip(&self.columns);
        columns.filter_map(move |(name, column)| Some((name.strip_suffix(suffix)?, column.as_slice())))
    }
}

/// Files of a run's folder.
#[derive(Debug)]
pub struct Run {
    /// Contents of `summary.json`.
    pub summary: Summary,
    /// Contents of `telemetry.csv`, if there is one.
    pub telemetry: Option<Telemetry>,
    /// Contents of `console.log`, if there is one.
    pub console: Option<String>,
    /// Contents of `power.csv`; none if no laser burned.
    pub power: Vec<Change>,
}

impl Run {
    /// Reads a run's folder.
    pub fn read(out: &Path) -> Result<Self> {
        let text = |name: &str| std::fs::read_to_string(out.join(name));
        let summary = text("summary.json").with_context(|| format!("{} holds no run", out.display()))?;
        let summary = serde_json::from_str(&summary).context("summary.json is not what a run writes")?;
        let telemetry = text("telemetry.csv").ok().map(|text| Telemetry::parse(&text)).transpose()?;
        let console = std::fs::read(out.join("console.log")).ok();
        let console = console.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        Ok(Self { summary, telemetry, console, power: power::read(out)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_is_read_whether_or_not_it_has_the_optional_parts() {
        let text = r#"{"virtual_seconds": 12.5, "lines": 3, "halted": null, "errors": [],
            "actuators": {"alpha": {"steps": 10, "position_mm": 1.0, "max_steps_per_s": 800.0}},
            "heaters": {"bed": {"final_c": 40.0, "max_c": 46.0}}, "edge_hash": "85944171f73967e8", "board": []}"#;
        let summary: Summary = serde_json::from_str(text).unwrap();
        assert_eq!((summary.edge_hash(), summary.actuators["alpha"].steps), (Some(0x8594_4171_F739_67E8), 10));
        assert!(summary.step_error_ns.is_none() && summary.board.unwrap().is_empty());
        let bare: Summary =
            serde_json::from_str(r#"{"edge_hash": 7, "step_error_ns": {"max": 3, "rms": 1.5}}"#).unwrap();
        assert_eq!((bare.edge_hash(), bare.step_error_ns.unwrap().max, bare.board), (Some(7), 3.0, None));
    }

    #[test]
    fn telemetry_columns_are_found_by_their_ending() {
        let table = Telemetry::parse("time_s,bed_c,bed_duty,vmotor_v\n0.0,20.5,255,24.1\n0.1,,12,nan\n").unwrap();
        assert_eq!(table.ending("_c").collect::<Vec<_>>(), [("bed", &[Some(20.5), None][..])]);
        assert_eq!(table.ending("_v").next(), Some(("vmotor", &[Some(24.1), None][..])));
        assert!(Telemetry::parse("a,b\n").is_err());
        assert!(format!("{:#}", Telemetry::parse("time_s,a\nx,1\n").unwrap_err()).contains("line 2"));
    }
}
