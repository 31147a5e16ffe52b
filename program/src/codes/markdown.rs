//! Writers of the tables of codes and console commands for `docs/commands.md`.

use core::fmt::{self, Write};

use super::{Bounds, CodeInfo, Otherwise, READ_OTHERWISE, TOPICS, WordInfo};
use crate::commands::COMMANDS;
use crate::dialect::Dialect;
use crate::extended;

/// Writes the tables of codes, a chapter for each topic.
///
/// # Errors
/// When `out` refuses.
pub fn write_codes(out: &mut impl Write) -> fmt::Result {
    for (title, rows) in TOPICS {
        writeln!(out, "### {title}\n")?;
        writeln!(out, "| code | what it does | words | waits for | Smoothieware v2 |\n|---|---|---|---|---|")?;
        rows.chunk_by(reads_the_same).try_for_each(|rows| write_row(out, rows))?;
        writeln!(out)?;
    }
    Ok(())
}

/// Whether two rows differ in nothing but their code.
fn reads_the_same(a: &CodeInfo, b: &CodeInfo) -> bool {
    let same_words = core::ptr::eq(a.words, b.words) || a.words.is_empty() && b.words.is_empty();
    a.help == b.help && same_words && a.waits == b.waits && a.difference.text() == b.difference.text()
}

fn write_row(out: &mut impl Write, rows: &[CodeInfo]) -> fmt::Result {
    let Some(row) = rows.first() else { return Ok(()) };
    write!(out, "| ")?;
    for (place, row) in rows.iter().enumerate() {
        write!(out, "{}{}", if place == 0 { "" } else { ", " }, row.code)?;
    }
    write!(out, " | {}{} | ", kept(row), escaped(row.help))?;
    write_all_words(out, row)?;
    writeln!(out, " | {} | {} |", row.waits.name(), escaped(row.difference.text()))
}

fn write_all_words(out: &mut impl Write, row: &CodeInfo) -> fmt::Result {
    for (place, words) in row.words.chunk_by(|a, b| a.text.text() == b.text.text() && a.unit == b.unit).enumerate() {
        if place > 0 {
            write!(out, "<br>")?;
        }
        write_words(out, words)?;
    }
    Ok(())
}

/// Writes words that differ in their letter alone.
fn write_words(out: &mut impl Write, words: &[WordInfo]) -> fmt::Result {
    let Some(word) = words.first() else { return Ok(()) };
    words.iter().try_for_each(|word| write!(out, "{} ", word.letter()))?;
    write!(out, "{}", escaped(word.text.text()))?;
    if !word.unit.name().is_empty() {
        write!(out, " ({})", word.unit.name())?;
    }
    match word.bounds {
        Bounds::Any => Ok(()),
        Bounds::AtLeast(least) => write!(out, ", {least} or more"),
        Bounds::Above(bound) => write!(out, ", above {bound}"),
        Bounds::Within(least, most) | Bounds::Whole(least, most) => write!(out, ", {least} to {most}"),
    }
}

/// Writes the table of codes that some dialects read otherwise than Smoothieware.
///
/// # Errors
/// When `out` refuses.
pub fn write_otherwise(out: &mut impl Write) -> fmt::Result {
    writeln!(out, "| code | in | what it does | words |\n|---|---|---|---|")?;
    for Otherwise { dialects, row } in READ_OTHERWISE {
        write!(out, "| {} | ", row.code)?;
        let names = Dialect::ALL.into_iter().filter(|dialect| dialects.has(*dialect)).map(Dialect::name);
        for (place, name) in names.enumerate() {
            write!(out, "{}{name}", if place == 0 { "" } else { ", " })?;
        }
        write!(out, " | {}{} | ", kept(row), escaped(row.help))?;
        write_all_words(out, row)?;
        writeln!(out, " |")?;
    }
    writeln!(out)
}

/// Writes the page of a dialect: every code as it is read there, a line each.
///
/// # Errors
/// When `out` refuses.
pub fn write_dialect(out: &mut impl Write, dialect: Dialect) -> fmt::Result {
    writeln!(out, "# Codes in {}'s dialect\n", dialect.name())?;
    writeln!(
        out,
        "Generated. Words and what a code waits for are in [commands.md](../commands.md); **bold** codes are read"
    )?;
    writeln!(
        out,
        "otherwise than in Smoothieware's dialect. *Left out*: changes no part, so it is counted and the file goes on."
    )?;
    writeln!(out, "*Missing*: a file pauses there, with the reason.\n")?;
    let otherwise = || READ_OTHERWISE.iter().filter(|other| other.dialects.has(dialect)).map(|other| &other.row);
    for (title, rows) in TOPICS {
        writeln!(out, "## {title}\n\n| code | what it does | words |\n|---|---|---|")?;
        for row in rows {
            match otherwise().find(|other| other.code == row.code) {
                Some(other) => write_read(out, other, "**")?,
                None => write_read(out, row, "")?,
            }
        }
        writeln!(out)?;
    }
    let mut own = otherwise().filter(|row| super::all().all(|other| other.code != row.code)).peekable();
    if own.peek().is_some() {
        writeln!(out, "## In this dialect alone\n\n| code | what it does | words |\n|---|---|---|")?;
        own.try_for_each(|row| write_read(out, row, "**"))?;
        writeln!(out)?;
    }
    if dialect == Dialect::Klipper {
        writeln!(out, "## Commands by name\n")?;
        write_named(out)?;
    }
    Ok(())
}

