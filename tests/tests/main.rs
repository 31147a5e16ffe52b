//! Scenarios that are about more than the machine: whole machines against simulated heaters, motors, beds and
//! chips, against recordings of Smoothieware v2, and against the tables of settings. A file or folder beside
//! this one is a topic. `cargo test -p scenarios TOPIC::` runs one.

mod addresses;
mod alignment;
mod bed_screws;
mod bring_up;
mod cam;
mod cool_step;
mod delta;
mod delta_calibration;
mod disagreements;
mod drivers;
mod endstop_phase;
mod every_setting;
mod filters;
mod heat_control;
mod heat_plants;
mod homing_overtravel;
mod homing_ways;
mod levelling;
mod mesh;
mod mesh_residuals;
mod outside_drivers;
mod power_cuts;
mod preflight;
mod probe_scripts;
mod probing;
mod samples;
mod sensors;
mod slicers;
mod spi_sensors;
mod stall_homing;
mod start_codes;
mod stuck_heater;
mod thermal_adjust;
mod tune_driver;
mod v2_codes;
mod v2_commands;
mod v2_motion;
mod v2_replay;
mod verified;
mod wire_drivers;

/// A file that no line above names would not be built, and its tests not run.
#[test]
fn every_topic_is_part_of_the_program() {
    assert_eq!(scenarios::topics::left_out(env!("CARGO_MANIFEST_DIR")), Vec::<std::path::PathBuf>::new());
}
