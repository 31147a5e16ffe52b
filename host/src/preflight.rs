//! `velvet preflight`: a job's demands on a machine, checked before anything moves.

mod macros;
mod page;

use std::cell::OnceCell;
use std::path::{Path, PathBuf};
use std::{fs, io};

use anyhow::{Context, Result, anyhow, bail};
use base::sessions::LineBytes;
use config::{BoardId, MachineConfig};
use macros::Macros;
use motion::{Motion, Passage};
use page::Way;
use preflight::{
    Called, Finding, Limit, Listener, MacroCall, MacroPlace, Preflight, Severity, TOLD_LINES, Told, Totals, dialect_of,
    read,
};

use crate::bed;

/// What `velvet preflight` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// The machine's configuration
    config: PathBuf,
    /// The job
    file: PathBuf,
    /// What the machine has saved (M500): config-override, as it is on its card
    #[arg(long, value_name = "FILE")]
    saved: Option<PathBuf>,
    /// The mesh that levels the bed, as it is on the card: NAME.mesh, cartesian.grid or delta.grid
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// Findings and totals as one JSON object
    #[arg(long)]
    json: bool,
    /// Draw the job: a page with its path by speed, flow, layer and object
    #[arg(long, value_name = "HTML")]
    page: Option<PathBuf>,
}

/// Collector of the findings.
#[derive(Default)]
struct Found<'t> {
    findings: Vec<Finding>,
    /// Macros of the machine, if it has any.
    macros: Option<Macros<'t>>,
    /// Path of the job's moves, if a page is to be drawn.
    way: Option<Way>,
}

impl Listener for Found<'_> {
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

    fn called(&mut self, call: MacroCall<'_>) -> Option<Called> {
        Some(self.macros.as_mut().map_or(Called::Nothing, |macros| macros.called(call)))
    }

    fn macro_line(&mut self, line: &mut LineBytes, place: &mut MacroPlace) -> Option<Called> {
        Some(self.macros.as_mut().map_or(Called::Nothing, |macros| macros.line(line, place)))
    }
}

