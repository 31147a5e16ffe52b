//! The image names nobody's computer: no folder of it stands in flash, where places of panics name sources.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::seal;

/// Where cargo keeps the sources of crates, below a folder of any name.
const REGISTRY: &str = "/registry/src/";
/// Places that are shown.
const SHOWN: usize = 10;
/// Bytes that are shown before what was found.
const BEFORE: usize = 40;
/// Bytes that are shown from there on.
const BEHIND: usize = 80;

/// Fails when the image `elf` holds a folder of the registry, of the workspace `root`, or of who builds it.
pub fn check(root: &Path, elf: &Path) -> Result<()> {
    let bytes = fs::read(elf).with_context(|| elf.display().to_string())?;
    let flash = seal::flash_image(&bytes).with_context(|| elf.display().to_string())?;
    let root = fs::canonicalize(root)?;
    let folders = [Some(root.display().to_string()), std::env::var("HOME").ok()];
    let mut marks = vec![REGISTRY.to_owned()];
    marks.extend(folders.into_iter().flatten().filter(|folder| folder.len() > 1).map(|folder| format!("{folder}/")));
    let found: Vec<String> = marks.iter().flat_map(|mark| places(&flash, mark)).collect();
    if found.is_empty() {
        println!("paths: none of this computer's in {}", elf.display());
        return Ok(());
    }
    for place in found.iter().take(SHOWN) {
        eprintln!("  {place}");
    }
    bail!(
        "{} names folders of this computer, {} times: target/paths.toml, which scripts/toolchain.sh writes, must name them",
        elf.display(),
        found.len()
    )
}

/// What stands around each occurrence of a mark.
fn places(flash: &[u8], mark: &str) -> Vec<String> {
    let windows = flash.windows(mark.len()).enumerate();
    let found = windows.filter(|(_, window)| *window == mark.as_bytes()).map(|(at, _)| at);
    found.map(|at| shown(&flash[at.saturating_sub(BEFORE)..flash.len().min(at + BEHIND)])).collect()
}

fn shown(bytes: &[u8]) -> String {
    bytes.iter().map(|&byte| if byte.is_ascii_graphic() { char::from(byte) } else { ' ' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_found_in_the_middle_of_texts() {
        let flash = b"\0\x01refused/home/anne/.cargo/registry/src/index/a-1.0.0/src/lib.rs/home/anne/velvet/a.rs\xFF";
        assert_eq!(places(flash, REGISTRY).len(), 1);
        assert!(places(flash, REGISTRY)[0].contains("anne/.cargo"));
        assert_eq!(places(flash, "/home/anne/").len(), 2);
        assert!(places(b"a-1.0.0/src/lib.rs", REGISTRY).is_empty());
        assert!(places(b"", REGISTRY).is_empty());
    }
}
