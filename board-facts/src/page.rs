//! The part of `docs/hardware.md` that shows the tables, and the test that every row has its tests.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::string::{String, ToString};
use std::vec::Vec;

use crate::Proof;
use crate::figures::FIGURES;
use crate::signals::{LEVELS, Level, Rest, SIGNALS, Speed};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/hardware.md");
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const BEGIN: &str = "<!-- Written by a test of board-facts; change the tables there. -->\n";
const END: &str = "<!-- End of what is written by a test. -->\n";

fn rest(rest: Rest) -> String {
    match rest {
        Rest::High(how) => format!("high: {how}"),
        Rest::Low(how) => format!("low: {how}"),
        Rest::Floats => "floats".into(),
        Rest::Driven(by) => by.into(),
    }
}

fn level(level: Level) -> String {
    match level {
        Level::Released => "released".into(),
        Level::PulledUp => "pull-up".into(),
        Level::Low => "low".into(),
        Level::High => "high".into(),
        Level::Either => "driven".into(),
        Level::Function(number) => format!("AF{number}"),
    }
}

const fn speed(speed: Option<Speed>) -> &'static str {
    match speed {
        None => "",
        Some(Speed::Low) => "low",
        Some(Speed::Medium) => "medium",
        Some(Speed::High) => "high",
        Some(Speed::VeryHigh) => "very high",
    }
}

/// Returns the names of the tests; their files are checked below.
fn tests(proofs: &[Proof]) -> String {
    proofs.iter().map(|proof| format!("`{}`", proof.test)).collect::<Vec<_>>().join(", ")
}

fn written() -> String {
    let mut page = String::from(BEGIN);
    // Writing to a String cannot fail.
    let _ = writeln!(
        page,
        "\n| signal | pins | in reset | boot | idle | in use | halted | edges | known from | tests |\n|---|---|---|---|---|---|---|---|---|---|"
    );
    for signal in SIGNALS {
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            signal.name,
            signal.pins.join(" "),
            rest(signal.rest),
            level(signal.boot),
            level(signal.idle),
            signal.active,
            level(signal.halted),
            speed(signal.speed),
            signal.origin,
            tests(signal.proofs)
        );
    }
    let _ = writeln!(page, "\nEvery row in reset, at boot, idle and halted: {}.", tests(LEVELS));
    let _ = writeln!(page, "\n| figure | value | known from | tests |\n|---|---|---|---|");
    for figure in FIGURES {
        let proofs = tests(figure.proofs);
        let _ = writeln!(page, "| {} | {} | {} | {proofs} |", figure.name, figure.value, figure.origin);
    }
    page.push('\n');
    page.push_str(END);
    page
}

/// Compares the page's part with the tables; `VELVET_WRITE=1 cargo test -p board-facts` writes it anew.
#[test]
fn the_page_shows_these_tables() {
    let page = std::fs::read_to_string(PAGE).unwrap();
    let (Some(begin), Some(end)) = (page.find(BEGIN), page.find(END)) else {
        panic!("docs/hardware.md has no place for it")
    };
    let fresh = written();
    if std::env::var_os("VELVET_WRITE").is_some() {
        let whole = format!("{}{fresh}{}", &page[..begin], &page[end + END.len()..]);
        std::fs::write(PAGE, whole).unwrap();
        return;
    }
    let present = &page[begin..end + END.len()];
    let differing = present.lines().zip(fresh.lines()).position(|(present, fresh)| present != fresh);
    assert!(present == fresh, "docs/hardware.md is stale from line {differing:?} of the tables on; see this test");
}

/// A row that no test looks at is an opinion. Signals that are never used have the tests of all rows alone.
#[test]
fn every_row_has_tests_that_exist() {
    let of_signals = SIGNALS.iter().map(|signal| (signal.name, signal.proofs, signal.active.contains("not used")));
    let of_figures = FIGURES.iter().map(|figure| (figure.name, figure.proofs, false));
    let of_all = [("every row", LEVELS, false)];
    for (name, proofs, unused) in of_signals.chain(of_figures).chain(of_all) {
        assert!(unused || !proofs.is_empty(), "{name}: no test");
        for Proof { test, file } in proofs {
            let source =
                std::fs::read_to_string(format!("{ROOT}/{file}")).unwrap_or_else(|error| panic!("{file}: {error}"));
            let indented = |by: &str| source.contains(&format!("#[test]\n{by}fn {test}("));
            let is_test = indented("") || indented("    ");
            assert!(is_test, "{name}: {file} has no test {test}");
        }
    }
}

#[test]
fn every_row_says_where_it_is_known_from_and_what_it_means() {
    for signal in SIGNALS {
        assert!(!signal.origin.is_empty() && !signal.active.is_empty() && !signal.pins.is_empty(), "{}", signal.name);
        let driven = |level| matches!(level, Level::Low | Level::High | Level::Either | Level::Function(_));
        let is_driven = [signal.boot, signal.idle, signal.halted].into_iter().any(driven);
        assert_eq!(is_driven, signal.speed.is_some(), "{}: edges of what is driven, and of nothing else", signal.name);
    }
    for figure in FIGURES {
        assert!(!figure.origin.is_empty() && !figure.value.is_empty(), "{}", figure.name);
    }
}

#[test]
fn no_pin_is_in_two_rows() {
    let mut seen = BTreeSet::new();
    for pin in SIGNALS.iter().flat_map(|signal| signal.pins) {
        assert!(seen.insert(pin.to_string()), "{pin} is in two rows");
    }
}
