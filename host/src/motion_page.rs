//! `velvet motion`: a page about a job's motion: speed, acceleration and jerk over time, its hardest
//! corners with and without input shaping, and the distance of each step from its ideal time.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};
use serde::Serialize;
use sim::models::tmc26x::Chip;
use sim::output::StepError;
use sim::runner::curves::{self, Corner, Curves};
use sim::runner::{self, Job};

use crate::page::fill;
use crate::progress::Progress;
use crate::verify;

const TEMPLATE: &str = include_str!("../assets/motion.html");
/// Names of the bins of [`StepError::bins`].
const BINS: [&str; 12] =
    ["< 1 ns", "< 2", "< 3", "< 4", "< 5", "< 10", "< 20", "< 50", "< 100", "< 250", "< 1000", "1 us and more"];

/// What `velvet motion` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// The run's folder; the page goes there as motion.html
    out: PathBuf,
    /// Configuration of the machine
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Job that was executed
    #[arg(long, value_name = "FILE")]
    gcode: PathBuf,
    /// Curves from this time on, seconds from boot [default: where the longest motion without a rest begins]
    #[arg(long, value_name = "SECONDS")]
    from: Option<f64>,
    /// Curves for this long, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    seconds: f64,
}

#[derive(Serialize)]
struct Data {
    title: String,
    period_ms: f64,
    time: Vec<f64>,
    speed: Vec<f64>,
    acceleration: Vec<f64>,
    jerk: Vec<f64>,
    corners: Vec<CornerData>,
    errors: Option<Errors>,
    missing: Option<String>,
}

#[derive(Serialize)]
struct CornerData {
    time: f64,
    at: [f64; 2],
    speed: f64,
    planned: Vec<[f64; 2]>,
    shaped: Vec<[f64; 2]>,
    shaper: String,
}

#[derive(Serialize)]
struct Errors {
    names: [&'static str; 12],
    counts: [u64; 12],
    max: f64,
    rms: f64,
}

/// Plans the job, compares the run's edges, writes the page; returns the page's path.
pub fn write(options: &Options) -> Result<PathBuf> {
    let job = Job {
        config: options.config.clone(),
        gcode: options.gcode.clone(),
        out: options.out.clone(),
        until_ns: None,
        chip: Chip::Tmc2590,
        faults: Vec::new(),
        verify: true,
    };
    let mut progress = Progress::new();
    let plan = runner::plan(&job, &[], None, &mut |share| progress.show(share)).map_err(|reason| anyhow!(reason))?;
    let edges = options.out.join("steps.csv");
    let compared = if edges.exists() {
        verify::compare(&job, &mut progress)
    } else {
        Err(format!("{} has no steps.csv", options.out.display()))
    };
    progress.clear();
    let title = options.gcode.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let from = options.from.unwrap_or_else(|| curves::longest_motion(&plan));
    let curves = curves::curves(&plan, from, from + options.seconds);
    let data = data(title, curves, curves::corners(&plan), compared);
    fs::create_dir_all(&options.out).with_context(|| options.out.display().to_string())?;
    let path = options.out.join("motion.html");
    fs::write(&path, fill(TEMPLATE, &data.title, &data)).with_context(|| path.display().to_string())?;
    Ok(path)
}

fn data(title: String, curves: Curves, corners: Vec<Corner>, compared: Result<StepError, String>) -> Data {
    let (errors, missing) = match compared {
        Ok(error) => (Some(Errors { names: BINS, counts: error.bins, max: error.max_ns, rms: error.rms_ns }), None),
        Err(reason) => (None, Some(reason)),
    };
    let rounded = |values: Vec<f64>, per_unit: f64| {
        values.into_iter().map(|value| (value * per_unit).round() / per_unit).collect()
    };
    let path = |path: Vec<[f64; 2]>| path.into_iter().map(|point| point.map(|mm| (mm * 1e5).round() / 1e5)).collect();
    Data {
        title,
        period_ms: curves.period * 1e3,
        time: rounded(curves.time, 1e5),
        speed: rounded(curves.speed, 1e2),
        acceleration: rounded(curves.acceleration, 1e0),
        jerk: rounded(curves.jerk, 1e-1),
        corners: corners
            .into_iter()
            .map(|corner| CornerData {
                time: corner.time,
                at: corner.at,
                speed: corner.speed,
                planned: path(corner.planned),
                shaped: path(corner.shaped),
                shaper: corner.shaper,
            })
            .collect(),
        errors,
        missing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_stands_alone_and_a_file_name_cannot_break_it() {
        let curves = Curves {
            time: vec![0.0, 1.0],
            speed: vec![0.0, 2.0],
            acceleration: vec![0.0; 2],
            jerk: vec![0.0; 2],
            period: 1.0,
        };
        let error = StepError { max_ns: 4.0, rms_ns: 1.5, bins: [3; 12] };
        let data = data("</script><b>".to_owned(), curves, Vec::new(), Ok(error));
        let page = fill(TEMPLATE, &data.title, &data);
        assert!(!page.contains("</script><b>") && !page.contains("{{data}}"));
        for outside in ["src=\"http", "href=\"http", "@import", "url(http"] {
            assert!(!page.contains(outside), "{outside}");
        }
    }
}
