//! Settings of the section `[temperature control]`.

use super::See::{Board, Boot, Look, Say};
use super::{Bench, Row, row};
use sim::world::Fault;

const READ: &[&str] = &["get temp hotend"];
const BY_BETA: &[&str] = &["[temperature control] hotend.thermistor"];
const AMPLIFIER: &[&str] = &["[temperature control] hotend.sensor = ad849x"];
const DIFFERENCE: &[&str] = &["[temperature control] board.sensor = difference"];
const VOLTAGE: &[&str] = &["[temperature control] hotend.sensor = voltage"];
const BANG: &[&str] = &["[temperature control] hotend.bang_bang = true"];
const MODEL: &[&str] =
    &["[temperature control] hotend.model_capacity = 12", "[temperature control] hotend.model_late = 1.5"];
const BY_MODEL: &[&str] = &[
    "[temperature control] hotend.control = model",
    "[temperature control] hotend.model_capacity = 12",
    "[temperature control] hotend.model_loss = 0.1",
    "[temperature control] hotend.model_fan_loss = 0.02",
    "[temperature control] hotend.model_late = 1.5",
    "[temperature control] hotend.fan = fan",
];
const THERMOCOUPLE: &[&str] = &[
    "[temperature control] hotend.sensor = max31856",
    "[temperature control] hotend.spi_channel = 0",
    "[temperature control] hotend.spi_select_pin = PD10",
];
const AVERAGED: &[&str] = &[
    "[temperature control] hotend.sensor = max31855",
    "[temperature control] hotend.spi_channel = 0",
    "[temperature control] hotend.spi_select_pin = PD10",
];
const PLATINUM: &[&str] = &[
    "[temperature control] hotend.sensor = max31865",
    "[temperature control] hotend.spi_channel = 0",
    "[temperature control] hotend.spi_select_pin = PD10",
];
const ANY_FALL: &str = "[temperature control] hotend.max_fall = 0";
const ANY_ERROR: &str = "[temperature control] hotend.verify_max_error = 0";
const ANY_RANGE: &str = "[temperature control] hotend.runaway_range = 0";
/// A thermistor with a known beta besides its curve.
const TWICE: &[&str] = &["[temperature control] hotend.thermistor = EPCOS100K"];

