//! Commands about macros, and what time asks of them: delayed G-code, a machine that is idle for long.

use core::fmt::Write as _;

use base::World;
use base::failure::{Answer, Failure, Outcome};
use base::own_frame::apart;
use base::ports::Clock as _;
use base::program_setup::PartNames;
use base::sessions::Recipient;
use gcode::Extended;
use heapless::String;
use printer_cfg::{Section, Setting};
use program::extended::{ExtendedFault, Names as _};
use units::Micros;

use super::calls::{self, Shares};
use super::hands::{MacroHands, has_option, read_option};
use super::look::Parameters;
use super::{kept_modes, saved, z_offset};
use crate::machine::source::Source;

/// Line that carries out the delayed G-code that is due.
pub(super) const DUE: &str = "UPDATE_DELAYED_GCODE";
/// Command that carries out a template of any section.
const RUN_TEMPLATE: &str = "RUN_TEMPLATE";
/// Lines for a machine that has been idle for long, where the configuration has none.
const WHEN_IDLE: &str = "TURN_OFF_HEATERS\nM84";
/// Longest time that G-code can be delayed, s.
const LONGEST_S: f64 = 1e7;

/// Runs a command about macros. None: it is none.
pub(super) fn run<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>, source: Source) -> Option<Outcome> {
    Some(match command {
        _ if command.is("SET_GCODE_VARIABLE") => apart(|| saved::set(hands, command)),
        _ if command.is(RUN_TEMPLATE) => run_template(hands, command, source.to, Shares::Yes),
        _ if command.is("SAVE_VARIABLE") => apart(|| saved::save(hands, command)),
        _ if command.is(DUE) && command.rest().is_empty() => run_due(hands, source.to),
        _ if command.is(DUE) => delay(hands, command),
        _ if command.is("SET_IDLE_TIMEOUT") => set_idle_timeout(hands, command),
        _ if command.is("FORCE_MOVE") => force_move(hands, command, source),
        _ if command.is("STEPPER_BUZZ") => buzz(hands, command, source),
        _ if command.is("Z_OFFSET_APPLY_ENDSTOP") => z_offset::apply(hands, false, source.to),
        _ if command.is("Z_OFFSET_APPLY_PROBE") => z_offset::apply(hands, true, source.to),
        _ if command.is("SAVE_GCODE_STATE") => kept_modes::save(hands, command),
        _ if command.is("RESTORE_GCODE_STATE") => kept_modes::restore(hands, command, source.to),
        _ => return None,
    })
}

/// Begins a template of any section.
fn run_template<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>, to: Recipient, shares: Shares) -> Outcome {
    let (Some(name), Some(option)) = (command.get("SECTION"), command.get("OPTION")) else {
        return Err(Failure::refused(&"RUN_TEMPLATE needs SECTION= and OPTION="));
    };
    let Some(section) = hands.macros().memory.store.section(name) else {
        return Err(hands.world().texts.refused(format_args!("RUN_TEMPLATE: the printer.cfg has no [{name}]")));
    };
    calls::call(hands, section, option, &Parameters::Named(*command), to, shares)
}

/// Begins what a line of a probe's script names, a macro or a template, to be carried out on the spot;
/// returns how many macros are under way before it. None: the line names neither.
pub(super) fn begin_on_the_spot<'c>(
    hands: &mut impl MacroHands<'c>,
    line: &str,
    shares: Shares,
) -> Option<Result<usize, Failure>> {
    let command = Extended::new(line);
    if shares == Shares::First {
        calls::forget_dropped(hands);
    }
    let above = hands.macros().memory.store.calls();
    // Codes mean what they mean without macros.
    let is_code = command.name().as_bytes().get(1).is_some_and(u8::is_ascii_digit);
    let begun = match hands.macros().memory.store.named("gcode_macro", command.name()) {
        Some(_) if is_code => return None,
        Some(section) => calls::call(hands, section, "gcode", &Parameters::Named(command), Recipient::Nobody, shares),
        None if command.is(RUN_TEMPLATE) => run_template(hands, &command, Recipient::Nobody, shares),
        None => return None,
    };
    Some(begun.map(|_| above))
}

/// Reads a time in seconds.
fn seconds(command: &Extended<'_>, key: &str) -> Option<f64> {
    command.get(key).and_then(|text| gcode::read_f64(text.trim())).filter(|seconds| (0.0..=LONGEST_S).contains(seconds))
}

