//! Klipper's commands of jobs, moves, heat and outputs.

use core::fmt::Write as _;

use gcode::Extended;

use super::outline;
use super::row::{
    Becomes, CodeLine, ExtendedFault, ExtendedInfo, NamedSwitch, Names, codes, label, number, passed_over, put,
    put_number,
};

pub(super) const COMMANDS: &[ExtendedInfo] = &[
    codes("ACTIVATE_EXTRUDER", "EXTRUDER", "select an extruder, as T", activate_extruder),
    ExtendedInfo {
        name: "CANCEL_PRINT",
        takes: "",
        help: "end the job; heaters stay as they are",
        becomes: Becomes::Console("abort"),
    },
    passed_over("CLEAR_PAUSE", "forget a pause: nothing is kept of one that has ended"),
    codes("DISABLE_FILAMENT_WIDTH_LOG", "", "the filament's width is not said, as M407.2 S0", |_, _, line| {
        put(line, "M407.2 S0")
    }),
    codes("DISABLE_FILAMENT_WIDTH_SENSOR", "", "sensor of the filament's width off, as M405.1", |_, _, line| {
        put(line, "M405.1")
    }),
    codes("ENABLE_FILAMENT_WIDTH_LOG", "", "the filament's width is said, as M407.2 S1", |_, _, line| {
        put(line, "M407.2 S1")
    }),
    codes("ENABLE_FILAMENT_WIDTH_SENSOR", "", "sensor of the filament's width on, as M406.1", |_, _, line| {
        put(line, "M406.1")
    }),
    codes("EXCLUDE_OBJECT", "NAME CURRENT RESET", "leave an object out; without NAME list them", exclude_object),
    codes("EXCLUDE_OBJECT_DEFINE", "NAME POLYGON", "an object of the file is noted, with its outline", outline::define),
    codes("EXCLUDE_OBJECT_END", "", "the object ends here", |_, _, line| put(line, "M486 E")),
    codes("EXCLUDE_OBJECT_START", "NAME", "an object begins here", |command, _, line| label(command, "B", line)),
    codes("PAUSE", "", "suspend the job; heaters stay on, as M600.1", |_, _, line| put(line, "M600.1")),
    codes("QUERY_FILAMENT_WIDTH", "", "the filament's width, as M407", |_, _, line| put(line, "M407")),
    codes("QUERY_RAW_FILAMENT_WIDTH", "", "what the sensor of the filament's width reads, as M407.1", |_, _, line| {
        put(line, "M407.1")
    }),
    codes("RESET_FILAMENT_WIDTH_SENSOR", "", "forget what was measured of the filament, as M404.1", |_, _, line| {
        put(line, "M404.1")
    }),
    codes("RESPOND", "MSG TYPE PREFIX", "say a text on every console, as M118", respond),
    codes("RESTORE_GCODE_STATE", "NAME MOVE MOVE_SPEED", "come back to the state kept by this name", |_, _, line| {
        put(line, "M121")
    }),
    codes("RESUME", "", "go on with the suspended job, as M602", |_, _, line| put(line, "M602")),
    // The machine and looks ahead keep states by their names, and never come here.
    codes(
        "SAVE_GCODE_STATE",
        "NAME",
        "keep units, distance modes, rates and coordinate system by a name",
        |_, _, line| put(line, "M120"),
    ),
    codes("SET_DISPLAY_TEXT", "MSG", "show a text to the operator, as M117", |command, _, line| {
        text(command, "M117", line)
    }),
    codes("SET_FAN_SPEED", "FAN SPEED", "set an output; FAN is fan, or the name of a switch", fan_speed),
    codes("SET_GCODE_OFFSET", "X Y Z X_ADJUST Y_ADJUST Z_ADJUST MOVE", "shift what follows, as M290", gcode_offset),
    codes("SET_HEATER_TEMPERATURE", "HEATER TARGET", "set a heater's target", heater_temperature),
    codes("SET_INPUT_SHAPER", "SHAPER_FREQ_X SHAPER_FREQ_Y SHAPER_TYPE", "input shaping, as M593", input_shaper),
    codes("SET_PIN", "PIN VALUE", "set an output by the name of its switch", pin),
    ExtendedInfo {
        name: "SET_PAUSE_NEXT_LAYER",
        takes: "",
        help: "suspend the job when the next layer begins, as pause next layer",
        becomes: Becomes::Console("pause next layer"),
    },
    codes("SET_PRESSURE_ADVANCE", "ADVANCE SMOOTH_TIME EXTRUDER", "pressure advance, as M900", pressure_advance),
    codes(
        "SET_LED",
        "LED RED GREEN BLUE WHITE INDEX TRANSMIT SYNC",
        "colour of a strip by its name, or of one light of it, as M150",
        set_led,
    ),
    passed_over("SET_LED_TEMPLATE", "a colour that a template works out: write shows = state in [led strip]"),
    passed_over("SET_PRINT_STATS_INFO", "layers, for a display"),
    codes("SET_SERVO", "SERVO ANGLE WIDTH", "turn a servo that is described, by the name of its switch", servo),
    codes(
        "SET_VELOCITY_LIMIT",
        "VELOCITY ACCEL ACCEL_TO_DECEL MINIMUM_CRUISE_RATIO SQUARE_CORNER_VELOCITY",
        "greatest speed, acceleration, and how corners are taken, as M203 P, M204 S and M205 V",
        velocity_limit,
    ),
    codes(
        "TEMPERATURE_WAIT",
        "SENSOR MINIMUM MAXIMUM",
        "wait until a heater is within bounds, as M116",
        temperature_wait,
    ),
    passed_over("TIMELAPSE_*", "pictures are the host's"),
    ExtendedInfo {
        name: "TUNING_TOWER",
        takes: "COMMAND PARAMETER START FACTOR BAND STEP_DELTA STEP_HEIGHT SKIP",
        help: "in the next job, a setting changes with the height of the part",
        becomes: Becomes::Tower,
    },
    codes("TURN_OFF_HEATERS", "", "every heater off, as M104 S0 and M140 S0", heaters_off),
];

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
    message(command, line)
}

