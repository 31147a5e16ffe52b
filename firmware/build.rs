//! Linker scripts and the date of the image.
use std::process::Command;

fn main() {
    // Here rather than in `.cargo/config.toml`, so that a caller's RUSTFLAGS cannot lose them.
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    // The date of the commit, not of the build: the same source gives the same image.
    let date =
        Command::new("git").args(["log", "-1", "--format=%cs"]).output().ok().filter(|output| output.status.success());
    let date = date.and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    let date = if date.trim().is_empty() { "unknown" } else { date.trim() };
    println!("cargo:rustc-env=VELVET_BUILD_DATE={date}");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../.git/HEAD");
}
