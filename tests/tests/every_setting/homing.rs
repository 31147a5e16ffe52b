//! Settings of the sections `[endstops]` and `[soft endstop]`.

use super::See::{Board, Boot, Edges, Look, Say};
use super::{Bench, Row, row};
use scenarios::DELTA;

const SAMPLES: &[&str] = &["[endstops] common.homing_samples = 4"];
const PHASE: &[&str] = &["[endstops] minx.phase_check = true"];
const TIGHT_PHASE: &[&str] = &["[endstops] minx.phase_check = true", "[endstops] minx.phase_tolerance = 0.1"];
const STALL: &[&str] = &["[endstops] minx.pin", "[endstops] minx.slow_rate", "[endstops] minx.stall_homing = true"];
const HOME: &[&str] = &["G28"];
const ROTARY: &[&str] = &["[motion control] arm_solution = rotary_delta"];
const MORGAN: &[&str] = &["[motion control] arm_solution = morgan"];
const HOMED_DELTA: &[&str] = &["G28", "G1 X5 Y3 F6000"];

pub const ROWS: &[Row] = &[
    row("[endstops] minx.enable", "true", "false", Say(&["M119"])),
    row("[endstops] minx.pin", "PD0^", "PE1^", Boot),
    row("[endstops] minx.pin", "PD0^", "PJ9^", Board("settings.rs")),
    row("[endstops] minx.axis", "X", "C", Boot),
    row("[endstops] minx.homing_direction", "home_to_min", "none", Edges(HOME)),
    row("[endstops] minx.homing_position", "0", "7", Say(&["G28", "M114"])).built(),
    row("[endstops] minx.max_travel", "220", "1", Say(HOME)).built(),
    row("[endstops] minx.fast_rate", "50", "20", Edges(HOME)),
    row("[endstops] minx.slow_rate", "10", "4", Edges(HOME)),
    row("[endstops] minx.retract", "5", "2", Edges(HOME)),
    row("[endstops] minx.limit_enable", "false", "true", Look(run_into_the_limit))
        .with(&["[soft endstop] enable = false"]),
    row("[endstops] minx.phase_check", "false", "true", Say(&["G28 X", "M875"])),
    row("[endstops] minx.phase", "", "400", Say(&["G28 X", "M875"])).with(PHASE),
    row("[endstops] minx.phase_tolerance", "0.1", "0.2", Look(homes_after_a_slip)).with(PHASE),
    row("[endstops] minx.phase_align_zero", "false", "true", Say(&["M206 X0.07", "G28 X", "M114"])).with(PHASE),
    row("[endstops] minx.phase_fault", "warn", "halt", Look(homes_after_a_slip)).with(TIGHT_PHASE),
    row("[endstops] minx.stall_homing", "false", "true", Edges(&["G28 X"])).with(&["[endstops] minx.fast_rate = 51"]),
    row("[endstops] minx.stall_current", "", "0.9", Look(chip_that_homes)).with(STALL),
    row("[endstops] minx.stall_threshold", "0", "3", Look(chip_that_homes)).with(STALL),
    row("[endstops] common.debounce_ms", "0", "20", Edges(HOME)),
    row("[endstops] common.homing_order", "", "ZXY", Edges(HOME)),
    row("[endstops] common.home_z_first", "false", "true", Edges(HOME)),
    row("[endstops] common.corexy_homing", "false", "true", Edges(HOME)),
    row("[endstops] common.delta_homing", "true", "false", Edges(HOME)).on(DELTA),
    row("[endstops] common.rdelta_homing", "true", "false", Look(homes)).with(ROTARY),
    row("[endstops] common.scara_homing", "true", "false", Look(homes)).with(MORGAN),
    row("[endstops] common.move_to_origin_after_home", "false", "true", Edges(HOME))
        .with(&["[endstops] minx.homing_position = -7"]),
    row("[endstops] common.home_lift", "0", "5", Edges(HOME)),
    row("[endstops] common.safe_z_x", "", "40", Edges(HOME)),
    row("[endstops] common.safe_z_y", "", "40", Edges(HOME)),
    row("[endstops] common.homing_samples", "1", "2", Edges(HOME)),
    row("[endstops] common.homing_tolerance", "0.02", "5", Look(homes_a_loose_switch)).with(SAMPLES),
    row("[endstops] common.homing_retries", "0", "2", Look(homes_a_loose_switch)).with(SAMPLES),
    row("[endstops] common.home_gcode", "", "G91 G1 Z2 F600 G90 G28", Edges(HOME)),
    row("[endstops] common.home_z_gcode", "", "G0 Z7 F600", Edges(HOME)),
    row("[endstops] common.alpha_trim_mm", "0", "-0.5", Edges(HOMED_DELTA)).on(DELTA).built(),
    row("[endstops] common.beta_trim_mm", "0", "-0.5", Edges(HOMED_DELTA)).on(DELTA).built(),
    row("[endstops] common.gamma_trim_mm", "0", "-0.5", Edges(HOMED_DELTA)).on(DELTA).built(),
    row("[soft endstop] enable", "true", "false", Say(BEYOND)),
    row("[soft endstop] halt", "false", "true", Say(BEYOND)),
    row("[soft endstop] x_min", "", "-10", Say(&["G28", "G1 X-5 F6000"])),
    row("[soft endstop] x_max", "", "100", Say(&["G28", "G1 X110 F6000"])),
    row("[soft endstop] y_min", "", "-10", Say(&["G28", "G1 Y-5 F6000"])),
    row("[soft endstop] y_max", "", "100", Say(&["G28", "G1 Y110 F6000"])),
    row("[soft endstop] z_min", "", "-10", Say(&["G28", "G1 Z-1 F600"])),
    row("[soft endstop] z_max", "", "20", Say(&["G28", "G1 Z22 F600"])),
];