pub const ROWS: &[Row] = &[
    row("[temperature control] board.enable", "true", "false", Say(&["M105"])),
    row("[temperature control] hotend.tool_id", "0", "5", Say(&["M104 S50 T5", "get temp hotend"])),
    row("[temperature control] hotend.designator", "T", "T7", Say(&["M105"])),
    row("[temperature control] hotend.thermistor_pin", "ADC1_1", "ADC1_3", Boot),
    row("[temperature control] hotend.thermistor_pin", "ADC1_1", "ADC1_2", Board("settings.rs")),
    row("[temperature control] hotend.thermistor", "Semitec-104NT4", "RRRF10K", Say(READ)).built(),
    row("[temperature control] hotend.sensor", "thermistor", "pt1000", Say(READ)).built(),
    row(
        "[temperature control] board.sensors",
        "hotend,bed",
        "bed,hotend",
        Say(&["M104 S40", "G4 P4000", "get temp board"]),
    )
    .with(DIFFERENCE),
    row("[temperature control] hotend.sensor_filter", "0", "3", Look(heated)),
    row("[temperature control] hotend.amplifier_offset", "0", "0.1", Say(READ)).with(AMPLIFIER).built(),
    row("[temperature control] hotend.voltage_curve", "0,0.5,100,1.5", "0,0.5,90,1.5", Say(READ)).with(VOLTAGE).built(),
    row("[temperature control] hotend.spi_channel", "0", "-1", Boot).with(AVERAGED),
    row("[temperature control] hotend.spi_channel", "0", "1", Board("spi_sensors.rs")).with(AVERAGED),
    row("[temperature control] hotend.spi_select_pin", "PD10", "nc", Boot).with(AVERAGED),
    row("[temperature control] hotend.spi_select_pin", "PD10", "PD12", Board("spi_sensors.rs")).with(AVERAGED),
    row("[temperature control] hotend.tc_type", "K", "J", Look(warm_chip)).with(THERMOCOUPLE).built(),
    row("[temperature control] hotend.tc_averaging", "4", "16", Look(warm_chip)).with(THERMOCOUPLE),
    row("[temperature control] hotend.tc_averaging", "1", "16", Look(heated)).with(AVERAGED),
    row("[temperature control] hotend.mains_frequency", "50", "60", Look(warm_chip)).with(THERMOCOUPLE),
    row("[temperature control] hotend.mains_frequency", "50", "60", Look(warm_chip)).with(PLATINUM),
    row("[temperature control] hotend.rtd_wires", "2", "3", Look(warm_chip)).with(PLATINUM),
    row("[temperature control] hotend.rtd_nominal", "100", "110", Look(warm_chip)).with(PLATINUM).built(),
    row("[temperature control] hotend.rtd_reference", "430", "400", Look(warm_chip)).with(PLATINUM).built(),
    row("[temperature control] hotend.use_beta_table", "false", "true", Say(READ)).with(TWICE).built(),
    row("[temperature control] hotend.beta", "4066", "3000", Say(READ)).with(BY_BETA).built(),
    row("[temperature control] hotend.r0", "100000", "50000", Say(READ)).with(BY_BETA).built(),
    row("[temperature control] hotend.t0", "25", "20", Say(READ)).with(BY_BETA).built(),
    row("[temperature control] hotend.r1", "0", "100000", Say(READ)).built(),
    row("[temperature control] hotend.r2", "4700", "10000", Say(READ)).built(),
    row("[temperature control] hotend.coefficients", "", "0.0007,0.0002,0.0000001", Say(READ)).built(),
    row("[temperature control] hotend.rt_curve", "", "25,90000,150,1300,240,200", Say(READ)).built(),
    row("[temperature control] hotend.heater_pin", "PE0", "nc", Look(heated)),
    row("[temperature control] hotend.heater_pin", "PE0", "PB8", Board("settings.rs")),
    row("[temperature control] hotend.max_pwm", "255", "100", Look(heated)),
    row("[temperature control] hotend.cycle_time", "0", "5", Look(warmed)),
    row("[temperature control] hotend.p_factor", "20", "5", Look(warmed)),
    row("[temperature control] hotend.i_factor", "1.2", "0.2", Look(warmed)),
    row("[temperature control] hotend.d_factor", "80", "400", Look(warmed)),
    row("[temperature control] hotend.d_filter", "0.5", "5", Look(warmed)),
    row("[temperature control] hotend.use_ponm", "false", "true", Look(warmed)),
    row("[temperature control] hotend.i_max", "255", "2", Look(warmed)),
    row("[temperature control] hotend.windup", "true", "false", Look(from_full_output)),
    row("[temperature control] hotend.control", "pid", "model", Look(warmed)).with(MODEL),
    row("[temperature control] hotend.heater_power", "40", "60", Look(warmed)).with(BY_MODEL),
    row("[temperature control] hotend.model_capacity", "12", "20", Look(warmed)).with(BY_MODEL),
    row("[temperature control] hotend.model_loss", "0.1", "1", Look(warmed)).with(BY_MODEL),
    row("[temperature control] hotend.model_late", "1.5", "4", Look(warmed)).with(BY_MODEL),
    row("[temperature control] hotend.model_fan_loss", "0.02", "0.5", Look(blown)).with(BY_MODEL),
    row("[temperature control] hotend.fan", "fan", "", Look(blown)).with(BY_MODEL),
    row("[temperature control] hotend.filament_heat", "0.0023", "0.05", Look(melts)).with(BY_MODEL),
    row("[temperature control] hotend.wait_window", "0", "10", Look(waited)),
    row("[temperature control] hotend.wait_dwell", "0", "5", Look(waited)),
    row("[temperature control] hotend.wait_timeout", "0", "1", Look(waited)),
    row("[temperature control] hotend.bang_bang", "false", "true", Look(warmed)),
    row("[temperature control] hotend.hysteresis", "1", "6", Look(warmed)).with(BANG),
    row("[temperature control] hotend.min_temp", "5", "60", Look(heated)),
    row("[temperature control] hotend.max_temp", "290", "50", Say(&["M104 S100", "get temp hotend"])),
    row("[temperature control] hotend.runaway_range", "20", "0", Look(blown_at)).with(&[ANY_FALL, ANY_ERROR]),
    row("[temperature control] hotend.verify_max_error", "120", "0", Look(blown_at)).with(&[ANY_FALL, ANY_RANGE]),
    row("[temperature control] hotend.verify_band", "5", "50", Look(blown_at)).with(&[ANY_FALL, ANY_RANGE]),
    row("[temperature control] hotend.verify_gain_time", "20", "2", Look(dead)),
    row("[temperature control] hotend.verify_gain", "2", "50", Look(heated))
        .with(&["[temperature control] hotend.verify_gain_time = 4"]),
    row("[temperature control] hotend.max_rise", "30", "1", Look(heated)),
    row("[temperature control] hotend.max_fall", "15", "0", Look(blown_at)),
    row("[temperature control] hotend.full_power_timeout", "0", "3", Look(heated)),
    row("[temperature control] hotend.hold_timeout", "0", "3", Look(heated)),
    row("[temperature control] hotend.runaway_heating_timeout", "240", "2", Look(heated)),
    row("[temperature control] hotend.runaway_cooling_timeout", "300", "1", Look(cooled)),
    row("[temperature control] hotend.runaway_error_range", "1", "200", Look(heated)).with(&[
        "[temperature control] hotend.runaway_heating_timeout = 2",
        "[temperature control] hotend.runaway_range = 500",
    ]),
    row("[temperature control] hotend.readings_per_second", "20", "2", Look(warmed)),
    row("[temperature control] hotend.set_m_code", "104", "154", Say(&["M154 S40", "get temp hotend"])),
    row("[temperature control] hotend.set_and_wait_m_code", "109", "159", Say(&["M159 S23", "get temp hotend"])),
    row("[temperature control] hotend.get_m_code", "105", "155", Say(&["M105"])),
    row("[temperature control] hotend.presets", "pla 45", "pla 50, abs 60", Say(&["preheat", "preheat pla", "M105"])),
    row("[temperature control] hotend.preset1", "0", "45", Say(&["M104 S1", "get temp hotend"])),
    row("[temperature control] hotend.preset2", "0", "45", Say(&["M104 S2", "get temp hotend"])),
];

