//! The table of console commands: name, arguments and help text. `help`, `-h` and the documentation use the
//! table.

use crate::states::States;

/// What a console command asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the help texts of the rows say what each does")]
pub enum Command {
    Ask(Question),
    File(FileCommand),
    Date,
    Check,
    Play,
    Abort,
    Pause,
    Queue,
    Suspend,
    Resume,
    LoadSettings,
    Preheat,
    Switch,
    SetRegisters,
    Test,
    TuneDriver,
    Gpio,
    Break,
    Flash,
    Dfu,
    Reset,
    LendCard,
    Dialect,
    Home,
    Jog,
    Probe,
    CheckMode,
    Sleep,
    Password,
    Fire,
    Macros,
}

/// Questions, answered whatever the machine waits for; `$X` is none, and must work at any time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the help texts of the rows say what each does")]
pub enum Question {
    Help,
    Version,
    Memory,
    Modules,
    Thermistors,
    CalculateThermistor,
    Modes,
    ModesWithoutOk,
    Offsets,
    Switches,
    Get,
    Progress,
    Events,
    Echo,
    Unlock,
    Network,
}

/// What a command does with files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the help texts of the rows say what each does")]
pub enum FileCommand {
    List,
    Show,
    ShowSection,
    Delete,
    Move,
    MakeFolder,
    ChangeFolder,
    Copy,
    Truncate,
    Md5Sum,
    Card,
    Edit,
    ReceiveByYmodem,
    Receive,
    ReceiveCounted,
    SetSetting,
}

/// Row of a console command.
#[derive(Clone, Copy, Debug)]
pub struct CommandInfo {
    /// Word that calls the command.
    pub word: &'static str,
    /// What the command asks for.
    pub does: Command,
    /// Arguments that may follow; empty for none.
    pub takes: &'static str,
    /// Help text of one line.
    pub help: &'static str,
    /// States in which the command runs.
    pub states: States,
    /// Whether the command reads or changes files, so that the card must be at rest before it.
    pub needs_card: bool,
    /// Whether the command moves or heats: check mode (`$C`) only reads it.
    pub acts: bool,
    /// Whether only the machine's owner may: the command changes files, settings or firmware.
    pub is_for_owner: bool,
}

const fn command(word: &'static str, does: Command, takes: &'static str, help: &'static str) -> CommandInfo {
    CommandInfo { word, does, takes, help, states: States::ALL, needs_card: false, acts: false, is_for_owner: false }
}

impl CommandInfo {
    const fn working(mut self) -> Self {
        self.states = States::WORKING;
        self
    }

    const fn card(mut self) -> Self {
        self.needs_card = true;
        self
    }

    const fn acts(mut self) -> Self {
        self.acts = true;
        self
    }

    const fn for_owner(mut self) -> Self {
        self.is_for_owner = true;
        self
    }
}

