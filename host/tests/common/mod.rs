//! Use of the velvet command by tests.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the velvet command with these arguments.
pub fn velvet(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_velvet")).args(arguments).output().expect("velvet was built with this test")
}

/// Returns all that it said.
pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Makes an empty folder of this test's own.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("left by an earlier run of this test");
    }
    std::fs::create_dir_all(&folder).expect("a folder to write to");
    folder
}

/// Returns a path as text.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("the folder's name is text")
}
