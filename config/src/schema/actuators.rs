//! `[actuator]`, `[tmc2590]`, `[tmc2660]`, `[current control]`.

use super::build::{ANY, POSITIVE, bool, integer, number, pin, registers, word};
use super::{ByName, CannotCreate, Docs, Form, Instances, PinRole, Section, Support, Words};
use super::{coil, driver_load, stall};
use crate::diagnostic::Severity;
use crate::machine::{DriverKind, MachineConfig};
use crate::pin::PinName;
use units::{Actuator, Amps, Micros, MmPerSecond, MmPerSecond2, Ohms};

const ACTUATOR_NAMES: &[&str] = &["alpha", "beta", "gamma", "delta", "epsilon", "zeta"];
const MASTERS: &Words = &Words(&["none", "alpha", "beta", "gamma"]);
const DRIVERS: &Words =
    &Words(&["tmc2590", "tmc2660", "external", "tmc2130", "tmc5160", "tmc2240", "tmc2208", "tmc2209", "tmc2226"]);

pub(super) fn actuator_place(name: &str) -> Result<usize, CannotCreate> {
    Actuator::from_name(name).map(|actuator| actuator as usize).ok_or(CannotCreate::UnknownName(ACTUATOR_NAMES))
}

pub(super) fn actuator_name(_: &MachineConfig, place: usize) -> &str {
    Actuator::from_index(place).map_or("", Actuator::name)
}

/// `|motor, value| ...` on the motor at the instance's place.
macro_rules! motor {
    (|$motor:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($motor) = c.actuators.0.get_mut(i) {
                $body;
            }
        }
    };
}

const fn driver(word: usize) -> DriverKind {
    match word {
        0 => DriverKind::Tmc2590,
        1 => DriverKind::Tmc2660,
        3 => DriverKind::Tmc2130,
        4 => DriverKind::Tmc5160,
        5 => DriverKind::Tmc2240,
        6 => DriverKind::Tmc2208,
        7 => DriverKind::Tmc2209,
        8 => DriverKind::Tmc2226,
        _ => DriverKind::External,
    }
}

