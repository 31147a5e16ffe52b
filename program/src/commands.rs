//! The table of console commands: name, arguments and help text. `help`, `-h` and the documentation use the
//! table.

use crate::state::States;

/// Row of a console command.
#[derive(Clone, Copy, Debug)]
pub struct CommandInfo {
    /// Word that calls the command.
    pub word: &'static str,
    /// Arguments that may follow; empty for none.
    pub takes: &'static str,
    /// Help text of one line.
    pub help: &'static str,
    /// States in which the command runs.
    pub states: States,
    /// Whether the command is a question, answered whatever the machine waits for.
    pub question: bool,
}

const fn command(word: &'static str, takes: &'static str, help: &'static str) -> CommandInfo {
    CommandInfo { word, takes, help, states: States::ALL, question: false }
}

impl CommandInfo {
    const fn working(mut self) -> Self {
        self.states = States::WORKING;
        self
    }

    const fn question(mut self) -> Self {
        self.question = true;
        self
    }
}

/// All commands, in the order in which `help` lists them.
pub const COMMANDS: &[CommandInfo] = &[
    command("help", "[command or code]", "list the commands; with one, say what it does").question(),
    command("version", "", "firmware, board and clock").question(),
    command("mem", "", "memory in use, and how long reading the configuration took").question(),
    command("modules", "", "the parts that the configuration switches on").question(),
    command("date", "[YYMMDDhhmmss]", "say or set date and time"),
    command("ls", "[-1] [folder]", "list files with marks, dates and sizes; -1: names only"),
    command("cd", "[folder]", "change the current folder; without one, to the card"),
    command("cat", "[-d] file [lines]", "show a file, or its first lines; -d: in five seconds, with Ctrl-Z at its end"),
    command("rm", "file ...", "delete files, or empty folders; quote names with blanks"),
    command("mv", "from to", "rename or move"),
    command("mkdir", "folder", "make a folder"),
    command("cp", "from to", "copy a file"),
    command("truncate", "file bytes", "keep the beginning of a file"),
    command("md5sum", "file ...", "MD5 sums of files"),
    command("card", "", "what the SD card is, how fast its bus is, what it has done, and how much of it is free"),
    command("ed", "from to", "edit a file line by line into another one: %h lists commands, %c ends it"),
    command("ry", "[silent]", "receive files by YModem; silent: say nothing beside"),
    command("upload", "file", "what is sent is the file, up to Ctrl-D or Ctrl-Z; Ctrl-X cancels"),
    command("dl", "file bytes", "what is sent is the file, so many bytes, whatever they are; over USB or the network"),
    command("check", "file", "look through a file: what it asks of the machine, and how long it takes; nothing moves"),
    command("play", "file [-v] [-p] [-t] [-f dialect] [--from line|layer|byte N] [--force]", "play a file, or the rest of it: show its lines, begin paused, tell its end; --force: whatever a look at it says")
        .working(),
    command("progress", "[-b]", "how far the file being played is; -b: in bytes").question(),
    command("abort", "", "stop the file being played; heaters stay as they are"),
    command("pause", "[at layer|line|height N [command] | next layer | list | clear]", "suspend the job, heaters on: now, or there")
        .working(),
    command("queue", "[add file [times] | next | remove place | clear]", "files to be played one after the other"),
    command("suspend", "[h]", "pause the job so that filament can be changed; h: heaters stay on").working(),
    command("resume", "", "go on with the suspended job").working(),
    command(
        "get",
        "pos|wcs|state|mode|status|steps|temp [name|chip]|volts [name]|fk x,y,z|ik x,y,z",
        "say what is; fk, ik: where motors put the tool, and where they stand for it",
    )
    .question(),
    command("config-get", "\"section\"", "show a section of config.ini"),
    command(
        "config-set",
        "\"section\" key [=] [value]",
        "change a setting, or delete it; takes effect at the next reset",
    ),
    command("config-load", "file", "replay saved settings").working(),
    command("load", "file", "replay saved settings").working(),
    command("preheat", "[name|off]", "set every heater that has a preset of this name; without one, list them").working(),
    command("switch", "[name [on|off|value]]", "list switches, look at one, or set it"),
    command("thermistors", "", "sensors that are known by name").question(),
    command("calc_thermistor", "T1,R1,T2,R2,T3,R3", "coefficients of a sensor from three points").question(),
    command("setregs", "motor r1,r2,r3,r4,r5", "write all registers of a motor's driver, in hexadecimal"),
    command(
        "test",
        "jog axis distance times | square size times | circle radius times [feed] | raw axis steps rate | acc axis mm rate | endstop axis [times] | speed axis mm rate [times] | sweep axis Hz Hz [s] | backlash axis mm",
        "move back and forth, squares or circles, so many steps of one motor; how well an axis homes, whether it loses steps, where it rings, its backlash",
    )
    .working(),
    command("tune_driver", "axis [mm/s ...]", "measure which stallGuard threshold a motor is to have: its axis moves over its travel")
        .working(),
    command("gpio", "pin [in | out on|off [ms]]", "look at a pin that nothing uses, or drive it for a while").working(),
    command("break", "", "stop for a debugger; without one, the last events"),
    command("events", "[count|all]", "what happened lately, before the last reset too, oldest first").question(),
    command("flash", "", "install the firmware in /sd/flashme.bin; this one is kept as firmware.previous"),
    command("dfu", "", "restart the board to wait for firmware over USB (dfu-util)"),
    command("reset", "", "restart the board in a second"),
    command("msc", "[off]", "let the computer at the USB socket have the SD card as a disk, until it ejects it; off: take it back"),
    command("dialect", "[smoothie|marlin|reprapfirmware|klipper]", "what this console speaks, until the next reset"),
    command("echo", "[-n] [-1] text", "say it; -n: without a line end; -1: to the auxiliary UART").question(),
    command("$G", "", "the modal state").question(),
    command("$#", "[-v]", "offsets and the last probe").question(),
    command("$H", "", "home").working(),
    command("$X", "", "clear a halt").question(),
    command("$I", "", "the modal state, without ok").question(),
    command("$S", "[name ...]", "switches, without ok").question(),
    command("$J", "[-c] axis distance ... [S scale | F rate]", "jog; -c: until Ctrl-Y").working(),
    command("$P", "[words]", "probe as G30 does").working(),
    command("$C", "", "check mode on or off: programs are read and nothing is carried out"),
    command("$SLP", "", "sleep: everything off until Ctrl-X or a reset"),
];

