//! Klipper's commands for what this machine does not have, each with the reason and the nearest thing.

use super::row::{Becomes, ExtendedInfo};

const NO_ACCELEROMETER: &str = "no accelerometer can be connected; print a ringing tower, then M593";
const NO_CARRIAGE: &str = "there is one carriage on each axis";
const NO_EDDY: &str = "probes here are switches; see [zprobe]";
const NO_CHIP: &str = "no chip of this kind can be connected";

pub(super) const COMMANDS: &[ExtendedInfo] = &[
    refused("ACCELEROMETER_*", NO_ACCELEROMETER),
    refused("ANGLE_*", NO_CHIP),
    refused("BLTOUCH_*", "the probe's pin is a servo's: M280, and deploy_gcode of [zprobe]"),
    refused("LDC_CALIBRATE_DRIVE_CURRENT", NO_EDDY),
    refused("LOAD_CELL_*", NO_CHIP),
    refused("MANUAL_STEPPER", "a motor outside the kinematics is an axis A, B or C, and G1 moves it"),
    refused("MEASURE_AXES_NOISE", NO_ACCELEROMETER),
    refused("PALETTE_*", "a splicer of filament has no port here"),
    refused("PROBE_EDDY_CURRENT_CALIBRATE", NO_EDDY),
    refused("QUERY_ADC", "readings of inputs are in M105 and the console command thermistors"),
    refused("RESET_SMART_EFFECTOR", NO_CHIP),
    refused("RESTORE_DUAL_CARRIAGE_STATE", NO_CARRIAGE),
    refused("RUN_SHELL_COMMAND", "there is no computer at the board whose programs could run"),
    refused("SAVE_DUAL_CARRIAGE_STATE", NO_CARRIAGE),
    refused("SDCARD_LOOP_*", "parts of a file are repeated by O words: o1 repeat [3] and o1 endrepeat"),
    refused("SET_DIGIPOT", "currents are set by M906"),
    refused("SET_DISPLAY_GROUP", "displays have no groups of data here"),
    refused("SET_DUAL_CARRIAGE", NO_CARRIAGE),
    refused("SET_EXTRUDER_ROTATION_DISTANCE", "an extruder's steps of a mm are set by M92 E"),
    refused("SET_SMART_EFFECTOR", NO_CHIP),
    refused("SET_STEPPER_CARRIAGES", NO_CARRIAGE),
    refused(
        "SET_TEMPERATURE_FAN_TARGET",
        "a fan that follows a temperature is a [temperature switch]: its threshold_temp",
    ),
    refused("SET_TMC_FIELD", "things of a driver are set by M911.3, registers by M911.2"),
    refused("SHAPER_CALIBRATE", NO_ACCELEROMETER),
    refused("SYNC_EXTRUDER_MOTION", "each extruder follows its own tool"),
    refused("TEMPERATURE_PROBE_*", NO_EDDY),
    refused("TEST_RESONANCES", NO_ACCELEROMETER),
];

const fn refused(name: &'static str, reason: &'static str) -> ExtendedInfo {
    ExtendedInfo { name, takes: "", help: reason, becomes: Becomes::Refused }
}
