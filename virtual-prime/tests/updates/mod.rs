//! Updates: every way to other firmware, every flaw that a file can have, and the power cut at every erase
//! and every programmed word. The quick share is part of `make test`, `make updates` runs all. The table of
//! `docs/updates.md` is made of the table here: `WRITE_UPDATES=1` writes it.

mod crystal;
mod cuts;
mod document;
mod download;
mod flaws;
mod machine;
mod small;
mod trials;

/// Share of a row's cases that is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Share {
    /// Cases that `make test` has time for.
    Quick,
    /// All cases of a row.
    Whole,
}

/// A fault during an update, and its consequence.
pub struct Row {
    /// Name of the row's test.
    pub name: &'static str,
    /// Fault in words, for the document.
    pub what: &'static str,
    /// Consequence in words, for the document.
    pub does: &'static str,
    /// Makes the fault happen, and asserts the consequence. Returns the number of cases tried.
    pub run: fn(Share) -> usize,
}

/// The whole table, in its parts.
const TABLE: &[(&str, &[Row])] = &[
    ("The power fails", cuts::ROWS),
    ("The power fails before that", machine::ROWS),
    ("The file", flaws::ROWS),
    ("The new firmware", trials::ROWS),
    ("USB", download::ROWS),
    ("The board", crystal::ROWS),
];

/// Tries the quick share of a row.
#[track_caller]
fn quick(rows: &[Row], name: &str) {
    let row = rows.iter().find(|row| row.name == name).expect("a row");
    let cases = (row.run)(Share::Quick);
    println!("{}: {cases} cases", row.what);
}

/// Makes a test for each row of a file.
macro_rules! tests {
    ($($name:ident)+) => {
        $(#[test]
        fn $name() {
            super::quick(ROWS, stringify!($name));
        })+

        #[test]
        fn every_row_has_its_test() {
            let named = [$(stringify!($name)),+];
            assert!(ROWS.iter().map(|row| row.name).eq(named), "the tests below the table are to be its rows");
        }
    };
}
use tests;

/// Runs two rows at a time, as the machine has cores; only rows whose names contain `UPDATES_ONLY`.
#[test]
#[ignore = "long: make updates"]
fn every_case_of_every_row() {
    let only = std::env::var("UPDATES_ONLY").unwrap_or_default();
    let rows: Vec<&Row> = TABLE.iter().flat_map(|(_, rows)| *rows).filter(|row| row.name.contains(&only)).collect();
    assert!(!rows.is_empty(), "no row has {only:?} in its name");
    let next = std::sync::atomic::AtomicUsize::new(0);
    let failed = std::sync::atomic::AtomicUsize::new(0);
    let work = || {
        while let Some(row) = rows.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
            match std::panic::catch_unwind(|| (row.run)(Share::Whole)) {
                Ok(cases) => println!("ok: {}: {cases} cases", row.what),
                Err(_) => {
                    failed.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    println!("FAILED: {}", row.what);
                }
            }
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(work);
        work();
    });
    assert_eq!(failed.into_inner(), 0, "rows failed");
}
