//! Klipper's commands of motors, their drivers, switches, heaters' gains, files and the firmware itself.

use core::fmt::Write as _;

use gcode::Extended;

use super::row::{Becomes, CodeLine, ExtendedFault, ExtendedInfo, Names, codes, number, passed_over, put, put_number};

pub(super) const COMMANDS: &[ExtendedInfo] = &[
    codes("BED_TILT_CALIBRATE", "", "level the bed by the plane through points, as G32", |_, _, line| put(line, "G32")),
    codes("DUMP_TMC", "STEPPER", "what a motor's driver says of itself, as M911", |command, names, line| {
        of_motor(command, names, "M911 ", line)
    }),
    console("FIRMWARE_RESTART", "start anew, as reset", "reset"),
    codes("GET_POSITION", "", "where motors, machine and program are, as M114.3, M114.2 and M114", |_, _, line| {
        put(line, "M114.3 M114.2 M114")
    }),
    codes("GET_RETRACTION", "", "the settings, those of G10 and G11 among them, as M503", |_, _, line| {
        put(line, "M503")
    }),
    console("HELP", "the commands, as help", "help"),
    passed_over("INIT_TMC", "set a driver up: M911.2 R255 does, and each start"),
    codes("PID_CALIBRATE", "HEATER TARGET", "find a heater's gains, as M303", pid_calibrate),
    codes("PROBE", "PROBE_SPEED", "search for the bed and say where it is, as G30", |command, _, line| {
        // P1: also where nist_G30 parks.
        put(line, "G30 P1")?;
        number(command, "PROBE_SPEED")?.map_or(Ok(()), |per_second| put_number(line, " F", 60.0 * per_second))
    }),
    codes("QUERY_ENDSTOPS", "", "the state of end switches and probe, as M119", |_, _, line| put(line, "M119")),
    codes("QUERY_FILAMENT_SENSOR", "", "whether the filament detector is on, as M412", |_, _, line| put(line, "M412")),
    codes("QUERY_PROBE", "", "the state of end switches and probe, as M119", |_, _, line| put(line, "M119")),
    console("RESTART", "start anew, as reset", "reset"),
    codes("SAVE_CONFIG", "", "save what was set at run time, as M500, without a restart", |_, _, line| {
        put(line, "M500")
    }),
    codes("SDCARD_PRINT_FILE", "FILENAME", "select a file and play it, as M32", |command, _, line| {
        put(line, "M32 ")?;
        put(line, command.get("FILENAME").ok_or(ExtendedFault::MustSupply("FILENAME"))?)
    }),
    console("SDCARD_RESET_FILE", "end the job and close its file, as abort", "abort"),
    codes("SET_FILAMENT_SENSOR", "SENSOR ENABLE", "filament detector on or off, as M412", |command, _, line| {
        put(line, if is_on(command, "ENABLE")? { "M412 S1" } else { "M412 S0" })
    }),
    codes(
        "SET_KINEMATIC_POSITION",
        "X Y Z CLEAR_HOMED",
        "the machine is here, and these axes count as homed, as G28.3; or they do not, as G28.5",
        kinematic_position,
    ),
    codes(
        "SET_RETRACTION",
        "RETRACT_LENGTH RETRACT_SPEED UNRETRACT_EXTRA_LENGTH UNRETRACT_SPEED",
        "how G10 retracts and G11 recovers, as M207 and M208",
        retraction,
    ),
    codes(
        "SET_STEPPER_ENABLE",
        "STEPPER ENABLE",
        "motors on, as M17, or this motor off, as M18",
        |command, names, line| {
            if is_on(command, "ENABLE")? { put(line, "M17") } else { of_motor(command, names, "M18 ", line) }
        },
    ),
    codes("SET_TMC_CURRENT", "STEPPER CURRENT", "a motor's current, RMS in A, as M906", tmc_current),
];

const fn console(name: &'static str, help: &'static str, command: &'static str) -> ExtendedInfo {
    ExtendedInfo { name, takes: "", help, becomes: Becomes::Console(command) }
}

/// Returns whether a number that must be there is another than zero.
fn is_on(command: &Extended<'_>, key: &'static str) -> Result<bool, ExtendedFault> {
    Ok(number(command, key)?.ok_or(ExtendedFault::MustSupply(key))? != 0.0)
}

/// Returns the letter of the motor that `STEPPER=` names.
fn motor(command: &Extended<'_>, names: &dyn Names) -> Result<char, ExtendedFault> {
    let name = command.get("STEPPER").ok_or(ExtendedFault::MustSupply("STEPPER"))?;
    names.motor(name.trim()).ok_or(ExtendedFault::NoMotor)
}

fn of_motor(command: &Extended<'_>, names: &dyn Names, code: &str, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    put(line, code)?;
    line.push(motor(command, names)?).map_err(|_| ExtendedFault::TooLong)
}

/// Klipper's current is RMS, a driver's here the peak, in whole milliamperes.
fn tmc_current(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let Some(amperes) = number(command, "CURRENT")? else { return of_motor(command, names, "M911 ", line) };
    of_motor(command, names, "M906 ", line)?;
    put_number(line, "", libm::round(1000.0 * amperes * core::f64::consts::SQRT_2))
}

fn pid_calibrate(command: &Extended<'_>, names: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let name = command.get("HEATER").ok_or(ExtendedFault::MustSupply("HEATER"))?;
    let target = number(command, "TARGET")?.ok_or(ExtendedFault::MustSupply("TARGET"))?;
    let (_, id) = names.heater(name.trim()).ok_or(ExtendedFault::NoHeater)?;
    write!(line, "M303 P{id} S{target}").map_err(|_| ExtendedFault::TooLong)
}

fn kinematic_position(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    const AXES: [(&str, &str, &[char]); 3] =
        [("X", " X", &['x', 'X']), ("Y", " Y", &['y', 'Y']), ("Z", " Z", &['z', 'Z'])];
    let forgotten = command.get("CLEAR_HOMED");
    let is_given = AXES.into_iter().any(|(key, ..)| command.get(key).is_some());
    if is_given || forgotten.is_none() {
        put(line, "G28.3")?;
        for (key, word, _) in AXES {
            number(command, key)?.map_or(Ok(()), |place| put_number(line, word, place))?;
        }
    }
    let Some(axes) = forgotten else { return Ok(()) };
    put(line, if is_given { " G28.5" } else { "G28.5" })?;
    // Without a word all axes would be meant.
    let named = AXES.into_iter().filter(|(_, _, letters)| axes.contains(*letters));
    if named.clone().next().is_none() {
        return Err(ExtendedFault::Missing("CLEAR_HOMED is letters of X, Y and Z"));
    }
    named.into_iter().try_for_each(|(_, word, _)| put(line, word))
}

/// Speeds are mm/s there, mm/min here.
fn retraction(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let groups = [
        ("M207", [("RETRACT_LENGTH", " S", 1.0), ("RETRACT_SPEED", " F", 60.0)]),
        ("M208", [("UNRETRACT_EXTRA_LENGTH", " S", 1.0), ("UNRETRACT_SPEED", " F", 60.0)]),
    ];
    for (code, keys) in groups {
        if keys.into_iter().all(|(key, ..)| command.get(key).is_none()) {
            continue;
        }
        put(line, if line.is_empty() { "" } else { " " })?;
        put(line, code)?;
        for (key, word, scale) in keys {
            number(command, key)?.map_or(Ok(()), |value| put_number(line, word, scale * value))?;
        }
    }
    Ok(())
}
