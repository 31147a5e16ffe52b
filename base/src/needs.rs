//! Parts that stay off because of an error in the configuration: a command that asks for such a part is
//! refused, with the place of the error.
//!
//! Nothing of such a part is wired (`config` takes its pins away), so this module is the message, not the
//! safety.

use core::fmt::{self, Write};

use config::{MAX_EXTRUDERS, MachineConfig, OffModule, ToolId};
use gcode::{Block, Letter};
use heapless::Vec;
use program::{CodeInfo, Fault, Part, Problem};

use crate::failure::{Failure, FailureKind, ShortText, Texts, short};
use crate::reason::Reason;
use crate::sessions::Reply;

/// Error that keeps a part off, and its place.
struct Explained<'c>(&'c OffModule);

impl fmt::Display for Explained<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(off) = self;
        match (off.key.is_empty(), off.line) {
            (_, 0) => write!(f, "{off} is off: see {} in config.ini", off.key),
            (true, line) => write!(f, "{off} is off: see config.ini, line {line}"),
            (false, line) => write!(f, "{off} is off: see {} in config.ini, line {line}", off.key),
        }
    }
}

/// Returns the section of a part, and its name where a section describes several.
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
            let named = config.extruders.iter().find(|extruder| extruder.tool.id == id);
            ("extruder", named.map_or("", |extruder| extruder.name.as_str()))
        }
        Part::Heater(id) => ("temperature control", config.heater(id).map_or("", |heater| heater.name.as_str())),
        Part::Switch(id) => ("switch", config.switches.get(id.index()).map_or("", |switch| switch.name.as_str())),
    }
}

/// Refuses a command that needs a part that stays off. A file being played must not go on without the part: a
/// spindle that does not turn breaks the tool, a nozzle that stays cold grinds the filament.
///
/// # Errors
/// When the part stays off; an alarm while a file is being played.
pub fn needs(texts: &Texts, config: &MachineConfig, part: Part, is_playing: bool) -> Result<(), Failure> {
    let (section, name) = section_of(config, part);
    let Some(off) = config.off(section, name) else { return Ok(()) };
    let refused = texts.refused(format_args!("{}", Explained(off)));
    Err(if is_playing { refused.meaning(FailureKind::Alarm) } else { refused })
}

/// Returns whether a code of this row levels the bed of other machines: this machine has neither probe nor
/// leveling, or no Z motors to align, or no screws. Nothing is lost when a file goes on without the code.
pub fn cannot_level(config: &MachineConfig, row: &CodeInfo) -> bool {
    row.levels
        && match row.part {
            Some(Part::ZAlignment) => config.z_alignment.motors.is_empty(),
            Some(Part::BedScrews) => config.bed_screws.screws.is_empty(),
            _ => !config.probe.enable && config.leveling.strategy.is_none(),
        }
}

/// Makes the failure for a fault of a block. The machine words it, as it knows names that the program does
/// not know.
pub fn failure_of(texts: &Texts, config: &MachineConfig, fault: &Fault, is_playing: bool) -> Failure {
    let refused = match fault.problem {
        Problem::PartIsOff(part) => match needs(texts, config, part, is_playing) {
            Err(failure) => return failure,
            Ok(()) => texts.refused(format_args!("{fault}")),
        },
        Problem::NoSuchTool(word) => texts.keep(FailureKind::Refused, &no_such_tool(config, word)),
        _ => texts.refused(format_args!("{fault}")),
    };
    let refused = refused.with_reason(Reason::of_problem(&fault.problem));
    if fault.halts { refused.meaning(FailureKind::Alarm) } else { refused }
}

/// Says that no extruder has this number, and lists the extruders.
fn no_such_tool(config: &MachineConfig, word: f64) -> ShortText {
    let mut extruders: Vec<(ToolId, &str), MAX_EXTRUDERS> =
        config.extruders.iter().map(|extruder| (extruder.tool.id, extruder.name.as_str())).collect();
    units::sort_short(&mut extruders, |(one, _), (other, _)| one.cmp(other));
    let mut text = short(format_args!("no extruder has tool_id {word}; there are"));
    for (place, (id, name)) in extruders.iter().enumerate() {
        let comma = if place == 0 { "" } else { "," };
        // Extruders that do not fit into the text are left out.
        let _ = write!(text, "{comma} P{id} {name}");
    }
    text
}

