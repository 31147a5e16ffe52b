//! Answers of many lines.

use heapless::Vec;
use units::Micros;

use crate::files::paths::Path;
use crate::ports::FileHandle;

/// A list that senders for grblHAL ask for.
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

/// An answer of many lines, given as fast as they are taken, beside everything else.
#[derive(Clone, Debug)]
pub enum Listing {
    /// Of a directory.
    Directory {
        /// Which.
        path: Path,
        /// Entries given so far.
        seen: usize,
        /// Files, folders and bytes so far.
        sums: (u32, u32, u64),
        /// Only names.
        names_only: bool,
        /// M20 asked, not `ls`.
        for_m20: bool,
    },
    /// Of a file, up to so many lines.
    File {
        /// Which.
        path: Path,
        /// It is open.
        file: FileHandle,
        /// Lines to go.
        lines: u32,
        /// Bytes of a character whose rest has not been read.
        carried: Vec<u8, 4>,
        /// When it begins, for `cat -d`, which marks its end.
        begins: Option<Micros>,
    },
    /// Of a section of config.ini.
    Section {
        /// It is open.
        file: FileHandle,
        /// Its name.
        section: heapless::String<48>,
        /// In that section now.
        inside: bool,
        /// There is such a section.
        found: bool,
        /// What has been read of a line whose end has not been.
        line: Vec<u8, 320>,
        /// That is its beginning.
        begins: bool,
    },
    /// What M500 would save: the parts from this one on.
    Settings {
        /// The next part.
        part: u8,
    },
    /// The grid's rows, from this one on.
    Grid {
        /// The next row, counted as they are shown; the first one is the heading.
        row: usize,
    },
    /// The map of the bed, from this line on.
    Map {
        /// The next line.
        line: usize,
    },
    /// What `help` says, from this line on.
    Help {
        /// The next line.
        line: usize,
    },
    /// Of what happened.
    Events {
        /// The number of the next one.
        next: u32,
        /// The number behind the last one.
        end: u32,
    },
    /// A list that senders for grblHAL ask for, from this line on.
    Enumeration {
        /// Which.
        list: Enumeration,
        /// The next line.
        line: usize,
    },
    /// What `check` finds; behind that the lines that say what the file comes to, from this one on.
    Check {
        /// The next line.
        line: usize,
    },
    /// What it sends is a file: its answer comes when that is whole.
    Transfer,
    /// What the drivers of these motors say of themselves.
    Drivers {
        /// One bit each.
        motors: u8,
        /// All were asked for: each has a heading.
        all: bool,
    },
}
