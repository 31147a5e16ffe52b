//! Drivers outside the board that are set up by us: `[tmc2130]`, `[tmc5160]`, `[tmc2240]` over SPI,
//! `[tmc2208]`, `[tmc2209]`, `[tmc2226]` over a UART.

use super::actuators::{actuator_name, actuator_place, chip, chips, milliamps};
use super::build::{NOT_NEGATIVE, bool, integer, number, pin, word};
use super::{Docs, Form, Instances, PinRole, Section, Setting, Words, outside_stall};
use crate::machine::DriverKind;
use crate::pin::PinName;
use units::{Micros, MmPerSecond, Ohms};

/// Clocks of the blanking time, as words since there are no others.
const BLANK_TIMES: &Words = &Words(&["16", "24", "36", "54"]);
const BLANK_CLOCKS: [u8; 4] = [16, 24, 36, 54];
/// Blanking times of the chips on a UART, clocks.
const WIRE_BLANK_TIMES: &Words = &Words(&["16", "24", "32", "40"]);
const WIRE_BLANK_CLOCKS: [u8; 4] = [16, 24, 32, 40];
const UP: &Words = &Words(&["1", "2", "4", "8"]);
const DOWN: &Words = &Words(&["32", "8", "2", "1"]);
const LEAST: &Words = &Words(&["half", "quarter"]);

macro_rules! stealth_section {
    (
        $name:ident, $section:literal, $family:ident, $kind:expr, $summary:literal, $channel:expr,
        [$($bus:expr),*], $resistor:expr, $most:literal,
        ($times:ident, $clocks:ident, $usual:literal), [$($load:expr),*]
    ) => {
        pub const $name: Section = Section {
            name: $section,
            store: None,
            docs: Docs::new($summary),
            form: chips!($family, $kind),
            settings: &[
                $channel,
                integer(
                    "standstill_time",
                    "10",
                    &(0, 86_400),
                    |c, _, v| c.$family.standstill_time = Micros::from_seconds(v.unsigned_abs()),
                    "Time without a step after which standstill_current applies.",
                )
                .common()
                .velvet()
                .unit("s"),
                $($bus,)*
                $resistor,
                integer(
                    "max_current",
                    $most,
                    &(1, 20_000),
                    chip!($family, |chip, v| chip.max_current = milliamps(v)),
                    "Ceiling of any motor current; higher requests are cut.",
                )
                .derived($most)
                .velvet()
                .unit("mA")
                .typical(&(100.0, 20_000.0)),
                bool(
                    "step_interpolation",
                    "false",
                    chip!($family, |chip, v| chip.step_interpolation = v),
                    "The driver divides every step into 256 microsteps by itself: quieter, same resolution.",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] interpolate")),
                integer(
                    "standstill_current",
                    "0",
                    &(0, 20_000),
                    chip!($family, |chip, v| chip.standstill_current = (v > 0).then_some(milliamps(v))),
                    "Lower current after standstill_time; 0 keeps the full current.",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] hold_current"))
                .unit("mA")
                .typical(&(50.0, 20_000.0)),
                number(
                    "stealthchop_threshold",
                    "0",
                    NOT_NEGATIVE,
                    chip!($family, |chip, v| chip.stealth_threshold = (v > 0.0).then_some(MmPerSecond(v))),
                    "Up to this speed of the motor the driver uses stealthChop, which is silent and weaker; 0: spreadCycle at \
                     any speed.",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] stealthchop_threshold"))
                .unit("mm/s"),
                integer(
                    "off_time",
                    "3",
                    &(1, 15),
                    chip!($family, |chip, v| chip.off_time = v as u8),
                    "spreadCycle's slow decay phase (TOFF).",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] driver_TOFF")),
                word(
                    "blank_time",
                    $usual,
                    $times,
                    chip!($family, |chip, v| chip.blank_time = $clocks.get(v).copied().unwrap_or($clocks[2])),
                    "Clocks after a switching of the bridges in which the current is not measured (TBL).",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] driver_TBL")),
                integer(
                    "hysteresis_start",
                    "5",
                    &(1, 8),
                    chip!($family, |chip, v| chip.hysteresis_start = v as u8),
                    "spreadCycle's hysteresis to begin with, above its end (HSTRT + 1).",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] driver_HSTRT")),
                integer(
                    "hysteresis_end",
                    "-2",
                    &(-3, 12),
                    chip!($family, |chip, v| chip.hysteresis_end = v as i8),
                    "spreadCycle's hysteresis in the end (HEND - 3); start and end together are at most 15.",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] driver_HEND")),
                $($load),*
            ],
        };
    };
}

