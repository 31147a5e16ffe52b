//! Table of codes on which dialects disagree, with each firmware's behaviour and its source:
//! `tests/tests/data/disagreements`. Each of its cells is run here. The page generated from it is
//! docs/disagreements.md, written by `WRITE_DISAGREEMENTS=1 cargo test -p scenarios disagreements::`.

mod facts;
mod page;
mod table;

use std::collections::BTreeSet;

use facts::Trial;
use table::{FIRMWARES, Row};

const FILES: [&str; 4] = [
    include_str!("../data/disagreements/moves.txt"),
    include_str!("../data/disagreements/extruder_and_heat.txt"),
    include_str!("../data/disagreements/files_and_answers.txt"),
    include_str!("../data/disagreements/settings.txt"),
];

fn rows() -> Vec<Row> {
    FILES.into_iter().flat_map(table::read).collect()
}

#[test]
fn every_cell_comes_out_as_it_is_stated() {
    let rows = rows();
    let (mut wrong, mut tried) = (Vec::new(), 0);
    for row in &rows {
        for (firmware, dialect) in FIRMWARES {
            let Some(cell) = row.cell(firmware) else { continue };
            let mut trial = Trial::run(row, dialect);
            tried += 1;
            if let Some(difference) = trial.difference(cell.facts()) {
                wrong.push(format!("{}, {:?}, {firmware}: {difference}", row.what, row.lines));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {tried} cells:\n{}", wrong.len(), wrong.join("\n"));
    assert!(tried >= 500, "{tried} cells");
}

/// A row has a cell for each dialect, and at least two that differ: else it is none of this table.
#[test]
fn every_row_is_a_disagreement_and_complete() {
    for row in rows() {
        assert!(!row.lines.is_empty(), "{}", row.what);
        for (firmware, _) in FIRMWARES.into_iter().filter(|(name, _)| *name != "LinuxCNC") {
            let count = row.cells.iter().filter(|cell| cell.firmwares.contains(&firmware)).count();
            assert_eq!(count, 1, "{}: cells of {firmware}", row.what);
        }
        let kinds: BTreeSet<&str> = row.cells.iter().map(|cell| cell.theirs).collect();
        assert!(kinds.len() > 1, "{}: they agree", row.what);
        assert!(row.cells.iter().all(|cell| !cell.source.is_empty()), "{}", row.what);
    }
}

#[test]
fn the_page_is_that_of_the_table() {
    page::settle(&page::page(&rows()));
}

/// A fact that is not so is found: the table's test can fail.
#[test]
fn what_is_not_so_is_told() {
    const TEXT: &str = "# Chapter\n## what\ntype: G1 X10 F6000\nMarlin: x 10 | here";
    let rows = table::read(TEXT);
    let mut trial = Trial::run(&rows[0], "marlin");
    assert_eq!(trial.difference("x 10, y 0"), None);
    for facts in ["x 11", "x 10, e 1", "hotend 200", "fan 255", "motors none", "says nothing of it", "time 9", "waits"]
    {
        assert!(trial.difference(facts).is_some(), "{facts}");
    }
}
