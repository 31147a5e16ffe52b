//! Answers of many lines, in progress.

use heapless::Vec;
use units::Micros;

use crate::paths::Path;
use crate::ports::FileHandle;

/// List that senders for grblHAL ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enumeration {
    /// `$EA`: every alarm.
    Alarms,
    /// `$EE`: every error.
    Errors,
    /// `$EG`: groups of settings.
    Groups,
    /// `$ES`: every setting, its name, unit and type (5: a whole number, 6: a number).
    Settings,
}

/// Answer of many lines, given as fast as it is taken, beside everything else.
#[derive(Clone, Debug)]
pub enum Listing {
    /// Listing of a directory.
    Directory {
        /// Path of the directory.
        path: Path,
        /// Entries given so far.
        seen: usize,
        /// Files, folders and bytes so far.
        sums: (u32, u32, u64),
        /// Whether only names are listed.
        names_only: bool,
        /// Whether M20 asked, not `ls`.
        for_m20: bool,
    },
    /// Contents of a file, up to so many lines.
    File {
        /// Path of the file.
        path: Path,
        /// Handle of the open file.
        file: FileHandle,
        /// Number of lines to go.
        lines: u32,
        /// Bytes of a character whose rest has not been read.
        carried: Vec<u8, 4>,
        /// Time of the beginning, for `cat -d`, which also marks the end.
        begins: Option<Micros>,
    },
    /// Settings of a section of config.ini.
    Section {
        /// Handle of the open config.ini.
        file: FileHandle,
        /// Name of the section.
        section: heapless::String<48>,
        /// Whether the present line is in that section.
        inside: bool,
        /// Whether there is such a section.
        found: bool,
        /// Bytes of a line whose end has not been read.
        line: Vec<u8, 320>,
        /// Whether these bytes begin the line.
        begins: bool,
    },
    /// Settings that M500 would save: the parts from this one on.
    Settings {
        /// Number of the next part.
        part: u8,
    },
    /// Rows of the grid, from this one on.
    Grid {
        /// Next row, counted as they are shown; the first one is the heading.
        row: usize,
    },
    /// Map of the bed, from this line on.
    Map {
        /// Number of the next line.
        line: usize,
    },
    /// Text of `help`, from this line on.
    Help {
        /// Number of the next line.
        line: usize,
    },
    /// Events from the log.
    Events {
        /// Number of the next event.
        next: u32,
        /// Number behind the last event.
        end: u32,
    },
    /// List that senders for grblHAL ask for, from this line on.
    Enumeration {
        /// Kind of the list.
        list: Enumeration,
        /// Number of the next line.
        line: usize,
    },
    /// Findings of `check`; then the summary of the file, from this line on.
    Check {
        /// Number of the next line.
        line: usize,
    },
    /// File transfer from the session: its answer comes when the file is whole.
    Transfer,
    /// Reports of the drivers of these motors.
    Drivers {
        /// Motors, one bit each.
        motors: u8,
        /// Whether all were asked for, and so each has a heading.
        all: bool,
    },
}