/// The bus of drivers on SPI.
macro_rules! spi_channel {
    ($family:ident) => {{
        const ROW: Setting = integer(
            "spi_channel",
            "1",
            &(0, 1),
            |c, _, v| c.$family.channel = v as u8,
            "SPI bus of these drivers: 1 is SPI4 on header GA, which the on-board drivers use too; 0 is SPI1 on header GE.",
        )
        .common()
        .velvet();
        ROW
    }};
}

/// The line of drivers on a UART.
macro_rules! uart_channel {
    ($family:ident) => {{
        const ROW: Setting = integer(
            "uart_channel",
            "0",
            &(0, 1),
            |c, _, v| c.$family.channel = v as u8,
            "UART of these drivers: 0 is on header GD, TX on 4 and RX on 5; 1 is on header GB, TX on 4 and RX on 5. TX goes \
             over 1 kOhm to PDN_UART, RX straight to it.",
        )
        .common()
        .velvet();
        ROW
    }};
}

macro_rules! chip_select {
    ($section:literal, $family:ident) => {{
        const ROW: Setting = pin(
            "spi_cs_pin",
            "nc",
            PinRole::Output,
            chip!($family, |chip, v| chip.spi_cs_pin = v.and_then(PinName::digital)),
            "Chip select; it is active low by itself, without !.",
        )
        .velvet()
        .klipper(concat!("[", $section, " <stepper>] cs_pin"));
        ROW
    }};
}

macro_rules! uart_address {
    ($section:literal, $family:ident) => {{
        const ROW: Setting = integer(
            "uart_address",
            "0",
            &(0, 3),
            chip!($family, |chip, v| chip.uart_address = v as u8),
            "The driver's address on its UART: 1 for MS1 high, and 2 for MS2 high.",
        )
        .velvet()
        .klipper(concat!("[", $section, " <stepper>] uart_address"));
        ROW
    }};
}

/// Row for the threshold of stallGuard2.
macro_rules! stall_guard_2 {
    ($section:literal, $family:ident) => {{
        const ROW: Setting = integer(
                "stall_threshold",
                "0",
                &(-64, 63),
                chip!($family, |chip, v| chip.stall_threshold = v as i16),
                "Shifts what the driver measures of the load (SGT), which coolStep goes by: lower reads lower. Homing without a \
                 switch has a threshold of its own, in [endstops].",
            )
            .velvet()
            .klipper(concat!("[", $section, " <stepper>] driver_SGT"));
        ROW
    }};
}

/// Row for the filter of stallGuard2.
macro_rules! stall_filter {
    ($section:literal, $family:ident) => {{
        const ROW: Setting = bool(
            "stall_filter",
            "false",
            chip!($family, |chip, v| chip.stall_filter = v),
            "Measures over four full steps rather than one (SFILT).",
        )
        .velvet()
        .klipper(concat!("[", $section, " <stepper>] driver_SFILT"));
        ROW
    }};
}

