//! Motor drivers: the Prime's own in place of those of the old board, or the same kind outside the board.

use std::f64::consts::SQRT_2;

use super::super::account::Verdict;
use super::super::migration::{Migration, text};
use super::motors::is_on_board;
use super::table::{Change, NUMBER, Rule, apply};

/// Current that no motor minds, A, until a person writes the right one.
const UNKNOWN_AMPS: &str = "0.5";
const OWN_WIRES: &str = "the board's drivers are wired to it";
const CHOPPER: &str = "the board's drivers chop otherwise, and tune_driver finds it out";
const NO_STEALTH: &str = "the board's drivers have no stealthChop";
const OTHER_LOAD: &str = "the board's drivers measure the load on another scale";

/// Converts a driver's section: `[tmc2209 stepper_x]`.
pub fn driver(m: &mut Migration<'_>, section: usize) {
    let label = m.section(section).label();
    let Some(motor) = m.motors.get(&label).copied() else {
        let why = format!("[{label}] has no motor on the Prime");
        return m.judge_rest(section, &Verdict::refused(why, "[actuator]"));
    };
    if is_on_board(motor) { on_board(m, section, motor) } else { outside(m, section, motor) }
}

/// Amps of a coil at their peak, from those that Klipper counts (their root mean square).
fn peak(amps: f64) -> f64 {
    // Fewer digits than that say nothing: the driver has 32 steps.
    (amps * SQRT_2 * 1000.0).round() / 1000.0
}

fn current(m: &mut Migration<'_>, section: usize, motor: &'static str, most: f64) -> Option<f64> {
    let amps = m.number(section, "run_current")?;
    let wanted = peak(amps);
    let given = wanted.min(most);
    if wanted > most {
        m.ask(format!("motor {motor}: {amps} A rms are {wanted} A at the peak; the driver gives {most}"));
    }
    let reason = "A rms to A at the peak";
    m.put_for(section, "run_current", ("current control", motor, "current"), text(given), reason);
    Some(given)
}

fn on_board(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let family = m.board.section;
    let given = current(m, section, motor, m.board.most_amps);
    let rest = m.number(section, "hold_current").map(peak);
    if let Some(rest) = rest {
        // As much as it runs with, or more, is the full current at rest.
        let lower = given.filter(|given| rest >= *given).map_or(rest, |_| 0.0);
        let amps = text((lower * 1000.0).round());
        m.put(section, "hold_current", (family, motor, "standstill_current"), amps);
    }
    if let (Some(percent), Some(given)) = (m.number(section, "idle_current_percent"), given) {
        let lower = if percent >= 100.0 { 0.0 } else { given * percent * 10.0 };
        m.put(section, "idle_current_percent", (family, motor, "standstill_current"), text(lower.round()));
    }
    if m.section(section).get("interpolate").is_none() {
        m.put(section, "interpolate", (family, motor, "step_interpolation"), "true");
    }
    if m.section(section).kind() == "tmc2660" {
        load(m, section, motor);
    }
    apply(m, section, motor, &[("interpolate", Rule::To(family, "step_interpolation", Change::Truth))]);
    apply(m, section, motor, ON_BOARD);
    wires(m, section);
    let names: Vec<&str> = m.section(section).options.iter().map(|option| option.name.as_str()).collect();
    for option in names.into_iter().filter(|name| name.starts_with("driver_")) {
        let is_load = ["driver_sg", "driver_se", "driver_sfilt"].iter().any(|start| option.starts_with(start));
        let (why, nearest) = match is_load {
            true => (OTHER_LOAD, "[endstops] stall_threshold, coolstep_lower"),
            false => (CHOPPER, "tune_driver (docs/drivers.md), reg of the driver's section"),
        };
        m.refuse(section, option, why, nearest);
    }
}