/// Sets when a section's G-code is carried out; 0 is never.
fn delay<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>) -> Outcome {
    let (Some(name), Some(seconds)) = (command.get("ID"), seconds(command, "DURATION")) else {
        return Err(Failure::refused(&"UPDATE_DELAYED_GCODE needs ID= and DURATION=, in seconds"));
    };
    let now = hands.world().ports.now();
    let store = &mut hands.macros().memory.store;
    let Some(section) = store.named("delayed_gcode", name) else {
        return Err(hands.world().texts.refused(format_args!("there is no [delayed_gcode {name}]")));
    };
    if store.delay(section, (seconds > 0.0).then_some(now.0 + (seconds * 1e6) as u64)) {
        return Ok(Answer::Ok);
    }
    Err(Failure::refused(&"16 delayed G-codes wait already"))
}

fn set_idle_timeout<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>) -> Outcome {
    let Some(seconds) = seconds(command, "TIMEOUT").filter(|seconds| *seconds > 0.0) else {
        return Err(Failure::refused(&"SET_IDLE_TIMEOUT needs TIMEOUT=, in seconds"));
    };
    let now = hands.world().ports.now();
    let macros = hands.macros();
    (macros.idle_timeout, macros.idle_since) = (Some(Micros((seconds * 1e6) as u64)), now);
    Ok(Answer::Ok)
}

/// Returns the letter of the motor that `STEPPER=` names.
fn motor<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>, source: Source) -> Result<char, Failure> {
    let World { config, texts, .. } = hands.world();
    let Some(name) = command.get("STEPPER") else {
        return Err(texts.refused(format_args!("{} needs STEPPER=", command.name())));
    };
    let names = PartNames { config, dialect: source.dialect };
    names.motor(name).ok_or_else(|| {
        let fault = ExtendedFault::NoMotor;
        texts.refused(format_args!("{} {fault}", command.name()))
    })
}

/// Moves one motor, where the configuration allows that.
fn force_move<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>, source: Source) -> Outcome {
    let is_allowed = match hands.macros().memory.store.section("force_move") {
        Some(section) => {
            const KEY: &str = "enable_force_move";
            read_option(hands, section, KEY)?
                && printer_cfg::read_setting(KEY, hands.macros().memory.text) == Setting::Bool(true)
        }
        None => false,
    };
    if !is_allowed {
        return Err(Failure::refused(&"FORCE_MOVE needs [force_move] enable_force_move: True in the printer.cfg"));
    }
    let letter = motor(hands, command, source)?;
    let number = |key| command.get(key).and_then(gcode::read_f64).filter(|number| number.is_finite());
    let (Some(distance), Some(velocity)) = (number("DISTANCE"), number("VELOCITY")) else {
        return Err(Failure::refused(&"FORCE_MOVE needs DISTANCE= in mm and VELOCITY= in mm/s"));
    };
    let mut line = String::<96>::new();
    // A number takes no more than is left for it.
    let _ = write!(line, "test acc {letter} {distance:.5} {velocity:.5} ");
    match (command.get("ACCEL"), number("ACCEL")) {
        (None, _) | (_, Some(0.0)) => {}
        (_, Some(acceleration)) => drop(write!(line, "{acceleration:.3}")),
        (Some(_), None) => return Err(Failure::refused(&"FORCE_MOVE: ACCEL is a number, in mm/s2")),
    }
    calls::run_text(hands, Section(u16::MAX), [&line, ""], source.to, Shares::No)
}

/// Moves one motor's axis to and fro, ten times.
fn buzz<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>, source: Source) -> Outcome {
    let letter = motor(hands, command, source)?;
    let mut line = String::<32>::new();
    // The line fits.
    let _ = write!(line, "test jog {letter} 1 20 240");
    calls::run_text(hands, Section(u16::MAX), [&line, ""], source.to, Shares::No)
}

/// Looks whether G-code is due.
pub(super) fn follow_time<'c>(hands: &mut impl MacroHands<'c>, now: Micros) {
    let is_at_rest = hands.is_at_rest();
    let macros = hands.macros();
    if !is_at_rest {
        macros.idle_since = now;
    }
    macros.is_due = macros.memory.store.is_due(now.0) || macros.is_idle_too_long(now);
}

/// Carries out G-code that is due.
fn run_due<'c>(hands: &mut impl MacroHands<'c>, to: Recipient) -> Outcome {
    let now = hands.world().ports.now();
    let macros = hands.macros();
    macros.is_due = false;
    if let Some(section) = macros.memory.store.take_due(now.0) {
        return calls::call(hands, section, "gcode", &Parameters::Coded(""), to, Shares::No);
    }
    if !macros.is_idle_too_long(now) {
        return Ok(Answer::Ok);
    }
    macros.is_idle = true;
    let section = macros.memory.store.section("idle_timeout");
    match section {
        Some(section) if has_option(hands, section, "gcode")? => {
            calls::call(hands, section, "gcode", &Parameters::Coded(""), to, Shares::No)
        }
        section => calls::run_text(hands, section.unwrap_or(Section(u16::MAX)), [WHEN_IDLE, ""], to, Shares::No),
    }
}
