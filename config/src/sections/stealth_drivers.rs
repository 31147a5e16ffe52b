//! External drivers that Velvet configures: `[tmc2130]`, `[tmc5160]`, `[tmc2240]` over SPI, `[tmc2208]`,
//! `[tmc2209]`, `[tmc2226]` over a UART.

use super::drivers::{CoolStepConfig, DOWN, LEAST, UP, milliamps, milliohms};
use crate::pin::Pin;
use crate::setting::build::{NOT_NEGATIVE, bool, integer, number, pin, word};
use crate::setting::declare::settings;
use crate::setting::{PinRole, Words};
use units::{Amps, Micros, MmPerSecond, Ohms, PerActuator};

settings! {
    /// Settings that all drivers of one kind share, and those of each driver.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct StealthFamily {
        /// Time without a step after which standstill_current applies.
        standstill_time: Micros = integer("10", &(0, 86_400)).common().velvet().unit("s");
        /// The bus: SPI1, or 1 for SPI4, the on-board chips' own; on a UART USART3, or 1 for UART4.
        channel: u8;
        /// Settings of each driver, by motor.
        axes: PerActuator<StealthConfig>;
    }
}

settings! {
    /// The bus of drivers on SPI.
    rows SpiBus of StealthFamily {
        /// SPI bus of these drivers: 1 is SPI4 on header GA, which the on-board drivers use too; 0 is SPI1 on
        /// header GE.
        "spi_channel" channel = integer("1", &(0, 1)).common().velvet();
    }
}

settings! {
    /// The line of drivers on a UART.
    rows UartLine of StealthFamily {
        /// UART of these drivers: 0 is on header GD, TX on 4 and RX on 5; 1 is on header GB, TX on 4 and RX
        /// on 5. TX goes over 1 kOhm to PDN_UART, RX straight to it.
        "uart_channel" channel = integer("0", &(0, 1)).common().velvet();
    }
}

/// Settings of one external driver.
#[derive(Clone, Copy, Debug, Default)]
pub struct StealthConfig {
    /// Whether the file has an entry for the driver.
    pub present: bool,
    /// Chip select, active low.
    pub spi_cs_pin: Option<Pin>,
    /// Address on a UART, 0 to 3.
    pub uart_address: u8,
    /// Sense resistor, or the reference resistor of a TMC2240; none: not written.
    pub resistor: Option<Ohms>,
    /// Ceiling of any requested current.
    pub max_current: Amps,
    /// Whether steps are interpolated to 256 microsteps.
    pub step_interpolation: bool,
    /// Current when standing still; none: no reduction.
    pub standstill_current: Option<Amps>,
    /// stealthChop up to this speed; none: never.
    pub stealth_threshold: Option<MmPerSecond>,
    /// spreadCycle's off time, 1 to 15.
    pub off_time: u8,
    /// spreadCycle's blanking time in clocks: 16, 24, 36 or 54; 16, 24, 32 or 40 on a UART.
    pub blank_time: u8,
    /// spreadCycle's hysteresis at the start, 1 to 8.
    pub hysteresis_start: u8,
    /// spreadCycle's hysteresis at the end, -3 to 12.
    pub hysteresis_end: i8,
    /// Stall threshold: `SGT`, or `SGTHRS` of a TMC2209 and TMC2226.
    pub stall_threshold: i16,
    /// StallGuard filter, the bit `SFILT`.
    pub stall_filter: bool,
    /// Whether stalls are monitored while the motor moves.
    pub stall_watch: bool,
    /// Input that is wired to the driver's DIAG output.
    pub stall_pin: Option<Pin>,
    /// Least speed at which the measured load is meaningful.
    pub stall_least_speed: MmPerSecond,
    /// Settings of the load-dependent current.
    pub cool_step: CoolStepConfig,
}

