//! The table in `docs/updates.md`, made of the tested table.

use std::fmt::Write as _;

use super::TABLE;

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/updates.md");
const BEGIN: &str = "<!-- the table of virtual-prime/tests/updates; WRITE_UPDATES=1 writes it -->\n";
const END: &str = "<!-- its end -->\n";

fn table() -> String {
    let mut text = String::from("| what goes wrong | what happens | test |\n|---|---|---|\n");
    for (part, rows) in TABLE {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "| **{part}** | | |");
        for row in *rows {
            let _ = writeln!(text, "| {} | {} | `{}` |", row.what, row.does, row.name);
        }
    }
    text
}

#[test]
fn the_page_has_this_table() {
    let page = std::fs::read_to_string(PAGE).expect("docs/updates.md");
    let (before, rest) = page.split_once(BEGIN).expect("the table's beginning");
    let (is, after) = rest.split_once(END).expect("the table's end");
    if std::env::var_os("WRITE_UPDATES").is_some() {
        std::fs::write(PAGE, format!("{before}{BEGIN}{}{END}{after}", table())).expect("the page");
        return;
    }
    assert_eq!(is, table(), "WRITE_UPDATES=1 cargo test updates::document writes it");
}
