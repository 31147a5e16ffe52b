//! Random lines as people and programs write them, from the tables of the firmware: codes with their words
//! and bounds, console commands with their arguments, settings. Wrong lines are among them.

use std::fmt::Write;

use config::schema::{Form, SECTIONS};
use gcode::{Letter, checksum_of};
use program::codes::{self, Bounds, CodeInfo, Unit};
use program::commands::COMMANDS;
use program::extended;

use crate::dice::Dice;

/// Names of files and folders: some on the card of the console's machine, some not.
pub const FILES: &[&str] = &[
    "part.g",
    "/sd/part.g",
    "other.g",
    "/sd",
    "/",
    "config.ini",
    "/sd/config-override",
    "none.g",
    "sub",
    "a b",
    "..",
    "",
];
/// Realtime bytes, which act at once.
pub const REALTIME: &[&[u8]] =
    &[b"?", b"!", b"~", b"\x18", b"\x19", b"\x84", b"\x85", b"!~", b"!\x18", b"\x08", b"\x7f"];
/// Codes that the configurations give a meaning to, and some without any.
const CLAIMED: &[&str] = &[
    "M3", "M4", "M5", "M8", "M9", "M104", "M106", "M107", "M109", "M140", "M190", "M105", "M42", "G6", "M9999", "G200",
];
/// Pieces of text that break lines.
const NOISE: &[&str] = &[
    "*",
    "**1",
    "(",
    ")",
    "(a)",
    ";",
    ";*",
    "%",
    "/",
    "N",
    "N-1",
    "N2147483647",
    "G",
    "M",
    "T",
    "G1.",
    "G1.256",
    "X",
    "X.",
    "X-",
    "X..1",
    "#1=2",
    "#1=[#1+1]",
    "#31=[#1/#2]",
    "#<name>=[SIN[#1]**2]",
    "#5221=-1",
    "#5220=2",
    "[1]",
    "[#1 LT 3]",
    "(PRINT,#1)",
    "(MSG,a)",
    "O100",
    "O1 sub",
    "O1 endsub [#1]",
    "O1 call [#1] [2]",
    "O1 return",
    "O2 if [#1 LT 3]",
    "O2 elseif [1]",
    "O2 else",
    "O2 endif",
    "O3 while [#1 LT 9]",
    "O3 endwhile",
    "O3 break",
    "O3 continue",
    "O4 do",
    "O4 while [0]",
    "O5 repeat [3]",
    "O5 endrepeat",
    "M98 P1",
    "M99",
    "\u{b5}",
    "\t",
    " ",
    "\"",
    "=",
    "@",
    "$",
    "$J",
    "-h",
    "M117 ",
    "M28 x.g",
    "M29",
    "M110 N0",
];
/// Numbers near which behaviour changes.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "5",
    "10",
    "-10",
    "0.1",
    "0.001",
    "0.00000001",
    "255",
    "256",
    "127",
    "1000",
    "65535",
    "65536",
    "-2147483648",
    "4294967296",
    "1000000",
    "999999999999999999999",
    "-99999",
    "3.4028236",
    "25.4",
    "6000",
    "300",
    "60000",
];

/// Returns a number mostly within the bounds; sometimes near or beyond them.
pub fn number(dice: &mut Dice, bounds: Bounds, unit: Unit) -> String {
    if dice.once_in(12) {
        return (*dice.pick(NUMBERS)).to_owned();
    }
    let share = dice.below(1001) as f64 / 1000.0;
    let span = |least: f64, most: f64| least + share * (most - least);
    match bounds {
        Bounds::Whole(least, most) => format!("{}", span(least, most.min(least + 12.0)).round()),
        Bounds::Within(least, most) => format!("{:.3}", span(least, most)),
        Bounds::AtLeast(least) => format!("{:.3}", span(least, least + size(unit))),
        Bounds::Above(least) => format!("{:.3}", span(least, least + size(unit)) + 0.001),
        Bounds::Any if matches!(unit, Unit::Number | Unit::Id) => (*dice.pick(NUMBERS)).to_owned(),
        Bounds::Any => format!("{:.3}", span(-0.4, 1.0) * size(unit)),
    }
}