/// Prints the findings; returns whether nothing stops the job.
pub fn preflight(options: &Options) -> Result<bool> {
    let (config, summary) = config::parse(&bytes(&options.config)?, BoardId::default(), &mut ());
    if !summary.is_usable() {
        bail!("{} has errors; see: velvet check {0}", options.config.display());
    }
    let text = bytes(&options.file)?;
    let subs = Subs::beside(&options.file)?;
    let texts = base::failure::Texts::new();
    let (mut motion, mut program, mut found) = (Box::new(Motion::new()), None, Found::default());
    found.way = options.page.is_some().then(Way::default);
    let mut preflight = Preflight::new(&texts, &config, dialect_of(&text), &mut program, &mut motion)
        .map_err(|arms| anyhow!("the geometry of {arms:?} fits no machine"))?;
    as_saved(options, &mut preflight, &mut motion)?;
    if !config.macros.file.is_empty() {
        let macros = Macros::read(&texts, &config, options.config.parent().unwrap_or(Path::new("")))?;
        preflight.takes(macros.taken());
        found.macros = Some(macros);
    }
    read(&mut preflight, &text, &|name| subs.text(name), &mut motion, &mut found).map_err(|why| anyhow!("{why}"))?;
    subs.check()?;
    let totals = preflight.totals();
    let told = told(&config, totals);
    if options.json {
        println!("{}", json(&config, &found.findings, totals));
    } else {
        found.findings.iter().for_each(|finding| println!("{finding}"));
        print!("{told}");
    }
    if let (Some(path), Some(way)) = (&options.page, &found.way) {
        let title = options.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        fs::write(path, way.page(&title, &found.findings, &told))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(totals.stops == 0)
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

/// Applies the settings and the mesh that the machine has saved, which are in force before the job begins.
fn as_saved(options: &Options, preflight: &mut Preflight<'_>, motion: &mut Motion) -> Result<()> {
    if let Some(path) = &options.saved {
        let mut wrong = Found::default();
        let loads_mesh = preflight.load_settings(&bytes(path)?, motion, &mut wrong);
        let stops = |finding: &&Finding| finding.kind.severity() == Severity::Stop;
        if let Some(finding) = wrong.findings.iter().find(stops) {
            let (line, what) = (finding.line, &finding.what);
            bail!("{}, line {line}: {what} (give what M500 wrote, config-override on the card)", path.display());
        }
        if let (Some(line), None) = (loads_mesh, &options.mesh) {
            let path = path.display();
            bail!("{path}, line {line}: the machine loads a mesh: give it with --mesh FILE, as it is on the card");
        }
    }
    if let Some(path) = &options.mesh {
        let (shape, heights) = bed::read(path)?;
        let loaded = preflight.load_mesh(&shape, &heights, !bed::is_grid(path), motion);
        loaded.map_err(|why| anyhow!("{}: {why}", path.display()))?;
    }
    Ok(())
}

/// Files of subroutines beside the job, each read at its first call. The card does not tell capital letters
/// from small ones, so neither does this reader.
pub(crate) struct Subs {
    files: Vec<(PathBuf, OnceCell<io::Result<Vec<u8>>>)>,
}

impl Subs {
    pub(crate) fn beside(job: &Path) -> Result<Self> {
        let folder = job.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let entries = fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        let is_sub = |path: &PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ngc"));
        Ok(Self { files: paths.filter(is_sub).map(|path| (path, OnceCell::new())).collect() })
    }

    pub(crate) fn text(&self, name: &str) -> Option<&[u8]> {
        let is_it = |path: &Path| path.file_stem().is_some_and(|stem| stem.eq_ignore_ascii_case(name));
        let (path, text) = self.files.iter().find(|(path, _)| is_it(path))?;
        text.get_or_init(|| fs::read(path)).as_ref().ok().map(Vec::as_slice)
    }

    /// Fails unless every file that was asked for could be read.
    pub(crate) fn check(&self) -> Result<()> {
        for (path, text) in &self.files {
            if let Some(Err(error)) = text.get() {
                bail!("cannot read {}: {error}", path.display());
            }
        }
        Ok(())
    }
}

fn json(config: &MachineConfig, found: &[Finding], totals: &Totals) -> serde_json::Value {
    let findings: Vec<_> = found
        .iter()
        .map(|finding| {
            serde_json::json!({
                "file": finding.sub.as_ref().map(|sub| format!("{sub}.ngc")), "line": finding.line, "kind": format!("{:?}", finding.kind), "what": finding.what.as_str(),
                "severity": format!("{:?}", finding.kind.severity()), "fix": finding.kind.fix(),
            })
        })
        .collect();
    let heats = config.heaters().filter_map(|(id, heater)| Some((heater, totals.heats.get(id.index())?)));
    let waited_for = heats.filter(|(_, (times, _))| *times > 0);
    let heating: serde_json::Map<_, _> = waited_for
        .map(|(heater, (times, most))| {
            (heater.name.as_str().to_owned(), serde_json::json!({ "waits": times, "most_c": most.0 }))
        })
        .collect();
    let cost = Limit::ALL.iter().zip(totals.limits).filter(|(_, seconds)| *seconds > 0.0);
    let limits: serde_json::Map<_, _> = cost.map(|(limit, seconds)| (limit.to_string(), seconds.into())).collect();
    serde_json::json!({
        "findings": findings, "stops": totals.stops, "warnings": totals.warnings, "lines": totals.lines,
        "seconds": totals.seconds(), "even_seconds": totals.even_seconds, "ramp_seconds": totals.ramp_seconds,
        "waiting_seconds": totals.waiting_seconds, "homing_seconds": totals.homing_seconds,
        "lost_seconds": totals.lost_seconds(), "limits": limits, "filament_mm": totals.filament, "heat_waits": totals.heat_waits, "heating": heating,
    })
}

/// Returns the totals as lines of text.
fn told(config: &MachineConfig, totals: &Totals) -> String {
    (0..TOLD_LINES).map(|line| Told { config, totals, line }.to_string()).collect()
}