pub const ACTUATOR: Section = Section {
    name: "actuator",
    store: None,
    docs: Docs::new("The motors: alpha, beta, gamma, delta, epsilon, zeta for X, Y, Z, A, B, C. A machine has those the file \
              names, without a gap. Extruders are delta and up."),
    form: Form::Named(Instances {
        noun: "motor",
        find: |c, name| {
            let place = actuator_place(name).ok()?;
            c.actuators.0.get(place)?.present.then_some(place)
        },
        create: |c, name| {
            let place = actuator_place(name)?;
            if let Some(motor) = c.actuators.0.get_mut(place) {
                motor.present = true;
            }
            Ok(place)
        },
        name: actuator_name,
        is_live: |c, i| c.actuators.0.get(i).is_some_and(|motor| motor.present),
    }),
    settings: &[
        number(
            "steps_per_mm",
            "80",
            &(1e-6, 1e6),
            motor!(|m, v| m.steps_per_mm = v),
            "Steps (with microsteps) per millimetre, or per degree of a rotary axis.",
        )
        .klipper("[stepper_<axis>] rotation_distance")
        .by_name(&ByName(&[("gamma", "2560")]))
        .unit("steps/mm")
        .typical(&(0.5, 20_000.0))
        .v1("<axis>_steps_per_mm"),
        number(
            "max_rate",
            "30000",
            POSITIVE,
            motor!(|m, v| m.max_rate = MmPerSecond::from_per_minute(v)),
            "Top speed of the motor. M203.1 changes it.",
        )
        .unit("mm/min")
        .typical(&(30.0, 1_000_000.0))
        .v1("<axis>_max_rate"),
        number(
            "acceleration",
            "-1",
            ANY,
            motor!(|m, v| m.acceleration = (v > 1e-4).then_some(MmPerSecond2(v))),
            "Acceleration limit of the motor; 0 or less: default_acceleration.",
        )
        .unit("mm/s^2")
        .typical(&(5.0, 100_000.0))
        .v1("<axis>_acceleration"),
        pin(
            "step_pin",
            "nc",
            PinRole::Output,
            motor!(|m, v| m.step_pin = v.and_then(PinName::digital)),
            "Step output.",
        )
        .klipper("[stepper_<axis>] step_pin")
        .by_name(&ByName(&[("alpha", "PD3"), ("beta", "PK2"), ("gamma", "PG3"), ("delta", "PC6")]))
        .v1("<axis>_step_pin"),
        pin(
            "dir_pin",
            "nc",
            PinRole::Output,
            motor!(|m, v| m.dir_pin = v.and_then(PinName::digital)),
            "Direction output: low while the motor counts up, high with !. Klipper's is the other way round: there high \
             counts up, so add the ! where it has none and take it away where it has one.",
        )
        .klipper("[stepper_<axis>] dir_pin")
        .by_name(&ByName(&[("alpha", "PD4"), ("beta", "PG2"), ("gamma", "PG4"), ("delta", "PG5")]))
        .v1("<axis>_dir_pin"),
        pin(
            "en_pin",
            "nc",
            PinRole::Output,
            motor!(|m, v| m.en_pin = v.and_then(PinName::digital)),
            "Enable output of a driver outside the board. On-board drivers are enabled over SPI.",
        )
        .klipper("[stepper_<axis>] enable_pin")
        .v1("<axis>_en_pin"),
        integer(
            "microsteps",
            "32",
            &(1, 256),
            motor!(|m, v| m.microsteps = v as u16),
            "Microsteps per full step of a driver that is not external: 1, 2, 4, 8, 16, 32, 64, 128 or 256. steps_per_mm must \
             fit. M909 changes it.",
        )
        .klipper("[stepper_<axis>] microsteps")
        .v1("motor_driver_control.<axis>.microsteps"),
        bool("reversed", "false", motor!(|m, v| m.reversed = v), "Turn the other way; the same as ! on dir_pin."),
        word(
            "driver",
            "tmc2590",
            DRIVERS,
            motor!(|m, v| m.driver = driver(v)),
            "What drives the motor. All but external also need their entry in the section of the same name.",
        )
        .by_name(&ByName(&[("epsilon", "external"), ("zeta", "external"), ("tmc2660 board", "tmc2660")]))
        .v1("motor_driver_control.<axis>.chip"),
        word(
            "slaved_to",
            "none",
            MASTERS,
            motor!(|m, v| m.slaved_to = v.checked_sub(1).and_then(Actuator::from_index)),
            "Makes delta, epsilon or zeta copy every step of alpha, beta or gamma. Such a motor is no axis of its own.",
        ),
        integer(
            "dir_setup_ns",
            "500",
            &(0, 100_000),
            motor!(|m, v| m.dir_setup_ns = v as u32),
            "Time from a change of direction to the next step. On-board drivers need 20 ns, optically isolated ones \
             some microseconds.",
        )
        .derived("5000 for external drivers, else 500")
        .unit("ns")
        .velvet(),
        coil::RESISTANCE,
        coil::INDUCTANCE,
        stall::ON_STALL,
        bool(
            "check_driver_errors",
            "true",
            |c, _, v| c.motors.check_driver_errors = v,
            "Once a second, ask the drivers for faults and report them; external ones cannot be asked.",
        )
        .common(),
        bool(
            "halt_on_driver_alarm",
            "false",
            |c, _, v| c.motors.halt_on_driver_alarm = v,
            "Halt when a driver shuts down or finds a short circuit. Needs check_driver_errors.",
        )
        .common()
        .v1("motor_driver_control.<axis>.alarm"),
        bool(
            "halt_on_stall",
            "true",
            |c, _, v| c.motors.halt_on_stall = v,
            "Halt when a motor with stall_watch stalls. Otherwise it is told, and the axis is not homed any more. on_stall \
             says more for a motor.",
        )
        .common()
        .velvet(),
        stall::RECOVERIES,
        stall::RECOVERY_TIME,
        stall::LIFT,
        pin(
            "motors_enable_pin",
            "PH13!",
            PinRole::Output,
            |c, _, v| c.motors.motors_enable_pin = v.and_then(PinName::digital),
            "Enables all on-board drivers; active except in a halt.",
        )
        .common(),
    ],
};

/// `|chip, value| ...` on the chip at the instance's place, in either section.
macro_rules! chip {
    ($family:ident, |$chip:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($chip) = c.$family.axes.0.get_mut(i) {
                $body;
            }
        }
    };
}

