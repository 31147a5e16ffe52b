//! `docs/v2-replay.md`: how many replies of each session are equal. Written with `WRITE_V2=1`, and held
//! against what the replay finds else.

use std::fs;
use std::path::{Path, PathBuf};

/// Comparison of a session with Smoothieware v2.
#[derive(Clone, Copy, Default)]
pub struct Counts {
    pub equal: usize,
    /// Equal but for live numbers.
    pub live: usize,
    /// Otherwise, for a reason of `docs/differences.md`.
    pub explained: usize,
    /// Without one on the host; about the board itself, or a moment, on the board.
    pub other: usize,
}

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/v2-replay.md")
}

/// Whether the page is to be written anew.
pub fn writes() -> bool {
    std::env::var_os("WRITE_V2").is_some()
}

impl Counts {
    /// Counts one reply that both firmwares give as the record says.
    pub fn count(&mut self, theirs: &[String], ours: &[String]) {
        let live = theirs.iter().any(|line| line.contains('#'));
        match (theirs == ours, live) {
            (true, false) => self.equal += 1,
            (true, true) => self.live += 1,
            (false, _) => self.explained += 1,
        }
    }

    /// The row of a session.
    pub fn row(&self, name: &str) -> String {
        let Self { equal, live, explained, other } = self;
        format!("| {name} | {} | {equal} | {live} | {explained} | {other} |\n", equal + live + explained + other)
    }
}

/// Returns the text of the page.
pub fn read() -> String {
    fs::read_to_string(path()).expect("docs/v2-replay.md")
}

/// Returns the part of the page below this heading.
pub fn part<'p>(page: &'p str, heading: &str) -> &'p str {
    let begin = page.find(heading).unwrap_or_else(|| panic!("docs/v2-replay.md has no `{heading}`"));
    let part = &page[begin + heading.len()..];
    &part[..part.find("\n## ").map_or(part.len(), |end| end + 1)]
}

/// Checks that the part below a heading is this text, or writes it.
pub fn hold(heading: &str, text: &str) -> Result<(), String> {
    let page = read();
    let old = part(&page, heading);
    if old == text {
        return Ok(());
    }
    if !writes() {
        return Err(format!("docs/v2-replay.md has other numbers {heading}: WRITE_V2=1 writes it\n"));
    }
    fs::write(path(), page.replace(&format!("{heading}{old}"), &format!("{heading}{text}"))).expect("the page");
    Ok(())
}
