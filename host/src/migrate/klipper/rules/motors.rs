//! Motors of axes: pins, steps per millimetre, the limits that follow from `[printer]`.

use super::super::migration::{Migration, text};
use super::super::source::number;
use super::machine::{kinematics, master};
use super::table::{Rule, apply};
use super::{endstops, generic, geometry};

/// Pins of the on-board drivers: motor, step, direction, connector.
const ON_BOARD: [(&str, &str, &str, &str); 4] = [
    ("alpha", "PD3", "PD4", "motor driver alpha (X)"),
    ("beta", "PK2", "PG2", "motor driver beta (Y)"),
    ("gamma", "PG3", "PG4", "motor driver gamma (Z)"),
    ("delta", "PC6", "PG5", "motor driver delta (A)"),
];
/// Pins of header GF for drivers outside the board: step, direction, enable, place.
const OUTSIDE: [(&str, &str, &str, &str); 2] =
    [("PG0", "PG1", "PJ2", "header GF pins 6, 8, 9"), ("PA4", "PJ3", "nc", "header GF pins 5, 7")];
/// Full steps of a turn, where the file does not say them.
const FULL_STEPS: f64 = 200.0;
/// Rate of steps that a machine has without a line of its own, Hz.
const USUAL_STEP_RATE: f64 = 200_000.0;
const MOST_STEP_RATE: f64 = 1_000_000.0;

/// Returns whether a motor has a driver on the board.
pub fn is_on_board(motor: &str) -> bool {
    ON_BOARD.iter().any(|(name, ..)| *name == motor)
}

/// Converts a section of a motor of an axis.
pub fn stepper(m: &mut Migration<'_>, section: usize) {
    let name = m.section(section).name.clone();
    let Some(motor) = m.motors.get(&name).copied() else { return refuse(m, section, &name) };
    drive(m, section, motor);
    rate(m, section, motor);
    generic::motor(m, section, motor);
    match master(m, &name) {
        Some(master) => {
            m.write(("actuator", motor, "slaved_to"), master, format!("[{name}] copies its steps"));
            endstops::of_slave(m, section, motor);
        }
        None => {
            endstops::of_axis(m, section, motor);
            geometry::stepper(m, section, motor);
        }
    }
}

fn refuse(m: &mut Migration<'_>, section: usize, name: &str) {
    let has_motors = !m.motors.is_empty();
    let knows_kinematics = kinematics(m).is_some();
    let why = match has_motors && knows_kinematics {
        true => "the Prime has six motors at most, extruders among them",
        false => "the kinematics do not say what this motor moves",
    };
    m.judge_rest(section, &super::super::account::Verdict::refused(why, "[actuator]"));
    m.ask(format!("[{name}]: {why}; it is left out"));
}

/// Converts pins, microsteps and the way of a turn.
pub fn drive(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let who = m.section(section).name.clone();
    let outside = outside_place(m, motor);
    let (step, direction, enable, label) = match ON_BOARD.iter().find(|(name, ..)| *name == motor) {
        Some((_, step, direction, label)) => (*step, *direction, "nc", *label),
        None => outside,
    };
    let old = ["step_pin", "dir_pin"].map(|option| m.section(section).get(option).unwrap_or("").to_owned());
    m.put(section, "step_pin", ("actuator", motor, "step_pin"), step);
    let is_inverted = m.pin(section, "dir_pin").is_some_and(|pin| pin.is_inverted);
    // Klipper's plain pin is high while the motor counts up, Velvet's is low.
    let turned = format!("{direction}{}", if is_inverted { "" } else { "!" });
    m.put(section, "dir_pin", ("actuator", motor, "dir_pin"), turned);
    let remark = if is_on_board(motor) { "" } else { "needs a driver outside the board" };
    m.wiring.note(format!("motor of [{who}]"), &old.join(", "), step, label, remark);
    if is_on_board(motor) {
        m.needless(section, "enable_pin", "on-board drivers are enabled over SPI");
        m.needless(section, "step_pulse_duration", "on-board drivers step on both edges");
    } else {
        m.write(("actuator", motor, "driver"), "external", "no driver on the board is left");
        enable_outside(m, section, motor, enable);
        if let Some(pulse) = m.number(section, "step_pulse_duration") {
            let micros = (pulse * 1e6).ceil().max(1.0);
            m.put(section, "step_pulse_duration", ("system", "", "step_pulse_us"), text(micros));
        }
    }
    steps(m, section, motor);
}

/// Returns the place of a driver outside the board: the first such motor has the whole header.
fn outside_place(m: &Migration<'_>, motor: &str) -> (&'static str, &'static str, &'static str, &'static str) {
    let is_first = motor == "epsilon" || !m.motors.values().any(|other| *other == "epsilon");
    OUTSIDE[usize::from(!is_first)]
}

fn enable_outside(m: &mut Migration<'_>, section: usize, motor: &'static str, enable: &str) {
    let Some(old) = m.pin(section, "enable_pin") else { return };
    if enable == "nc" {
        let why = "header GF has one enable: join the enable inputs of both drivers to its pin 9";
        m.needless(section, "enable_pin", why);
        return m.ask(format!("motor {motor}: {why}"));
    }
    let pin = format!("{enable}{}", if old.is_inverted { "!" } else { "" });
    m.put(section, "enable_pin", ("actuator", motor, "en_pin"), pin);
}

