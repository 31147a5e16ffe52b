//! `velvet macro`: Klipper's macros checked and rendered away from the machine, by the code of the board.

pub mod check;
pub mod files;
pub mod render;
pub mod state;

use std::path::PathBuf;

use anyhow::Result;

/// Memory for a macro's code, values and stack on the board, bytes.
pub const MEMORY: usize = 28 * 1024;
/// Memory for the lines that macros make on the board, bytes.
pub const OUTPUT: usize = printer_cfg::LINES_BYTES;

/// What `velvet macro` does.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum Options {
    /// Read every macro of Klipper's files, with what they include; exits 1 when one is not taken, 2 when a
    /// file cannot be read
    Check {
        /// Klipper's printer.cfg and others
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Print the lines that a macro makes; exits 1 when it raises an error
    Render {
        /// Klipper's printer.cfg, or another file that has the macro
        file: PathBuf,
        /// The macro's name
        name: String,
        /// Parameters as NAME=VALUE
        #[arg(value_name = "NAME=VALUE")]
        parameters: Vec<String>,
        /// The printer's state as JSON: what the macro finds under `printer`
        #[arg(long, value_name = "JSON")]
        state: Option<PathBuf>,
    },
}

/// Carries out `velvet macro`; returns whether all went well.
pub fn macros(options: &Options) -> Result<bool> {
    match options {
        Options::Check { files } => check::check(files),
        Options::Render { file, name, parameters, state } => render::render(file, name, parameters, state.as_deref()),
    }
}
