//! Motor drivers on the board: `[tmc2590]` and `[tmc2660]`.

use crate::diagnostic::Severity;
use crate::pin::Pin;
use crate::setting::build::{NOT_NEGATIVE, bool, integer, number, pin, registers, word};
use crate::setting::declare::settings;
use crate::setting::{ByName, PinRole, Support, Words};
use units::{Amps, Micros, MmPerSecond, Ohms, PerActuator};

settings! {
    /// Settings that all on-board drivers of one kind share, and those of each driver.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct DriverFamily {
        /// SPI bus of these drivers: 1 is SPI4, where the on-board ones are; 0 is SPI1 on header GE, for
        /// chips of this kind on a separate board.
        spi_channel: u8 = integer("1", &(0, 1)).common();
        /// Time without a step after which standstill_current applies.
        standstill_time: Micros = integer("10", &(0, 86_400)).common().unit("s");
        /// Reset line of an external driver board.
        reset_pin: Option<Pin>;
        /// Settings of each chip, by motor.
        axes: PerActuator<TmcConfig>;
    }
}

settings! {
    /// Settings of one on-board driver chip.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct TmcConfig {
        /// Whether the file has an entry for this chip, or the board is taken to have the chip.
        present: bool;
        /// Whether the file has no entry for this chip.
        is_assumed: bool;
        /// Chip select; it is active low by itself, without !.
        spi_cs_pin: Option<Pin> = pin("nc", PinRole::Output)
            .klipper("[tmc2660 <stepper>] cs_pin")
            .by_name(&ByName(&[("alpha", "PJ13"), ("beta", "PG8"), ("gamma", "PG7"), ("delta", "PG6")]));
        /// The driver divides every step into 256 microsteps by itself: quieter, same resolution.
        step_interpolation: bool = bool("false").klipper("[tmc2660 <stepper>] interpolate");
        /// Lower current after standstill_time; 0 keeps the full current.
        standstill_current: Option<Amps> = integer("0", &(0, 20_000))
            .klipper("[tmc2660 <stepper>] idle_current_percent").unit("mA").typical(&(50.0, 20_000.0))
            => |v: i64| (v > 0).then_some(milliamps(v));
        /// Raw register values, loaded before the settings above: driver control, chopper, coolStep,
        /// stallGuard and current, driver configuration. M911 prints such a line.
        "reg" registers: Option<[u32; 5]> = registers();
        /// Shifts what the driver measures of the load (SGT), which coolStep goes by: lower reads lower.
        /// Homing without a switch has a threshold of its own, in [endstops].
        stall_threshold: Option<i8> = integer("10", &(-64, 63))
            .klipper("[tmc2660 <stepper>] driver_SGT").derived("10, or what reg says").velvet();
        /// Measures over four full steps rather than one (SFILT).
        stall_filter: Option<bool> = bool("true")
            .klipper("[tmc2660 <stepper>] driver_SFILT").derived("true, or what reg says").velvet();
        /// Watch for a stall of the motor while it moves: a carriage that has hit something. Only at a
        /// constant speed of stall_least_speed or more is it seen. Set stall_threshold first, so that the
        /// motor never stalls by itself.
        stall_watch: bool = bool("false").velvet();
        /// Speed of the motor from which on its load says anything.
        stall_least_speed: MmPerSecond = number("0", NOT_NEGATIVE)
            .derived("200 full steps a second").unit("mm/s").velvet();
        /// Settings of the load-dependent current.
        cool_step: CoolStepConfig;
        /// Lets the driver lower the current by itself where the load is small, and raise it below this
        /// reading of the load (M911 says it; 32 SEMIN): a multiple of 32. 0 keeps the current as it is.
        "coolstep_lower" cool_step.lower = integer("0", &(0, 480))
            .klipper("[tmc2660 <stepper>] driver_SEMIN").derived("off, or what reg says").velvet();
        /// From this reading on the current falls (32 (SEMIN + SEMAX + 1)): a multiple of 32 above
        /// coolstep_lower.
        "coolstep_upper" cool_step.upper = integer("0", &(0, 992))
            .klipper("[tmc2660 <stepper>] driver_SEMAX").derived("coolstep_lower + 64").velvet();
        /// 32nds of the current that a low reading adds (SEUP).
        "coolstep_up" cool_step.up = word("1", UP).klipper("[tmc2660 <stepper>] driver_SEUP").velvet()
            => |place: usize| place as u8;
        /// High readings that take one 32nd of the current away (SEDN): 32 is the slowest.
        "coolstep_down" cool_step.down = word("32", DOWN).klipper("[tmc2660 <stepper>] driver_SEDN").velvet()
            => |place: usize| place as u8;
        /// How far down the current goes (SEIMIN).
        "coolstep_least" cool_step.quarter = word("half", LEAST).klipper("[tmc2660 <stepper>] driver_SEIMIN").velvet();
        /// Sense resistor of the driver.
        sense_resistor: Ohms;
        /// Ceiling of any requested current.
        max_current: Amps;
        /// Whether passive fast decay is used.
        passive_fast_decay: bool;
        /// Drive strength of the MOSFETs' gates, 0 the gentlest; none: as the raw registers say, or the
        /// driver's default.
        gate_drive: Option<u8>;
        /// Short-circuit detection on the bridges' low side; none: as the raw registers say, or on.
        short_to_supply_detection: Option<bool>;
    }
}

