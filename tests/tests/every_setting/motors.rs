//! Settings of `[actuator]`, `[tmc2590]`, `[tmc2660]`, `[tmc2130]`, `[tmc5160]`, `[tmc2240]`, `[tmc2208]`,
//! `[tmc2209]`, `[tmc2226]` and `[current control]`.

use super::See::{Board, Boot, Edges, Look, Say};
use super::system::EXTERNAL;
use super::{Bench, Row, row};
use units::Actuator::{Alpha, Delta};

const LINE: &[&str] = &["G91", "G1 X20 F12000"];
/// Settings for a fourth motor that can be slaved to the third.
const SLAVE: &[&str] =
    &["[extruder] hotend.enable = false", "[actuator] delta.steps_per_mm = 400", "[actuator] delta.max_rate = 900"];
const RESTING: &[&str] = &["[tmc2590] alpha.standstill_current = 600", "[tmc2590] common.standstill_time = 2"];
/// Settings for drivers of the other kind.
const OTHER: &[&str] = &[
    "[actuator] alpha.driver = tmc2660",
    "[tmc2660] alpha.spi_cs_pin = PJ13",
    "[tmc2660] alpha.sense_resistor = 50",
    "[tmc2660] alpha.max_current = 3000",
    "[tmc2660] alpha.standstill_current = 600",
    "[tmc2660] common.standstill_time = 2",
];

const COOL: &[&str] = &["[tmc2590] alpha.coolstep_lower = 64"];
const OTHER_COOL: &[&str] =
    &["[actuator] alpha.driver = tmc2660", "[tmc2660] alpha.spi_cs_pin = PJ13", "[tmc2660] alpha.coolstep_lower = 64"];

const WATCH: &[&str] = &[
    "[tmc2590] alpha.stall_watch = true",
    "[tmc2590] alpha.stall_threshold = 2",
    "[tmc2590] alpha.stall_filter = false",
];
const RECOVER: &[&str] = &[
    "[tmc2590] alpha.stall_watch = true",
    "[tmc2590] alpha.stall_threshold = 2",
    "[tmc2590] alpha.stall_filter = false",
    "[actuator] alpha.on_stall = recover",
];
const OTHER_WATCH: &[&str] = &[
    "[actuator] alpha.driver = tmc2660",
    "[tmc2660] alpha.spi_cs_pin = PJ13",
    "[tmc2660] alpha.stall_watch = true",
    "[tmc2660] alpha.stall_threshold = 2",
    "[tmc2660] alpha.stall_filter = false",
];

