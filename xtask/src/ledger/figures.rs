//! Figures by name, as they are kept in `bench/ledger.json`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Flat numbers by name.
pub type Ledger = BTreeMap<String, f64>;

/// Keys of what a crate takes of the flash. Code moves from one to another when it is inlined: only their sum
/// is held to anything.
pub const SIZE: &str = "flash_of_";

/// Of these, more is better.
pub const RATES: [&str; 5] =
    ["sustained_steps_per_s", "lines_per_s", "lines_per_s_smooth", "queue_depth_ms", "laser_pixels_per_s"];

/// The ledger that lies there.
pub fn read(path: &Path) -> Option<Ledger> {
    serde_json::from_slice(&fs::read(path).ok()?).ok()
}

/// The ledger of the last commit: the file in the work tree may be this machine's own last run.
pub fn committed(root: &Path) -> Option<Ledger> {
    let output = Command::new("git").args(["show", "HEAD:bench/ledger.json"]).current_dir(root).output().ok()?;
    serde_json::from_slice(&output.stdout).ok()
}
