//! The progress of a long command.

use std::io::{IsTerminal, Write};

/// Percentage on a terminal; nothing in a log file.
pub struct Progress {
    shown: Option<u32>,
    terminal: bool,
}

impl Progress {
    /// Makes a progress line with nothing shown yet.
    pub fn new() -> Self {
        Self { shown: None, terminal: std::io::stderr().is_terminal() }
    }

    /// Shows this share of the work done, 0 to 1.
    pub fn show(&mut self, share: f64) {
        let percent = (100.0 * share) as u32;
        if self.terminal && self.shown != Some(percent) {
            eprint!("\r{percent:3} %");
            // A failed flush only shows the percentage later; nothing depends on it.
            let _ = std::io::stderr().flush();
            self.shown = Some(percent);
        }
    }

    /// Takes the percentage off the screen.
    pub fn clear(&self) {
        if self.shown.is_some() {
            eprint!("\r      \r");
        }
    }
}
