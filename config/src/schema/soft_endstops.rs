//! `[soft endstop]`: where moves end.

use super::build::{ANY, bool, number};
use super::{Docs, Form, Section, Set, Setting};
use units::Mm;

pub const SOFT_ENDSTOP: Section = Section {
    name: "soft endstop",
    store: None,
    docs: Docs::new("The ends of travel in machine coordinates: no move of a homed axis starts that would leave them."),
    form: Form::Plain,
    settings: &[
        bool(
            "enable",
            "true",
            |c, _, v| c.soft_endstops.enable = v,
            "Moves are held against the ends of travel. M211 S changes it until the next reset.",
        )
        .v1("soft_endstop.enable")
        .velvet(),
        bool(
            "halt",
            "false",
            |c, _, v| c.soft_endstops.halt = v,
            "A move that would leave the travel halts the machine; otherwise it is refused, and a file waits there.",
        )
        .derived("as grbl_mode")
        .v1("soft_endstop.halt")
        .velvet(),
        end("x_min", "soft_endstop.x_min", |c, _, v| c.soft_endstops.least[0] = Some(Mm(v)), LEAST),
        end("x_max", "soft_endstop.x_max", |c, _, v| c.soft_endstops.most[0] = Some(Mm(v)), MOST),
        end("y_min", "soft_endstop.y_min", |c, _, v| c.soft_endstops.least[1] = Some(Mm(v)), LEAST),
        end("y_max", "soft_endstop.y_max", |c, _, v| c.soft_endstops.most[1] = Some(Mm(v)), MOST),
        end("z_min", "soft_endstop.z_min", |c, _, v| c.soft_endstops.least[2] = Some(Mm(v)), LEAST),
        end("z_max", "soft_endstop.z_max", |c, _, v| c.soft_endstops.most[2] = Some(Mm(v)), MOST),
    ],
};

const LEAST: &str = "The least machine position of the axis.";
const MOST: &str = "The greatest machine position of the axis.";

const fn end(key: &'static str, v1: &'static str, set: Set<f64>, summary: &'static str) -> Setting {
    number(key, "0", ANY, set, summary)
        .derived("from homing_position and max_travel")
        .unit("mm")
        .v1(v1)
        .klipper(if is_least(key) { "[stepper_<axis>] position_min" } else { "[stepper_<axis>] position_max" })
        .velvet()
}

const fn is_least(key: &str) -> bool {
    matches!(key.as_bytes(), [.., b'm', b'i', b'n'])
}
