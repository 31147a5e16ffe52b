//! Reports of the machine's position and of its switches: M114, `get pos`, M119.

use base::CodeContext;
use base::failure::{Answer, Outcome};
use base::ports::{Input, Inputs, MotionPort};
use base::sessions::Reply;
use base::tuning::Tuning;
use config::{HomingDirection, MachineConfig};
use motion::Motion;
use program::{Dialect, Interpreter, Words};
use units::{Actuator, PerAxis};

use super::{Line, add, auxiliary_axes, free_axes};

/// Answers M114 and its subcodes.
///
/// # Errors
/// None; an unknown subcode is [`Answer::Unknown`].
pub fn position(code: CodeContext<'_, impl MotionPort>, program: &Interpreter, dialect: Dialect) -> Outcome {
    let CodeContext { ports, config, words, reply, .. } = code;
    let (modal, subcode) = (program.modal(), words.code().subcode);
    if subcode == 0 && !matches!(dialect, Dialect::Smoothie | Dialect::Grbl) {
        return Ok(printers_position(ports, program, (dialect, words), reply));
    }
    let (live, last) = ports.motion(|motion| (motion.live_position(), motion.commanded_position()));
    let (label, position, in_units) = match subcode {
        0 => ("C", modal.work(&last), true),
        1 => ("WCS", modal.work(&live), true),
        2 => ("MCS", live, false),
        3 => ("APOS", ports.motion(|motion| motor_position(motion, &live)), false),
        4 => ("MP", last, false),
        5 => ("CMP", ports.motion(|motion| motion.compensation().motors(&last)), false),
        _ => return Ok(Answer::Unknown),
    };
    let [x, y, z, ..] = position.0.map(|mm| if in_units { modal.in_program_units(mm) } else { mm });
    let mut line = Line::new();
    add!(line, "{label}: X:{x:.4} Y:{y:.4} Z:{z:.4}");
    if matches!(subcode, 2..=4) {
        for axis in free_axes(config, program.tools()) {
            add!(line, " {}:{:.4}", axis.letter(), position[axis]);
        }
    }
    if let Some(tool) = program.tools().active().filter(|_| matches!(subcode, 0 | 1 | 3)) {
        add!(line, " E:{:.4} ", tool.e);
    }
    reply.say(format_args!("ok {line}\n"));
    Ok(Answer::Said)
}

/// Answers M114 as the firmware of the dialect does: `X:0.00 Y:0.00 Z:0.00 E:0.00 Count X:0 Y:0 Z:0`.
fn printers_position(
    ports: &mut impl MotionPort,
    program: &Interpreter,
    (dialect, words): (Dialect, &Words<'_>),
    reply: &mut Reply<'_>,
) -> Answer {
    let modal = program.modal();
    let (live, last, steps) =
        ports.motion(|motion| (motion.live_position(), motion.commanded_position(), motion.steps()));
    let place = modal.work(if words.has('R') { &live } else { &last });
    let [x, y, z, ..] = place.0.map(|mm| modal.in_program_units(mm));
    let mut line = Line::new();
    add!(line, "X:{x:.2} Y:{y:.2} Z:{z:.2} E:{:.2}", program.tools().active().map_or(0.0, |tool| tool.e));
    let [a, b, c] = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma].map(|motor| steps[motor]);
    match dialect {
        Dialect::Marlin => add!(line, " Count X:{a} Y:{b} Z:{c}"),
        Dialect::RepRapFirmware => add!(line, " Count {a} {b} {c}"),
        _ => {}
    }
    reply.say(format_args!("{line}\n"));
    if words.has('D') {
        let (leveled, motors) =
            ports.motion(|motion| (motion.compensation().motors(&last), motor_position(motion, &live)));
        let places = [("Logical", modal.work(&last)), ("Raw", last), ("Leveled", leveled), ("FromStp", motors)];
        for (label, PerAxis([x, y, z, ..])) in places {
            reply.say(format_args!("{label}: X:{x:.3} Y:{y:.3} Z:{z:.3}\n"));
        }
    }
    Answer::Ok
}

/// Returns the motor positions in mm, in the form of a position.
fn motor_position(motion: &Motion, machine: &PerAxis<f64>) -> PerAxis<f64> {
    let place = motion.compensation().motors(machine);
    motion.config().map_or(*machine, |config| PerAxis(config.kinematics.actuators(&place).0))
}

/// Reports all positions (`get pos`).
pub(super) fn positions(
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    program: &Interpreter,
    reply: &mut Reply<'_>,
) {
    let modal = program.modal();
    let (live, last) = ports.motion(|motion| (motion.live_position(), motion.commanded_position()));
    let (motors, steps) = ports.motion(|motion| (motor_position(motion, &live), motion.steps()));
    let compensated = ports.motion(|motion| motion.compensation().motors(&last));
    for (label, position, is_whole) in [
        ("last C", modal.work(&last), false),
        ("realtime WCS", modal.work(&live), false),
        ("MCS", live, true),
        ("APOS", motors, true),
        ("MP", last, true),
        ("CMP", compensated, false),
    ] {
        let [x, y, z, ..] = position.0;
        reply.say(format_args!("{label}: X:{x:.4} Y:{y:.4} Z:{z:.4}"));
        for axis in auxiliary_axes(config).filter(|_| is_whole) {
            reply.say(format_args!(" {}:{:.4}", axis.letter(), position[axis]));
        }
        reply.say(format_args!("\n"));
    }
    reply.say(format_args!("RAW:"));
    for (actuator, _) in config.actuators() {
        reply.say(format_args!(" {:11}", steps[actuator]));
    }
    reply.say(format_args!("\n"));
}

/// M119: reports the switches as `X_min:0 Y_min:0 pins- (X:H:L)PD0^:0 `.
pub fn end_switches(ports: &impl Inputs, config: &MachineConfig, tuning: &Tuning, reply: &mut Reply<'_>) {
    let levels = ports.inputs();
    let mut line = Line::new();
    let stops = || (0..).zip(&config.endstops).filter(|(_, stop)| stop.pin.is_some());
    for (index, stop) in stops() {
        let Some(axis) = stop.axis else { continue };
        let end = match stop.homing_direction {
            HomingDirection::ToMin => "min",
            HomingDirection::ToMax => "max",
            HomingDirection::None => "limit",
        };
        add!(line, "{}_{end}:{} ", axis.letter(), u8::from(levels.is_active(Input::Endstop(index))));
    }
    add!(line, "pins- ");
    for (index, stop) in stops() {
        let Some((axis, pin)) = stop.axis.zip(stop.pin) else { continue };
        let homes = if stop.homing_direction == HomingDirection::None { "" } else { ":H" };
        let limits = if stop.limit_enable { ":L" } else { "" };
        let level = u8::from(levels.is_active(Input::Endstop(index)));
        add!(line, "({}{homes}{limits}){pin}:{level} ", axis.letter());
    }
    if let Some(pin) = config.probe.pin.filter(|_| config.probe.enable) {
        add!(line, " (Probe){pin}:{} ", u8::from(tuning.probe_touches(levels)));
    }
    reply.say(format_args!("{line}\n"));
}
