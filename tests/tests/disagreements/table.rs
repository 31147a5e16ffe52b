//! The rows of `tests/tests/data/disagreements`: lines to run, and the result in each firmware.

/// Lines that firmwares read differently.
#[derive(Debug, Default)]
pub struct Row {
    /// Chapter of the page.
    pub chapter: &'static str,
    /// Subject of the disagreement.
    pub what: &'static str,
    /// Settings of the machine, `[section] key = value`.
    pub settings: Vec<&'static str>,
    /// Lines that prepare the machine.
    pub given: Vec<&'static str>,
    /// Lines that the dialects treat differently.
    pub lines: Vec<&'static str>,
    /// Whether the lines are a file that is played; otherwise they are typed.
    pub is_file: bool,
    /// Results of the row, by firmware.
    pub cells: Vec<Cell>,
}

/// Result of a row in one firmware or several, and here in their dialect.
#[derive(Debug)]
pub struct Cell {
    /// Firmwares with this result.
    pub firmwares: Vec<&'static str>,
    /// Result in the firmware: facts, or a sentence where Velvet has facts of its own.
    pub theirs: &'static str,
    /// Source: page of the firmware's manual, or file of its source.
    pub source: &'static str,
    /// Result in Velvet where it differs, and the reason.
    pub ours: Option<(&'static str, &'static str)>,
}

impl Cell {
    /// Returns the facts that Velvet is held to.
    pub fn facts(&self) -> &'static str {
        self.ours.map_or(self.theirs, |(facts, _)| facts)
    }
}

/// Firmwares, and the dialect in which Velvet reads their programs.
pub const FIRMWARES: [(&str, &str); 6] = [
    ("Smoothieware", "smoothie"),
    ("GRBL", "grbl"),
    ("Marlin", "marlin"),
    ("RepRapFirmware", "reprapfirmware"),
    ("Klipper", "klipper"),
    ("LinuxCNC", "grbl"),
];

/// Reads the rows of a file: `# chapter`, `## what`, and below that `key: value` lines.
pub fn read(text: &'static str) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    let mut chapter = "";
    for line in text.lines().filter(|line| !line.is_empty()) {
        if let Some(title) = line.strip_prefix("# ") {
            chapter = title;
        } else if let Some(what) = line.strip_prefix("## ") {
            rows.push(Row { chapter, what, ..Row::default() });
        } else {
            let row = rows.last_mut().unwrap_or_else(|| panic!("a row begins with ##: {line}"));
            row.read(line);
        }
    }
    rows
}

impl Row {
    fn read(&mut self, line: &'static str) {
        let (key, value) = line.split_once(": ").unwrap_or_else(|| panic!("no key: {line}"));
        match key {
            "set" => self.settings.push(value),
            "given" => self.given.push(value),
            "type" | "play" => {
                self.lines.push(value);
                self.is_file = key == "play";
            }
            names => self.cells.push(Cell::read(names, value)),
        }
    }

    /// Returns the cell of a firmware.
    pub fn cell(&self, firmware: &str) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.firmwares.contains(&firmware))
    }
}

impl Cell {
    /// Parses `FACTS | SOURCE`, and where Velvet differs ` | ours: FACTS | WHY`.
    fn read(names: &'static str, value: &'static str) -> Self {
        let firmwares: Vec<&str> = names.split(", ").collect();
        for name in &firmwares {
            assert!(FIRMWARES.iter().any(|(known, _)| known == name), "nobody's cell: {name}: {value}");
        }
        let parts: Vec<&str> = value.split(" | ").collect();
        let (theirs, source, ours) = match parts[..] {
            [theirs, source] => (theirs, source, None),
            [theirs, source, ours, why] => {
                let facts = ours.strip_prefix("ours: ").unwrap_or_else(|| panic!("no facts: {value}"));
                (theirs, source, Some((facts, why)))
            }
            _ => panic!("a cell is `facts | source` or `facts | source | ours: facts | why`: {value}"),
        };
        Self { firmwares, theirs, source, ours }
    }
}