/// Settings of the drivers of one kind: those of its bus and its resistor, those that all kinds have, and
/// those of its stall threshold.
macro_rules! kind_of_driver {
    (
        $rows:ident, $section:literal, $about:literal, {$($bus:tt)*}, $most:literal,
        ($usual:literal, $times:ident, $clocks:ident), {$($load:tt)*}
    ) => {
        settings! {
            #[doc = $about]
            rows $rows of StealthConfig {
                $($bus)*
                /// Ceiling of any motor current; higher requests are cut.
                "max_current" max_current = integer($most, &(1, 20_000))
                    .derived($most).velvet().unit("mA").typical(&(100.0, 20_000.0)) => milliamps;
                /// The driver divides every step into 256 microsteps by itself: quieter, same resolution.
                "step_interpolation" step_interpolation = bool("false")
                    .velvet().klipper(concat!("[", $section, " <stepper>] interpolate"));
                /// Lower current after standstill_time; 0 keeps the full current.
                "standstill_current" standstill_current = integer("0", &(0, 20_000))
                    .velvet().klipper(concat!("[", $section, " <stepper>] hold_current")).unit("mA")
                    .typical(&(50.0, 20_000.0)) => |v: i64| (v > 0).then_some(milliamps(v));
                /// Up to this speed of the motor the driver uses stealthChop, which is silent and weaker; 0:
                /// spreadCycle at any speed.
                "stealthchop_threshold" stealth_threshold = number("0", NOT_NEGATIVE)
                    .velvet().klipper(concat!("[", $section, " <stepper>] stealthchop_threshold")).unit("mm/s")
                    => |v: f64| (v > 0.0).then_some(MmPerSecond(v));
                /// spreadCycle's slow decay phase (TOFF).
                "off_time" off_time = integer("3", &(1, 15))
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_TOFF"));
                /// Clocks after a switching of the bridges in which the current is not measured (TBL).
                "blank_time" blank_time = word($usual, $times)
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_TBL"))
                    => |v: usize| $clocks.get(v).copied().unwrap_or($clocks[2]);
                /// spreadCycle's hysteresis to begin with, above its end (HSTRT + 1).
                "hysteresis_start" hysteresis_start = integer("5", &(1, 8))
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_HSTRT"));
                /// spreadCycle's hysteresis in the end (HEND - 3); start and end together are at most 15.
                "hysteresis_end" hysteresis_end = integer("-2", &(-3, 12))
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_HEND"));
                $($load)*
            }
        }
    };
}

/// Drivers on SPI.
macro_rules! spi_drivers {
    ($rows:ident, $section:literal, $about:literal, {$($resistor:tt)*}, $most:literal) => {
        kind_of_driver! {
            $rows, $section, $about,
            {
                /// Chip select; it is active low by itself, without !.
                "spi_cs_pin" spi_cs_pin = pin("nc", PinRole::Output)
                    .velvet().klipper(concat!("[", $section, " <stepper>] cs_pin"));
                $($resistor)*
            },
            $most, ("36", BLANK_TIMES, BLANK_CLOCKS),
            {
                /// Shifts what the driver measures of the load (SGT), which coolStep goes by: lower reads
                /// lower. Homing without a switch has a threshold of its own, in [endstops].
                "stall_threshold" stall_threshold = integer("0", &(-64, 63))
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_SGT"));
                /// Measures over four full steps rather than one (SFILT).
                "stall_filter" stall_filter = bool("false")
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_SFILT"));
            }
        }
    };
}

/// Drivers on a UART.
macro_rules! uart_drivers {
    ($rows:ident, $section:literal, $about:literal, {$($address:tt)*}, {$($load:tt)*}) => {
        kind_of_driver! {
            $rows, $section, $about,
            {
                $($address)*
                /// The sense resistor on the driver's own board; the motor current scales with it.
                "sense_resistor" resistor = integer("", &(1, 1_000))
                    .required().velvet().klipper(concat!("[", $section, " <stepper>] sense_resistor")).unit("mOhm")
                    .typical(&(10.0, 500.0)) => |v: i64| Some(milliohms(v));
            },
            "what the sense resistor can measure, at most 2800", ("32", WIRE_BLANK_TIMES, WIRE_BLANK_CLOCKS),
            {$($load)*}
        }
    };
}

/// Drivers with an address on a UART, which measure the load.
macro_rules! addressed_drivers {
    ($rows:ident, $section:literal, $about:literal) => {
        uart_drivers! {
            $rows, $section, $about,
            {
                /// The driver's address on its UART: 1 for MS1 high, and 2 for MS2 high.
                "uart_address" uart_address = integer("0", &(0, 3))
                    .velvet().klipper(concat!("[", $section, " <stepper>] uart_address"));
            },
            {
                /// Half of the reading up to which the driver's output DIAG says stall (SGTHRS): higher is
                /// more sensitive. Homing without a switch has a threshold of its own, in [endstops].
                "stall_threshold" stall_threshold = integer("0", &(0, 255))
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_SGTHRS"));
            }
        }
    };
}

