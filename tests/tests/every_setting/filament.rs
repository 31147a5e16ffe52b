//! Settings of the sections `[filament detector]`, `[filament width sensor]` and `[filament change]`.

use std::fmt::Write as _;

use units::Actuator::Delta;

use super::See::{Board, Boot, Edges, Look};
use super::{Bench, Row, row};

const INPUT: &[&str] = &["[filament detector] enable = true", "[filament detector] detector_pin = PB7^"];
const BULGE: &[&str] = &["[filament detector] enable = true", "[filament detector] bulge_pin = PB7^"];
const WHEEL: &[&str] = &["[filament detector] enable = true", "[filament detector] encoder_pin = PB7^"];
const WIDTH: &[&str] = &[
    "[filament width sensor] enable = true",
    "[filament width sensor] adc_pin = ADC1_4",
    // The sum of both readings may exceed the range of a single input.
    "[filament width sensor] second_adc_pin = ADC1_5",
    "[filament width sensor] measurement_delay = 8",
];
const VOLTS: &[&str] = &[
    "[filament width sensor] enable = true",
    "[filament width sensor] adc_pin = ADC1_4",
    "[filament width sensor] measurement_delay = 8",
    "[filament width sensor] mm_per_volt = 1",
];
const CHANGE: &[&str] = &["G91", "G1 X20 Y20 F6000", "M600", "resume"];
const LENGTHS: &[&str] = &["[filament change] unload_length = 4", "[filament change] load_length = 3"];

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
    row("[filament detector] suspends", "true", "false", Look(prints_without)).with(INPUT),
    row("[filament detector] runout_gcode", "", "M104 S70", Look(prints_without)).with(INPUT),
    row("[filament detector] insert_gcode", "", "M118 put in", Look(puts_in)).with(INPUT),
    row("[filament width sensor] enable", "true", "false", Look(fed)).with(WIDTH).built(),
    row("[filament width sensor] adc_pin", "ADC1_4", "ADC1_5", Look(fed)).with(WIDTH).built(),
    row("[filament width sensor] second_adc_pin", "ADC1_5", "ADC1_6", Look(fed)).with(WIDTH).built(),
    row("[filament width sensor] first_raw", "9500", "9000", Look(fed)).with(WIDTH).built(),
    row("[filament width sensor] first_diameter", "1.5", "1.6", Look(fed)).with(WIDTH).built(),
    row("[filament width sensor] second_raw", "10500", "10000", Look(fed)).with(WIDTH).built(),
    row("[filament width sensor] second_diameter", "2", "1.9", Look(fed)).with(WIDTH).built(),
    row("[filament width sensor] mm_per_volt", "1", "1.05", Look(fed)).with(VOLTS).built(),
    row("[filament width sensor] nominal_diameter", "1.75", "1.8", Look(fed)).with(VOLTS).built(),
    row("[filament width sensor] max_difference", "0.2", "0.01", Look(fed)).with(VOLTS).built(),
    row("[filament width sensor] measurement_delay", "8", "4", Look(fed)).with(VOLTS).built(),
    row("[filament width sensor] min_diameter", "1", "1.73", Look(fed)).with(VOLTS).built(),
    row("[filament width sensor] max_diameter", "0", "1.8", Look(fed)).with(VOLTS).built(),
    row("[filament width sensor] correct_flow", "true", "false", Look(fed)).with(VOLTS).built(),
    row("[filament width sensor] measured_at_once", "false", "true", Look(fed)).with(VOLTS).built(),
    row("[filament width sensor] tool_id", "0", "1", Boot).with(VOLTS),
    row("[filament width sensor] log", "false", "true", Look(fed)).with(VOLTS).built(),
    row("[filament change] retract", "0", "2", Edges(CHANGE)),
    row("[filament change] lift", "0", "3", Edges(CHANGE)),
    row("[filament change] park_x", "5", "10", Edges(&["G28", "G1 X20 Y20 F6000", "M600", "resume"])),
    row("[filament change] park_y", "5", "10", Edges(&["G28", "G1 X20 Y20 F6000", "M600", "resume"])),
    row("[filament change] park_feedrate", "100", "20", Edges(&["G28", "G1 X20 Y20 F6000", "M600", "resume"]))
        .with(&["[filament change] park_x = 5"]),
    row("[filament change] unload_length", "0", "4", Edges(CHANGE)),
    row("[filament change] unload_feedrate", "25", "5", Edges(CHANGE)).with(LENGTHS),
    row("[filament change] load_length", "0", "4", Edges(CHANGE)),
    row("[filament change] load_feedrate", "25", "5", Edges(CHANGE)).with(LENGTHS),
    row("[filament change] purge_length", "0", "4", Edges(CHANGE)),
    row("[filament change] purge_feedrate", "3", "1", Edges(&["M701 L1"]))
        .with(&["[filament change] purge_length = 2"]),
];

/// Prints without filament, or with a standing wheel; returns the messages and the heater's target.
fn prints_without(bench: &mut Bench) -> String {
    for line in ["M104 S60", "G91", "G1 X10 E5 F300", "G1 X-10 E5", "G1 X10 E5"] {
        bench.say(line);
    }
    let mut said = bench.hear(1.0);
    let at_ns = (bench.now_s() * 1e9) as u64;
    // Machines without a detector, or with a wheel alone, have no such input.
    let _ = bench.world(|world| world.press(at_ns, "filament", true));
    said += &bench.hear(12.0);
    said + &bench.say("M105")
}

/// Returns what is said as filament is taken out and put in.
fn puts_in(bench: &mut Bench) -> String {
    let mut said = String::new();
    for is_out in [true, false] {
        let at_ns = (bench.now_s() * 1e9) as u64;
        bench.world(|world| world.press(at_ns, "filament", is_out)).expect("an input of this machine");
        said += &bench.hear(1.0);
    }
    said
}

/// Returns the measurements, messages and feed of filament that is thinner, and then thicker.
fn fed(bench: &mut Bench) -> String {
    bench.world(|world| world.thread_filament(&[(0.0, 1.7), (20.0, 1.85)]));
    let mut said = bench.hear(1.0) + &bench.say("M407") + &bench.say("QUERY_RAW_FILAMENT_WIDTH");
    bench.say("M83");
    for line in ["G91", "G1 X10 E5 F1200", "G1 X-10 E5", "G1 X10 E5", "G1 X-10 E5", "M400"] {
        said += &bench.say(line);
        let _ = write!(said, "{:.2} ", bench.carriage(Delta));
    }
    said + &bench.hear(1.0)
}
