//! `velvet macro check`: every template of Klipper's files read.

use std::path::PathBuf;

use anyhow::Result;

use super::MEMORY;
use super::files::{self, Entry};

/// Prints what is not taken, with its place, and how many templates there are; returns whether all are taken.
pub fn check(paths: &[PathBuf]) -> Result<bool> {
    let (mut count, mut refused) = (0, 0);
    for path in paths {
        for entry in files::read(path)? {
            let finding = if is_template(&entry) {
                count += 1;
                ::macros::compile(&mut entry.value().bytes(), &mut vec![0; MEMORY]).err()
            } else if is_variable(&entry) {
                ::macros::rewrite_literal(&entry.value(), &mut vec![0; MEMORY], &mut vec![0; MEMORY]).err()
            } else {
                None
            };
            if let Some(error) = finding {
                refused += 1;
                println!("{}", told(&entry, &error));
            }
        }
    }
    match refused {
        0 => println!("{count} macros and templates, all are taken"),
        1 => println!("{count} macros and templates, 1 value is not taken"),
        _ => println!("{count} macros and templates, {refused} values are not taken"),
    }
    Ok(refused == 0)
}

/// An error with its place in the file: `printer.cfg:12:5: [gcode_macro X] gcode: what is wrong`.
pub fn told(entry: &Entry, error: &::macros::Error) -> String {
    let detail = if error.detail.is_empty() { String::new() } else { format!("{}: ", error.detail) };
    let place = entry.place(error.line, error.column);
    format!("{place}: [{}] {}: {detail}{}", entry.section, entry.name, error.words)
}

/// Whether an option holds a template: `gcode`, `activate_gcode` and their like.
fn is_template(entry: &Entry) -> bool {
    let is_named = entry.name == "gcode" || entry.name.ends_with("_gcode") && !entry.name.starts_with("variable_");
    is_named && !entry.value().is_empty()
}

/// Whether an option is a macro's variable, which is a Python literal.
pub fn is_variable(entry: &Entry) -> bool {
    entry.section.starts_with("gcode_macro ") && entry.name.starts_with("variable_")
}