/// Returns why a file must not go on without this code, when leaving it out would make another part, or harm
/// somebody.
#[cold]
pub fn makes_another_part(texts: &Texts, row: Option<&CodeInfo>, block: &Block<'_>) -> Option<Failure> {
    let code = block.code?;
    let is_off = block.get('S') == Some(0.0);
    let why = match row {
        None if code.letter == Letter::G => "is not known here, and what follows counts on it",
        Some(row) if row.is_missing() => {
            return Some(texts.refused(format_args!("{code} is not carried out here: {}", row.help)));
        }
        Some(row) if row.is_needed && !is_off || code.letter == Letter::G => "is for a part that this machine has not",
        _ => return None,
    };
    Some(texts.refused(format_args!("{code} {why}")))
}

/// Prints at boot, in one line, the parts that stay off.
pub fn tell_what_is_off(config: &MachineConfig, reply: &mut Reply<'_>) {
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
    use gcode::Code;

    fn machine() -> MachineConfig {
        let mut config = MachineConfig::default();
        let off = OffModule { section: "zprobe", name: Default::default(), line: 12, key: Default::default() };
        assert!(config.off.push(off).is_ok());
        for (name, id) in [("second", 1), ("first", 0)] {
            let name = name.try_into().unwrap();
            let extruder = config::ExtruderConfig {
                name,
                tool: units::ToolSettings { id: ToolId(id), ..Default::default() },
                ..config::ExtruderConfig::default()
            };
            assert!(config.extruders.push(extruder).is_ok());
        }
        config
    }

    /// Returns a failure's kind and text.
    fn said(texts: &Texts, failure: Failure) -> (FailureKind, String) {
        (failure.kind, texts.of(failure).to_string())
    }

    #[test]
    fn a_part_that_is_off_is_refused_and_stops_a_file() {
        let (config, texts) = (machine(), Texts::new());
        let needs = |part, is_playing| needs(&texts, &config, part, is_playing);
        let (kind, text) = said(&texts, needs(Part::Probe, false).unwrap_err());
        assert_eq!(kind, FailureKind::Refused);
        assert!(text.ends_with("is off: see config.ini, line 12"), "{text}");
        assert_eq!(said(&texts, needs(Part::Probe, true).unwrap_err()), (FailureKind::Alarm, text));
        assert_eq!(needs(Part::Player, true), Ok(()));
    }

    #[test]
    fn a_tool_that_nobody_has_is_refused_with_those_there_are() {
        let texts = Texts::new();
        let failure = failure_of(&texts, &machine(), &Problem::NoSuchTool(7.0).refused(6), false);
        let text = "no extruder has tool_id 7; there are P0 first, P1 second".to_owned();
        assert_eq!(said(&texts, failure), (FailureKind::Refused, text));
    }

    #[test]
    fn a_fault_that_halts_is_an_alarm() {
        let texts = Texts::new();
        let failure = failure_of(&texts, &machine(), &Problem::NegativeFeedRate.alarm(3), false);
        assert_eq!(said(&texts, failure), (FailureKind::Alarm, "feed rate < 0, column 3".to_owned()));
        assert_eq!(failure.reason, Reason::Negative);
    }

    #[test]
    fn a_file_goes_on_without_a_code_only_where_the_part_is_the_same() {
        let texts = Texts::new();
        let why = |code, s: Option<f64>| {
            let block = Block::new(Some(code), 1);
            let block = s.map_or_else(|| block.clone(), |s| block.clone().with('S', s));
            let failure = makes_another_part(&texts, program::codes::find(code), &block)?;
            Some(texts.of(failure).to_string())
        };
        assert!(why(Code::g(999), None).expect("a reason").contains("G999 is not known here"));
        assert_eq!(why(Code::m(999), None), None, "an M-code that nobody knows");
        assert!(why(Code::m(104), Some(100.0)).expect("a reason").contains("M104 is for a part"));
        assert_eq!(why(Code::m(104), Some(0.0)), None, "off is as good as not there");
        assert_eq!(makes_another_part(&texts, None, &Block::new(None, 1)), None);
    }

    #[test]
    fn leveling_is_left_out_only_by_a_machine_that_has_none() {
        let row = |code| program::codes::find(code).expect("a row");
        let mut config = MachineConfig::default();
        let levels = |config: &MachineConfig| [29, 32, 34].map(|number| cannot_level(config, row(Code::g(number))));
        assert_eq!(levels(&config), [true; 3]);
        assert!(!cannot_level(&config, row(Code::g(1))));
        config.probe.enable = true;
        assert_eq!(levels(&config), [false, false, true]);
        config.z_alignment.motors.push([0.0; 2]).expect("room");
        assert_eq!(levels(&config), [false; 3]);
    }
}