fn write_read(out: &mut impl Write, row: &CodeInfo, mark: &str) -> fmt::Result {
    write!(out, "| {mark}{}{mark} | {}{} |", row.code, kept(row), escaped(row.help))?;
    row.words.iter().try_for_each(|word| write!(out, " {}", word.letter()))?;
    writeln!(out, " |")
}

/// Returns a remark on a code that is not carried out.
fn kept(row: &CodeInfo) -> &'static str {
    match (row.is_missing(), row.is_passed_over()) {
        (true, _) => "missing: ",
        (_, true) => "left out: ",
        _ => "",
    }
}

/// Writes the table of commands by name.
///
/// # Errors
/// When `out` refuses.
pub fn write_named(out: &mut impl Write) -> fmt::Result {
    writeln!(out, "| command | parameters | what it does |\n|---|---|---|")?;
    for command in extended::all() {
        writeln!(out, "| `{}` | {} | {}{} |", command.name, command.takes, command.kept(), escaped(command.help))?;
    }
    writeln!(out)
}

/// Writes the table of console commands.
///
/// # Errors
/// When `out` refuses.
pub fn write_commands(out: &mut impl Write) -> fmt::Result {
    writeln!(out, "| command | what it does |\n|---|---|")?;
    for command in COMMANDS {
        let blank = if command.takes.is_empty() { "" } else { " " };
        writeln!(out, "| `{}{blank}{}` | {} |", command.word, escaped(command.takes), escaped(command.help))?;
    }
    writeln!(out)
}

/// Returns text escaped for a table's cell.
pub(super) fn escaped(text: &str) -> std::string::String {
    text.replace('|', "\\|").replace('[', "\\[").replace('<', "\\<")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::fs;
    use std::string::String;

    const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/commands.md");

    /// Returns the page with the text between two marks replaced.
    fn with(page: &str, mark: &str, text: &str) -> String {
        let (begin, end) =
            (std::format!("<!-- {mark}: from program/src/codes -->\n"), std::format!("<!-- end of {mark} -->"));
        let (before, rest) = page.split_once(&begin).unwrap_or_else(|| panic!("no {begin}"));
        let (_, after) = rest.split_once(&end).unwrap_or_else(|| panic!("no {end}"));
        std::format!("{before}{begin}\n{text}{end}{after}")
    }

    const DIALECTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/dialects.md");

    /// Writes a page, or asserts that the page on disk is up to date.
    pub(in crate::codes) fn settle(path: &str, page: &str, is: String) {
        if std::env::var_os("WRITE_DOCS").is_some() {
            return fs::write(path, is).unwrap();
        }
        let stale = page.lines().zip(is.lines()).position(|(a, b)| a != b);
        assert_eq!(page, is, "{path} is stale from line {:?} on; see this test", stale.map(|line| line + 1));
    }

    #[test]
    fn the_page_of_dialects_is_that_of_the_tables() {
        let page = fs::read_to_string(DIALECTS).unwrap();
        let (mut codes, mut commands) = (String::new(), String::new());
        write_otherwise(&mut codes).unwrap();
        write_named(&mut commands).unwrap();
        let is = with(&with(&page, "codes read otherwise", &codes), "commands by name", &commands);
        settle(DIALECTS, &page, is);
    }

    #[test]
    fn each_dialect_has_its_page() {
        for dialect in Dialect::ALL {
            let name = dialect.name().to_lowercase();
            let path = std::format!("{}/../docs/codes/{name}.md", env!("CARGO_MANIFEST_DIR"));
            let mut page = String::new();
            write_dialect(&mut page, dialect).unwrap();
            settle(&path, &fs::read_to_string(&path).unwrap_or_default(), page);
        }
    }

    /// Compares the page with the tables; `WRITE_DOCS=1 cargo test -p program --features docs` writes the
    /// page.
    #[test]
    fn the_page_of_commands_is_that_of_the_tables() {
        let page = fs::read_to_string(PAGE).unwrap();
        let (mut codes, mut commands) = (String::new(), String::new());
        write_codes(&mut codes).unwrap();
        write_commands(&mut commands).unwrap();
        let is = with(&with(&page, "codes", &codes), "console commands", &commands);
        settle(PAGE, &page, is);
    }
}
