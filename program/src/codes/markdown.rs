//! Writers of the tables of codes and console commands for `docs/commands.md`.

use core::fmt::{self, Write};

use gcode::Code;
use std::string::String;
use std::vec::Vec;

use super::varying::{Reading, VARYING, Varying};
use super::{Bounds, CodeInfo, Otherwise, READ_OTHERWISE, TOPICS, WordInfo};
use crate::commands::COMMANDS;
use crate::extended;
use gcode::{Dialect, Dialects};

/// Writes the tables of codes, a chapter for each topic, with a column for each dialect.
///
/// # Errors
/// When `out` refuses.
pub fn write_codes(out: &mut impl Write) -> fmt::Result {
    for (title, rows) in TOPICS {
        write_head(out, title)?;
        let mut written = Vec::new();
        for rows in rows.chunk_by(reads_the_same) {
            write_row(out, rows, &written)?;
            written.extend(rows);
        }
        writeln!(out)?;
    }
    write_head(out, "Codes of one firmware alone")?;
    for Otherwise { row, .. } in of_one_firmware() {
        write_row(out, core::slice::from_ref(row), &[])?;
    }
    writeln!(out)
}

fn write_head(out: &mut impl Write, title: &str) -> fmt::Result {
    writeln!(out, "### {title}\n\n| code | S | G | M | R | K | what it does | words | waits for | Smoothieware v2 |")?;
    writeln!(out, "|---|:-:|:-:|:-:|:-:|:-:|---|---|---|---|")
}

/// Returns the rows of codes that only one dialect knows.
fn of_one_firmware() -> impl Iterator<Item = &'static Otherwise> {
    READ_OTHERWISE.iter().filter(|other| super::find(other.row.code).is_none())
}

/// Returns the rows by which some dialects read a code otherwise.
fn otherwise(code: Code) -> impl Iterator<Item = &'static Otherwise> {
    READ_OTHERWISE.iter().filter(move |other| other.row.code == code && super::find(code).is_some())
}

/// Returns the differences of some dialects that read a code by its common row.
fn varying(code: Code) -> impl Iterator<Item = &'static Varying> {
    VARYING.iter().filter(move |varying| varying.codes.contains(&code))
}

/// Whether two rows differ in nothing but their code.
fn reads_the_same(a: &CodeInfo, b: &CodeInfo) -> bool {
    let same = |a: &CodeInfo, b: &CodeInfo| a.help == b.help && same_words(a.words, b.words) && a.waits == b.waits;
    let others = otherwise(a.code).map(|other| (other.dialects, &other.row));
    let same_others = || {
        otherwise(a.code).count() == otherwise(b.code).count()
            && others.zip(otherwise(b.code)).all(|((dialects, a), b)| dialects == b.dialects && same(a, &b.row))
    };
    same(a, b)
        && a.difference.text() == b.difference.text()
        && varying(a.code).map(|varying| varying.text).eq(varying(b.code).map(|varying| varying.text))
        && same_others()
}

fn same_words(a: &[WordInfo], b: &[WordInfo]) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|(a, b)| a.letter() == b.letter() && reads_alike(a, b) && a.bounds == b.bounds)
}

/// Whether two words have text and unit in common.
fn reads_alike(a: &WordInfo, b: &WordInfo) -> bool {
    a.text.text() == b.text.text() && a.unit == b.unit
}

/// Returns how a dialect reads the code of a row.
fn reading(row: &CodeInfo, dialect: Dialect) -> Reading {
    if let Some(other) = otherwise(row.code).find(|other| other.dialects.has(dialect)) {
        return own_reading(&other.row, Reading::Otherwise);
    }
    if of_one_firmware().any(|other| core::ptr::eq(row, &other.row) && !other.dialects.has(dialect)) {
        return Reading::Unknown;
    }
    match varying(row.code).find(|varying| varying.dialects.has(dialect)) {
        Some(varying) => varying.reading,
        None => own_reading(row, Reading::Same),
    }
}

/// Returns the reading by a row, given that for a row that is carried out.
fn own_reading(row: &CodeInfo, carried_out: Reading) -> Reading {
    match () {
        () if row.is_passed_over() => Reading::LeftOut,
        // The help of a row whose function refuses says so, as its first or last words.
        () if row.is_missing() || row.help.split("; ").any(|part| part.starts_with("refused: ")) => Reading::Refused,
        () => carried_out,
    }
}

