//! Parts that stay off because of an error in the configuration: whoever asks for one is told where the error
//! is.
//!
//! Nothing of such a part is wired (`config` takes its pins away), so this is the message, not the safety.

use core::fmt::Write;

use config::{MAX_EXTRUDERS, MachineConfig, OffModule, ToolId};
use gcode::{Block, Letter};
use heapless::Vec;
use program::{CodeInfo, Fault, Part, Problem};

use crate::failure::{Failure, Message, message};
use crate::grbl::numbers::Error;
use crate::sessions::Reply;

/// What keeps a part off, and where it stands.
fn explained(off: &OffModule) -> Message {
    match (off.key.is_empty(), off.line) {
        (_, 0) => message(format_args!("{off} is off: see {} in config.ini", off.key)),
        (true, line) => message(format_args!("{off} is off: see config.ini, line {line}")),
        (false, line) => message(format_args!("{off} is off: see {} in config.ini, line {line}", off.key)),
    }
}

/// The section of a part, and its name where a section describes several.
fn section_of(config: &MachineConfig, part: Part) -> (&'static str, &str) {
    match part {
        Part::Probe => ("zprobe", ""),
        Part::ZAlignment => ("z alignment", ""),
        Part::BedScrews => ("bed screws", ""),
        Part::Lathe => ("lathe", ""),
        Part::DrillingCycles => ("drillingcycles", ""),
        Part::Laser => ("laser", ""),
        Part::Player => ("player", ""),
        Part::Extruder(id) => {
            let named = config.extruders.iter().find(|extruder| extruder.tool_id == id);
            ("extruder", named.map_or("", |extruder| extruder.name.as_str()))
        }
        Part::Heater(id) => ("temperature control", config.heater(id).map_or("", |heater| heater.name.as_str())),
        Part::Switch(id) => ("switch", config.switches.get(id.index()).map_or("", |switch| switch.name.as_str())),
    }
}

/// Refuses what needs a part that stays off. A file being played must not go on without it: a spindle that
/// does not turn breaks the tool, a nozzle that stays cold grinds the filament.
///
/// # Errors
/// When it stays off; an alarm while a file is being played.
pub(crate) fn needs(config: &MachineConfig, part: Part, is_playing: bool) -> Result<(), Failure> {
    let (section, name) = section_of(config, part);
    match config.off(section, name).map(explained) {
        None => Ok(()),
        Some(text) if is_playing => Err(Failure::Alarm(text)),
        Some(text) => Err(Failure::Refused(text)),
    }
}

/// What the program found wrong with a block, as the machine says it: it knows the names that the program
/// does not.
pub(crate) fn failure_of(config: &MachineConfig, fault: &Fault, is_playing: bool) -> Failure {
    let refused = match fault.problem {
        Problem::PartIsOff(part) => match needs(config, part, is_playing) {
            Err(failure) => return failure,
            Ok(()) => message(format_args!("{fault}")),
        },
        Problem::NoSuchTool(word) => no_such_tool(config, word),
        _ => message(format_args!("{fault}")),
    };
    let refused = refused.numbered(Error::of_problem(&fault.problem));
    if fault.halts { Failure::Alarm(refused) } else { Failure::Refused(refused) }
}

/// That no extruder has this number, and those there are.
fn no_such_tool(config: &MachineConfig, word: f64) -> Message {
    let mut extruders: Vec<(ToolId, &str), MAX_EXTRUDERS> =
        config.extruders.iter().map(|extruder| (extruder.tool_id, extruder.name.as_str())).collect();
    units::sort_short(&mut extruders, |(one, _), (other, _)| one.cmp(other));
    let mut text = message(format_args!("no extruder has tool_id {word}; there are"));
    for (place, (id, name)) in extruders.iter().enumerate() {
        let comma = if place == 0 { "" } else { "," };
        // What does not fit any more is left out.
        let _ = write!(text, "{comma} P{id} {name}");
    }
    text
}

/// Whether a file whose code of this row is not carried out makes another part, or harms somebody: why.
#[cold]
pub(crate) fn makes_another_part(row: Option<&CodeInfo>, block: &Block<'_>) -> Option<Failure> {
    let code = block.code?;
    let is_off = block.get('S') == Some(0.0);
    let why = match row {
        None if code.letter == Letter::G => "is not known here, and what follows counts on it",
        Some(row) if row.is_missing() => {
            return Some(Failure::Refused(message(format_args!("{code} is not carried out here: {}", row.help))));
        }
        Some(row) if row.is_needed && !is_off || code.letter == Letter::G => "is for a part that this machine has not",
        _ => return None,
    };
    Some(Failure::Refused(message(format_args!("{code} {why}"))))
}

/// At boot: what stays off, in one line.
pub(crate) fn tell_what_is_off(config: &MachineConfig, reply: &mut Reply<'_>) {
    if config.off.is_empty() {
        return;
    }
    reply.say(format_args!("WARNING: until config.ini is mended these stay off: "));
    for (index, off) in config.off.iter().enumerate() {
        reply.say(format_args!("{}{off}", if index == 0 { "" } else { ", " }));
    }
    reply.say(format_args!("\n"));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine() -> MachineConfig {
        let mut config = MachineConfig::default();
        let off = OffModule { section: "zprobe", name: Default::default(), line: 12, key: Default::default() };
        assert!(config.off.push(off).is_ok());
        for (name, id) in [("second", 1), ("first", 0)] {
            let name = name.try_into().unwrap();
            let extruder = config::ExtruderConfig { name, tool_id: ToolId(id), ..config::ExtruderConfig::default() };
            assert!(config.extruders.push(extruder).is_ok());
        }
        config
    }

    #[test]
    fn a_part_that_is_off_is_refused_and_stops_a_file() {
        let config = machine();
        let Err(Failure::Refused(text)) = needs(&config, Part::Probe, false) else { panic!("it must be refused") };
        assert!(text.ends_with("is off: see config.ini, line 12"), "{text}");
        assert_eq!(needs(&config, Part::Probe, true), Err(Failure::Alarm(text)));
        assert_eq!(needs(&config, Part::Player, true), Ok(()));
    }

    #[test]
    fn a_tool_that_nobody_has_is_refused_with_those_there_are() {
        let fault = Problem::NoSuchTool(7.0).refused(6);
        let text = message(format_args!("no extruder has tool_id 7; there are P0 first, P1 second"));
        assert_eq!(failure_of(&machine(), &fault, false), Failure::Refused(text));
    }

    #[test]
    fn a_fault_that_halts_is_an_alarm() {
        let fault = Problem::NegativeFeedRate.alarm(3);
        let text = message(format_args!("feed rate < 0, column 3")).numbered(Error::Negative);
        assert_eq!(failure_of(&machine(), &fault, false), Failure::Alarm(text));
    }
}