/// Returns the temperatures of the hotend, and whether the machine has halted.
fn course(bench: &mut Bench, seconds: u32) -> String {
    let mut course = String::new();
    for _ in 0..seconds * 2 {
        course += &bench.hear(0.5);
        course += &format!("{:.3} C, {:.4}; ", bench.celsius("hotend"), bench.duty("hotend"));
    }
    course + &bench.status()
}

/// Returns the registers of the sensor's chip, and the reading at 200 C.
fn warm_chip(bench: &mut Bench) -> String {
    soak(bench, 200.0);
    bench.hear(1.0);
    let told = bench.world(|world| world.converter_registers(world.heater_index("hotend").expect("a hotend")).to_vec());
    format!("{:?} {}", &told[..2.min(told.len())], bench.say("get temp hotend"))
}

fn heated(bench: &mut Bench) -> String {
    bench.say("M104 S120") + &course(bench, 6)
}

/// Heats to a temperature that is soon reached.
fn warmed(bench: &mut Bench) -> String {
    bench.say("M104 S32") + &course(bench, 12)
}

/// Heats at full output, and lets the temperature settle.
fn from_full_output(bench: &mut Bench) -> String {
    bench.say("M104 S70") + &course(bench, 30)
}

/// Heats as [`warmed`] with the part's fan on.
fn blown(bench: &mut Bench) -> String {
    bench.say("M106 S255") + &warmed(bench)
}

/// Holds the target while filament flows.
fn melts(bench: &mut Bench) -> String {
    soak(bench, 100.0);
    bench.say("M104 S100");
    bench.say("M83");
    bench.say("G1 E30 F300") + &course(bench, 6)
}

/// Returns the duration of a wait.
fn waited(bench: &mut Bench) -> String {
    format!("{} {}", bench.say("M109 S32"), bench.now_s())
}

fn soak(bench: &mut Bench, celsius: f64) {
    bench.world(|world| {
        let hotend = world.heater_index("hotend").expect("a hotend");
        world.soak(hotend, celsius);
    });
}

/// Holds the target, then moves the temperature far from it.
fn blown_at(bench: &mut Bench) -> String {
    soak(bench, 100.0);
    let said = bench.say("M109 S98") + &course(bench, 2);
    soak(bench, 60.0);
    said + &course(bench, 8)
}

/// Switches the heater on while no heat comes.
fn dead(bench: &mut Bench) -> String {
    bench.world(|world| world.inject(&Fault::HeaterDead("hotend".into()))).expect("a heater of this machine");
    heated(bench)
}

/// Cools a hot heater that is slow to cool.
fn cooled(bench: &mut Bench) -> String {
    soak(bench, 63.0);
    bench.hear(0.5);
    bench.say("M104 S50") + &course(bench, 6)
}
