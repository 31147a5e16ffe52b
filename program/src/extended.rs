//! Klipper's commands by name: the table of those that are known, and what each comes to: a line of codes, a
//! console command, nothing, or a refusal.
//!
//! Source: Klipper's "G-Codes" and "Status reference". Names of heaters and fans are the machine's, so it
//! says what they are ([`Names`]).

use core::fmt::{self, Write};

use gcode::{Code, Extended};
use heapless::String;

/// A line of codes.
pub type CodeLine = String<{ gcode::MAX_LINE_LENGTH }>;

/// What the machine calls its parts.
pub trait Names {
    /// The code that switches an output of this name on, its S from 0 to 255.
    fn switch(&self, name: &str) -> Option<Code>;
    /// The code that sets the target of a heater of this name, and the heater's id.
    fn heater(&self, name: &str) -> Option<(Code, u8)>;
    /// The same of the heaters in turn.
    fn heater_at(&self, place: usize) -> Option<(Code, u8)>;
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct ExtendedInfo {
    /// Its name; one that ends in `*` is the beginning of a name.
    pub name: &'static str,
    /// The parameters that it looks at.
    pub takes: &'static str,
    /// What it does here, in one line.
    pub help: &'static str,
    becomes: Becomes,
}

/// What a command comes to.
#[derive(Clone, Copy, Debug)]
enum Becomes {
    /// A line of codes.
    Codes(Translate),
    /// A console command.
    Console(&'static str),
    /// Nothing, and the part is the same.
    PassedOver,
    /// Nothing, and the part is another one.
    Missing,
}

type Translate = fn(&Extended<'_>, &dyn Names, &mut CodeLine) -> Result<(), ExtendedFault>;

/// What a command asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// The line of codes that was written.
    Codes,
    /// This console command.
    Console(&'static str),
    /// Nothing: it is passed over, by the name of its row.
    PassedOver(&'static str),
}

/// Why a command is not carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "their texts say it")]
pub enum ExtendedFault {
    Unknown,
    Missing(&'static str),
    MustSupply(&'static str),
    NotANumber(&'static str),
    NoHeater,
    NoFan,
    TooLong,
}

impl fmt::Display for ExtendedFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Unknown => {
                f.write_str("is not known here; if it is a macro, write its commands into the file instead")
            }
            Self::Missing(what) => write!(f, "is not carried out here: {what}"),
            Self::MustSupply(key) => write!(f, "needs {key}="),
            Self::NotANumber(key) => write!(f, "needs a number for {key}="),
            Self::NoHeater => f.write_str("names no heater of this machine"),
            Self::NoFan => f.write_str("names no switch of this machine"),
            Self::TooLong => f.write_str("is too long"),
        }
    }
}

#[cfg(feature = "docs")]
impl ExtendedInfo {
    /// Whether it is carried out, for a table.
    pub(crate) const fn kept(&self) -> &'static str {
        match self.becomes {
            Becomes::PassedOver => "left out: ",
            Becomes::Missing => "refused: ",
            _ => "",
        }
    }
}

const fn codes(name: &'static str, takes: &'static str, help: &'static str, write: Translate) -> ExtendedInfo {
    ExtendedInfo { name, takes, help, becomes: Becomes::Codes(write) }
}

const fn passed_over(name: &'static str, help: &'static str) -> ExtendedInfo {
    ExtendedInfo { name, takes: "", help, becomes: Becomes::PassedOver }
}

const fn missing(name: &'static str, help: &'static str) -> ExtendedInfo {
    ExtendedInfo { name, takes: "", help, becomes: Becomes::Missing }
}

/// Every command that is known.
pub const COMMANDS: &[ExtendedInfo] = &[
    codes("ACTIVATE_EXTRUDER", "EXTRUDER", "select an extruder, as T", activate_extruder),
    codes("BED_MESH_CALIBRATE", "", "measure the bed and level by it, as G31", |_, _, line| put(line, "G31")),
    codes("BED_MESH_CLEAR", "", "no leveling, as M370", |_, _, line| put(line, "M370")),
    codes("BED_MESH_PROFILE", "LOAD SAVE REMOVE", "the saved grid, of which there is one: M375, M374", mesh_profile),
    ExtendedInfo {
        name: "CANCEL_PRINT",
        takes: "",
        help: "end the job; heaters stay as they are",
        becomes: Becomes::Console("abort"),
    },
    passed_over("CLEAR_PAUSE", "forget a pause: nothing is kept of one that has ended"),
    codes("EXCLUDE_OBJECT", "NAME CURRENT RESET", "leave an object out; without NAME list them", exclude_object),
    codes("EXCLUDE_OBJECT_DEFINE", "NAME", "an object of the file is noted", |command, _, line| {
        label(command, "D", line)
    }),
    codes("EXCLUDE_OBJECT_END", "", "the object ends here", |_, _, line| put(line, "M486 E")),
    codes("EXCLUDE_OBJECT_START", "NAME", "an object begins here", |command, _, line| label(command, "B", line)),
    codes("PAUSE", "", "suspend the job; heaters stay on, as M600.1", |_, _, line| put(line, "M600.1")),
    codes("RESPOND", "MSG", "say a text on every console, as M118", |command, _, line| text(command, "M118", line)),
    codes("RESTORE_GCODE_STATE", "MOVE", "come back to the kept state; the last one, as M121", restore_state),
    codes("RESUME", "", "go on with the suspended job, as M601", |_, _, line| put(line, "M601")),
    codes("SAVE_GCODE_STATE", "", "keep units, distance modes, rates and coordinate system, as M120", |_, _, line| {
        put(line, "M120")
    }),
    codes("SET_DISPLAY_TEXT", "MSG", "show a text to the operator, as M117", |command, _, line| {
        text(command, "M117", line)
    }),
    codes("SET_FAN_SPEED", "FAN SPEED", "set an output; FAN is fan, or the name of a switch", fan_speed),
    codes("SET_GCODE_OFFSET", "X Y Z X_ADJUST Y_ADJUST Z_ADJUST MOVE", "shift what follows, as M290", gcode_offset),
    codes("SET_HEATER_TEMPERATURE", "HEATER TARGET", "set a heater's target", heater_temperature),
    codes("SET_INPUT_SHAPER", "SHAPER_FREQ_X SHAPER_FREQ_Y SHAPER_TYPE", "input shaping, as M593", input_shaper),
    codes("SET_PIN", "PIN VALUE", "set an output by the name of its switch", pin),
    codes("SET_PRESSURE_ADVANCE", "ADVANCE SMOOTH_TIME EXTRUDER", "pressure advance, as M900", pressure_advance),
    passed_over("SET_LED", "colour of a light"),
    passed_over("SET_PRINT_STATS_INFO", "layers, for a display"),
    codes(
        "SET_VELOCITY_LIMIT",
        "VELOCITY ACCEL ACCEL_TO_DECEL MINIMUM_CRUISE_RATIO SQUARE_CORNER_VELOCITY",
        "greatest speed, acceleration, and how corners are taken, as M203 P, M204 S and M205 V",
        velocity_limit,
    ),
    missing("SKEW_PROFILE", "the skew is that of M852"),
    codes(
        "TEMPERATURE_WAIT",
        "SENSOR MINIMUM MAXIMUM",
        "wait until a heater is within bounds, as M116",
        temperature_wait,
    ),
    passed_over("TIMELAPSE_*", "pictures are the host's"),
    codes("TURN_OFF_HEATERS", "", "every heater off, as M104 S0 and M140 S0", heaters_off),
];

/// The row of a command.
#[must_use]
pub fn find(name: &str) -> Option<&'static ExtendedInfo> {
    COMMANDS.iter().find(|row| match row.name.strip_suffix('*') {
        Some(begin) => name.get(..begin.len()).is_some_and(|start| start.eq_ignore_ascii_case(begin)),
        None => row.name.eq_ignore_ascii_case(name),
    })
}

/// What a command comes to; its codes are written into `line`, which is empty.
///
/// # Errors
/// When it is not known, or cannot be carried out.
pub fn translate(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<Asked, ExtendedFault> {
    let row = find(command.name()).ok_or(ExtendedFault::Unknown)?;
    match row.becomes {
        Becomes::Codes(write) => {
            write(command, names, line)?;
            Ok(Asked::Codes)
        }
        Becomes::Console(text) => Ok(Asked::Console(text)),
        Becomes::PassedOver => Ok(Asked::PassedOver(row.name)),
        Becomes::Missing => Err(ExtendedFault::Missing(row.help)),
    }
}

// --- pieces of a line ---

fn put(line: &mut CodeLine, text: &str) -> Result<(), ExtendedFault> {
    line.push_str(text).map_err(|_| ExtendedFault::TooLong)
}

/// A parameter that is to be a number.
fn number(command: &Extended<'_>, key: &'static str) -> Result<Option<f64>, ExtendedFault> {
    let Some(text) = command.get(key) else { return Ok(None) };
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    number.map(Some).ok_or(ExtendedFault::NotANumber(key))
}

/// Appends a word, or a code and its word.
fn put_number(line: &mut CodeLine, before: &str, value: f64) -> Result<(), ExtendedFault> {
    write!(line, "{before}{value}").map_err(|_| ExtendedFault::TooLong)
}

fn label(command: &Extended<'_>, what: &str, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    // Klipper: a definition without a name lists the objects.
    let Some(name) = command.get("NAME") else { return put(line, "M486") };
    put(line, "M486 ")?;
    put(line, what)?;
    put(line, name)
}

fn exclude_object(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let is_on = |key: &str| command.get(key).is_some_and(|value| value != "0");
    match (command.get("NAME"), is_on("RESET")) {
        (Some(name), again) => {
            put(line, if again { "M486 Y" } else { "M486 X" })?;
            put(line, name)
        }
        (None, true) => put(line, "M486 R"),
        (None, false) if is_on("CURRENT") => put(line, "M486 C"),
        (None, false) => put(line, "M486"),
    }
}

fn text(command: &Extended<'_>, code: &str, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    put(line, code)?;
    put(line, " ")?;
    // A comment would begin with it.
    let parts = command.get("MSG").unwrap_or("").split(';');
    parts.enumerate().try_for_each(|(place, part)| {
        put(line, if place == 0 { "" } else { "," })?;
        put(line, part)
    })
}

/// Which tool Klipper's `extruder`, `extruder1` and so on are.
fn tool_of(name: &str) -> Option<u8> {
    let number = name.get(..8).filter(|start| start.eq_ignore_ascii_case("extruder")).and_then(|_| name.get(8..))?;
    if number.is_empty() { Some(0) } else { number.parse().ok() }
}

// --- the commands ---

fn activate_extruder(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let name = command.get("EXTRUDER").ok_or(ExtendedFault::MustSupply("EXTRUDER"))?;
    let tool = tool_of(name).ok_or(ExtendedFault::NotANumber("EXTRUDER"))?;
    put_number(line, "T", tool.into())
}

fn mesh_profile(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let asked = [("LOAD", "M375"), ("SAVE", "M374"), ("REMOVE", "M374.1")];
    let code = asked.into_iter().find(|(key, _)| command.get(key).is_some()).map(|(_, code)| code);
    put(line, code.ok_or(ExtendedFault::MustSupply("LOAD"))?)
}

fn restore_state(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    if number(command, "MOVE")?.is_some_and(|moves| moves != 0.0) {
        return Err(ExtendedFault::Missing("MOVE=1, going back to where the state was kept"));
    }
    put(line, "M121")
}

fn fan_speed(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    output(command, names, "FAN", "SPEED", line)
}

fn pin(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    output(command, names, "PIN", "VALUE", line)
}

fn output(
    command: &Extended<'_>,
    names: &dyn Names,
    which: &'static str,
    value: &'static str,
    line: &mut CodeLine,
) -> Result<(), ExtendedFault> {
    let name = command.get(which).ok_or(ExtendedFault::MustSupply(which))?;
    let share = number(command, value)?.ok_or(ExtendedFault::MustSupply(value))?;
    let code = names.switch(name).ok_or(ExtendedFault::NoFan)?;
    write!(line, "{code} S{}", libm::round(share.clamp(0.0, 1.0) * 255.0)).map_err(|_| ExtendedFault::TooLong)
}

/// `Z=` is where the shift is to be, `Z_ADJUST=` by how much it is to change.
fn gcode_offset(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let moves = number(command, "MOVE")?.is_some_and(|moves| moves != 0.0);
    for (keys, code) in [(["X", "Y", "Z"], " M290 R0"), (["X_ADJUST", "Y_ADJUST", "Z_ADJUST"], " M290")] {
        let before = line.len();
        for (key, letter) in keys.into_iter().zip([" X", " Y", " Z"]) {
            let Some(value) = number(command, key)? else { continue };
            if line.len() == before {
                put(line, code)?;
                put(line, if moves { "" } else { " Q0" })?;
            }
            put_number(line, letter, value)?;
        }
    }
    Ok(())
}

fn heaters_off(_: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let heaters = (0..).map_while(|place| names.heater_at(place));
    heaters.into_iter().try_for_each(|(code, id)| write!(line, "{code} S0 T{id} ").map_err(|_| ExtendedFault::TooLong))
}

fn heater_temperature(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let name = command.get("HEATER").ok_or(ExtendedFault::MustSupply("HEATER"))?;
    let (code, id) = names.heater(name).ok_or(ExtendedFault::NoHeater)?;
    let target = number(command, "TARGET")?.unwrap_or(0.0);
    write!(line, "{code} S{target} T{id}").map_err(|_| ExtendedFault::TooLong)
}

fn temperature_wait(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let name = command.get("SENSOR").ok_or(ExtendedFault::MustSupply("SENSOR"))?;
    let (_, id) = names.heater(name).ok_or(ExtendedFault::NoHeater)?;
    let bounds = [(" A", number(command, "MINIMUM")?), (" B", number(command, "MAXIMUM")?)];
    if bounds.iter().all(|(_, bound)| bound.is_none()) {
        return Err(ExtendedFault::MustSupply("MINIMUM"));
    }
    put_number(line, "M116 P", id.into())?;
    bounds.into_iter().try_for_each(|(word, bound)| bound.map_or(Ok(()), |bound| put_number(line, word, bound)))
}

fn input_shaper(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    for (key, own, axis) in [("SHAPER_FREQ_X", "SHAPER_TYPE_X", "X"), ("SHAPER_FREQ_Y", "SHAPER_TYPE_Y", "Y")] {
        let Some(frequency) = number(command, key)? else { continue };
        put(line, if line.is_empty() { "M593 " } else { " M593 " })?;
        put(line, axis)?;
        put_number(line, " F", frequency)?;
        if let Some(kind) = command.get(own).or(command.get("SHAPER_TYPE")) {
            write!(line, " P\"{kind}\"").map_err(|_| ExtendedFault::TooLong)?;
        }
    }
    if line.is_empty() { put(line, "M593") } else { Ok(()) }
}

fn pressure_advance(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    put(line, "M900")?;
    if let Some(advance) = number(command, "ADVANCE")? {
        put_number(line, " K", advance)?;
    }
    if let Some(time) = number(command, "SMOOTH_TIME")? {
        put_number(line, " W", time)?;
    }
    let Some(name) = command.get("EXTRUDER") else { return Ok(()) };
    put_number(line, " P", tool_of(name).ok_or(ExtendedFault::NotANumber("EXTRUDER"))?.into())
}

fn velocity_limit(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let acceleration = number(command, "ACCEL")?;
    for (key, code) in [("VELOCITY", " M203 P"), ("ACCEL", " M204 S"), ("SQUARE_CORNER_VELOCITY", " M205 V")] {
        if let Some(value) = number(command, key)? {
            put_number(line, code, value)?;
        }
    }
    let ratio = match (number(command, "MINIMUM_CRUISE_RATIO")?, number(command, "ACCEL_TO_DECEL")?, acceleration) {
        (Some(ratio), _, _) => Some(ratio),
        // Klipper before 0.12 said it so.
        (_, Some(to_decelerate), Some(acceleration)) if acceleration > 0.0 => {
            Some((1.0 - to_decelerate / acceleration).clamp(0.0, 0.95))
        }
        _ => None,
    };
    ratio.map_or(Ok(()), |ratio| put_number(line, " M205 C", ratio))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::{String as Text, ToString};

    struct Machine;

    impl Names for Machine {
        fn switch(&self, name: &str) -> Option<Code> {
            (name == "fan").then_some(Code::m(106))
        }

        fn heater(&self, name: &str) -> Option<(Code, u8)> {
            (0..2)
                .filter_map(|place| self.heater_at(place))
                .nth(["extruder", "heater_bed"].iter().position(|n| *n == name)?)
        }

        fn heater_at(&self, place: usize) -> Option<(Code, u8)> {
            [(Code::m(104), 0), (Code::m(140), 254)].get(place).copied()
        }
    }

    fn becomes(line: &str) -> Text {
        let mut codes = CodeLine::new();
        match translate(&Extended::new(line), &Machine, &mut codes) {
            Ok(Asked::Codes) => codes.trim().into(),
            Ok(Asked::Console(command)) => command.into(),
            Ok(Asked::PassedOver(name)) => std::format!("({name})"),
            Err(fault) => fault.to_string(),
        }
    }

    #[test]
    fn commands_become_codes() {
        for (line, codes) in [
            ("SET_VELOCITY_LIMIT ACCEL=3000 ACCEL_TO_DECEL=1500", "M204 S3000 M205 C0.5"),
            ("set_velocity_limit VELOCITY=200 SQUARE_CORNER_VELOCITY=5", "M203 P200 M205 V5"),
            ("SET_VELOCITY_LIMIT", ""),
            ("SET_PRESSURE_ADVANCE ADVANCE=0.05 EXTRUDER=extruder", "M900 K0.05 P0"),
            ("SET_PRESSURE_ADVANCE EXTRUDER=extruder1 SMOOTH_TIME=0.02", "M900 W0.02 P1"),
            ("SET_GCODE_OFFSET Z=0.1 Z_ADJUST=5 X_ADJUST=-0.2", "M290 R0 Q0 Z0.1 M290 Q0 X-0.2 Z5"),
            ("SET_GCODE_OFFSET Z_ADJUST=-0.05 MOVE=1", "M290 Z-0.05"),
            ("SET_FAN_SPEED FAN=fan SPEED=0.5", "M106 S128"),
            ("SET_HEATER_TEMPERATURE HEATER=heater_bed TARGET=60", "M140 S60 T254"),
            ("TURN_OFF_HEATERS", "M104 S0 T0 M140 S0 T254"),
            ("RESPOND TYPE=command MSG=\"a;b\"", "M118 a,b"),
            ("BED_MESH_PROFILE LOAD=default", "M375"),
            ("TEMPERATURE_WAIT SENSOR=heater_bed MINIMUM=59 MAXIMUM=61", "M116 P254 A59 B61"),
            ("BED_MESH_CALIBRATE ADAPTIVE=1", "G31"),
            ("EXCLUDE_OBJECT_START NAME=cube_1", "M486 Bcube_1"),
            ("EXCLUDE_OBJECT NAME=cube_1", "M486 Xcube_1"),
            ("EXCLUDE_OBJECT NAME=cube_1 RESET=1", "M486 Ycube_1"),
            ("EXCLUDE_OBJECT CURRENT=1", "M486 C"),
            ("EXCLUDE_OBJECT RESET=1", "M486 R"),
            ("EXCLUDE_OBJECT", "M486"),
            ("SET_INPUT_SHAPER SHAPER_FREQ_X=40 SHAPER_TYPE=mzv", "M593 X F40 P\"mzv\""),
            ("TIMELAPSE_TAKE_FRAME", "(TIMELAPSE_*)"),
            ("ACTIVATE_EXTRUDER EXTRUDER=extruder2", "T2"),
            ("CANCEL_PRINT", "abort"),
        ] {
            assert_eq!(becomes(line), codes, "{line}");
        }
    }

    #[test]
    fn what_cannot_be_carried_out_says_why() {
        for (line, why) in [
            ("PRINT_START BED=60", "is not known here"),
            ("SET_VELOCITY_LIMIT ACCEL=fast", "needs a number for ACCEL="),
            ("SET_FAN_SPEED FAN=other SPEED=1", "names no switch"),
            ("SET_HEATER_TEMPERATURE HEATER=chamber TARGET=60", "names no heater"),
            ("RESTORE_GCODE_STATE NAME=x MOVE=1", "MOVE=1"),
            ("BED_MESH_PROFILE", "needs LOAD="),
            ("TEMPERATURE_WAIT SENSOR=extruder", "needs MINIMUM="),
        ] {
            assert!(becomes(line).contains(why), "{line}: {}", becomes(line));
        }
    }

    #[test]
    fn every_row_says_what_it_does_and_is_found() {
        for row in COMMANDS {
            let found = find(row.name.trim_end_matches('*')).map(|found| found.name);
            assert_eq!(found, Some(row.name));
            assert!(row.help.len() > 8 && row.help.len() <= 90 && !row.help.ends_with('.'), "{}", row.name);
        }
    }
}
