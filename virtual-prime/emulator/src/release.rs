//! Source of the release as cargo has it: wherever this machine keeps or vendors its crates.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Finds the folder of the crate's source. Cargo fetches it if need be, and checks it against the checksum in
/// Cargo.lock.
///
/// # Errors
/// What cargo says, or that it does not name the crate.
pub fn find(here: &Path) -> Result<PathBuf, String> {
    let compiler = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let about = said_by(Command::new(compiler).arg("-vV"))?;
    // The target is limited to this machine, so that nothing is fetched that is not built.
    let host = about.lines().find_map(|line| line.strip_prefix("host: ")).ok_or("rustc does not name this machine")?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let metadata = said_by(
        Command::new(cargo)
            .args(["metadata", "--format-version", "1", "--locked", "--features", "release", "--filter-platform", host])
            .current_dir(here),
    )?;
    let manifest = manifest_path(&metadata).ok_or("cargo metadata names no rigless")?;
    manifest.parent().map(Path::to_path_buf).ok_or_else(|| "rigless lies nowhere".into())
}

fn said_by(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr)))
    }
}

/// Finds the path of the package's manifest in the output of `cargo metadata`. Of all objects called rigless
/// in there, only the package is followed by its version.
fn manifest_path(metadata: &str) -> Option<PathBuf> {
    const KEY: &str = "\"manifest_path\":\"";
    let package = &metadata[metadata.find("\"name\":\"rigless\",\"version\"")?..];
    let path = &package[package.find(KEY)? + KEY.len()..];
    Some(path[..path.find('"')?].replace("\\\\", "\\").into())
}

/// Takes the crate's lints out of its manifest. Lints are for the crate's own developers; cargo caps them for
/// crates from a registry, and not for a crate in a folder.
///
/// # Errors
/// When the manifest cannot be read or written.
pub fn drop_lints(manifest: &Path) -> Result<(), String> {
    let text = super::read(manifest)?;
    let mut kept = String::new();
    let mut lints = false;
    for line in text.lines() {
        if line.starts_with('[') {
            lints = line.starts_with("[lints");
        }
        if !lints {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    super::write(manifest, &kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_package_is_told_from_those_that_depend_on_it() {
        let metadata = r#"{"packages":[{"name":"emulator","version":"0.1.0","dependencies":[{"name":"rigless","source":"r"}],
            "manifest_path":"/here/Cargo.toml"},{"name":"rigless","version":"0.4.0","manifest_path":"/there/Cargo.toml"}]}"#;
        assert_eq!(manifest_path(metadata), Some("/there/Cargo.toml".into()));
    }
}
