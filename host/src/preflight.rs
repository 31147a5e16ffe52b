//! `velvet preflight`: what a job asks of a machine, before anything moves.

mod page;

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, anyhow, bail};
use config::BoardId;
use machine::preflight::{Finding, Listener, Preflight, TOLD_LINES, Told, Totals, dialect_of, read};
use motion::{Motion, Passage};
use page::Way;

/// What `velvet preflight` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// The machine's configuration
    config: PathBuf,
    /// The job
    file: PathBuf,
    /// Findings and totals as one JSON object
    #[arg(long)]
    json: bool,
    /// Draw the job: a page with its path by speed, flow, layer and object
    #[arg(long, value_name = "HTML")]
    page: Option<PathBuf>,
}

/// Keeps what is found.
#[derive(Default)]
struct Found {
    findings: Vec<Finding>,
    /// The way of its moves, where a page is to be drawn.
    way: Option<Way>,
}

impl Listener for Found {
    fn found(&mut self, finding: &Finding) {
        self.findings.push(finding.clone());
    }

    fn passed(&mut self, passage: &Passage, motion: &Motion) {
        if let Some(way) = &mut self.way {
            way.passed(passage, motion);
        }
    }

    fn labelled(&mut self, line: u32, text: &str) {
        if let Some(way) = &mut self.way {
            way.labelled(line, text);
        }
    }
}

/// Prints what is found; whether nothing stops the job.
pub fn preflight(options: &Options) -> Result<bool> {
    let bytes = |path: &PathBuf| fs::read(path).with_context(|| format!("cannot read {}", path.display()));
    let (config, summary) = config::parse(&bytes(&options.config)?, BoardId::default(), &mut ());
    if !summary.is_usable() {
        bail!("{} has errors; see: velvet check {0}", options.config.display());
    }
    let text = bytes(&options.file)?;
    let (mut motion, mut program, mut found) = (Box::new(Motion::new()), None, Found::default());
    found.way = options.page.is_some().then(Way::default);
    let mut preflight = Preflight::new(&config, dialect_of(&text), &mut program, &mut motion)
        .map_err(|arms| anyhow!("the geometry of {arms:?} fits no machine"))?;
    read(&mut preflight, &text, &mut motion, &mut found);
    let totals = preflight.totals();
    if options.json {
        println!("{}", json(&found.findings, totals));
    } else {
        found.findings.iter().for_each(|finding| println!("{finding}"));
        print!("{}", told(totals));
    }
    if let (Some(path), Some(way)) = (&options.page, &found.way) {
        let title = options.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        fs::write(path, way.page(&title, &found.findings, &told(totals)))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(totals.stops == 0)
}

fn json(found: &[Finding], totals: &Totals) -> serde_json::Value {
    let findings: Vec<_> = found
        .iter()
        .map(|finding| {
            serde_json::json!({
                "line": finding.line, "kind": format!("{:?}", finding.kind), "what": finding.what.as_str(),
                "severity": format!("{:?}", finding.kind.severity()), "fix": finding.kind.fix(),
            })
        })
        .collect();
    serde_json::json!({
        "findings": findings, "stops": totals.stops, "warnings": totals.warnings, "lines": totals.lines,
        "seconds": totals.seconds(), "even_seconds": totals.even_seconds, "ramp_seconds": totals.ramp_seconds,
        "waiting_seconds": totals.waiting_seconds, "homing_seconds": totals.homing_seconds,
        "lost_seconds": totals.lost_seconds, "filament_mm": totals.filament, "heat_waits": totals.heat_waits,
    })
}

/// Totals as lines of text.
fn told(totals: &Totals) -> String {
    (0..TOLD_LINES).map(|line| Told { totals, line }.to_string()).collect()
}