/// coolStep, a module of rows.
macro_rules! cool_step {
    ($section:literal, $family:ident) => {
        mod $family {
            use super::*;

            pub const LOWER: Setting = integer(
                "coolstep_lower",
                "0",
                &(0, 480),
                chip!($family, |chip, v| chip.cool_step.lower = v as u16),
                "Lets the driver lower the current by itself where the load is small, and raise it below this reading of the \
                 load (M911 says it; 32 SEMIN): a multiple of 32. 0 keeps the current as it is.",
            )
            .velvet()
            .klipper(concat!("[", $section, " <stepper>] driver_SEMIN"));

            pub const UPPER: Setting = integer(
                "coolstep_upper",
                "0",
                &(0, 992),
                chip!($family, |chip, v| chip.cool_step.upper = Some(v as u16)),
                "From this reading on the current falls (32 (SEMIN + SEMAX + 1)): a multiple of 32 above coolstep_lower.",
            )
            .derived("coolstep_lower + 64")
            .velvet()
            .klipper(concat!("[", $section, " <stepper>] driver_SEMAX"));

            pub const RISE: Setting = word(
                "coolstep_up",
                "1",
                UP,
                chip!($family, |chip, v| chip.cool_step.up = v as u8),
                "32nds of the current that a low reading adds (SEUP).",
            )
            .velvet()
            .klipper(concat!("[", $section, " <stepper>] driver_SEUP"));

            pub const FALL: Setting = word(
                "coolstep_down",
                "32",
                DOWN,
                chip!($family, |chip, v| chip.cool_step.down = v as u8),
                "High readings that take one 32nd of the current away (SEDN): 32 is the slowest.",
            )
            .velvet()
            .klipper(concat!("[", $section, " <stepper>] driver_SEDN"));

            pub const FLOOR: Setting = word(
                "coolstep_least",
                "half",
                LEAST,
                chip!($family, |chip, v| chip.cool_step.quarter = v == 1),
                "How far down the current goes (SEIMIN).",
            )
            .velvet()
            .klipper(concat!("[", $section, " <stepper>] driver_SEIMIN"));
        }
    };
}

/// Row for the threshold of stallGuard4.
macro_rules! stall_guard_4 {
    ($section:literal, $family:ident) => {{
        const ROW: Setting = integer(
            "stall_threshold",
            "0",
            &(0, 255),
            chip!($family, |chip, v| chip.stall_threshold = v as i16),
            "Half of the reading up to which the driver's output DIAG says stall (SGTHRS): higher is more sensitive. Homing \
             without a switch has a threshold of its own, in [endstops].",
        )
        .velvet()
        .klipper(concat!("[", $section, " <stepper>] driver_SGTHRS"));
        ROW
    }};
}

/// A sense resistor. There is no default: outside the board nobody knows which it is.
macro_rules! sense_resistor {
    ($section:literal, $family:ident) => {{
        const ROW: Setting = integer(
            "sense_resistor",
            "",
            &(1, 1_000),
            chip!($family, |chip, v| chip.resistor = Some(Ohms(v as f32 / 1_000.0))),
            "The sense resistor on the driver's own board; the motor current scales with it.",
        )
        .required()
        .velvet()
        .klipper(concat!("[", $section, " <stepper>] sense_resistor"))
        .unit("mOhm")
        .typical(&(10.0, 500.0));
        ROW
    }};
}

cool_step!("tmc2130", tmc2130);
cool_step!("tmc5160", tmc5160);
cool_step!("tmc2240", tmc2240);
cool_step!("tmc2209", tmc2209);
cool_step!("tmc2226", tmc2226);

macro_rules! spi_section {
    ($name:ident, $section:literal, $family:ident, $kind:expr, $summary:literal, $resistor:expr, $most:literal) => {
        stealth_section!(
            $name,
            $section,
            $family,
            $kind,
            $summary,
            spi_channel!($family),
            [chip_select!($section, $family)],
            $resistor,
            $most,
            (BLANK_TIMES, BLANK_CLOCKS, "36"),
            [
                stall_guard_2!($section, $family),
                stall_filter!($section, $family),
                outside_stall::$family::WATCH,
                outside_stall::$family::OUTPUT,
                outside_stall::$family::LEAST_SPEED,
                $family::LOWER,
                $family::UPPER,
                $family::RISE,
                $family::FALL,
                $family::FLOOR
            ]
        );
    };
}

