//! A printer.cfg as Klipper sees it: sections and options with the place each was written at.

use std::path::PathBuf;

/// Place of a line: which file of [`Source::files`], and its number from 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    pub file: usize,
    pub line: usize,
}

/// Option of a section, with the value that counts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Entry {
    /// Name in lower case.
    pub name: String,
    /// Value without comments; the lines of a long one are joined by line ends.
    pub value: String,
    pub place: Place,
    /// The owner's comment behind the value.
    pub comment: String,
    /// The owner's comment lines directly above.
    pub above: Vec<String>,
    /// Earlier lines that gave another value, which counts no more.
    pub earlier: Vec<(Place, String)>,
}

/// Section with its options, those of later sections of the same name included.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Section {
    /// Name as written: `stepper_x`, `gcode_macro PRINT_START`.
    pub name: String,
    /// Place of its first header.
    pub place: Place,
    pub above: Vec<String>,
    pub options: Vec<Entry>,
}

impl Section {
    /// Returns the kind of the section, the first word of its name.
    pub fn kind(&self) -> &str {
        self.name.split_whitespace().next().unwrap_or("")
    }

    /// Returns what stands behind the kind: `PRINT_START` of `gcode_macro PRINT_START`.
    pub fn label(&self) -> String {
        self.name.split_whitespace().skip(1).collect::<Vec<_>>().join(" ")
    }

    /// Returns the value of an option.
    pub fn get(&self, option: &str) -> Option<&str> {
        self.options.iter().find(|entry| entry.name == option).map(|entry| entry.value.as_str())
    }

    /// Returns an option as a number.
    pub fn number(&self, option: &str) -> Option<f64> {
        self.get(option).and_then(number)
    }
}

/// All that was read.
#[derive(Debug, Default)]
pub struct Source {
    /// Files in the order in which they were first opened; the first is printer.cfg itself.
    pub files: Vec<PathBuf>,
    pub sections: Vec<Section>,
    /// Remarks for a person on how the file was read.
    pub remarks: Vec<(Place, String)>,
}

impl Source {
    /// Returns a section by its whole name.
    pub fn section(&self, name: &str) -> Option<&Section> {
        self.sections.iter().find(|section| section.name == name)
    }

    /// Returns a place as `file:line`.
    pub fn told(&self, place: Place) -> String {
        let file = self.files.get(place.file).and_then(|path| path.file_name());
        format!("{}:{}", file.map_or_else(String::new, |name| name.to_string_lossy().into_owned()), place.line)
    }
}

/// Reads a number as Klipper does; one that is not finite is none.
pub fn number(text: &str) -> Option<f64> {
    // Python takes underscores between digits.
    let plain: String = text.trim().chars().filter(|c| *c != '_').collect();
    plain.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Reads a list of numbers, `235, 235`.
pub fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(number).collect()
}

/// Reads points: a line or a pair each, `10, 20` over several lines.
pub fn points(text: &str) -> Option<Vec<[f64; 2]>> {
    let lines = text.lines().filter(|line| !line.trim().is_empty());
    let all: Vec<Vec<f64>> = lines.map(numbers).collect::<Option<_>>()?;
    all.into_iter().map(|pair| <[f64; 2]>::try_from(pair).ok()).collect()
}

/// Reads a truth value as Klipper does.
pub fn truth(text: &str) -> Option<bool> {
    match text.to_lowercase().as_str() {
        "1" | "yes" | "true" | "on" => Some(true),
        "0" | "no" | "false" | "off" => Some(false),
        _ => None,
    }
}