fn message(command: &Extended<'_>, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    // A semicolon would begin a comment.
    let parts = command.get("MSG").unwrap_or("").split(';');
    parts.enumerate().try_for_each(|(place, part)| {
        put(line, if place == 0 { "" } else { "," })?;
        put(line, part)
    })
}

/// Says a text behind the beginning that its kind has, which hosts go by: `//` for what they do.
fn respond(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    const KINDS: [(&str, &str); 4] =
        [("echo", "echo: "), ("echo_no_space", "echo:"), ("command", "// "), ("error", "!! ")];
    let kind = command.get("TYPE").unwrap_or("echo");
    let known = KINDS.into_iter().find(|(known, _)| known.eq_ignore_ascii_case(kind));
    let (_, begins) = known.ok_or(ExtendedFault::Missing("TYPE is echo, echo_no_space, command or error"))?;
    put(line, "M118 ")?;
    match command.get("PREFIX") {
        Some(prefix) => [prefix, " "].into_iter().try_for_each(|part| put(line, part))?,
        None => put(line, begins)?,
    }
    message(command, line)
}

/// Returns the tool number of Klipper's `extruder`, `extruder1` and so on.
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
    let NamedSwitch { on, number: place, off, full } = names.switch(name).ok_or(ExtendedFault::NoFan)?;
    // Resolution is a tenth of a percent, or a whole step of 255.
    let fine = if full <= 100.0 { 10.0 } else { 1.0 };
    // A plain on/off switch takes any S for on.
    let value = libm::round(units::within(share, 0.0, 1.0) * full * fine) / fine;
    let written = match (off.filter(|_| share <= 0.0), place) {
        (Some(off), _) => write!(line, "{off}"),
        (None, Some(place)) => write!(line, "{on} P{place} S{value}"),
        (None, None) => write!(line, "{on} S{value}"),
    };
    written.map_err(|_| ExtendedFault::TooLong)
}

/// Translates `ANGLE=` in degrees or `WIDTH=` in seconds to the S of a servo's switch.
fn servo(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let name = command.get("SERVO").ok_or(ExtendedFault::MustSupply("SERVO"))?;
    let NamedSwitch { on, number: place, .. } = names.switch(name).ok_or(ExtendedFault::NoFan)?;
    let code = match place {
        Some(place) => write!(line, "{on} P{place}"),
        None => write!(line, "{on}"),
    };
    code.map_err(|_| ExtendedFault::TooLong)?;
    let written = match (number(command, "ANGLE")?, number(command, "WIDTH")?) {
        (Some(angle), _) => write!(line, " S{angle}"),
        (None, Some(width)) => write!(line, " S{}", libm::round(width * 1e6)),
        (None, None) => return Err(ExtendedFault::MustSupply("ANGLE")),
    };
    written.map_err(|_| ExtendedFault::TooLong)
}

/// Translates shares of full brightness, and the place of a light from 1 on. A machine without strips ignores
/// M150, whatever name is given.
fn set_led(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let name = command.get("LED").ok_or(ExtendedFault::MustSupply("LED"))?;
    put(line, "M150")?;
    if !names.has_strips() {
        return Ok(());
    }
    put_number(line, " S", names.strip(name).ok_or(ExtendedFault::NoStrip)?.into())?;
    for (key, letter) in [("RED", " R"), ("GREEN", " U"), ("BLUE", " B"), ("WHITE", " W")] {
        let share = number(command, key)?.unwrap_or(0.0);
        put_number(line, letter, libm::round(units::within(share, 0.0, 1.0) * 255.0))?;
    }
    if let Some(place) = number(command, "INDEX")? {
        put_number(line, " I", place - 1.0)?;
    }
    for (key, word) in [("TRANSMIT", " T0"), ("SYNC", " Q0")] {
        if number(command, key)? == Some(0.0) {
            put(line, word)?;
        }
    }
    Ok(())
}

/// Translates `Z=`, the absolute shift, and `Z_ADJUST=`, the change of the shift.
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
        // Klipper before 0.12 gave the ratio by `ACCEL_TO_DECEL`.
        (_, Some(to_decelerate), Some(acceleration)) if acceleration > 0.0 => {
            Some(units::within(1.0 - to_decelerate / acceleration, 0.0, 0.95))
        }
        _ => None,
    };
    ratio.map_or(Ok(()), |ratio| put_number(line, " M205 C", ratio))
}