/// Lines that move X past its end at 220, and one more.
const BEYOND: &[&str] = &["G28", "G1 X225 F6000", "G1 X20"];

fn run_into_the_limit(bench: &mut Bench) -> String {
    bench.run(&["G28", "G1 X10 F3000", "M400", "G92 X50"]);
    bench.type_in("G1 X38 F3000\n");
    bench.hear(2.0) + &bench.status()
}

/// Homes after a pulley has slipped by 0.15 mm since the first homing.
fn homes_after_a_slip(bench: &mut Bench) -> String {
    bench.say("G28 X");
    let (at_ns, place) = ((bench.now_s() * 1e9) as u64, bench.carriage(units::Actuator::Alpha));
    bench.world(|world| world.place_carriage(at_ns, units::Actuator::Alpha, place + 0.15));
    bench.say("G28 X") + &bench.status()
}

/// Homes a carriage that slips a little all the time: approaches do not agree.
fn homes_a_loose_switch(bench: &mut Bench) -> String {
    bench.type_in("G28 X\n");
    let mut said = String::new();
    for _ in 0..300 {
        said += &bench.hear(0.05);
        let (at_ns, place) = ((bench.now_s() * 1e9) as u64, bench.carriage(units::Actuator::Alpha));
        bench.world(|world| world.place_carriage(at_ns, units::Actuator::Alpha, place + 0.004));
    }
    said
}

/// Homes, whether or not homing ends well on this machine.
fn homes(bench: &mut Bench) -> String {
    let said = bench.say("G28") + &bench.status();
    let tally = bench.world(|world| units::Actuator::ALL.map(|motor| *world.trace().tally(motor)));
    format!("{said}{tally:?}")
}

/// Returns the current and load measurement settings of alpha's chip during homing.
fn chip_that_homes(bench: &mut Bench) -> String {
    bench.type_in("G28 X\n");
    bench.hear(0.3);
    bench.world(|world| format!("{:x?}", world.driver(0).registers()))
}
