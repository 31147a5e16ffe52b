//! `velvet heat`: a tuning of a heater, M303 or M306, as words and a page: the readings, the values
//! measured from them, the model that follows laid over them, and the meaning of each gain.

mod answer;
mod log;
mod page;
mod words;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use sim::runner::{Runner, Setup};

use answer::{Laid, Swing};
use log::Log;

/// Longest time given to a tuning, ns: it ends by itself within little more than an hour.
const LONGEST_NS: u64 = 5_000_000_000_000;
/// Time from power-on until readings are there, ns.
const BOOT_NS: u64 = 1_000_000_000;

/// What `velvet heat` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// What a console has said while M303 or M306 ran; with --config it is written
    log: PathBuf,
    /// Tune a heater of this machine on this computer first
    #[arg(long, value_name = "FILE", requires = "tune")]
    config: Option<PathBuf>,
    /// How: the line that a console would be given
    #[arg(long, value_name = "LINE", requires = "config")]
    tune: Option<String>,
    /// Draw it: a page with curves, the lines that were measured, the model, the gains
    #[arg(long, value_name = "HTML")]
    page: Option<PathBuf>,
}

/// Log of a tuning, and the findings about it.
pub struct Tuning {
    pub log: Log,
    pub swings: Vec<Swing>,
    pub laid: Option<Laid>,
}

/// Prints the sentences; writes the page.
pub fn heat(options: &Options) -> Result<()> {
    let path = options.log.display();
    if let (Some(config), Some(line)) = (&options.config, &options.tune) {
        let said = tune(config, line)?;
        fs::write(&options.log, said).with_context(|| format!("cannot write {path}"))?;
    }
    let bytes = fs::read(&options.log).with_context(|| format!("cannot read {path}"))?;
    let tuning = Tuning::of(&String::from_utf8_lossy(&bytes)).with_context(|| path.to_string())?;
    for line in words::facts(&tuning).into_iter().chain(words::gains(&tuning).into_iter().map(|gain| gain.line())) {
        println!("{line}");
    }
    if let Some(page) = &options.page {
        fs::write(page, page::page(&tuning)).with_context(|| format!("cannot write {}", page.display()))?;
    }
    Ok(())
}

impl Tuning {
    /// Reads the last tuning of a log.
    fn of(text: &str) -> Result<Self> {
        let log = log::read(text)?;
        let laid = answer::model(&log).map(|model| answer::laid(&log, model));
        let swings = answer::swings(&log, laid.as_ref().map(|laid| laid.model));
        Ok(Self { swings, laid, log })
    }
}

/// Tunes a heater on a simulated machine of this configuration; returns the console's text.
fn tune(config: &Path, line: &str) -> Result<String> {
    let card = std::env::temp_dir().join(format!("velvet-heat-{}", std::process::id()));
    fs::create_dir_all(&card).with_context(|| card.display().to_string())?;
    let said = fs::copy(config, card.join("config.ini"))
        .with_context(|| config.display().to_string())
        .and_then(|_| Runner::new(&Setup::new(&card)).map_err(|reason| anyhow!(reason)))
        .map(|mut runner| {
            runner.run_until(BOOT_NS);
            runner.command(line, LONGEST_NS)
        });
    // A folder left behind harms nobody.
    let _ = fs::remove_dir_all(&card);
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heater_that_is_tuned_here_is_drawn_and_explained() {
        let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/samples/cartesian.ini");
        for (line, words) in [
            ("M303 P0 S200", ["p_factor", "i_factor", "d_factor"]),
            ("M306 T0 S200", ["model_capacity", "model_loss", "model_late"]),
        ] {
            let tuning = Tuning::of(&tune(&config, line).expect("a machine")).expect("a tuning");
            let laid = tuning.laid.as_ref().expect("a model");
            assert!(laid.off_by[0] < 4.0 && laid.off_by[1] < 1.5, "{line}: {:?}", laid.off_by);
            assert!(tuning.swings.len() >= 2, "{line}");
            let gains = words::gains(&tuning);
            assert!(words.iter().all(|word| gains.iter().any(|gain| gain.name == *word)), "{line}");
            let page = page::page(&tuning);
            for outside in ["src=\"http", "href=\"http", "@import", "url(http", "{{"] {
                assert!(!page.contains(outside), "{outside}");
            }
            assert!(words.iter().all(|word| page.contains(word)));
        }
        let refused = Tuning::of(&tune(&config, "M303 P0 S289").expect("a machine"));
        assert!(refused.is_err());
    }
}
