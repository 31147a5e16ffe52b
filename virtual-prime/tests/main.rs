//! Every test of the virtual board, as one program: a file or folder beside this one is a topic. `cargo test
//! --release TOPIC::` runs one.

mod boot;
mod card;
mod card_faults;
mod card_service;
mod common;
mod controller;
mod conventions;
mod faults;
mod files;
mod firmware;
mod forecast;
mod golden;
mod hold;
mod homing;
mod images;
mod laser;
mod led_strips;
mod macros;
mod network;
mod operation;
mod other_stacks;
mod outside_drivers;
mod power_cuts;
mod probing;
mod rtt;
mod schedule;
mod settings;
mod spi_sensors;
mod stream;
mod updates;
mod usb;
mod v2_replay;

/// A file that no line above names would not be built, and its tests not run.
#[test]
fn every_topic_is_part_of_the_program() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    let mut topics: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "rs") || path.join("mod.rs").exists())
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|topic| topic != "main")
        .collect();
    topics.sort();
    let named: Vec<&str> =
        include_str!("main.rs").lines().filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';')).collect();
    assert_eq!(named, topics, "virtual-prime/tests/main.rs is to name each topic, in order");
}
