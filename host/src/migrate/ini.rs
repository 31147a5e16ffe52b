//! Lines of the new file, and the file that they make.

use std::fmt::Write as _;

use config::schema::{Form, SECTIONS};

/// Column of comments behind settings that are shorter.
const COMMENT_COLUMN: usize = 44;

/// Line of the new file.
#[derive(Clone, Debug, Default)]
pub struct Entry {
    pub section: &'static str,
    pub instance: String,
    pub key: String,
    pub value: String,
    pub comment: String,
    /// Comment lines above the setting.
    pub above: Vec<String>,
}

impl Entry {
    /// Returns the setting's name within its section: `alpha.steps_per_mm`.
    pub fn name(&self) -> String {
        let form = SECTIONS.iter().find(|section| section.name == self.section).map(|section| section.form);
        match form {
            Some(Form::Keyed(_)) => self.instance.clone(),
            Some(Form::Named(_)) => format!("{}.{}", self.instance, self.key),
            Some(Form::Plain) | None => self.key.clone(),
        }
    }
}

/// Returns the text of the file: its head, the work that is left, the sections in the order of the reference.
pub fn write(head: &str, to_do: &[String], entries: &[Entry]) -> String {
    let mut out = format!("# {head}\n");
    if !to_do.is_empty() {
        out += "#\n# To do before the first start:\n";
    }
    for item in to_do {
        let _ = writeln!(out, "# [ ] {item}");
    }
    for section in SECTIONS {
        let of_section: Vec<&Entry> = entries.iter().filter(|entry| entry.section == section.name).collect();
        if of_section.is_empty() {
            continue;
        }
        let _ = writeln!(out, "\n[{}]", section.name);
        let mut instances: Vec<&str> = Vec::new();
        for entry in &of_section {
            if !instances.contains(&entry.instance.as_str()) {
                instances.push(&entry.instance);
            }
        }
        // Motors in their own order, whatever else in the order in which it was found.
        instances.sort_by_key(|name| units::Actuator::ALL.iter().position(|motor| motor.name() == *name));
        for (index, instance) in instances.iter().enumerate() {
            let mut lines: Vec<&&Entry> = of_section.iter().filter(|entry| entry.instance == *instance).collect();
            // The order is that of the reference, not that in which settings were found.
            lines.sort_by_key(|entry| section.settings.iter().position(|row| row.key == entry.key));
            if index > 0 && lines.len() > 1 {
                out.push('\n');
            }
            for entry in lines {
                line(&mut out, entry);
            }
        }
    }
    out
}

fn line(out: &mut String, entry: &Entry) {
    for comment in &entry.above {
        let _ = writeln!(out, "# {comment}");
    }
    let setting = format!("{} = {}", entry.name(), entry.value);
    let _ = match entry.comment.is_empty() {
        true => writeln!(out, "{setting}"),
        false => writeln!(out, "{setting:<COMMENT_COLUMN$} # {}", entry.comment),
    };
}
