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
    // Klipper's macros: text to text; the machine is handed in as what can be looked up, and `gcode` reads
    // numbers.
    ("macros", &["gcode"]),
    ("program", &["units", "gcode"]),
    ("config", &["units", "gcode"]),
    // Power along the path, which motion looks at where it changes, never per step: small rather than fast.
    ("laser-power", &["units"]),
    ("motion", &["units", "laser-power"]),
    // A Klipper host's messages to pins and steps: pins, buses and the clock are handed in.
    ("klipper", &["units", "motion"]),
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
    // Klipper's configuration on the card, and what macros keep: it knows no machine, and renders nothing.
    ("printer-cfg", &["gcode", "base"]),
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
            "macros",
            "printer-cfg",
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
    // Ethernet frames to bytes of consoles: who reads these is handed in.
    ("net", &[]),
    // Bytes to requests, answers to bytes: sockets, files and the machine are handed in.
    ("http", &[]),
    // Requests to what the machine shows and does: sockets are handed in, the machine is a snapshot and a
    // console.
    ("site", &["base", "http", "program", "units"]),
    // The step interrupt plays `motion::queue`, the one structure solver and interrupt share; the card's host
    // controller is driven by `card::sd`, the Ethernet transceiver by `drivers`; the flash is what `update`
    // writes to.
    ("bsp-prime", &["units", "events", "motion", "drivers", "card", "update"]),
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
            "net",
            "site",
            "bsp-prime",
        ],
    ),
    // The second image, for a host that has the machine: it knows none.
    ("controller", &["units", "events", "klipper", "card", "update", "usb", "bsp-prime"]),
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
    ("fuzz", &["units", "gcode", "program", "config", "motion", "thermal", "base", "http", "klipper", "sim"]),
    ("fuzz-engine", &["fuzz"]),
    (
        "host",
        &[
            "units",
            "gcode",
            "macros",
            "program",
            "config",
            "motion",
            "sim",
            "base",
            "jobs",
            "printer-cfg",
            "procedures",
            "preflight",
            "update",
        ],
    ),
    ("xtask", &["update"]),
];

/// Crates from outside that only the board's crates may name.
const HARDWARE: &[&str] = &["stm32h7xx-hal", "stm32h7", "cortex-m", "cortex-m-rt", "cortex-m-semihosting"];
const MAY_NAME_HARDWARE: &[&str] = &["bsp-prime", "boot", "firmware", "controller", "on-target"];

/// The framework of the board's tasks. Everything below the images is called by it and never knows it.
const TASKS: &[&str] = &["rtic", "rtic-sync", "rtic-monotonics", "rtic-time"];
const MAY_NAME_TASKS: &[&str] = &["firmware", "controller"];

/// Crates that run on the board and on a desk alike: no standard library outside tests.
const PURE: &[&str] = &[
    "units",
    "events",
    "board-facts",
    "gcode",
    "macros",
    "program",
    "config",
    "laser-power",
    "motion",
    "klipper",
    "tmc",
    "drivers",
    "card",
    "thermal",
    "base",
    "parts",
    "jobs",
    "printer-cfg",
    "procedures",
    "preflight",
    "machine",
    "driver-bank",
    "sensor-bank",
    "storage",
    "update",
    "usb",
    "net",
    "http",
    "site",
];

/// Crates of the board itself. Neither they nor the pure crates wait but by a call: whoever calls them does.
const OF_THE_BOARD: &[&str] = &["bsp-prime", "boot", "firmware", "controller"];
/// The look ahead at a file, which has to be able to stop in the middle of a line.
const FUTURES: &[&str] = &["preflight/src/"];

/// Packages whose types are each in few files.
const GATHERED: &[&str] = &["machine", "program"];

/// Rooms of a package from the lowest to the highest: none names a file of a room above it.
const ROOMS: (&str, &[&str]) = ("machine", &["machine/", "features/", "executor/"]);
/// Room with a folder for each feature, and its files that the rooms of the core may name: the list of
/// features, the tables that lead codes and commands to them.
const FEATURES: (&str, &[&str]) = ("features/", &["features/mod.rs", "features/functions.rs", "features/commands.rs"]);
/// Field with the state of all features, which only features touch.
const STATE_OF_FEATURES: &str = ".features.";

/// Runs every rule and reports all violations at once.
pub fn check(root: &Path) -> Result<()> {
    let manifests = package::workspace(root)?;
    let mut faults = Vec::new();
    for manifest in &manifests {
        faults.extend(dependency_faults(&manifest.name, &manifest.dependencies));
    }
    faults.extend(sources::faults(root, PURE)?);
    faults.extend(sources::waiting(root, &[PURE, OF_THE_BOARD].concat(), FUTURES)?);
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
    if name == ROOMS.0 {
        faults.extend(room_faults(package, structure).into_iter().map(|fault| format!("{name}: {fault}")));
    }
    faults
}

/// Arrows from a room to one above it, and features that the core names.
fn room_faults(package: &Package, structure: &Structure) -> Vec<String> {
    let level = |file: &str| ROOMS.1.iter().position(|room| file.starts_with(room));
    let is_core = |file: &str| level(file).is_some() && !file.starts_with(FEATURES.0);
    let mut faults = Vec::new();
    for (from, to) in structure.arrows() {
        let is_upwards = matches!((level(from), level(to)), (Some(from), Some(to)) if from < to);
        let names_feature = is_core(from) && to.starts_with(FEATURES.0) && !FEATURES.1.contains(&to);
        if is_upwards {
            faults.push(format!("{from} names {to}, which stands above it"));
        } else if names_feature {
            faults.push(format!("{from} names a feature, {to}: have it act at a moment (machine/moments.rs)"));
        }
    }
    let touch = package.files.iter().filter(|file| is_core(&file.name) && file.text.contains(STATE_OF_FEATURES));
    faults.extend(touch.map(|file| format!("{} touches the state of a feature", file.name)));
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
            faults.push(format!("{package}: only the images may name {name}"));
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
    fn a_core_that_names_a_feature_or_a_room_above_it_is_named() {
        let files = [
            ("lib.rs", "mod machine; mod features; mod executor;"),
            ("machine/mod.rs", "use crate::features::Door; pub struct Machine;"),
            (
                "machine/halt.rs",
                "use super::Machine; fn halt(machine: &mut Machine) { machine.features.door.close(); }",
            ),
            ("features/mod.rs", "mod door; pub struct Door;"),
            ("features/door.rs", "use crate::machine::Machine; use crate::executor::Lines; pub struct Hinge;"),
            ("executor/mod.rs", "use crate::features::Door; use crate::features::door::Hinge; pub struct Lines;"),
        ];
        let found = |name: &str| {
            let package = Package::of(name, &files);
            spread_faults(&package, &Structure::read(&package))
        };
        assert_eq!(
            found("machine"),
            [
                "machine: executor/mod.rs names a feature, features/door.rs: have it act at a moment (machine/moments.rs)",
                "machine: features/door.rs names executor/mod.rs, which stands above it",
                "machine: machine/mod.rs names features/mod.rs, which stands above it",
                "machine: machine/halt.rs touches the state of a feature",
            ]
        );
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
        assert_eq!(faults("machine", "rtic"), ["machine: only the images may name rtic"]);
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
