//! Linker scripts, and the version and date of the image. The controller's image is built with this script
//! too.
use std::process::Command;

/// Returns the first line of git's answer, if it has one.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    text.lines().next().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty())
}

fn main() {
    // Here rather than in `.cargo/config.toml`, so that a caller's RUSTFLAGS cannot lose them. Functions of
    // equal code are one in the image: nothing compares the addresses of functions.
    for argument in ["--nmagic", "-Tlink.x", "-Tdefmt.x", "-Timage.x", "--icf=all"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    println!("cargo:rustc-link-search={}/../firmware", env!("CARGO_MANIFEST_DIR"));
    for file in ["flash.x", "image.x", "build.rs"] {
        println!("cargo:rerun-if-changed=../firmware/{file}");
    }
    // Version and date of the commit, not of the build: the same source gives the same image.
    let date = git(&["log", "-1", "--format=%cs"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo:rustc-env=VELVET_BUILD_DATE={date}");
    let package = env!("CARGO_PKG_VERSION");
    let version = git(&["log", "-1", "--abbrev=8", "--format=%h"])
        .map_or(package.to_owned(), |commit| format!("{package}-{commit}"));
    println!("cargo:rustc-env=VELVET_VERSION={version}");
    // Git names the paths: in a worktree these are not below `.git`, which is a file there. `logs/HEAD` grows
    // with each commit.
    for file in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", file]) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
}