/// Returns a usual size of numbers of this unit.
const fn size(unit: Unit) -> f64 {
    match unit {
        Unit::Length | Unit::Mm | Unit::Number => 30.0,
        Unit::Feed | Unit::MmPerMinute => 9_000.0,
        Unit::MmPerSecond => 120.0,
        Unit::MmPerSecond2 => 4_000.0,
        Unit::Milliseconds | Unit::Dwell => 300.0,
        Unit::Seconds | Unit::Amps => 2.0,
        Unit::Celsius | Unit::Percent | Unit::StepsPerLength => 200.0,
        Unit::Milliamps => 2_000.0,
        Unit::Id | Unit::Flag => 3.0,
    }
}

/// Returns a code with some of its words.
pub fn code(dice: &mut Dice) -> String {
    let rows: Vec<&CodeInfo> = codes::all().collect();
    if dice.once_in(8) {
        let mut line = (*dice.pick(CLAIMED)).to_owned();
        if dice.once_in(2) {
            let _ = write!(line, " S{}", dice.below(300));
        }
        return line;
    }
    let row = *dice.pick(&rows);
    let mut line = match row.code.letter {
        Letter::T => format!("T{}", dice.below(4)),
        _ => row.code.to_string(),
    };
    if row.any_subcode && dice.once_in(3) {
        let _ = write!(line, ".{}", dice.below(10));
    }
    for word in row.words {
        if dice.once_in(2) {
            let _ = write!(line, " {}", word.letter());
            if word.unit != Unit::Flag || dice.once_in(4) {
                line.push_str(&number(dice, *word.bounds, word.unit));
            }
        }
    }
    if dice.once_in(20) {
        let _ = write!(line, " {}{}", (b'A' + dice.below(26) as u8) as char, dice.pick(NUMBERS));
    }
    if dice.once_in(6) {
        let _ = write!(line, " {}", dice.pick(FILES));
    }
    line
}

/// Returns a move, the part of most machines with the most to go wrong.
pub fn motion(dice: &mut Dice) -> String {
    let mut line = (*dice
        .pick(&["G0", "G1", "G1", "G1", "G2", "G3", "", "G91 G1", "G90 G1", "G5", "G5.1", "$J", "G53 G0"]))
    .to_owned();
    for letter in ["X", "Y", "Z", "E", "I", "J", "K", "R", "P", "Q", "F", "A"] {
        let often = match letter {
            "X" | "Y" => 2,
            "Z" | "F" | "E" => 4,
            "I" | "J" if line.starts_with("G2") || line.starts_with("G3") || line.starts_with("G5") => 2,
            _ => 14,
        };
        if dice.once_in(often) {
            let unit = if letter == "F" { Unit::Feed } else { Unit::Length };
            let _ = write!(line, " {letter}{}", number(dice, Bounds::Any, unit));
        }
    }
    line
}

/// Returns a console command with its arguments.
pub fn command(dice: &mut Dice) -> String {
    let info = dice.pick(COMMANDS);
    let mut line = info.word.to_owned();
    let takes: Vec<&str> = info.takes.split(|c: char| " []|".contains(c)).filter(|word| !word.is_empty()).collect();
    for word in takes {
        if dice.once_in(3) {
            continue;
        }
        let argument = match word {
            "file" | "folder" | "from" | "to" | "..." => (*dice.pick(FILES)).to_owned(),
            "axis" => (*dice.pick(&["X1", "Y-1", "Z0.5", "E1", "X", "A1"])).to_owned(),
            "\"section\"" => format!("\"{}\"", dice.pick(SECTIONS).name),
            "key" => setting(dice),
            "value" | "text" | "rate" | "scale" => (*dice.pick(NUMBERS)).to_owned(),
            "words" => format!("F{}", dice.below(500)),
            other => other.to_owned(),
        };
        let _ = write!(line, " {argument}");
    }
    line
}

/// Returns the key of a setting, with an instance's name if there are instances.
fn setting(dice: &mut Dice) -> String {
    let section = dice.pick(SECTIONS);
    let key = section.settings.get(dice.below(section.settings.len())).map_or("key", |setting| setting.key);
    match section.form {
        Form::Plain => key.to_owned(),
        _ => format!("{}.{key}", dice.pick(&["alpha", "hotend", "fan", "minx", "common", "x"])),
    }
}