macro_rules! wire_section {
    (
        $name:ident, $section:literal, $family:ident, $kind:expr, $summary:literal,
        [$($address:expr),*], [$($load:expr),*]
    ) => {
        stealth_section!(
            $name,
            $section,
            $family,
            $kind,
            $summary,
            uart_channel!($family),
            [$($address),*],
            sense_resistor!($section, $family),
            "what the sense resistor can measure, at most 2800",
            (WIRE_BLANK_TIMES, WIRE_BLANK_CLOCKS, "32"),
            [$($load),*]
        );
    };
}

spi_section!(
    TMC2130,
    "tmc2130",
    tmc2130,
    DriverKind::Tmc2130,
    "Drivers outside the board with a TMC2130, on an SPI header. Steps come over step_pin and dir_pin.",
    sense_resistor!("tmc2130", tmc2130),
    "what the sense resistor can measure, at most 2500"
);

spi_section!(
    TMC5160,
    "tmc5160",
    tmc5160,
    DriverKind::Tmc5160,
    "Drivers outside the board with a TMC5160 or TMC2160, on an SPI header. Steps come over step_pin and dir_pin.",
    sense_resistor!("tmc5160", tmc5160),
    "what the sense resistor can measure"
);

spi_section!(
    TMC2240,
    "tmc2240",
    tmc2240,
    DriverKind::Tmc2240,
    "Drivers outside the board with a TMC2240, on an SPI header. Steps come over step_pin and dir_pin.",
    {
        const ROW: Setting = integer(
            "reference_resistor",
            "",
            &(1_000, 1_000_000),
            chip!(tmc2240, |chip, v| chip.resistor = Some(Ohms(v as f32))),
            "The resistor at IREF on the driver's own board, mostly 12000; the motor current scales with it.",
        )
        .required()
        .velvet()
        .klipper("[tmc2240 <stepper>] rref")
        .unit("Ohm")
        .typical(&(12_000.0, 60_000.0));
        ROW
    },
    "what the reference resistor gives, at most 3000"
);

wire_section!(
    TMC2208,
    "tmc2208",
    tmc2208,
    DriverKind::Tmc2208,
    "Drivers outside the board with a TMC2208 (2202, 2220, 2224, 2225), on a UART of its own. Steps come over step_pin and \
     dir_pin.",
    [],
    []
);

wire_section!(
    TMC2209,
    "tmc2209",
    tmc2209,
    DriverKind::Tmc2209,
    "Drivers outside the board with a TMC2209, up to four on one UART. Steps come over step_pin and dir_pin.",
    [uart_address!("tmc2209", tmc2209)],
    [
        stall_guard_4!("tmc2209", tmc2209),
        outside_stall::tmc2209::WATCH,
        outside_stall::tmc2209::OUTPUT,
        outside_stall::tmc2209::LEAST_SPEED,
        tmc2209::LOWER,
        tmc2209::UPPER,
        tmc2209::RISE,
        tmc2209::FALL,
        tmc2209::FLOOR
    ]
);

wire_section!(
    TMC2226,
    "tmc2226",
    tmc2226,
    DriverKind::Tmc2226,
    "Drivers outside the board with a TMC2226, which is a TMC2209 in another case: up to four of both on one UART.",
    [uart_address!("tmc2226", tmc2226)],
    [
        stall_guard_4!("tmc2226", tmc2226),
        outside_stall::tmc2226::WATCH,
        outside_stall::tmc2226::OUTPUT,
        outside_stall::tmc2226::LEAST_SPEED,
        tmc2226::LOWER,
        tmc2226::UPPER,
        tmc2226::RISE,
        tmc2226::FALL,
        tmc2226::FLOOR
    ]
);
