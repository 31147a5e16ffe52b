//! The console commands and a line about each: `help`, and `-h` after any of them.

/// Every command word in the order `help` lists them, and what `-h` says of it.
pub const COMMANDS: [(&str, &str); 30] = [
    ("help", "help - list the commands; any of them with -h says what it does"),
    ("version", "version - firmware, board and clock"),
    ("mem", "mem - memory in use, and how long reading the configuration took"),
    ("ls", "ls [-1] [folder] - list files; -1: names only"),
    ("cd", "cd [folder] - change the current folder; without one, to the card"),
    ("cat", "cat file [lines] - show a file, or its first lines"),
    ("rm", "rm file ... - delete files, or empty folders; quote names with blanks"),
    ("mv", "mv from to - rename or move"),
    ("mkdir", "mkdir folder - make a folder"),
    ("play", "play file [-v] [-p] [-t] - play a file: show its lines, begin paused, tell its end"),
    ("progress", "progress [-b] - how far the file being played is; -b: in bytes"),
    ("abort", "abort - stop the file being played; heaters stay as they are"),
    ("suspend", "suspend [h] - pause the job so that filament can be changed; h: heaters stay on"),
    ("resume", "resume - go on with the suspended job"),
    ("get", "get pos|wcs|state|status|steps|temp [name|chip]|volts [name]"),
    ("config-get", "config-get \"section\" - show a section of config.ini"),
    (
        "config-set",
        "config-set \"section\" key [=] [value] - change a setting, or delete it; takes effect at the next reset",
    ),
    ("config-load", "config-load file - replay saved settings"),
    ("load", "load file - replay saved settings"),
    ("switch", "switch [name [on|off|value]] - list switches, look at one, or set it"),
    ("reset", "reset - restart the board in a second"),
    ("echo", "echo text - say it"),
    ("$G", "$G - the modal state"),
    ("$#", "$# [-v] - offsets and the last probe"),
    ("$H", "$H - home"),
    ("$X", "$X - clear a halt"),
    ("$I", "$I - the modal state, at once"),
    ("$S", "$S - switches, at once"),
    ("$J", "$J [-c] axis distance ... [S scale | F rate] - jog; -c: until Ctrl-Y"),
    ("$P", "$P [words] - probe as G30 does"),
];

/// Whether these arguments ask what a command does.
#[must_use]
pub fn is_asked(arguments: &str) -> bool {
    arguments.trim() == "-h"
}

/// What a command word does; `None` for a word that is no command.
#[must_use]
pub fn help(word: &str) -> Option<&'static str> {
    COMMANDS.iter().find(|(name, _)| *name == word).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_says_what_it_does_on_one_line() {
        for (name, text) in COMMANDS {
            assert!(text.starts_with(name) && text.len() > name.len() + 3 && !text.contains('\n'), "{name}: {text}");
        }
    }

    #[test]
    fn only_a_lone_option_asks() {
        assert!(is_asked("-h") && is_asked("  -h "));
        assert!(!is_asked("") && !is_asked("-h file") && !is_asked("-help"));
    }
}