/// Converts what a TMC2660 does by the load of its motor: the board's driver measures it in the same way.
fn load(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let family = m.board.section;
    apply(
        m,
        section,
        motor,
        &[
            ("driver_sgt", Rule::To(family, "stall_threshold", NUMBER)),
            ("driver_sfilt", Rule::To(family, "stall_filter", Change::Truth)),
        ],
    );
    let fields = ["driver_semin", "driver_semax", "driver_seup", "driver_sedn", "driver_seimin"];
    let [least, most, up, down, floor] = fields.map(|option| m.number(section, option));
    let Some(least) = least.filter(|least| *least > 0.0) else {
        for option in fields {
            m.merged(section, option, "coolStep is off", "");
        }
        return;
    };
    m.put(section, "driver_semin", (family, motor, "coolstep_lower"), text(32.0 * least));
    if let Some(most) = most {
        m.put(section, "driver_semax", (family, motor, "coolstep_upper"), text(32.0 * (least + most + 1.0)));
    }
    let word = |field: Option<f64>, words: [&'static str; 4]| Some(*words.get(field? as usize)?);
    if let Some(value) = word(up, ["1", "2", "4", "8"]) {
        m.put(section, "driver_seup", (family, motor, "coolstep_up"), value);
    }
    if let Some(value) = word(down, ["32", "8", "2", "1"]) {
        m.put(section, "driver_sedn", (family, motor, "coolstep_down"), value);
    }
    if let Some(floor) = floor {
        let value = if floor > 0.0 { "quarter" } else { "half" };
        m.put(section, "driver_seimin", (family, motor, "coolstep_least"), value);
    }
}

const ON_BOARD: &[(&str, Rule)] = &[
    ("sense_resistor", Rule::Needless("the board's own resistors count")),
    ("rref", Rule::Needless("the board's own resistors count")),
    ("diag_pin", Rule::Needless("the stall outputs of the board's drivers are wired")),
    ("diag0_pin", Rule::Needless("the stall outputs of the board's drivers are wired")),
    ("diag1_pin", Rule::Needless("the stall outputs of the board's drivers are wired")),
    ("stealthchop_threshold", Rule::Only("0", NO_STEALTH, "step_interpolation of the driver makes it quieter")),
    ("coolstep_threshold", Rule::Refused("coolStep has no speed from which on it acts", "coolstep_lower")),
    ("high_velocity_threshold", Rule::Refused("the driver has no other mode at high speed", "nothing")),
    ("microsteps", Rule::Needless("Klipper reads it in the section of the motor")),
];

/// Gives verdicts on how the old board speaks to its drivers.
fn wires(m: &mut Migration<'_>, section: usize) {
    for option in ["uart_pin", "tx_pin", "select_pins", "uart_address", "cs_pin", "chain_position", "chain_length"] {
        m.needless(section, option, OWN_WIRES);
    }
    let names: Vec<&str> = m.section(section).options.iter().map(|option| option.name.as_str()).collect();
    for option in names.into_iter().filter(|name| name.starts_with("spi_")) {
        m.needless(section, option, OWN_WIRES);
    }
}

/// Keys of the drivers outside the board that are named as Klipper's options are.
const OUTSIDE: &[(&str, &str, Change)] = &[
    ("interpolate", "step_interpolation", Change::Truth),
    ("stealthchop_threshold", "stealthchop_threshold", NUMBER),
    ("sense_resistor", "sense_resistor", Change::Whole(1000.0)),
    ("rref", "reference_resistor", Change::Whole(1.0)),
    ("driver_toff", "off_time", NUMBER),
    ("driver_sgt", "stall_threshold", NUMBER),
    ("driver_sgthrs", "stall_threshold", NUMBER),
    ("driver_sfilt", "stall_filter", Change::Truth),
];

/// Converts the driver of a motor that has none on the board: the same kind is to be outside it.
fn outside(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let kind = match m.section(section).kind() {
        "tmc2130" => "tmc2130",
        "tmc5160" => "tmc5160",
        "tmc2240" => "tmc2240",
        "tmc2208" => "tmc2208",
        "tmc2209" => "tmc2209",
        _ => {
            let why = "a TMC2660 outside the board is a driver of your own choice";
            return m.judge_rest(section, &Verdict::refused(why, "[actuator] driver, [tmc2660]"));
        }
    };
    m.write(("actuator", motor, "driver"), kind, "outside the board, of the same kind as before");
    if let Some(microsteps) = m.source.section(&m.section(section).label()).and_then(|of| of.number("microsteps")) {
        m.write(("actuator", motor, "microsteps"), text(microsteps), "of the driver outside the board");
    }
    if m.written(("actuator", motor, "slaved_to")).is_none() {
        current(m, section, motor, 20.0);
    } else {
        m.merged(section, "run_current", "a slave takes its master's", "");
    }
    let rows: Vec<(&str, Rule)> =
        OUTSIDE.iter().map(|(from, key, change)| (*from, Rule::To(kind, key, *change))).collect();
    apply(m, section, motor, &rows);
    if m.section(section).get("sense_resistor").is_none() && kind != "tmc2240" {
        let usual = if kind == "tmc5160" { "75" } else { "110" };
        m.write((kind, motor, "sense_resistor"), usual, "mOhm, as Klipper takes it");
    }
    if let Some(rest) = m.number(section, "hold_current") {
        let amps = text((peak(rest) * 1000.0).round());
        m.put(section, "hold_current", (kind, motor, "standstill_current"), amps);
    }
    wire_outside(m, section, motor, kind);
    wires(m, section);
    let names: Vec<&str> = m.section(section).options.iter().map(|option| option.name.as_str()).collect();
    for option in names {
        m.refuse(section, option, "Velvet does not set this field", "docs/drivers.md");
    }
    m.ask(format!("motor {motor}: put a {} at header GF (docs/drivers.md)", kind.to_uppercase()));
}

fn wire_outside(m: &mut Migration<'_>, section: usize, motor: &'static str, kind: &'static str) {
    if kind == "tmc2209" {
        let address = m.number(section, "uart_address").unwrap_or(0.0);
        let is_free =
            !m.entries.iter().any(|e| (e.section, &*e.key) == (kind, "uart_address") && e.value == text(address));
        let address = if is_free { address } else { address + 1.0 };
        m.put(section, "uart_address", (kind, motor, "uart_address"), text(address));
        return m.ask(format!("motor {motor}: the TMC2209's UART goes to header GD, and its address is {address}"));
    }
    if !matches!(kind, "tmc2208") {
        let select = if motor == "epsilon" { "PJ10" } else { "PJ11" };
        m.put(section, "cs_pin", (kind, motor, "spi_cs_pin"), select);
        let pin = if motor == "epsilon" { 5 } else { 6 };
        m.wiring.note(
            format!("chip select of the driver of motor {motor}"),
            "",
            select,
            &format!("header GA pin {pin}"),
            "",
        );
    }
}

/// Writes a current for on-board motors whose old driver had its current set by hand.
pub fn finish(m: &mut Migration<'_>) {
    let motors: Vec<&'static str> = m.motors.values().copied().filter(|motor| is_on_board(motor)).collect();
    for motor in motors {
        let is_slave = m.written(("actuator", motor, "slaved_to")).is_some();
        let is_there = m.written(("actuator", motor, "steps_per_mm")).is_some();
        if is_there && !is_slave && m.written(("current control", motor, "current")).is_none() {
            m.write(("current control", motor, "current"), UNKNOWN_AMPS, "A at the peak: a guess, see the list");
            m.ask(format!(
                "[current control] {motor}.current: the old file does not say it (a trimmer does): write it"
            ));
        }
        if is_there {
            m.write((m.board.section, motor, "sense_resistor"), m.board.sense_resistor, "mOhm, as on the board");
            m.write(("actuator", motor, "driver"), m.board.section, "on the board");
        }
    }
}
