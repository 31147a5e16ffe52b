//! Files read ahead on the sample printer: totals, findings, and calls of the listener.

mod flow;
mod forecast;
mod listening;
mod machine;
mod moves;
mod outputs;
mod power;
mod time;

use base::failure::Texts;
use config::{BoardId, MachineConfig};
use motion::Motion;
use program::Interpreter;

use super::{Finding, Kind, Listener, Preflight, Totals, dialect_of, read};

/// Cartesian printer with switches at X0 Y0 Z0 and a travel of 220, 220 and 200 mm.
const PRINTER: &str = include_str!("../../../config/samples/cartesian.ini");

/// Listener that keeps all findings.
#[derive(Default)]
struct Found(Vec<Finding>);

impl Listener for Found {
    fn found(&mut self, finding: &Finding) {
        self.0.push(finding.clone());
    }
}

/// Memory of a machine on which a file is read.
struct Desk {
    config: MachineConfig,
    texts: Texts,
    motion: Box<Motion>,
    program: Option<Interpreter>,
}

impl Desk {
    /// Makes the sample printer.
    fn new() -> Self {
        Self::with(&[])
    }

    /// Makes the sample printer with pieces of its configuration replaced.
    fn with(changes: &[(&str, &str)]) -> Self {
        let mut text = PRINTER.to_owned();
        for (piece, instead) in changes {
            assert!(text.contains(piece), "the configuration has no `{piece}`");
            text = text.replace(piece, instead);
        }
        let (config, summary) = config::parse(text.as_bytes(), BoardId::default(), &mut ());
        assert!(summary.is_usable());
        Self { config, texts: Texts::new(), motion: Box::new(Motion::new()), program: None }
    }

    /// Calls `f` with the state of the machine just switched on, which reads a file of this text.
    fn preflight<R>(&mut self, text: &str, f: impl FnOnce(&mut Preflight<'_>, &mut Motion) -> R) -> R {
        let Self { config, texts, motion, program } = self;
        let dialect = dialect_of(text.as_bytes());
        let mut preflight = Preflight::new(texts, config, dialect, program, motion).expect("a machine that can move");
        f(&mut preflight, motion)
    }

    /// Reads a file to its end with this listener.
    fn hear(&mut self, text: &str, listener: &mut dyn Listener) -> Totals {
        self.preflight(text, |preflight, motion| {
            read(preflight, text.as_bytes(), &|_| None, motion, listener).expect("no calls of files");
            *preflight.totals()
        })
    }

    /// Reads a file to its end.
    fn read(&mut self, text: &str) -> (Vec<Finding>, Totals) {
        let mut found = Found::default();
        let totals = self.hear(text, &mut found);
        (found.0, totals)
    }
}

/// Reads a file on the sample printer.
fn look(text: &str) -> (Vec<Finding>, Totals) {
    Desk::new().read(text)
}

/// Returns line and kind of each finding.
fn places(found: &[Finding]) -> Vec<(u32, Kind)> {
    found.iter().map(|finding| (finding.line, finding.kind)).collect()
}

/// Asserts that two values are the same but for the rounding of positions to steps.
#[track_caller]
fn assert_near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-3, "{value}, not {expected}");
}
