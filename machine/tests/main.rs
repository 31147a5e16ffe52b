//! Scenarios of the machine, as one program: whole machines with their replies, positions and faults, on the
//! native runner. A file beside this one is a topic; a feature's scenarios stand in its folder.
//! `cargo test -p machine TOPIC::` runs one, `cargo test -p machine --test scenarios` all.

mod beside_a_job;
mod codes;
mod console;
mod curves;
mod cycles;
mod executor;
mod extruder_modes;
mod faults;
mod feed_rates;
mod going_back;
mod halt_walk;
mod hosts;
mod in_order;
mod inputs;
mod job_control;
mod jobs;
mod late_steps;
mod mills;
mod operation;
mod operator_texts;
mod out_of_service;
mod senders;
mod sessions;
mod settings;
mod soft_endstops;
mod spindle;
mod state_walk;
mod subroutines;
mod switches;
mod tapping;
mod tool_change;
mod tools;
mod transfers;
mod unknown_words;
mod usb_sessions;
mod web_sessions;

#[path = "../src/features/automatic_outputs/scenarios.rs"]
mod automatic_outputs;
#[path = "../src/features/axis_tests/scenarios.rs"]
mod axis_tests;
#[path = "../src/features/door/scenarios.rs"]
mod door;
#[path = "../src/features/editing/scenarios.rs"]
mod editing;
#[path = "../src/features/event_log/scenarios.rs"]
mod event_log;
#[path = "../src/features/filament/scenarios/mod.rs"]
mod filament;
#[path = "../src/features/grbl/scenarios/mod.rs"]
mod grbl;
#[path = "../src/features/laser/scenarios.rs"]
mod laser;
#[path = "../src/features/lights/scenarios.rs"]
mod lights;
#[path = "../src/features/macros/scenarios/mod.rs"]
mod macros;
#[path = "../src/features/network/scenarios.rs"]
mod network;
#[path = "../src/features/objects/scenarios/mod.rs"]
mod objects;
#[path = "../src/features/paper/scenarios.rs"]
mod paper;
#[path = "../src/features/periodic_reports/scenarios.rs"]
mod periodic_reports;
#[path = "../src/features/play_from/scenarios.rs"]
mod play_from;
#[path = "../src/features/power_loss/scenarios/mod.rs"]
mod power_loss;
#[path = "../src/features/stalls/scenarios/mod.rs"]
mod stalls;
#[path = "../src/features/statistics/scenarios.rs"]
mod statistics;
#[path = "../src/features/viewers/scenarios.rs"]
mod viewers;

/// A file that no line above names would not be built, and its tests not run.
#[test]
fn every_topic_is_part_of_the_program() {
    assert_eq!(scenarios::topics::left_out(env!("CARGO_MANIFEST_DIR")), Vec::<std::path::PathBuf>::new());
}
