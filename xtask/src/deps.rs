//! The dependency rules of `docs/architecture.md`, checked against what cargo resolved.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Result, bail};

use crate::package::{self, Package};
use crate::structure::Structure;
use crate::{circles, sources};

/// The workspace's crates that each crate may use. A crate that is not listed may not exist.
const MAY_USE: &[(&str, &[&str])] = &[
    ("units", &[]),
    // The log of events, which every crate may write.
    ("events", &["units"]),
    // The board on paper: what the simulated machine is wired by, and never the firmware.
    ("board-facts", &[]),
    ("gcode", &["units"]),
    ("program", &["units", "gcode"]),
    ("config", &["units", "gcode"]),
    ("motion", &["units"]),
    ("tmc", &["units"]),
    ("drivers", &["units"]),
    // Cards and the file systems on them: blocks and bytes, and nothing of a machine.
    ("card", &[]),
    // What keeps heaters safe, apart from everything that moves; `drivers` knows sensors' curves and no chip.
    // Of motion it knows marks, the places on the path at which outputs change.
    ("thermal", &["units", "config", "motion", "drivers"]),
    // The machine in layers, the lowest first: ports, sessions, safety and failures, and the machine as a
    // sequence may use it. Which names of files are legal is the file system's knowledge, in `card`.
    ("base", &["units", "events", "gcode", "program", "config", "motion", "card", "thermal"]),
    ("parts", &["units", "gcode", "program", "config", "motion", "drivers", "thermal", "base"]),
    ("jobs", &["units", "events", "gcode", "program", "config", "motion", "thermal", "base"]),
    ("procedures", &["units", "gcode", "program", "config", "motion", "thermal", "base", "parts", "jobs"]),
    // The dry run, which never sees the machine itself.
    ("preflight", &["units", "gcode", "program", "config", "motion", "thermal", "base", "parts", "jobs", "procedures"]),
    (
        "machine",
        &[
            "units",
            "events",
            "gcode",
            "program",
            "config",
            "motion",
            "thermal",
            "base",
            "parts",
            "jobs",
            "procedures",
            "preflight",
        ],
    ),
    // The machine's port over the chips: `machine` never sees a chip, `tmc` never sees a machine.
    ("driver-bank", &["units", "config", "base", "tmc"]),
    // The same for the converter chips of sensors: their settings, and when each is read.
    ("sensor-bank", &["units", "config", "base", "drivers"]),
    // The machine's port over a card's file system.
    ("storage", &["base", "card"]),
    // Images and how they are installed, over flash and card as traits: the boot stage has no machine.
    ("update", &[]),
    // A USB device over a bus as a trait: what its ports and its disk are connected to is handed in.
    ("usb", &[]),
    // The step interrupt plays `motion::queue`, the one structure solver and interrupt share; the card's host
    // controller is driven by `card::sd`; the flash is what `update` writes to.
    ("bsp-prime", &["units", "events", "motion", "card", "update"]),
    // Boot code knows no machine.
    ("boot", &["bsp-prime", "card", "update", "usb"]),
    (
        "firmware",
        &[
            "units",
            "events",
            "gcode",
            "config",
            "motion",
            "card",
            "thermal",
            "base",
            "machine",
            "driver-bank",
            "sensor-bank",
            "storage",
            "update",
            "usb",
            "bsp-prime",
        ],
    ),
    (
        "sim",
        &[
            "units",
            "events",
            "board-facts",
            "gcode",
            "config",
            "motion",
            "drivers",
            "card",
            "thermal",
            "base",
            "machine",
            "driver-bank",
            "sensor-bank",
        ],
    ),
    (
        "scenarios",
        &[
            "units",
            "events",
            "program",
            "gcode",
            "config",
            "motion",
            "drivers",
            "thermal",
            "base",
            "jobs",
            "preflight",
            "sim",
        ],
    ),
    ("on-target", &["units", "events", "config", "motion", "tmc", "drivers", "base", "bsp-prime"]),
    ("fuzz", &["units", "gcode", "program", "config", "motion", "thermal", "base", "sim"]),
    ("fuzz-engine", &["fuzz"]),
    (
        "host",
        &["units", "gcode", "program", "config", "motion", "sim", "base", "jobs", "procedures", "preflight", "update"],
    ),
    ("xtask", &["update"]),
];

/// Crates from outside that only the board's crates may name.
const HARDWARE: &[&str] = &["stm32h7xx-hal", "stm32h7", "cortex-m", "cortex-m-rt", "cortex-m-semihosting"];
const MAY_NAME_HARDWARE: &[&str] = &["bsp-prime", "boot", "firmware", "on-target"];

/// The framework of the board's tasks. Everything below the firmware is called by it and never knows it.
const TASKS: &[&str] = &["rtic", "rtic-sync", "rtic-monotonics", "rtic-time"];
const MAY_NAME_TASKS: &[&str] = &["firmware"];

/// Crates that run on the board and on a desk alike: no standard library outside tests.
const PURE: &[&str] = &[
    "units",
    "events",
    "board-facts",
    "gcode",
    "program",
    "config",
    "motion",
    "tmc",
    "drivers",
    "card",
    "thermal",
    "base",
    "parts",
    "jobs",
    "procedures",
    "preflight",
    "machine",
    "driver-bank",
    "sensor-bank",
    "storage",
    "update",
    "usb",
];

