//! `[tmc2130]`, `[tmc5160]`, `[tmc2240]`: drivers outside the board that are set up over SPI.

use super::actuators::{actuator_name, actuator_place, chip, chips, milliamps};
use super::build::{NOT_NEGATIVE, bool, integer, number, pin, word};
use super::{Form, Instances, PinRole, Section, Setting};
use crate::machine::DriverKind;
use crate::pin::PinName;
use units::{Micros, MmPerSecond, Ohms};

/// Clocks of the blanking time, as words since there are no others.
const BLANK_TIMES: &[&str] = &["16", "24", "36", "54"];
const BLANK_CLOCKS: [u8; 4] = [16, 24, 36, 54];

macro_rules! stealth_section {
    ($name:ident, $section:literal, $family:ident, $kind:expr, $summary:literal, $resistor:expr, $most:literal) => {
        pub const $name: Section = Section {
            name: $section,
            summary: $summary,
            form: chips!($family, $kind),
            settings: &[
                integer(
                    "spi_channel",
                    "1",
                    (0, 1),
                    |c, _, v| c.$family.spi_channel = v as u8,
                    "SPI bus of these drivers: 1 is SPI4 on header GA, which the on-board drivers use too; 0 is SPI1 on header GE.",
                )
                .common()
                .velvet(),
                integer(
                    "standstill_time",
                    "10",
                    (0, 86_400),
                    |c, _, v| c.$family.standstill_time = Micros::from_seconds(v.unsigned_abs()),
                    "Time without a step after which standstill_current applies.",
                )
                .common()
                .velvet()
                .unit("s"),
                pin(
                    "spi_cs_pin",
                    "nc",
                    PinRole::Output,
                    chip!($family, |chip, v| chip.spi_cs_pin = v.and_then(PinName::digital)),
                    "Chip select; it is active low by itself, without !.",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] cs_pin")),
                $resistor,
                integer(
                    "max_current",
                    $most,
                    (1, 20_000),
                    chip!($family, |chip, v| chip.max_current = milliamps(v)),
                    "Ceiling of any motor current; higher requests are cut.",
                )
                .derived($most)
                .velvet()
                .unit("mA")
                .typical(100.0, 20_000.0),
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
                    (0, 20_000),
                    chip!($family, |chip, v| chip.standstill_current = (v > 0).then_some(milliamps(v))),
                    "Lower current after standstill_time; 0 keeps the full current.",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] hold_current"))
                .unit("mA")
                .typical(50.0, 20_000.0),
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
                    (1, 15),
                    chip!($family, |chip, v| chip.off_time = v as u8),
                    "spreadCycle's slow decay phase (TOFF).",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] driver_TOFF")),
                word(
                    "blank_time",
                    "36",
                    BLANK_TIMES,
                    chip!($family, |chip, v| chip.blank_time = BLANK_CLOCKS.get(v).copied().unwrap_or(36)),
                    "Clocks after a switching of the bridges in which the current is not measured (TBL).",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] driver_TBL")),
                integer(
                    "hysteresis_start",
                    "5",
                    (1, 8),
                    chip!($family, |chip, v| chip.hysteresis_start = v as u8),
                    "spreadCycle's hysteresis to begin with, above its end (HSTRT + 1).",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] driver_HSTRT")),
                integer(
                    "hysteresis_end",
                    "-2",
                    (-3, 12),
                    chip!($family, |chip, v| chip.hysteresis_end = v as i8),
                    "spreadCycle's hysteresis in the end (HEND - 3); start and end together are at most 15.",
                )
                .velvet()
                .klipper(concat!("[", $section, " <stepper>] driver_HEND")),
            ],
        };
    };
}

/// A sense resistor. There is no default: outside the board nobody knows which it is.
macro_rules! sense_resistor {
    ($section:literal, $family:ident) => {{
        const ROW: Setting = integer(
            "sense_resistor",
            "",
            (1, 1_000),
            chip!($family, |chip, v| chip.resistor = Some(Ohms(v as f32 / 1_000.0))),
            "The sense resistor on the driver's own board; the motor current scales with it.",
        )
        .required()
        .velvet()
        .klipper(concat!("[", $section, " <stepper>] sense_resistor"))
        .unit("mOhm")
        .typical(10.0, 500.0);
        ROW
    }};
}

stealth_section!(
    TMC2130,
    "tmc2130",
    tmc2130,
    DriverKind::Tmc2130,
    "Drivers outside the board with a TMC2130, on an SPI header. Steps come over step_pin and dir_pin.",
    sense_resistor!("tmc2130", tmc2130),
    "what the sense resistor can measure, at most 2500"
);

stealth_section!(
    TMC5160,
    "tmc5160",
    tmc5160,
    DriverKind::Tmc5160,
    "Drivers outside the board with a TMC5160 or TMC2160, on an SPI header. Steps come over step_pin and dir_pin.",
    sense_resistor!("tmc5160", tmc5160),
    "what the sense resistor can measure"
);

stealth_section!(
    TMC2240,
    "tmc2240",
    tmc2240,
    DriverKind::Tmc2240,
    "Drivers outside the board with a TMC2240, on an SPI header. Steps come over step_pin and dir_pin.",
    {
        const ROW: Setting = integer(
            "reference_resistor",
            "",
            (1_000, 1_000_000),
            chip!(tmc2240, |chip, v| chip.resistor = Some(Ohms(v as f32))),
            "The resistor at IREF on the driver's own board, mostly 12000; the motor current scales with it.",
        )
        .required()
        .velvet()
        .klipper("[tmc2240 <stepper>] rref")
        .unit("Ohm")
        .typical(12_000.0, 60_000.0);
        ROW
    },
    "what the reference resistor gives, at most 3000"
);
