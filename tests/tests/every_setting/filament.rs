//! `[filament detector]` and `[filament change]`.

use super::See::{Board, Boot, Edges, Look};
use super::{Bench, Row, row};

const INPUT: &[&str] = &["[filament detector] enable = true", "[filament detector] detector_pin = PB7^"];
const BULGE: &[&str] = &["[filament detector] enable = true", "[filament detector] bulge_pin = PB7^"];
const WHEEL: &[&str] = &["[filament detector] enable = true", "[filament detector] encoder_pin = PB7^"];
const CHANGE: &[&str] = &["G91", "G1 X20 Y20 F6000", "M600", "resume"];
const LENGTHS: &[&str] = &["[filament change] unload_length = 4", "[filament change] load_length = 3"];
const LIFT: &[&str] = &["[filament change] lift = 3"];

pub const ROWS: &[Row] = &[
    row("[filament detector] enable", "true", "false", Look(prints_without)).with(INPUT),
    row("[filament detector] detector_pin", "PB7^", "PD3^", Boot).with(INPUT),
    row("[filament detector] detector_pin", "PB7^", "PD14^", Board("settings.rs")).with(INPUT),
    row("[filament detector] bulge_pin", "PB7^", "PD3^", Boot).with(BULGE),
    row("[filament detector] encoder_pin", "PB7^", "PD3^", Boot).with(WHEEL),
    row("[filament detector] encoder_pin", "PB7^", "PD12^", Board("settings.rs")).with(WHEEL),
    row("[filament detector] seconds_per_check", "2", "60", Look(prints_without)).with(WHEEL),
    row("[filament detector] pulses_per_mm", "1", "0.1", Look(prints_without)).with(WHEEL),
    row("[filament detector] leave_heaters_on", "false", "true", Look(prints_without)).with(INPUT),
    row("[filament change] retract", "0", "2", Edges(CHANGE)),
    row("[filament change] lift", "0", "3", Edges(CHANGE)),
    row("[filament change] park_x", "5", "10", Edges(&["G28", "G1 X20 Y20 F6000", "M600", "resume"])),
    row("[filament change] park_y", "5", "10", Edges(&["G28", "G1 X20 Y20 F6000", "M600", "resume"])),
    row("[filament change] park_feedrate", "100", "20", Edges(CHANGE)).with(LIFT),
    row("[filament change] unload_length", "0", "4", Edges(CHANGE)),
    row("[filament change] unload_feedrate", "25", "5", Edges(CHANGE)).with(LENGTHS),
    row("[filament change] load_length", "0", "4", Edges(CHANGE)),
    row("[filament change] load_feedrate", "25", "5", Edges(CHANGE)).with(LENGTHS),
    row("[filament change] purge_length", "0", "4", Edges(CHANGE)),
    row("[filament change] purge_feedrate", "3", "1", Edges(&["M701 L1"]))
        .with(&["[filament change] purge_length = 2"]),
];

/// A print that runs out of filament, or whose wheel stands; what is said, and how warm it is kept.
fn prints_without(bench: &mut Bench) -> String {
    for line in ["M104 S60", "G91", "G1 X10 E5 F300", "G1 X-10 E5", "G1 X10 E5"] {
        bench.say(line);
    }
    let mut said = bench.hear(1.0);
    let at_ns = (bench.now_s() * 1e9) as u64;
    // Without a detector, or with a wheel alone, there is none.
    let _ = bench.world(|world| world.press(at_ns, "filament", true));
    said += &bench.hear(12.0);
    said + &bench.say("M105")[..20]
}
