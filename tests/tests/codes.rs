//! The table of codes, row by row, on a whole machine.

use std::collections::BTreeSet;

use program::codes;
use scenarios::{Bench, CARTESIAN, Plan};

/// Codes that do what the configuration says, and it says nothing here.
const NOBODY_S: [&str; 3] = ["M80", "M81", "M9"];

fn start() -> Bench {
    Plan::new(CARTESIAN)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[leveling strategy] rectangular grid.enable = true")
        .start()
}

/// A code whose function has no arm in `machine/src/executor/functions.rs` would be passed over.
#[test]
fn no_row_of_the_table_is_passed_over() {
    let mut passed_over = BTreeSet::new();
    for row in codes::all().filter(|row| !row.is_missing()) {
        let mut bench = start();
        bench.hear(0.05);
        bench.type_in(&format!("{}\n", row.code));
        let heard = bench.hear(0.2);
        if heard.contains("ignored") {
            passed_over.insert(row.code.to_string());
        }
    }
    assert_eq!(passed_over, NOBODY_S.into_iter().map(String::from).collect());
}