/// Returns the text as a line with a number and a checksum, right or not.
fn numbered(dice: &mut Dice, text: &str) -> String {
    let line = format!("N{} {text}", dice.below(4));
    let sum = checksum_of(line.as_bytes()) ^ u8::from(dice.once_in(4));
    format!("{line}*{sum}")
}

/// Returns a command by name, with its words and numbers or names for them.
fn named(dice: &mut Dice) -> String {
    let rows: Vec<_> = extended::all().collect();
    let row = dice.pick(&rows);
    let mut line = row.name.replace('*', "X");
    for key in row.takes.split_whitespace().filter(|_| !dice.once_in(4)).collect::<Vec<_>>() {
        let value = if dice.once_in(4) { "extruder" } else { dice.pick(NUMBERS) };
        let _ = write!(line, " {key}={value}");
    }
    line
}

/// Returns a piece of a line.
pub fn token(dice: &mut Dice) -> Vec<u8> {
    match dice.below(6) {
        0 => dice.pick(REALTIME).to_vec(),
        1 => dice.pick(NOISE).as_bytes().to_vec(),
        2 => code(dice).into_bytes(),
        3 => format!(" {}{}", dice.pick(&["X", "Y", "Z", "E", "F", "S", "P", "I", "J", "L", "R"]), dice.pick(NUMBERS))
            .into_bytes(),
        4 => dice.pick(NUMBERS).as_bytes().to_vec(),
        _ => dice.pick(FILES).as_bytes().to_vec(),
    }
}

/// Returns a line of any kind, without its end. `directions`: those that the target understands.
pub fn line(dice: &mut Dice, directions: &[&str]) -> Vec<u8> {
    let text = match dice.below(16) {
        0..=3 => motion(dice),
        4..=8 => code(dice),
        9 => command(dice),
        10 if !directions.is_empty() => (*dice.pick(directions)).to_owned(),
        11 if !directions.is_empty() => (*dice.pick(directions)).to_owned(),
        12 => return dice.pick(REALTIME).to_vec(),
        13 => {
            let text = code(dice);
            numbered(dice, &text)
        }
        14 if dice.once_in(2) => named(dice),
        14 => format!("{}{}", code(dice), motion(dice)),
        _ => {
            let mut bytes = Vec::new();
            for _ in 0..=dice.below(4) {
                bytes.extend(token(dice));
            }
            return bytes;
        }
    };
    text.into_bytes()
}

/// Returns a whole input of at most `lines` lines.
pub fn input(dice: &mut Dice, directions: &[&str], lines: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for _ in 0..=dice.below(lines) {
        bytes.extend(line(dice, directions));
        bytes.push(if dice.once_in(40) { b'\r' } else { b'\n' });
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use gcode::{Decoder, Line};

    #[test]
    fn every_code_and_command_is_written_and_most_lines_are_sound() {
        let mut dice = Dice::new(1);
        let (mut codes_seen, mut commands_seen) =
            (std::collections::BTreeSet::new(), std::collections::BTreeSet::new());
        let (mut sound, all) = (0, 20_000);
        for _ in 0..all {
            let line = code(&mut dice);
            if let Ok(Line::Code(mut blocks)) = Decoder::new().decode(line.as_bytes())
                && let Some(Ok(block)) = blocks.next()
            {
                sound += 1;
                codes_seen.extend(block.code.map(|code| code.to_string()));
            }
            let line = command(&mut dice);
            commands_seen.extend(line.split(' ').next().map(str::to_owned));
        }
        for row in codes::all().filter(|row| row.code.letter != Letter::T) {
            assert!(codes_seen.contains(&row.code.to_string()), "{} is never written", row.code);
        }
        assert!(COMMANDS.iter().all(|command| commands_seen.contains(command.word)), "{commands_seen:?}");
        // Codes whose words all need numbers do not take the name of a file.
        assert!(sound > all * 8 / 10, "{sound} of {all}");
    }
}
