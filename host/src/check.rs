//! `velvet check`: what is wrong with a configuration, before anything moves.

use std::io::IsTerminal;
use std::path::Path;

use anyhow::{Context, Result};
use config::{BoardId, Diagnostic};

use crate::colour;

/// Prints the findings; whether everything of the machine works.
pub fn check(path: &Path, json: bool, deny_warnings: bool, board: BoardId) -> Result<bool> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut findings: Vec<Diagnostic> = Vec::new();
    let (_, summary) = config::parse(&bytes, board, &mut findings);
    let (file, text) = (path.display().to_string(), String::from_utf8_lossy(&bytes));
    if json {
        println!("{}", config::to_json(&findings, summary, &file));
    } else {
        let told = config::render_all(&findings, summary, &file, &text);
        let is_seen = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
        print!("{}", if is_seen { colour::findings(&told) } else { told });
    }
    Ok(summary.is_complete() && !(deny_warnings && summary.warnings > 0))
}
