//! Generates the page docs/disagreements.md from the table.

use std::fmt::Write;
use std::path::Path;

use super::table::{Cell, FIRMWARES, Row};

const HEAD: &str = "# Where firmwares disagree\n
Generated from `tests/tests/data/disagreements` by `WRITE_DISAGREEMENTS=1 cargo test -p scenarios disagreements::`, which runs
each cell on a machine. A row is a line or lines that firmwares read otherwise; each firmware's cell says what comes of them there, from which page
of its manual or file of its source that is known, and, after *here*, what Velvet makes of it in that dialect where that is something else. GRBL's
dialect is read with `grbl_mode`, and programs for LinuxCNC in it. G90, G91, M82 and M83 have their own table in
[dialects.md](dialects.md#e-places-or-distances).\n
`x 10` is a move by 10 mm in the end, `time` is in seconds, targets of heaters are in C, the fan's value is of 255; `done` is a file
that comes to its end, `waits` one that stops there for a person.\n";

/// Returns the page, a chapter for each part and a table for each row.
pub fn page(rows: &[Row]) -> String {
    let mut page = HEAD.to_owned();
    let mut chapter = "";
    for row in rows {
        if row.chapter != chapter {
            chapter = row.chapter;
            let _ = write!(page, "\n## {chapter}\n");
        }
        write_row(&mut page, row);
    }
    page
}

fn write_row(page: &mut String, row: &Row) {
    let _ = write!(page, "\n**{}**: ", capital(row.what));
    let code = |lines: &[&str]| lines.iter().map(|line| format!("`{line}`")).collect::<Vec<_>>().join(" ");
    let _ = write!(page, "{}", code(&row.lines));
    if row.is_file {
        page.push_str(" in a file");
    }
    if !row.given.is_empty() {
        let _ = write!(page, " after {}", code(&row.given));
    }
    if !row.settings.is_empty() {
        let _ = write!(page, ", with {}", code(&row.settings));
    }
    page.push_str("\n\n| firmware | what comes of it | from |\n|---|---|---|\n");
    for cells in row_cells(row) {
        let (names, cell) = cells;
        let ours = cell.ours.map_or(String::new(), |(facts, why)| format!("; *here* {facts}: {why}"));
        let _ = writeln!(page, "| {names} | {}{} | {} |", escaped(cell.theirs), escaped(&ours), escaped(cell.source));
    }
}

/// Returns the cells in the order of the firmwares.
fn row_cells(row: &Row) -> Vec<(String, &Cell)> {
    let mut cells: Vec<&Cell> = row.cells.iter().collect();
    let place = |cell: &Cell| FIRMWARES.iter().position(|(name, _)| cell.firmwares.contains(name));
    cells.sort_by_key(|cell| place(cell));
    cells.into_iter().map(|cell| (cell.firmwares.join(", "), cell)).collect()
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().collect::<String>() + letters.as_str())
}

fn escaped(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "\\<")
}

/// Writes the page, or compares the written one with it.
pub fn settle(page: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/disagreements.md");
    if std::env::var_os("WRITE_DISAGREEMENTS").is_some() {
        return std::fs::write(path, page).expect("docs/disagreements.md");
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(written == page, "docs/disagreements.md is stale: WRITE_DISAGREEMENTS=1 writes it");
}