/// A section of drivers of a kind, each by its motor's name.
macro_rules! chips {
    ($family:ident, $kind:expr) => {
        Form::Named(Instances {
            noun: "driver",
            find: |c, name| {
                let place = actuator_place(name).ok()?;
                c.$family.axes.0.get(place)?.present.then_some(place)
            },
            create: |c, name| {
                let place = actuator_place(name)?;
                if let Some(chip) = c.$family.axes.0.get_mut(place) {
                    chip.present = true;
                }
                Ok(place)
            },
            name: actuator_name,
            is_live: |c, i| c.actuators.0.get(i).is_some_and(|motor| motor.present && motor.driver == $kind),
        })
    };
}

pub(super) use {chip, chips};

macro_rules! driver_section {
    ($section:literal, $family:ident, $kind:expr, $summary:literal, [$($row:expr),* $(,)?]) => {
        Section {
            name: $section,
            store: None,
            docs: Docs::new($summary),
            form: chips!($family, $kind),
            settings: &[
                integer(
                    "spi_channel",
                    "1",
                    &(0, 1),
                    |c, _, v| c.$family.spi_channel = v as u8,
                    "SPI bus of these drivers: 1 is SPI4, where the on-board ones are; 0 is SPI1 on header GE, for chips of this \
                     kind on a separate board.",
                )
                .common(),
                integer(
                    "standstill_time",
                    "10",
                    &(0, 86_400),
                    |c, _, v| c.$family.standstill_time = Micros::from_seconds(v.unsigned_abs()),
                    "Time without a step after which standstill_current applies.",
                )
                .common()
                .unit("s"),
                pin(
                    "spi_cs_pin",
                    "nc",
                    PinRole::Output,
                    chip!($family, |chip, v| chip.spi_cs_pin = v.and_then(PinName::digital)),
                    "Chip select; it is active low by itself, without !.",
                ).klipper("[tmc2660 <stepper>] cs_pin")
                .by_name(&ByName(&[("alpha", "PJ13"), ("beta", "PG8"), ("gamma", "PG7"), ("delta", "PG6")])),
                bool(
                    "step_interpolation",
                    "false",
                    chip!($family, |chip, v| chip.step_interpolation = v),
                    "The driver divides every step into 256 microsteps by itself: quieter, same resolution.",
                ).klipper("[tmc2660 <stepper>] interpolate"),
                integer(
                    "standstill_current",
                    "0",
                    &(0, 20_000),
                    chip!($family, |chip, v| chip.standstill_current = (v > 0).then_some(milliamps(v))),
                    "Lower current after standstill_time; 0 keeps the full current.",
                ).klipper("[tmc2660 <stepper>] idle_current_percent")
                .unit("mA").typical(&(50.0, 20_000.0)),
                registers(
                    "reg",
                    chip!($family, |chip, v| chip.registers = v),
                    "Raw register values, loaded before the settings above: driver control, chopper, coolStep, \
                     stallGuard and current, driver configuration. M911 prints such a line.",
                ),
                driver_load::$family::THRESHOLD,
                driver_load::$family::FILTER,
                driver_load::$family::WATCH,
                driver_load::$family::LEAST_SPEED,
                driver_load::$family::LOWER,
                driver_load::$family::UPPER,
                driver_load::$family::RISE,
                driver_load::$family::FALL,
                driver_load::$family::FLOOR,
                $($row),*
            ],
        }
    };
}

pub(super) fn milliamps(value: i64) -> Amps {
    Amps(value as f32 / 1_000.0)
}

fn milliohms(value: i64) -> Ohms {
    Ohms(value as f32 / 1_000.0)
}