fn write_row(out: &mut impl Write, rows: &[CodeInfo], written: &[&CodeInfo]) -> fmt::Result {
    let Some(row) = rows.first() else { return Ok(()) };
    write!(out, "| ")?;
    for (place, row) in rows.iter().enumerate() {
        write!(out, "{}{}", if place == 0 { "" } else { ", " }, row.code)?;
    }
    for dialect in Dialect::ALL {
        write!(out, " | {}", reading(row, dialect).mark())?;
    }
    write!(out, " | {}{}", kept(row), escaped(row.help))?;
    for varying in varying(row.code).filter(|varying| !varying.text.is_empty()) {
        write!(out, "<br>{}{}", names(varying.dialects), escaped(varying.text))?;
    }
    for other in otherwise(row.code).filter(|other| other.row.help != row.help) {
        write!(out, "<br>{}{}{}", names(other.dialects), kept(&other.row), escaped(other.row.help))?;
    }
    write!(out, " | ")?;
    write_all_words(out, row, written)?;
    for other in carried_out(row).filter(|other| !same_words(other.row.words, row.words)) {
        write!(out, "<br>{}", names(other.dialects))?;
        if other.row.words.is_empty() {
            write!(out, "none")?;
        }
        write_all_words(out, &other.row, written)?;
    }
    write!(out, " | {}", row.waits.name())?;
    for other in carried_out(row).filter(|other| other.row.waits != row.waits) {
        write!(out, "<br>{}{}", names(other.dialects), other.row.waits.name())?;
    }
    writeln!(out, " | {} |", escaped(row.difference.text()))
}

/// Returns the other readings of a row's code that are carried out.
fn carried_out(row: &CodeInfo) -> impl Iterator<Item = &'static Otherwise> {
    otherwise(row.code).filter(|other| own_reading(&other.row, Reading::Otherwise) == Reading::Otherwise)
}

/// Returns the names of dialects, to stand before what they read.
fn names(dialects: Dialects) -> String {
    let names: Vec<_> = Dialect::ALL.into_iter().filter(|dialect| dialects.has(*dialect)).map(Dialect::name).collect();
    std::format!("**{}**: ", names.join(", "))
}

/// Fewest words that are told by another row that has them too.
const MANY_WORDS: usize = 5;

/// Writes the words of a row. Many words that begin an earlier row's words are named by their letters alone.
fn write_all_words(out: &mut impl Write, row: &CodeInfo, written: &[&CodeInfo]) -> fmt::Result {
    let begins = |earlier: &&&CodeInfo| {
        let words = row.words.get(..earlier.words.len());
        earlier.words.len() >= MANY_WORDS && words.is_some_and(|words| same_words(words, earlier.words))
    };
    // Of several rows the first one, which tells its words.
    let earlier = written.iter().filter(begins).rev().max_by_key(|earlier| earlier.words.len());
    let told = earlier.map_or(0, |earlier| earlier.words.len());
    if let Some(earlier) = earlier {
        earlier.words.iter().try_for_each(|word| write!(out, "{} ", word.letter()))?;
        write!(out, "as {}", earlier.code)?;
    }
    let rest = row.words.get(told..).unwrap_or_default();
    for (place, words) in rest.chunk_by(reads_alike).enumerate() {
        if place > 0 || told > 0 {
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

/// Writes which codes each dialect does not read as the common row says.
///
/// # Errors
/// When `out` refuses.
pub fn write_otherwise(out: &mut impl Write) -> fmt::Result {
    writeln!(out, "| in | otherwise | refused | left out | known there alone |\n|---|---|---|---|---|")?;
    for dialect in Dialect::ALL {
        write!(out, "| {}", dialect.name())?;
        for wanted in [Reading::Otherwise, Reading::Refused, Reading::LeftOut] {
            let is_own = |row: &&CodeInfo| reading(row, dialect) == wanted && own_reading(row, Reading::Same) != wanted;
            write!(out, " | {}", listed(super::all().filter(is_own)))?;
        }
        let alone = of_one_firmware().filter(|other| other.dialects.has(dialect)).map(|other| &other.row);
        writeln!(out, " | {} |", listed(alone))?;
    }
    writeln!(out)
}

fn listed<'r>(rows: impl Iterator<Item = &'r CodeInfo>) -> String {
    let codes: Vec<_> = rows.map(|row| std::format!("{}", row.code)).collect();
    codes.join(", ")
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
        let takes = command.takes.replace('|', "\\|");
        writeln!(out, "| `{}{blank}{takes}` | {} |", command.word, escaped(command.help))?;
    }
    writeln!(out)
}

/// Returns text escaped for a table's cell. Between backticks nothing but a bar has a meaning there.
pub(super) fn escaped(text: &str) -> String {
    let escape = |(place, part): (usize, &str)| {
        let is_code = place % 2 == 1;
        if is_code { part.into() } else { part.replace('[', "\\[").replace('<', "\\<") }
    };
    let parts: Vec<String> = text.split('`').enumerate().map(escape).collect();
    parts.join("`").replace('|', "\\|")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::fs;

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
