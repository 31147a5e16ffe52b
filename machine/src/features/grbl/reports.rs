//! `$G`, `$#`, `$I`, `$N`: GRBL's reports of the program and of itself, in its brackets.

use base::sessions::Reply;
use config::{ArmSolution, MachineConfig};
use parts::outputs::Outputs;
use program::{Interpreter, write_system_name};
use units::Plane;

use crate::features::grbl::state::Own;

/// Millimetres in an inch.
pub(super) const MM_PER_INCH: f64 = 25.4;

/// Length as reports have it: three decimals of a millimetre, four of an inch (`$13`).
#[derive(Clone, Copy, Debug)]
pub(super) struct Length {
    pub mm: f64,
    pub inches: bool,
}

impl core::fmt::Display for Length {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (value, decimals, least) =
            if self.inches { (self.mm / MM_PER_INCH, 4, 0.000_05) } else { (self.mm, 3, 0.000_5) };
        // Values that round to zero must not be printed as `-0.000`.
        let value = if libm::fabs(value) < least { 0.0 } else { value };
        write!(f, "{value:.decimals$}")
    }
}

/// Prints `[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]`.
pub(crate) fn modal(config: &MachineConfig, program: &Interpreter, outputs: &Outputs, reply: &mut Reply<'_>) {
    let modal = program.modal();
    let plane = match modal.plane {
        Plane::Xy => 17,
        Plane::Xz => 18,
        Plane::Yz => 19,
    };
    let (units, distance) = (if modal.inches { 20 } else { 21 }, if modal.absolute { 90 } else { 91 });
    reply.say(format_args!("[GC:{} ", modal.motion_code()));
    // A reply takes any text, so errors are ignored.
    let _ = write_system_name(reply, modal.system);
    reply.say(format_args!(" G{plane} G{units} G{distance} {} ", modal.feed_mode.code()));
    reply.say(format_args!("M{}", outputs.spindle(config, modal.auxiliary.spindle).code()));
    let is_on = |code| outputs.is_on_by_code(config, code);
    if is_on(7) {
        reply.say(format_args!(" M7"));
    }
    if is_on(8) || !is_on(7) {
        reply.say(format_args!("{}", if is_on(8) { " M8" } else { " M9" }));
    }
    let feed = modal.in_program_units(modal.feed_rate.per_minute());
    // M5 keeps the spindle speed.
    let (speed, tool) = (modal.auxiliary.speed.unwrap_or(0.0), program.tools().number());
    reply.say(format_args!(" T{tool} F{feed:.0} S{speed:.0}]\n"));
}

/// `$#`: prints every offset, and the last probe.
pub(crate) fn offsets(own: &Own, program: &Interpreter, reply: &mut Reply<'_>) {
    let modal = program.modal();
    let length = |mm: f64| Length { mm, inches: own.inches };
    for (system, offsets) in modal.systems.iter().enumerate() {
        reply.say(format_args!("["));
        // A reply takes any text, so errors are ignored.
        let _ = write_system_name(reply, system);
        say_point(reply, offsets.map(length));
    }
    let park = program.park();
    // The G92 offset is subtracted from a place here, in GRBL added: hence the minus.
    let g92 = modal.g92.map(|mm| -mm);
    let second = program.second_park().map_or([0.0; 3], |place| [place.x, place.y, place.z.unwrap_or(0.0)]);
    for (name, point) in [("G28", [park.x, park.y, park.z.unwrap_or(0.0)]), ("G30", second), ("G92", g92)] {
        reply.say(format_args!("[{name}"));
        say_point(reply, point.map(length));
    }
    let [_, _, z] = modal.tool_offset.map(length);
    let ([x, y, z_probe], found) = program.last_probe();
    let [x, y, z_probe] = [x, y, z_probe].map(length);
    reply.say(format_args!("[TLO:{z}]\n[PRB:{x},{y},{z_probe}:{}]\n", u8::from(found)));
}

fn say_point(reply: &mut Reply<'_>, [x, y, z]: [Length; 3]) {
    reply.say(format_args!(":{x},{y},{z}]\n"));
}

/// How much a sender may send ahead of the motors.
#[derive(Clone, Copy)]
pub(crate) struct Ahead {
    /// Moves in the look-ahead queue.
    pub moves: usize,
    /// Bytes that wait for it.
    pub bytes: usize,
}

/// `$I`: prints the version that senders look for, the build's text, the options, and how much may be sent
/// ahead.
pub(crate) fn build(config: &MachineConfig, own: &Own, version: &str, ahead: Ahead, reply: &mut Reply<'_>) {
    let corexy = if config.motion.arm_solution == ArmSolution::CoreXy { "C" } else { "" };
    self::version(own, reply);
    reply.say(format_args!("[OPT:VNM{corexy}H,{},{}]\n", ahead.moves, ahead.bytes));
    short(version, reply);
}

/// Prints the version that senders look for, and the build's text.
pub(crate) fn version(own: &Own, reply: &mut Reply<'_>) {
    reply.say(format_args!("[VER:1.1f.20170801:{}]\n", own.build));
}

/// Prints the name and version of this firmware.
pub(crate) fn short(version: &str, reply: &mut Reply<'_>) {
    reply.say(format_args!("[MSG:Velvet {version}]\n"));
}

/// `$N`: prints the startup lines.
pub(crate) fn startup(own: &Own, reply: &mut Reply<'_>) {
    for (index, line) in own.startup.iter().enumerate() {
        reply.say(format_args!("$N{index}={line}\n"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_grbls_decimals_and_no_negative_zero() {
        let said = |mm, inches| std::format!("{}", Length { mm, inches });
        assert_eq!((said(1.5, false), said(25.4, true)), ("1.500".into(), "1.0000".into()));
        assert_eq!((said(-1e-9, false), said(-0.0004, false)), ("0.000".into(), "0.000".into()));
        assert_eq!((said(-0.0006, false), said(-0.001, true)), ("-0.001".into(), "0.0000".into()));
    }
}