/// All commands, in the order in which `help` lists them.
pub const COMMANDS: &[CommandInfo] = &[
    command("help", Command::Ask(Question::Help), "[command or code]", "list the commands; with one, say what it does"),
    command("version", Command::Ask(Question::Version), "", "firmware, board and clock"),
    command("mem", Command::Ask(Question::Memory), "", "memory in use, and how long reading the configuration took"),
    command("modules", Command::Ask(Question::Modules), "", "the parts that the configuration switches on"),
    command("date", Command::Date, "[YYMMDDhhmmss]", "say or set date and time"),
    command("ls", Command::File(FileCommand::List), "[-1] [folder]", "list files with marks, dates and sizes; -1: names only"),
    command("cd", Command::File(FileCommand::ChangeFolder), "[folder]", "change the current folder; without one, to the card").card(),
    command("cat", Command::File(FileCommand::Show), "[-d] file [lines]", "show a file, or its first lines; -d: in five seconds, with Ctrl-Z at its end").card(),
    command("rm", Command::File(FileCommand::Delete), "file ...", "delete files, or empty folders; quote names with blanks").card().for_owner(),
    command("mv", Command::File(FileCommand::Move), "from to", "rename or move").card().for_owner(),
    command("mkdir", Command::File(FileCommand::MakeFolder), "folder", "make a folder").card().for_owner(),
    command("cp", Command::File(FileCommand::Copy), "from to", "copy a file").card().for_owner(),
    command("truncate", Command::File(FileCommand::Truncate), "file bytes", "keep the beginning of a file").card().for_owner(),
    command("md5sum", Command::File(FileCommand::Md5Sum), "file ...", "MD5 sums of files").card(),
    command("card", Command::File(FileCommand::Card), "", "what the SD card is, how fast its bus is, what it has done, and how much of it is free").card(),
    command("ed", Command::File(FileCommand::Edit), "from to", "edit a file line by line into another one: %h lists commands, %c ends it").card().for_owner(),
    command("ry", Command::File(FileCommand::ReceiveByYmodem), "[silent]", "receive files by YModem; silent: say nothing beside").for_owner(),
    command("upload", Command::File(FileCommand::Receive), "file", "what is sent is the file, up to Ctrl-D or Ctrl-Z; Ctrl-X cancels").card().for_owner(),
    command("dl", Command::File(FileCommand::ReceiveCounted), "file bytes", "what is sent is the file, so many bytes, whatever they are; over USB or the network").for_owner(),
    command("check", Command::Check, "file", "look through a file: what it asks of the machine, and how long it takes; nothing moves").card(),
    command("play", Command::Play, "file [-v] [-p] [-t] [-f dialect] [--from line|layer|byte N] [--force]", "play a file, or the rest of it: show its lines, begin paused, tell its end; --force: whatever a look at it says")
        .working().card(),
    command("progress", Command::Ask(Question::Progress), "[-b]", "how far the file being played is; -b: in bytes"),
    command("abort", Command::Abort, "", "stop the file being played; heaters stay as they are").card(),
    command("pause", Command::Pause, "[at layer|line|height N [command] | next layer | list | clear]", "suspend the job, heaters on: now, or there")
        .working().acts(),
    command("queue", Command::Queue, "[add file [times] | next | remove place | clear]", "files to be played one after the other").card(),
    command("suspend", Command::Suspend, "[h]", "pause the job so that filament can be changed; h: heaters stay on").working().acts(),
    command("resume", Command::Resume, "", "go on with the suspended job").working().acts(),
    command(
        "get", Command::Ask(Question::Get),
        "pos|wcs|state|mode|status|steps|temp [name|chip]|volts [name]|fk x,y,z|ik x,y,z",
        "say what is; fk, ik: where motors put the tool, and where they stand for it",
    ),
    command("config-get", Command::File(FileCommand::ShowSection), "\"section\"", "show a section of config.ini").card(),
    command(
        "config-set", Command::File(FileCommand::SetSetting),
        "[--check] \"section\" key [=] [value]",
        "change a setting, or delete it, with effect from the next reset; --check: only say what is wrong with it",
    ).card().for_owner(),
    command("config-load", Command::LoadSettings, "file", "replay saved settings").working().card(),
    command("load", Command::LoadSettings, "file", "replay saved settings").working().card(),
    command("preheat", Command::Preheat, "[name|off]", "set every heater that has a preset of this name; without one, list them").working().acts(),
    command("switch", Command::Switch, "[name [on|off|value]]", "list switches, look at one, or set it"),
    command("thermistors", Command::Ask(Question::Thermistors), "", "sensors that are known by name"),
    command("calc_thermistor", Command::Ask(Question::CalculateThermistor), "T1,R1,T2,R2,T3,R3", "coefficients of a sensor from three points"),
    command("setregs", Command::SetRegisters, "motor r1,r2,r3,r4,r5", "write all registers of a motor's driver, in hexadecimal"),
    command(
        "test", Command::Test,
        "jog axis distance times | square size times | circle radius times [feed] | raw axis steps rate | acc axis mm rate | endstop axis [times] | speed axis mm rate [times] | sweep axis Hz Hz [s] | backlash axis mm",
        "move back and forth, squares or circles, so many steps of one motor; how well an axis homes, whether it loses steps, where it rings, its backlash",
    )
    .working().acts(),
    command("tune_driver", Command::TuneDriver, "axis [mm/s ...]", "measure which stallGuard threshold a motor is to have: its axis moves over its travel")
        .working().acts(),
    command("fire", Command::Fire, "percent [ms] | off | status", "laser on at rest: a second where no ms say how long, a minute at most; any line ends it")
        .working().acts(),
    command("macros", Command::Macros, "[reload]", "Klipper's macros with what they say of themselves; reload reads their file anew")
        .working().card(),
    command("gpio", Command::Gpio, "pin [in | out on|off [ms]]", "look at a pin that nothing uses, or drive it for a while").working().acts(),
    command("break", Command::Break, "", "stop for a debugger; without one, the last events"),
    command("events", Command::Ask(Question::Events), "[count|all]", "what happened lately, before the last reset too, oldest first"),
    command("flash", Command::Flash, "", "install the firmware in /sd/flashme.bin; this one is kept as firmware.previous").card().for_owner(),
    command("dfu", Command::Dfu, "", "restart the board to wait for firmware over USB (dfu-util)").card().for_owner(),
    command("net", Command::Ask(Question::Network), "", "the network: link, address, name, consoles, traffic"),
    command("password", Command::Password, "word|off", "set the password that consoles of the network ask for, or forget it").card().for_owner(),
    command("reset", Command::Reset, "", "restart the board in a second").for_owner(),
    command("msc", Command::LendCard, "[off]", "let the computer at the USB socket have the SD card as a disk, until it ejects it; off: take it back").for_owner(),
    command("dialect", Command::Dialect, "[smoothie|marlin|reprapfirmware|klipper]", "what this console speaks, until the next reset"),
    command("echo", Command::Ask(Question::Echo), "[-n] [-1] text", "say it; -n: without a line end; -1: to the auxiliary UART"),
    command("$G", Command::Ask(Question::Modes), "", "the modal state"),
    command("$#", Command::Ask(Question::Offsets), "[-v]", "offsets and the last probe"),
    command("$H", Command::Home, "", "home").working().acts(),
    command("$X", Command::Ask(Question::Unlock), "", "clear a halt"),
    command("$I", Command::Ask(Question::ModesWithoutOk), "", "the modal state, without ok"),
    command("$S", Command::Ask(Question::Switches), "[name ...]", "switches, without ok"),
    command("$J", Command::Jog, "[-c] axis distance ... [S scale | F rate]", "jog; -c: until Ctrl-Y").working(),
    command("$P", Command::Probe, "[words]", "probe as G30 does").working(),
    command("$C", Command::CheckMode, "", "check mode on or off: programs are read, and nothing moves, heats or is deleted"),
    command("$SLP", Command::Sleep, "", "sleep: everything off until Ctrl-X or a reset"),
];

