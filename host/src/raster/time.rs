//! Time that a picture takes: by the machine's own planner, or estimated where the machine is not known.

use anyhow::{Result, anyhow};
use config::MachineConfig;
use motion::Motion;
use preflight::{Finding, Listener, Preflight, dialect_of, read};

use super::machine::Limits;
use super::strokes::{Layout, Stroke};

/// Listener that leaves findings to `velvet preflight`.
struct Silent;

impl Listener for Silent {
    fn found(&mut self, _: &Finding) {}
}

/// Returns the time that a machine takes for a file, seconds, from a dry run.
pub fn of_file(config: &MachineConfig, text: &str) -> Result<f64> {
    let (mut motion, mut program) = (Box::new(Motion::new()), None);
    let texts = base::failure::Texts::new();
    let mut preflight = Preflight::new(&texts, config, dialect_of(text.as_bytes()), &mut program, &mut motion)
        .map_err(|arms| anyhow!("the geometry of {arms:?} fits no machine"))?;
    let done = read(&mut preflight, text.as_bytes(), &|_| None, &mut motion, &mut Silent);
    done.map_err(|why| anyhow!("{why}"))?;
    Ok(preflight.totals().seconds())
}

/// Returns the time that strokes take with the ways between them, seconds, where the machine is not known: as
/// if each way began and ended at rest.
pub fn of_strokes(layout: &Layout, strokes: &[Stroke], limits: &Limits, speed: f64) -> f64 {
    let mut at: Option<[f64; 2]> = None;
    let mut seconds = 0.0;
    for stroke in strokes {
        let [from, to] = layout.ends(stroke).map(|along| layout.place(along, layout.across(stroke.line)));
        let way = |from: [f64; 2], to: [f64; 2]| (to[0] - from[0]).hypot(to[1] - from[1]);
        seconds += limits.seconds(at.map_or(0.0, |at| way(at, from)), limits.seek);
        seconds += limits.seconds(way(from, to), speed);
        at = Some(to);
    }
    seconds
}