/// Settings of drivers that measure the load of the motor.
macro_rules! measured_load {
    ($rows:ident, $section:literal) => {
        settings! {
            /// What follows from the load of the motor.
            rows $rows of StealthConfig {
                /// Watch for a stall of the motor while it moves: a carriage that has hit something. Only at
                /// a constant speed of stall_least_speed or more is it seen, and where the chopper drives
                /// whose load the chip measures. Set stall_threshold first, so that the motor never stalls by
                /// itself.
                "stall_watch" stall_watch = bool("false").velvet();
                /// The input that the driver's output DIAG is wired to, for stall_watch. A TMC2209 says stall
                /// with a high level; the chips on SPI with a low one: write !.
                "stall_pin" stall_pin = pin("nc", PinRole::Input)
                    .derived("the pin of the endstop by which its axis homes without a switch").velvet();
                /// Speed of the motor from which on its load says anything.
                "stall_least_speed" stall_least_speed = number("0", NOT_NEGATIVE)
                    .derived("200 full steps a second").unit("mm/s").velvet();
                /// Lets the driver lower the current by itself where the load is small, and raise it below
                /// this reading of the load (M911 says it; 32 SEMIN): a multiple of 32. 0 keeps the current
                /// as it is.
                "coolstep_lower" cool_step.lower = integer("0", &(0, 480))
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_SEMIN"));
                /// From this reading on the current falls (32 (SEMIN + SEMAX + 1)): a multiple of 32 above
                /// coolstep_lower.
                "coolstep_upper" cool_step.upper = integer("0", &(0, 992))
                    .derived("coolstep_lower + 64").velvet()
                    .klipper(concat!("[", $section, " <stepper>] driver_SEMAX"));
                /// 32nds of the current that a low reading adds (SEUP).
                "coolstep_up" cool_step.up = word("1", UP)
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_SEUP")) => |place: usize| place as u8;
                /// High readings that take one 32nd of the current away (SEDN): 32 is the slowest.
                "coolstep_down" cool_step.down = word("32", DOWN)
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_SEDN")) => |place: usize| place as u8;
                /// How far down the current goes (SEIMIN).
                "coolstep_least" cool_step.quarter = word("half", LEAST)
                    .velvet().klipper(concat!("[", $section, " <stepper>] driver_SEIMIN"));
            }
        }
    };
}

spi_drivers! {
    Tmc2130, "tmc2130",
    "Drivers outside the board with a TMC2130, on an SPI header. Steps come over step_pin and dir_pin.",
    {
        /// The sense resistor on the driver's own board; the motor current scales with it.
        "sense_resistor" resistor = integer("", &(1, 1_000))
            .required().velvet().klipper(concat!("[", "tmc2130", " <stepper>] sense_resistor")).unit("mOhm")
            .typical(&(10.0, 500.0)) => |v: i64| Some(milliohms(v));
    },
    "what the sense resistor can measure, at most 2500"
}

spi_drivers! {
    Tmc5160, "tmc5160",
    "Drivers outside the board with a TMC5160 or TMC2160, on an SPI header. Steps come over step_pin and dir_pin.",
    {
        /// The sense resistor on the driver's own board; the motor current scales with it.
        "sense_resistor" resistor = integer("", &(1, 1_000))
            .required().velvet().klipper(concat!("[", "tmc5160", " <stepper>] sense_resistor")).unit("mOhm")
            .typical(&(10.0, 500.0)) => |v: i64| Some(milliohms(v));
    },
    "what the sense resistor can measure"
}

spi_drivers! {
    Tmc2240, "tmc2240",
    "Drivers outside the board with a TMC2240, on an SPI header. Steps come over step_pin and dir_pin.",
    {
        /// The resistor at IREF on the driver's own board, mostly 12000; the motor current scales with it.
        "reference_resistor" resistor = integer("", &(1_000, 1_000_000))
            .required().velvet().klipper("[tmc2240 <stepper>] rref").unit("Ohm").typical(&(12_000.0, 60_000.0))
            => |v: i64| Some(Ohms(v as f32));
    },
    "what the reference resistor gives, at most 3000"
}

uart_drivers! {
    Tmc2208, "tmc2208",
    "Drivers outside the board with a TMC2208 (2202, 2220, 2224, 2225), on a UART of its own. Steps come over step_pin \
     and dir_pin.",
    {}, {}
}

addressed_drivers! {
    Tmc2209, "tmc2209",
    "Drivers outside the board with a TMC2209, up to four on one UART. Steps come over step_pin and dir_pin."
}

addressed_drivers! {
    Tmc2226, "tmc2226",
    "Drivers outside the board with a TMC2226, which is a TMC2209 in another case: up to four of both on one UART."
}

measured_load!(Tmc2130Load, "tmc2130");
measured_load!(Tmc5160Load, "tmc5160");
measured_load!(Tmc2240Load, "tmc2240");
measured_load!(Tmc2209Load, "tmc2209");
measured_load!(Tmc2226Load, "tmc2226");

/// Clocks of the blanking time, as words since there are no others.
const BLANK_TIMES: &Words = &Words(&["16", "24", "36", "54"]);
const BLANK_CLOCKS: [u8; 4] = [16, 24, 36, 54];
/// Blanking times of the chips on a UART, clocks.
const WIRE_BLANK_TIMES: &Words = &Words(&["16", "24", "32", "40"]);
const WIRE_BLANK_CLOCKS: [u8; 4] = [16, 24, 32, 40];
