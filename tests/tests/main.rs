//! Every scenario, as one program: a file or folder beside this one is a topic.
//! `cargo test -p scenarios TOPIC::` runs one.

mod addresses;
mod alignment;
mod bed_screws;
mod beside_a_job;
mod bring_up;
mod cam;
mod codes;
mod console;
mod cool_step;
mod curves;
mod cycles;
mod delta;
mod delta_calibration;
mod disagreements;
mod drivers;
mod endstop_phase;
mod events;
mod every_setting;
mod executor;
mod extruder_modes;
mod fans;
mod faults;
mod feed_rates;
mod filament;
mod filament_width;
mod filters;
mod going_back;
mod grbl;
mod halt_walk;
mod heat_control;
mod heat_plants;
mod homing_overtravel;
mod homing_ways;
mod hosts;
mod in_order;
mod inputs;
mod job_control;
mod jobs;
mod late_steps;
mod levelling;
mod lights;
mod mesh;
mod mesh_residuals;
mod mills;
mod objects;
mod objects_at_once;
mod operation;
mod operator_texts;
mod out_of_service;
mod outside_drivers;
mod paper;
mod power_cuts;
mod power_loss;
mod preflight;
mod probe_scripts;
mod probing;
mod recovery;
mod samples;
mod senders;
mod sensors;
mod sessions;
mod settings;
mod slicers;
mod soft_endstops;
mod spi_sensors;
mod spindle;
mod stall_homing;
mod stall_recovery;
mod stall_watch;
mod start_codes;
mod state_walk;
mod stuck_heater;
mod subroutines;
mod switches;
mod tapping;
mod thermal_adjust;
mod tool_change;
mod tools;
mod transfers;
mod tune_driver;
mod unknown_words;
mod usb_sessions;
mod v2_codes;
mod v2_commands;
mod v2_motion;
mod v2_replay;
mod verified;
mod wire_drivers;

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
    assert_eq!(named, topics, "tests/tests/main.rs is to name each topic, in order");
}