/// Commands of Smoothieware v2 whose part of the machine is missing so far, with that part or a substitute.
const LATER: &[(&str, &str)] = &[
    ("fire", "the laser (not there yet)"),
    ("net", "the network (not there yet)"),
    ("ntp", "the network (not there yet)"),
    ("qspi", "the QSPI flash (not there yet)"),
    ("rpm", "a spindle's encoder (not there yet)"),
    ("update", "the network (not there yet)"),
    ("wget", "the network (not there yet)"),
];

/// Returns the missing part of the machine that an unsupported command waits for.
#[must_use]
pub fn waits_for(word: &str) -> Option<&'static str> {
    LATER.iter().find(|(name, _)| *name == word).map(|(_, part)| *part)
}

/// Returns the row of a command word.
#[must_use]
pub fn find(word: &str) -> Option<&'static CommandInfo> {
    COMMANDS.iter().find(|command| command.word == word)
}

/// Whether these arguments ask for the command's help text.
#[must_use]
pub fn asks_for_help(arguments: &str) -> bool {
    arguments.trim() == "-h"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_says_what_it_does_on_one_line() {
        for command in COMMANDS {
            let help = command.help;
            assert!(help.len() > 3 && !help.contains('\n') && !help.ends_with('.'), "{}: {help}", command.word);
            assert_eq!(find(command.word).map(|found| found.help), Some(help), "{} stands there twice", command.word);
        }
    }

    #[test]
    fn only_a_lone_option_asks_for_help() {
        assert!(asks_for_help("-h") && asks_for_help("  -h "));
        assert!(!asks_for_help("") && !asks_for_help("-h file") && !asks_for_help("-help"));
    }
}