pub const TMC2590: Section = driver_section!(
    "tmc2590",
    tmc2590,
    DriverKind::Tmc2590,
    "Motor drivers of the TMC2590 kind.",
    [
        bool(
            "passive_fast_decay",
            "true",
            chip!(tmc2590, |chip, v| chip.passive_fast_decay = v),
            "Passive fast decay of the coil current, which damps resonance at medium speed; a TMC2590 has it.",
        ),
        integer(
            "gate_drive",
            "3",
            &(0, 7),
            chip!(tmc2590, |chip, v| chip.gate_drive = Some(v as u8)),
            "How hard the MOSFETs' gates are driven: the slopes SLPH and SLPL, with SLP2 as their top bit. More is cooler \
             MOSFETs, and more ringing, radio noise and false short circuits.",
        )
        .klipper("[tmc2660 <stepper>] driver_SLPH, driver_SLPL")
        .derived("3, or what reg says")
        .velvet(),
        bool(
            "short_to_supply_detection",
            "true",
            chip!(tmc2590, |chip, v| chip.short_to_supply_detection = Some(v)),
            "Shuts the bridges when a motor's wire touches the motor supply, or a coil takes far too much current.",
        )
        .derived("true, or what reg says")
        .velvet(),
        integer(
            "sense_resistor",
            "50",
            &(1, 1_000),
            chip!(tmc2590, |chip, v| chip.sense_resistor = milliohms(v)),
            "The driver's sense resistor; the motor current scales with it.",
        )
        .klipper("[tmc2660 <stepper>] sense_resistor")
        .unit("mOhm")
        .typical(&(10.0, 500.0))
        .v1("motor_driver_control.<axis>.sense_resistor"),
        integer(
            "max_current",
            "5500",
            &(1, 20_000),
            chip!(tmc2590, |chip, v| chip.max_current = milliamps(v)),
            "Ceiling of any motor current; higher requests are cut.",
        )
        .derived("5500 with 50 mOhm, 4400 with 75 mOhm, else 3200")
        .unit("mA")
        .typical(&(100.0, 20_000.0))
        .v1("motor_driver_control.<axis>.max_current"),
        pin(
            "reset_pin",
            "nc",
            PinRole::Output,
            |c, _, v| c.tmc2590.reset_pin = v.and_then(PinName::digital),
            "Reset of a separate driver board, raised at boot before anything is said to its chips; with ! it is lowered. The \
             Prime has none.",
        )
        .common(),
    ]
);

pub const TMC2660: Section = driver_section!(
    "tmc2660",
    tmc2660,
    DriverKind::Tmc2660,
    "Motor drivers of the TMC2660 kind.",
    [
        bool(
            "passive_fast_decay",
            "true",
            chip!(tmc2660, |chip, v| chip.passive_fast_decay = v),
            "Passive fast decay of the coil current, which damps resonance at medium speed; a TMC2590 has it.",
        )
        .support(&Support::NotYet {
            severity: Severity::Warning,
            advice: "leave it out; a TMC2660 has no passive fast decay",
        }),
        integer(
            "gate_drive",
            "0",
            &(0, 3),
            chip!(tmc2660, |chip, v| chip.gate_drive = Some(v as u8)),
            "Slopes of the bridges, SLPH and SLPL: 0 the gentlest, 3 the steepest. More is a cooler chip, and more ringing, \
             radio noise and false short circuits.",
        )
        .klipper("[tmc2660 <stepper>] driver_SLPH, driver_SLPL")
        .derived("0, or what reg says")
        .velvet(),
        integer(
            "sense_resistor",
            "100",
            &(1, 1_000),
            chip!(tmc2660, |chip, v| chip.sense_resistor = milliohms(v)),
            "The driver's sense resistor; the motor current scales with it.",
        )
        .klipper("[tmc2660 <stepper>] sense_resistor")
        .unit("mOhm")
        .typical(&(10.0, 500.0)),
        integer(
            "max_current",
            "2800",
            &(1, 20_000),
            chip!(tmc2660, |chip, v| chip.max_current = milliamps(v)),
            "Ceiling of any motor current; higher requests are cut.",
        )
        .unit("mA")
        .typical(&(100.0, 20_000.0)),
    ]
);

pub const CURRENT_CONTROL: Section = Section {
    name: "current control",
    store: None,
    docs: Docs::new("Motor currents."),
    form: Form::Named(Instances {
        noun: "motor",
        find: |_, name| actuator_place(name).ok(),
        create: |_, name| actuator_place(name),
        name: actuator_name,
        is_live: |c, i| c.actuators.0.get(i).is_some_and(|motor| motor.present),
    }),
    settings: &[number(
        "current",
        "",
        &(0.0, 20.0),
        motor!(|m, v| m.current = (v > 0.0).then_some(Amps(v as f32))),
        "Peak coil current of a driver that is not external; 0 is the least it can give. A slave takes its master's. M906 and M907 change it.",
    )
    .klipper("[tmc2660 <stepper>] run_current")
    .required()
    .unit("A")
    .typical(&(0.05, 10.0))
    .v1("<axis>_current")],
};