pub const ROWS: &[Row] = &[
    row("[actuator] alpha.steps_per_mm", "80", "100", Edges(LINE)),
    row("[actuator] alpha.max_rate", "18000", "600", Edges(LINE)),
    row("[actuator] alpha.acceleration", "-1", "300", Edges(LINE)),
    row("[actuator] delta.step_pin", "PJ5", "PJ6", Board("settings.rs")),
    row("[actuator] delta.dir_pin", "PJ1", "PJ6", Board("settings.rs")),
    row("[actuator] delta.en_pin", "PJ3", "PJ6", Board("settings.rs")),
    row("[actuator] alpha.microsteps", "16", "32", Look(registers)),
    row("[actuator] alpha.reversed", "false", "true", Board("settings.rs")),
    row("[actuator] delta.driver", "external", "tmc2590", Say(&["M907 A0.5"])).with(EXTERNAL),
    row("[actuator] delta.slaved_to", "none", "gamma", Edges(&["G91", "G1 Z1 F300"])).with(SLAVE),
    row("[actuator] delta.dir_setup_ns", "500", "200000", Edges(&["G91", "G1 A5 F3000", "G1 A-5"])).with(EXTERNAL),
    row("[actuator] common.check_driver_errors", "true", "false", Look(overheated)),
    row("[actuator] common.halt_on_driver_alarm", "true", "false", Look(overheated)),
    row("[actuator] common.motors_enable_pin", "PH13!", "PH14!", Boot),
    row("[tmc2590] common.standstill_time", "2", "20", Look(resting)).with(RESTING),
    row("[tmc2590] common.reset_pin", "", "PJ9", Board("settings.rs")),
    row("[tmc2590] alpha.spi_cs_pin", "PJ13", "PJ12", Board("settings.rs")),
    row("[tmc2590] alpha.passive_fast_decay", "true", "false", Look(registers)),
    row("[tmc2590] alpha.gate_drive", "3", "5", Look(registers)),
    row("[tmc2590] alpha.short_to_supply_detection", "true", "false", Look(registers)),
    row("[tmc2590] alpha.reg", "", "0,901B4,A8202,C031F,E0010", Look(registers)),
    row("[tmc2590] alpha.step_interpolation", "true", "false", Look(registers)),
    row("[tmc2590] alpha.standstill_current", "0", "600", Look(resting)).with(RESTING),
    row("[tmc2590] alpha.sense_resistor", "50", "100", Look(registers)),
    row("[tmc2590] alpha.max_current", "3000", "1500", Say(&["M907 X2", "M907"])),
    row("[tmc2660] common.standstill_time", "2", "20", Look(resting)).with(OTHER),
    row("[tmc2660] alpha.spi_cs_pin", "PJ13", "PE1", Boot).with(OTHER),
    row("[tmc2660] alpha.gate_drive", "0", "2", Look(registers)).with(OTHER),
    row("[tmc2660] alpha.reg", "", "0,901B4,A8202,C031F,E0010", Look(registers)).with(OTHER),
    row("[tmc2660] alpha.step_interpolation", "true", "false", Look(registers)).with(OTHER),
    row("[tmc2660] alpha.standstill_current", "0", "600", Look(resting)).with(OTHER),
    row("[tmc2660] alpha.sense_resistor", "50", "100", Look(registers)).with(OTHER),
    row("[tmc2660] alpha.max_current", "3000", "1500", Say(&["M907 X2", "M907"])).with(OTHER),
    row("[tmc2590] alpha.stall_threshold", "", "-3", Look(registers)),
    row("[tmc2590] alpha.stall_filter", "true", "false", Look(registers)),
    row("[tmc2590] alpha.coolstep_lower", "0", "64", Look(registers)),
    row("[tmc2590] alpha.coolstep_upper", "128", "256", Look(registers)).with(COOL),
    row("[tmc2590] alpha.coolstep_up", "1", "4", Look(registers)).with(COOL),
    row("[tmc2590] alpha.coolstep_down", "32", "8", Look(registers)).with(COOL),
    row("[tmc2590] alpha.coolstep_least", "half", "quarter", Look(registers)).with(COOL),
    row("[tmc2660] alpha.stall_threshold", "", "-3", Look(registers)).with(OTHER),
    row("[tmc2660] alpha.stall_filter", "true", "false", Look(registers)).with(OTHER),
    row("[tmc2660] alpha.coolstep_lower", "0", "64", Look(registers)).with(OTHER),
    row("[tmc2660] alpha.coolstep_upper", "128", "256", Look(registers)).with(OTHER_COOL),
    row("[tmc2660] alpha.coolstep_up", "1", "4", Look(registers)).with(OTHER_COOL),
    row("[tmc2660] alpha.coolstep_down", "32", "8", Look(registers)).with(OTHER_COOL),
    row("[tmc2660] alpha.coolstep_least", "half", "quarter", Look(registers)).with(OTHER_COOL),
    row("[tmc2590] alpha.stall_watch", "false", "true", Look(crash)).with(WATCH),
    row("[tmc2590] alpha.stall_least_speed", "", "120", Look(crash)).with(WATCH),
    row("[tmc2660] alpha.stall_watch", "false", "true", Look(crash)).with(OTHER_WATCH),
    row("[tmc2660] alpha.stall_least_speed", "", "120", Look(crash)).with(OTHER_WATCH),
    row("[tmc2130] alpha.stall_watch", "false", "true", Look(crash)).with(WATCH_2130),
    row("[tmc2130] alpha.stall_pin", "PG0!", "PG1!", Board("outside_drivers.rs")).with(WATCH_2130),
    row("[tmc2130] alpha.stall_least_speed", "", "120", Look(crash)).with(WATCH_2130),
    row("[tmc5160] alpha.stall_watch", "false", "true", Look(crash)).with(WATCH_5160),
    row("[tmc5160] alpha.stall_pin", "PG0!", "PG1!", Board("outside_drivers.rs")).with(WATCH_5160),
    row("[tmc5160] alpha.stall_least_speed", "", "120", Look(crash)).with(WATCH_5160),
    row("[tmc2240] alpha.stall_watch", "false", "true", Look(crash)).with(WATCH_2240),
    row("[tmc2240] alpha.stall_pin", "PG0!", "PG1!", Board("outside_drivers.rs")).with(WATCH_2240),
    row("[tmc2240] alpha.stall_least_speed", "", "120", Look(crash)).with(WATCH_2240),
    row("[tmc2209] alpha.stall_watch", "false", "true", Look(crash)).with(WATCH_2209),
    row("[tmc2209] alpha.stall_pin", "PG0", "PG1", Board("outside_drivers.rs")).with(WATCH_2209),
    row("[tmc2209] alpha.stall_least_speed", "", "120", Look(crash)).with(WATCH_2209),
    row("[tmc2226] alpha.stall_watch", "false", "true", Look(crash)).with(WATCH_2226),
    row("[tmc2226] alpha.stall_pin", "PG0", "PG1", Board("outside_drivers.rs")).with(WATCH_2226),
    row("[tmc2226] alpha.stall_least_speed", "", "120", Look(crash)).with(WATCH_2226),
    row("[actuator] common.halt_on_stall", "true", "false", Look(crash)).with(WATCH),
    row("[tmc2590] common.spi_channel", "1", "0", Boot).with(&["[switch] fan.output_pin = PA5"]),
    row("[tmc2660] common.spi_channel", "1", "0", Boot).with(BUS_2660),
    row("[tmc2130] common.spi_channel", "1", "0", Boot).with(BUS_2130),
    row("[tmc2130] common.standstill_time", "2", "20", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.spi_cs_pin", "PJ9", "PE1", Boot).with(OUTSIDE_2130),
    row("[tmc2130] delta.sense_resistor", "110", "150", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.max_current", "2000", "500", Say(&["M907 A1", "M907"])).with(OUTSIDE_2130),
    row("[tmc2130] delta.step_interpolation", "true", "false", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.standstill_current", "0", "600", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.stealthchop_threshold", "0", "50", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.off_time", "3", "5", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.blank_time", "36", "24", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.hysteresis_start", "5", "3", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.hysteresis_end", "-2", "4", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc5160] common.spi_channel", "1", "0", Boot).with(BUS_5160),
    row("[tmc5160] common.standstill_time", "2", "20", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.spi_cs_pin", "PJ9", "PE1", Boot).with(OUTSIDE_5160),
    row("[tmc5160] delta.sense_resistor", "75", "100", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.max_current", "2000", "500", Say(&["M907 A1", "M907"])).with(OUTSIDE_5160),
    row("[tmc5160] delta.step_interpolation", "true", "false", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.standstill_current", "0", "600", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.stealthchop_threshold", "0", "50", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.off_time", "3", "5", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.blank_time", "36", "24", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.hysteresis_start", "5", "3", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.hysteresis_end", "-2", "4", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc2240] common.spi_channel", "1", "0", Boot).with(BUS_2240),
    row("[tmc2240] common.standstill_time", "2", "20", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.spi_cs_pin", "PJ9", "PE1", Boot).with(OUTSIDE_2240),
    row("[tmc2240] delta.reference_resistor", "12000", "24000", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.max_current", "2000", "500", Say(&["M907 A1", "M907"])).with(OUTSIDE_2240),
    row("[tmc2240] delta.step_interpolation", "true", "false", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.standstill_current", "0", "600", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.stealthchop_threshold", "0", "50", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.off_time", "3", "5", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.blank_time", "36", "24", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.hysteresis_start", "5", "3", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.hysteresis_end", "-2", "4", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2130] delta.stall_threshold", "0", "-5", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.stall_filter", "false", "true", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.coolstep_lower", "0", "64", Look(outside_registers)).with(OUTSIDE_2130),
    row("[tmc2130] delta.coolstep_upper", "128", "256", Look(outside_registers)).with(COOL_2130),
    row("[tmc2130] delta.coolstep_up", "1", "4", Look(outside_registers)).with(COOL_2130),
    row("[tmc2130] delta.coolstep_down", "32", "8", Look(outside_registers)).with(COOL_2130),
    row("[tmc2130] delta.coolstep_least", "half", "quarter", Look(outside_registers)).with(COOL_2130),
    row("[tmc5160] delta.stall_threshold", "0", "-5", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.stall_filter", "false", "true", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.coolstep_lower", "0", "64", Look(outside_registers)).with(OUTSIDE_5160),
    row("[tmc5160] delta.coolstep_upper", "128", "256", Look(outside_registers)).with(COOL_5160),
    row("[tmc5160] delta.coolstep_up", "1", "4", Look(outside_registers)).with(COOL_5160),
    row("[tmc5160] delta.coolstep_down", "32", "8", Look(outside_registers)).with(COOL_5160),
    row("[tmc5160] delta.coolstep_least", "half", "quarter", Look(outside_registers)).with(COOL_5160),
    row("[tmc2240] delta.stall_threshold", "0", "-5", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.stall_filter", "false", "true", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.coolstep_lower", "0", "64", Look(outside_registers)).with(OUTSIDE_2240),
    row("[tmc2240] delta.coolstep_upper", "128", "256", Look(outside_registers)).with(COOL_2240),
    row("[tmc2240] delta.coolstep_up", "1", "4", Look(outside_registers)).with(COOL_2240),
    row("[tmc2240] delta.coolstep_down", "32", "8", Look(outside_registers)).with(COOL_2240),
    row("[tmc2240] delta.coolstep_least", "half", "quarter", Look(outside_registers)).with(COOL_2240),
    row("[tmc2208] common.uart_channel", "0", "1", Boot).with(LINE_2208),
    row("[tmc2208] common.standstill_time", "2", "20", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2208] delta.sense_resistor", "110", "150", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2208] delta.max_current", "2000", "500", Say(&["M907 A1", "M907"])).with(OUTSIDE_2208),
    row("[tmc2208] delta.step_interpolation", "true", "false", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2208] delta.standstill_current", "0", "600", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2208] delta.stealthchop_threshold", "0", "50", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2208] delta.off_time", "3", "5", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2208] delta.blank_time", "32", "24", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2208] delta.hysteresis_start", "5", "3", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2208] delta.hysteresis_end", "-2", "4", Look(outside_registers)).with(OUTSIDE_2208),
    row("[tmc2209] common.uart_channel", "0", "1", Boot).with(LINE_2209),
    row("[tmc2209] common.standstill_time", "2", "20", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.sense_resistor", "110", "150", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.max_current", "2000", "500", Say(&["M907 A1", "M907"])).with(OUTSIDE_2209),
    row("[tmc2209] delta.step_interpolation", "true", "false", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.standstill_current", "0", "600", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.stealthchop_threshold", "0", "50", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.off_time", "3", "5", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.blank_time", "32", "24", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.hysteresis_start", "5", "3", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.hysteresis_end", "-2", "4", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.uart_address", "0", "2", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.stall_threshold", "0", "60", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.coolstep_lower", "0", "64", Look(outside_registers)).with(OUTSIDE_2209),
    row("[tmc2209] delta.coolstep_upper", "128", "256", Look(outside_registers)).with(COOL_2209),
    row("[tmc2209] delta.coolstep_up", "1", "4", Look(outside_registers)).with(COOL_2209),
    row("[tmc2209] delta.coolstep_down", "32", "8", Look(outside_registers)).with(COOL_2209),
    row("[tmc2209] delta.coolstep_least", "half", "quarter", Look(outside_registers)).with(COOL_2209),
    row("[tmc2226] common.uart_channel", "0", "1", Boot).with(LINE_2226),
    row("[tmc2226] common.standstill_time", "2", "20", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.sense_resistor", "110", "150", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.max_current", "2000", "500", Say(&["M907 A1", "M907"])).with(OUTSIDE_2226),
    row("[tmc2226] delta.step_interpolation", "true", "false", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.standstill_current", "0", "600", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.stealthchop_threshold", "0", "50", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.off_time", "3", "5", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.blank_time", "32", "24", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.hysteresis_start", "5", "3", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.hysteresis_end", "-2", "4", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.uart_address", "0", "2", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.stall_threshold", "0", "60", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.coolstep_lower", "0", "64", Look(outside_registers)).with(OUTSIDE_2226),
    row("[tmc2226] delta.coolstep_upper", "128", "256", Look(outside_registers)).with(COOL_2226),
    row("[tmc2226] delta.coolstep_up", "1", "4", Look(outside_registers)).with(COOL_2226),
    row("[tmc2226] delta.coolstep_down", "32", "8", Look(outside_registers)).with(COOL_2226),
    row("[tmc2226] delta.coolstep_least", "half", "quarter", Look(outside_registers)).with(COOL_2226),
    row("[actuator] alpha.coil_resistance", "1", "3", Say(&["tune_driver X chopper"])).with(COIL),
    row("[actuator] alpha.coil_inductance", "2", "4", Say(&["tune_driver X chopper"])).with(COIL),
    row("[actuator] alpha.on_stall", "halt", "tell", Look(crash)).with(WATCH),
    row("[actuator] common.stall_recoveries", "1", "2", Look(crash_in_a_job)).with(RECOVER),
    row("[actuator] common.stall_recovery_time", "600", "5", Look(crash_in_a_job)).with(RECOVER),
    row("[actuator] common.stall_lift", "5", "8", Look(crash_in_a_job)).with(RECOVER),
    row("[current control] alpha.current", "1.2", "0.6", Look(registers)),
];

/// A TMC2660 board, with a switch on a pin of the other bus.
const BUS_2660: &[&str] =
    &["[actuator] alpha.driver = tmc2660", "[tmc2660] alpha.spi_cs_pin = PJ13", "[switch] fan.output_pin = PA5"];
/// A motor whose data sheet is known.
const COIL: &[&str] = &["[actuator] alpha.coil_resistance = 1", "[actuator] alpha.coil_inductance = 2"];
/// Settings for the fourth motor on an external driver, over SPI.
macro_rules! outside {
    ($kind:literal, $resistor:literal $(, $more:expr)*) => {
        wired!($kind, $resistor, concat!("[", $kind, "] delta.spi_cs_pin = PJ9") $(, $more)*)
    };
}
/// Settings for the fourth motor on an external driver, over a UART.
macro_rules! wired {
    ($kind:literal, $resistor:literal $(, $more:expr)*) => {
        &[
            "[extruder] hotend.enable = false",
            "[uart console] enable = false",
            concat!("[actuator] delta.driver = ", $kind),
            "[actuator] delta.step_pin = PJ5",
            "[actuator] delta.dir_pin = PJ1",
            concat!("[", $kind, "] delta.", $resistor),
            concat!("[", $kind, "] delta.standstill_current = 600"),
            concat!("[", $kind, "] common.standstill_time = 2"),
            $($more),*
        ]
    };
}
/// Settings for alpha on such a driver, with its stalls monitored.
macro_rules! watched_outside {
    ($kind:literal $(, $own:literal)+) => {
        &[
            "[uart console] enable = false",
            "[tmc2590] alpha.spi_cs_pin",
            "[tmc2590] alpha.sense_resistor",
            "[tmc2590] alpha.max_current",
            "[tmc2590] alpha.step_interpolation",
            "[actuator] alpha.step_pin = PJ5",
            "[actuator] alpha.dir_pin = PJ1",
            concat!("[actuator] alpha.driver = ", $kind),
            concat!("[", $kind, "] alpha.stall_watch = true"),
            $(concat!("[", $kind, "] alpha.", $own)),+
        ]
    };
}
const WATCH_2130: &[&str] =
    watched_outside!("tmc2130", "sense_resistor = 110", "spi_cs_pin = PJ9", "stall_pin = PG0!", "stall_threshold = 2");
const WATCH_5160: &[&str] =
    watched_outside!("tmc5160", "sense_resistor = 75", "spi_cs_pin = PJ9", "stall_pin = PG0!", "stall_threshold = 2");
const WATCH_2240: &[&str] = watched_outside!(
    "tmc2240",
    "reference_resistor = 12000",
    "spi_cs_pin = PJ9",
    "stall_pin = PG0!",
    "stall_threshold = 2"
);
const WATCH_2209: &[&str] = watched_outside!(
    "tmc2209",
    "sense_resistor = 110",
    "stall_pin = PG0",
    "stealthchop_threshold = 300",
    "stall_threshold = 10"
);
const WATCH_2226: &[&str] = watched_outside!(
    "tmc2226",
    "sense_resistor = 110",
    "stall_pin = PG0",
    "stealthchop_threshold = 300",
    "stall_threshold = 10"
);
const OUTSIDE_2130: &[&str] = outside!("tmc2130", "sense_resistor = 110");
/// A TMC2130, with a switch on a pin of the other bus.
const BUS_2130: &[&str] = outside!("tmc2130", "sense_resistor = 110", "[switch] fan.output_pin = PA5");
const OUTSIDE_5160: &[&str] = outside!("tmc5160", "sense_resistor = 75");
/// A TMC5160, with a switch on a pin of the other bus.
const BUS_5160: &[&str] = outside!("tmc5160", "sense_resistor = 75", "[switch] fan.output_pin = PA5");
const OUTSIDE_2240: &[&str] = outside!("tmc2240", "reference_resistor = 12000");
/// A TMC2240, with a switch on a pin of the other bus.
const BUS_2240: &[&str] = outside!("tmc2240", "reference_resistor = 12000", "[switch] fan.output_pin = PA5");

const COOL_2130: &[&str] = outside!("tmc2130", "sense_resistor = 110", "[tmc2130] delta.coolstep_lower = 64");
const COOL_5160: &[&str] = outside!("tmc5160", "sense_resistor = 75", "[tmc5160] delta.coolstep_lower = 64");
const COOL_2240: &[&str] = outside!("tmc2240", "reference_resistor = 12000", "[tmc2240] delta.coolstep_lower = 64");
const OUTSIDE_2208: &[&str] = wired!("tmc2208", "sense_resistor = 110");
/// A TMC2208, with a switch on a pin of the other UART.
const LINE_2208: &[&str] = wired!("tmc2208", "sense_resistor = 110", "[switch] fan.output_pin = PB9");
const OUTSIDE_2209: &[&str] = wired!("tmc2209", "sense_resistor = 110");
/// A TMC2209, with a switch on a pin of the other UART.
const LINE_2209: &[&str] = wired!("tmc2209", "sense_resistor = 110", "[switch] fan.output_pin = PB9");
const COOL_2209: &[&str] = wired!("tmc2209", "sense_resistor = 110", "[tmc2209] delta.coolstep_lower = 64");
const OUTSIDE_2226: &[&str] = wired!("tmc2226", "sense_resistor = 110");
/// A TMC2226, with a switch on a pin of the other UART.
const LINE_2226: &[&str] = wired!("tmc2226", "sense_resistor = 110", "[switch] fan.output_pin = PB9");
const COOL_2226: &[&str] = wired!("tmc2226", "sense_resistor = 110", "[tmc2226] delta.coolstep_lower = 64");

/// Returns the registers of an external driver's chip while its motor rests: chopper, microsteps, current,
/// stealthChop, load measurement; and its address on a UART.
fn outside_registers(bench: &mut Bench) -> String {
    bench.run(&["G91", "G1 A1 F600", "M400"]);
    bench.hear(4.0);
    bench.world(|world| {
        let chip = world.outside_driver(Delta).expect("a driver outside");
        let registers = [0x00, 0x0A, 0x0B, 0x10, 0x13, 0x14, 0x40, 0x42, 0x6C, 0x6D];
        format!("{} {:x?}", chip.address(), registers.map(|address| chip.register(address)))
    })
}

/// Returns the registers of alpha's chip, as far as settings change them.
fn registers(bench: &mut Bench) -> String {
    bench.world(|world| {
        let chip = world.driver(Alpha as usize);
        let (scale, fine) = (chip.current_scale(), chip.high_sensitivity());
        // Hysteresis, decay and coolStep; passive fast decay and the low side's short detector; slopes.
        let [_, chopconf, smarten, sgcsconf, drvconf] = chip.registers();
        let load = sgcsconf >> 8;
        let (chopper, flags, slopes) = (chopconf & !0xF, drvconf & 3, drvconf >> 11 & 0x1F);
        let raw =
            format!("chopper {chopper:x}, coolStep {smarten:x}, load {load:x}, flags {flags:02b}, slopes {slopes:05b}");
        let (count, smooth) = (chip.microsteps(), chip.interpolates());
        format!("{count} microsteps, interpolated: {smooth}, scale {scale}, fine: {fine}, {raw}")
    })
}

fn resting(bench: &mut Bench) -> String {
    bench.run(&["G91", "G1 X1 F600", "M400"]);
    bench.hear(4.0);
    registers(bench)
}

fn overheated(bench: &mut Bench) -> String {
    bench.run(&["G91", "G1 X1 F600", "M400"]);
    let fault = sim::world::Fault::DriverTemperature(Alpha, 160);
    bench.world(|world| world.inject(&fault)).expect("a fault of this machine");
    bench.hear(4.0) + &bench.status()
}

/// Runs X into an obstacle at 100 mm/s.
fn crash(bench: &mut Bench) -> String {
    bench.world(|world| world.obstruct(Alpha, [-3.0, 80.0]));
    bench.say("G1 X120 F6000");
    bench.hear(2.0) + &bench.status()
}

/// Runs a job into an obstacle again and again; returns the messages and the rise of Z.
fn crash_in_a_job(bench: &mut Bench) -> String {
    bench.world(|world| world.obstruct(Alpha, [-3.0, 80.0]));
    bench.type_in("play /sd/crash.gcode\n");
    let (mut said, mut highest) = (String::new(), 0.0_f64);
    for _ in 0..400 {
        said += &bench.hear(0.1);
        if said.contains("the job stops") {
            highest = highest.max(bench.carriage(units::Actuator::Gamma));
        }
    }
    format!("{said} up to {highest:.1}")
}