/// Returns the product of the gears in `80:20, 3:1`, as numerator and denominator.
pub fn gears(text: &str) -> Option<(f64, f64)> {
    text.split(',').filter(|pair| !pair.trim().is_empty()).try_fold((1.0, 1.0), |(over, under), pair| {
        let (a, b) = pair.split_once(':')?;
        Some((over * number(a)?, under * number(b)?))
    })
}

/// Writes steps_per_mm and microsteps.
fn steps(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let full = m.number(section, "full_steps_per_rotation").unwrap_or(FULL_STEPS);
    let Some(microsteps) = m.number(section, "microsteps") else { return };
    let gear = m.section(section).get("gear_ratio");
    let Some((over, under)) = gears(gear.unwrap_or("")) else {
        return m.refuse(section, "gear_ratio", "this is no ratio as in 80:20", "[actuator] steps_per_mm");
    };
    let distance = m.number(section, "rotation_distance");
    // Without it the motor turns an arm or a bed, and 360 degrees are a turn.
    let way = distance.unwrap_or(360.0);
    if under == 0.0 || way == 0.0 || full <= 0.0 || microsteps <= 0.0 {
        return m.refuse(section, "rotation_distance", "a turn of no length", "[actuator] steps_per_mm");
    }
    let per_mm = (full * microsteps * over / (way * under)).abs();
    let named = ["rotation_distance", "gear_ratio", "full_steps_per_rotation"];
    let first = named.into_iter().find(|option| m.section(section).get(option).is_some()).unwrap_or("microsteps");
    let reason = "full steps x microsteps x gear ratio / rotation distance";
    m.put_for(section, first, ("actuator", motor, "steps_per_mm"), text(per_mm), reason);
    if distance.is_some_and(|distance| distance < 0.0) {
        m.write(("actuator", motor, "reversed"), "true", "the rotation distance was negative");
    }
    let becomes = format!("[actuator] {motor}.steps_per_mm = {}", text(per_mm));
    for option in named.into_iter().filter(|option| *option != first) {
        m.merged(section, option, reason, &becomes);
    }
    if is_on_board(motor) && !(microsteps.log2().fract() == 0.0 && (1.0..=256.0).contains(&microsteps)) {
        let why = "a driver on the board makes 1, 2, 4 ... 256 microsteps: steps_per_mm is off until one is chosen";
        m.ask(format!("motor {motor}: {} microsteps: {why}", text(microsteps)));
        return m.refuse(section, "microsteps", why, "[actuator] microsteps");
    }
    m.put(section, "microsteps", ("actuator", motor, "microsteps"), text(microsteps));
}

/// Writes the top speed of an axis' motor: as fast as the axis may go, since Klipper limits no motor.
fn rate(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let Some(printer) = m.source.section("printer") else { return };
    let Some(speed) = printer.number("max_velocity") else { return };
    let kinematics = kinematics(m).unwrap_or_default();
    let is_z = m.section(section).name.starts_with("stepper_z");
    let factor = match kinematics.as_str() {
        "cartesian" => 1.0,
        // Two axes at once, at right angles.
        "corexy" | "hybrid_corexy" | "corexz" | "hybrid_corexz" => std::f64::consts::SQRT_2,
        _ => 2.0,
    };
    let z_is_alone = is_z && kinematics != "corexz";
    let rate = match z_is_alone {
        true => printer.number("max_z_velocity").unwrap_or(speed),
        false => speed * factor,
    };
    let rate = if m.section(section).get("rotation_distance").is_none() { rate * 10.0 } else { rate };
    m.write(("actuator", motor, "max_rate"), text((rate * 60.0).ceil()), "mm/min; Klipper has no limit for a motor");
    step_rate(m, motor, rate);
}

/// Raises the highest rate of steps where a motor needs more than is usual.
pub fn step_rate(m: &mut Migration<'_>, motor: &str, rate: f64) {
    let per_mm = m.written(("actuator", motor, "steps_per_mm")).and_then(number).unwrap_or(0.0);
    let known = m.written(("system", "", "step_frequency")).and_then(number).unwrap_or(USUAL_STEP_RATE);
    let wanted = (rate * per_mm * 1.01).ceil();
    if wanted > MOST_STEP_RATE {
        // A motor that no board can turn so fast has the speed that this one can.
        let slower = (MOST_STEP_RATE / per_mm / 1.01 * 60.0).floor();
        m.write(("actuator", motor, "max_rate"), text(slower), "mm/min; a million steps a second are the most");
    }
    if wanted > known {
        let comment = format!("Hz, for motor {motor} at its top speed");
        m.write(("system", "", "step_frequency"), text(wanted.min(MOST_STEP_RATE)), comment);
    }
}

/// Converts a motor that no axis and no extruder has.
pub fn extra(m: &mut Migration<'_>, section: usize) {
    let why = match m.section(section).kind() {
        "extruder_stepper" => "no motor follows an extruder",
        "manual_stepper" => "a motor without an axis is an axis A, B or C in Velvet, moved by G0 and G1",
        _ => "one carriage on each axis",
    };
    apply(m, section, "", &[("enable_pin", Rule::Refused(why, "[actuator] delta, epsilon, zeta"))]);
    m.judge_rest(section, &super::super::account::Verdict::refused(why, "[actuator] delta, epsilon, zeta"));
}
