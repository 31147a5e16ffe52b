//! Rows of a table: `RCC.CR = 0x0303c1a5 : what for (where it says so)`.
//!
//! `value/mask` compares the bits of the mask alone; `one -> other` is the value when ready and the value
//! after a job; `live` is not compared: a counter, a flag, the last of many. Lines that begin with `#` are
//! comments.

/// Expected value of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    Value { value: u64, mask: u64 },
    Live,
}

/// A row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    pub name: String,
    pub ready: Expected,
    pub after: Expected,
    pub reason: String,
}

/// Least length of a reason, bytes; a shorter reason says nothing.
const LEAST_REASON: usize = 5;

/// Whether a value's reason ends with its source: `(RM0399 section 4.9.1)`.
fn names_its_source(row: &Row) -> bool {
    let live = row.ready == Expected::Live && row.after == Expected::Live;
    live || row.reason.ends_with(')') && row.reason.contains(" (")
}

/// Parses all rows of the table.
///
/// # Panics
/// With the line, when a row is not one, is there twice, or has no reason.
pub fn parse(text: &str) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')) {
        let row = parse_row(line).unwrap_or_else(|| panic!("not a row: {line}"));
        assert!(row.reason.len() >= LEAST_REASON, "no reason: {line}");
        assert!(names_its_source(&row), "no source: {line}");
        assert!(!rows.iter().any(|known| known.name == row.name), "twice: {line}");
        rows.push(row);
    }
    rows
}

fn parse_row(line: &str) -> Option<Row> {
    let (setting, reason) = line.split_once(" : ")?;
    let (name, values) = setting.split_once('=')?;
    let (ready, after) = values.split_once("->").unwrap_or((values, values));
    Some(Row {
        name: name.trim().to_owned(),
        ready: expected(ready.trim())?,
        after: expected(after.trim())?,
        reason: reason.trim().to_owned(),
    })
}

fn expected(text: &str) -> Option<Expected> {
    if text == "live" {
        return Some(Expected::Live);
    }
    let number = |text: &str| u64::from_str_radix(&text.trim().strip_prefix("0x")?.replace('_', ""), 16).ok();
    let (value, mask) = match text.split_once('/') {
        Some((value, mask)) => (number(value)?, number(mask)?),
        None => (number(text)?, u64::MAX),
    };
    Some(Expected::Value { value, mask })
}

#[test]
fn a_row_is_read_with_its_mask_and_both_states() {
    let rows = parse("# comment\nA.B = 0x12/0xf0 -> live : because it is so (section 1)\n");
    assert_eq!(rows[0].ready, Expected::Value { value: 0x12, mask: 0xF0 });
    assert_eq!((rows[0].name.as_str(), rows[0].after), ("A.B", Expected::Live));
}

#[test]
#[should_panic(expected = "no reason")]
fn a_row_without_a_reason_is_refused() {
    parse("A.B = 0x12 : \n");
}

#[test]
#[should_panic(expected = "no source")]
fn a_value_without_a_source_is_refused() {
    parse("A.B = 0x12 : because somebody said so\n");
}

#[test]
#[should_panic(expected = "twice")]
fn a_register_has_one_row() {
    parse("A.B = 0x12 : so it is (section 1)\nA.B = 0x13 : so it is not (section 2)\n");
}