/// Crates that never wait, for whoever calls them does, or wait by a call.
const SYNCHRONOUS: &[&str] = &[
    "units",
    "events",
    "gcode",
    "program",
    "config",
    "motion",
    "tmc",
    "drivers",
    "card",
    "usb",
    "update",
    "storage",
    "thermal",
    "base",
    "parts",
    "jobs",
    "procedures",
    "preflight",
    "machine",
    "driver-bank",
    "sensor-bank",
    "bsp-prime",
    "boot",
    "firmware",
];
/// The look ahead at a file, which has to be able to stop in the middle of a line.
const FUTURES: &[&str] = &["preflight/src/"];

/// Packages whose types are each in few files, and the folder of `machine` whose functions alone may take the
/// whole of it.
const GATHERED: &[&str] = &["machine", "program"];
const EXECUTOR: (&str, &str) = ("machine", "executor/");

/// Runs every rule and reports all violations at once.
pub fn check(root: &Path) -> Result<()> {
    let manifests = package::workspace(root)?;
    let mut faults = Vec::new();
    for manifest in &manifests {
        faults.extend(dependency_faults(&manifest.name, &manifest.dependencies));
    }
    faults.extend(sources::faults(root, PURE)?);
    faults.extend(sources::waiting(root, SYNCHRONOUS, FUTURES)?);
    for package in package::all(root)? {
        let structure = Structure::read(&package);
        faults.extend(circles::faults(&package, &structure));
        faults.extend(spread_faults(&package, &structure));
    }
    if faults.is_empty() {
        println!("deps: {} crates keep the rules", manifests.len());
        return Ok(());
    }
    for fault in &faults {
        eprintln!("  {fault}");
    }
    bail!("{} broken rule(s)", faults.len())
}

fn spread_faults(package: &Package, structure: &Structure) -> Vec<String> {
    let name = package.name.as_str();
    let mut faults = Vec::new();
    if GATHERED.contains(&name) {
        faults.extend(structure.spread().map(|fault| format!("{name}: {fault}")));
    }
    if name == EXECUTOR.0 {
        let outside = structure.takers("Machine").iter().filter(|(file, _)| !file.starts_with(EXECUTOR.1));
        faults.extend(outside.map(|(file, function)| format!("{name}/src/{file}: {function} takes the whole Machine")));
    }
    faults
}

fn dependency_faults(package: &str, dependencies: &BTreeSet<String>) -> Vec<String> {
    let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| *name == package) else {
        return vec![format!("{package}: not in the architecture's table; add it there and to xtask/src/deps.rs")];
    };
    let ours: BTreeSet<&str> = MAY_USE.iter().map(|(name, _)| *name).collect();
    let mut faults = Vec::new();
    for dependency in dependencies {
        let name = dependency.as_str();
        if ours.contains(name) && !allowed.contains(&name) {
            faults.push(format!("{package}: may not use {name}"));
        }
        if HARDWARE.contains(&name) && !MAY_NAME_HARDWARE.contains(&package) {
            faults.push(format!("{package}: only the board's crates may name {name}"));
        }
        if TASKS.contains(&name) && !MAY_NAME_TASKS.contains(&package) {
            faults.push(format!("{package}: only the firmware may name {name}"));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(package: &str, dependency: &str) -> Vec<String> {
        dependency_faults(package, &BTreeSet::from([dependency.to_owned()]))
    }

    #[test]
    fn who_may_not_take_the_whole_machine_is_named() {
        let files = [
            ("lib.rs", "mod executor; mod b;"),
            ("executor/mod.rs", "pub struct Machine; fn f(machine: &mut Machine) {}"),
            ("b.rs", "use crate::executor::Machine; fn g(machine: &Machine) {}"),
        ];
        let found = |name: &str| {
            let package = Package::of(name, &files);
            spread_faults(&package, &Structure::read(&package))
        };
        assert_eq!(found("machine"), ["machine/src/b.rs: g takes the whole Machine"]);
        assert!(found("motion").is_empty());
    }

    #[test]
    fn a_type_in_too_many_files_is_named() {
        let body = "use crate::A; impl A { fn f(&self) {} }";
        let files = [("lib.rs", "pub struct A;"), ("a.rs", body), ("b.rs", body), ("c.rs", body), ("d.rs", body)];
        let package = Package::of("program", &files);
        let found = spread_faults(&package, &Structure::read(&package));
        assert_eq!(found, ["program: A has methods in 4 files: a.rs b.rs c.rs d.rs"]);
    }

    #[test]
    fn a_forbidden_dependency_is_named() {
        assert_eq!(faults("motion", "gcode"), ["motion: may not use gcode"]);
        assert_eq!(faults("machine", "tmc"), ["machine: may not use tmc"]);
        assert_eq!(faults("machine", "rtic"), ["machine: only the firmware may name rtic"]);
        assert_eq!(faults("drivers", "stm32h7"), ["drivers: only the board's crates may name stm32h7"]);
        assert_eq!(faults("surprise", "units").len(), 1);
    }

    #[test]
    fn an_allowed_dependency_passes() {
        assert!(faults("machine", "motion").is_empty());
        assert!(faults("firmware", "rtic").is_empty());
        assert!(faults("bsp-prime", "cortex-m").is_empty());
        assert!(faults("gcode", "heapless").is_empty());
    }
}