/// Settings of coolStep, by which the driver adapts the current to the measured load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoolStepConfig {
    /// StallGuard reading below which the current rises; 0: as the raw registers say, or off.
    pub lower: u16,
    /// StallGuard reading from which on the current falls; none: 64 above `lower`.
    pub upper: Option<u16>,
    /// `SEUP`: 0 to 3 for 1, 2, 4, 8 steps up at a time.
    pub up: u8,
    /// `SEDN`: 0 to 3 for 32, 8, 2, 1 readings for one step down.
    pub down: u8,
    /// Whether the current falls to a quarter at least rather than half.
    pub quarter: bool,
}

impl CoolStepConfig {
    /// Readings for one step of the thresholds.
    pub const STEP: u16 = 32;

    /// Returns the reading from which on the current falls.
    #[must_use]
    pub fn falls_from(&self) -> u16 {
        self.upper.unwrap_or(self.lower + 2 * Self::STEP)
    }
}

settings! {
    /// Motor drivers of the TMC2590 kind.
    rows Tmc2590 of TmcConfig {
        /// Passive fast decay of the coil current, which damps resonance at medium speed; a TMC2590 has it.
        "passive_fast_decay" passive_fast_decay = bool("true");
        /// How hard the MOSFETs' gates are driven: the slopes SLPH and SLPL, with SLP2 as their top bit. More
        /// is cooler MOSFETs, and more ringing, radio noise and false short circuits.
        "gate_drive" gate_drive = integer("3", &(0, 7))
            .klipper("[tmc2660 <stepper>] driver_SLPH, driver_SLPL").derived("3, or what reg says").velvet();
        /// Shuts the bridges when a motor's wire touches the motor supply, or a coil takes far too much
        /// current.
        "short_to_supply_detection" short_to_supply_detection = bool("true")
            .derived("true, or what reg says").velvet();
        /// The driver's sense resistor; the motor current scales with it.
        "sense_resistor" sense_resistor = integer("50", &(1, 1_000))
            .klipper("[tmc2660 <stepper>] sense_resistor").unit("mOhm").typical(&(10.0, 500.0))
            .v1("motor_driver_control.<axis>.sense_resistor") => milliohms;
        /// Ceiling of any motor current; higher requests are cut.
        "max_current" max_current = integer("5500", &(1, 20_000))
            .derived("5500 with 50 mOhm, 4400 with 75 mOhm, else 3200").unit("mA").typical(&(100.0, 20_000.0))
            .v1("motor_driver_control.<axis>.max_current") => milliamps;
    }
}

settings! {
    /// Settings of a board of drivers.
    rows Tmc2590Board of DriverFamily {
        /// Reset of a separate driver board, raised at boot before anything is said to its chips; with ! it
        /// is lowered. The Prime has none.
        "reset_pin" reset_pin = pin("nc", PinRole::Output).common();
    }
}

settings! {
    /// Motor drivers of the TMC2660 kind.
    rows Tmc2660 of TmcConfig {
        /// Passive fast decay of the coil current, which damps resonance at medium speed; a TMC2590 has it.
        "passive_fast_decay" passive_fast_decay = bool("true")
            .support(&Support::NotYet {
                severity: Severity::Warning,
                advice: "leave it out; a TMC2660 has no passive fast decay",
            });
        /// Slopes of the bridges, SLPH and SLPL: 0 the gentlest, 3 the steepest. More is a cooler chip, and
        /// more ringing, radio noise and false short circuits.
        "gate_drive" gate_drive = integer("0", &(0, 3))
            .klipper("[tmc2660 <stepper>] driver_SLPH, driver_SLPL").derived("0, or what reg says").velvet();
        /// The driver's sense resistor; the motor current scales with it.
        "sense_resistor" sense_resistor = integer("100", &(1, 1_000))
            .klipper("[tmc2660 <stepper>] sense_resistor").unit("mOhm").typical(&(10.0, 500.0)) => milliohms;
        /// Ceiling of any motor current; higher requests are cut.
        "max_current" max_current = integer("2800", &(1, 20_000)).unit("mA").typical(&(100.0, 20_000.0)) => milliamps;
    }
}

pub(super) const UP: &Words = &Words(&["1", "2", "4", "8"]);
pub(super) const DOWN: &Words = &Words(&["32", "8", "2", "1"]);
pub(super) const LEAST: &Words = &Words(&["half", "quarter"]);

pub(super) fn milliamps(value: i64) -> Amps {
    Amps(value as f32 / 1_000.0)
}

pub(super) fn milliohms(value: i64) -> Ohms {
    Ohms(value as f32 / 1_000.0)
}
