//! Makes the emulator's source: the pinned release of the crate `rigless`, as cargo has it from the registry,
//! with the patches of `patches/` applied in the order of their names. `make` runs this before it builds the
//! virtual board; by hand it is `cargo run` in this folder.
//!
//! Nothing is done when the result is there and made from these patches. A patch that does not fit exactly is
//! an error: there is no fuzz, since the release is pinned.

mod patch;
mod release;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// File in the result with the hash of its sources.
const STAMP: &str = ".made-from";

fn main() -> ExitCode {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    match make(here, &here.with_file_name("target").join("emulator")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("emulator: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn make(here: &Path, result: &Path) -> Result<(), String> {
    let lock = read(&here.join("Cargo.lock"))?;
    let mut patches = Vec::new();
    for path in files(&here.join("patches"))? {
        patches.push((path.clone(), read(&path)?));
    }
    let stamp = stamp(std::iter::once(lock.as_str()).chain(patches.iter().map(|(_, text)| text.as_str())));
    if fs::read_to_string(result.join(STAMP)).is_ok_and(|made_from| made_from == stamp) {
        return Ok(());
    }
    let source = release::find(here)?;
    // The source is made beside the result first, so that an interrupted run leaves nothing half made.
    let fresh = result.with_extension("new");
    let _ = fs::remove_dir_all(&fresh);
    copy(&source, &fresh)?;
    for (path, text) in &patches {
        patch::apply(text, &fresh).map_err(|reason| format!("{}: {reason}", path.display()))?;
    }
    release::drop_lints(&fresh.join("Cargo.toml"))?;
    write(&fresh.join(STAMP), &stamp)?;
    let _ = fs::remove_dir_all(result);
    fs::rename(&fresh, result).map_err(|error| format!("{}: {error}", result.display()))
}

/// Computes FNV-1a over all texts, in hexadecimal.
fn stamp<'a>(texts: impl Iterator<Item = &'a str>) -> String {
    let hash = texts
        .flat_map(str::bytes)
        .fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3));
    format!("{hash:016x}")
}

/// Returns the paths in a folder, sorted by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let fail = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries = fs::read_dir(folder).map_err(fail)?.map(|entry| entry.map(|entry| entry.path()));
    let mut paths = entries.collect::<Result<Vec<_>, _>>().map_err(fail)?;
    paths.sort();
    Ok(paths)
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    fs::create_dir_all(to).map_err(|error| format!("{}: {error}", to.display()))?;
    for path in files(from)? {
        let place = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &place)?;
        } else {
            // The file is read and written rather than copied, as files of the registry may be read-only.
            let bytes = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            fs::write(&place, bytes).map_err(|error| format!("{}: {error}", place.display()))?;
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}