/// Commands of Smoothieware v2 whose part of the machine is missing so far, with that part or a substitute.
const LATER: &[(&str, &str)] = &[
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

    #[test]
    fn every_word_calls_one_command() {
        for command in COMMANDS {
            assert_eq!(COMMANDS.iter().filter(|other| other.word == command.word).count(), 1, "{}", command.word);
            assert_eq!(find(command.word).map(|found| found.does), Some(command.does));
        }
        assert!(find("nonsense").is_none());
    }

    #[test]
    fn a_question_runs_in_every_state_and_touches_neither_card_nor_machine() {
        for command in COMMANDS.iter().filter(|command| matches!(command.does, Command::Ask(_))) {
            let waits_for_something = command.acts || command.needs_card || command.states != States::ALL;
            assert!(!waits_for_something, "{} is answered while the machine waits", command.word);
        }
    }

    #[test]
    fn what_moves_or_heats_runs_on_a_machine_that_works() {
        for command in COMMANDS.iter().filter(|command| command.acts) {
            assert_eq!(command.states, States::WORKING, "{}", command.word);
        }
    }

    #[test]
    fn a_missing_part_is_named_for_its_commands_alone() {
        assert_eq!(waits_for("wget"), Some("the network (not there yet)"));
        assert!(COMMANDS.iter().all(|command| waits_for(command.word).is_none()));
    }
}
