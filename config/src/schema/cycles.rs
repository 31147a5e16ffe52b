//! `[drillingcycles]`: canned cycles.

use super::build::{bool, word};
use super::{Docs, Form, Section, Words};

pub const DRILLING_CYCLES: Section = Section {
    name: "drillingcycles",
    store: None,
    docs: Docs::new("Canned cycles G73 and G81 to G89."),
    form: Form::Plain,
    settings: &[
        bool("enable", "true", |c, _, v| c.cycles.enable = v, "Understand canned cycles; else they are refused.")
            .v1("drillingcycles.enable"),
        word(
            "dwell_units",
            "S",
            &Words(&["S", "P"]),
            |c, _, v| c.cycles.dwell_in_ms = v == 1,
            "Unit of a cycle's P word: S for seconds, P for milliseconds.",
        )
        .v1("drillingcycles.dwell_units"),
    ],
};
