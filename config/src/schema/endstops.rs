//! Rows of the section `[endstops]`.

use super::build::{ANY, NOT_NEGATIVE, POSITIVE, axes, bool, integer, new_name, number, pin, text, word};
use super::{CannotCreate, Docs, Form, Instances, PinRole, Section, Set, Setting, Words, endstop_phase, endstop_stall};
use crate::machine::{EndstopConfig, HomingDirection, MAX_ENDSTOPS};
use crate::pin::PinName;
use units::{Axis, Micros, Mm, MmPerSecond};

const AXES: &Words = &Words(&["X", "Y", "Z", "A", "B", "C"]);
const DIRECTIONS: &Words = &Words(&["none", "home_to_min", "home_to_max"]);

/// `|stop, value| ...` on the endstop at the instance's place.
macro_rules! stop {
    (|$stop:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($stop) = c.endstops.get_mut(i) {
                $body;
            }
        }
    };
}

const fn direction(word: usize) -> HomingDirection {
    match word {
        1 => HomingDirection::ToMin,
        2 => HomingDirection::ToMax,
        _ => HomingDirection::None,
    }
}

const fn trim(key: &'static str, v1: &'static str, set: Set<f64>) -> Setting {
    number(
        key,
        "0",
        ANY,
        set,
        "How much the switch of this tower or arm sits too low; negative where it sits too high. M666 changes it.",
    )
    .common()
    .unit("mm")
    .v1(v1)
}

const fn safe_z(key: &'static str, set: Set<f64>, summary: &'static str) -> Setting {
    number(key, "0", ANY, set, summary)
        .derived("wherever the tool is")
        .common()
        .klipper("[safe_z_home] home_xy_position")
        .unit("mm")
        .velvet()
}

/// A duration that was counted in milliseconds.
pub fn millis(value: f64) -> Micros {
    Micros((value * 1_000.0) as u64)
}

pub const ENDSTOPS: Section = Section {
    name: "endstops",
    store: None,
    docs: Docs::new("Switches that axes home to and that limit their travel, and how homing goes."),
    form: Form::Named(Instances {
        noun: "endstop",
        find: |c, name| c.endstops.iter().position(|stop| stop.name == name),
        create: |c, name| {
            let stop = EndstopConfig { name: new_name(name)?, ..EndstopConfig::default() };
            c.endstops.push(stop).map_err(|_| CannotCreate::Full(MAX_ENDSTOPS))?;
            Ok(c.endstops.len() - 1)
        },
        name: |c, i| c.endstops.get(i).map_or("", |stop| stop.name.as_str()),
        is_live: |c, i| c.endstops.get(i).is_some_and(|stop| stop.enable),
    }),
    settings: &[
        bool("enable", "false", stop!(|s, v| s.enable = v), "There is such an endstop."),
        pin(
            "pin",
            "nc",
            PinRole::Input,
            stop!(|s, v| s.pin = v.and_then(PinName::digital)),
            "Input, logically high when the switch is hit. The endstop connectors need a pull-up: ^.",
        )
        .klipper("[stepper_<axis>] endstop_pin")
        .v1("<axis>_min_endstop"),
        word(
            "axis",
            "",
            AXES,
            stop!(|s, v| s.axis = Axis::ALL.get(v).copied()),
            "Axis of the switch; for a slaved motor's own switch the letter of that motor (A, B or C).",
        )
        .required(),
        word(
            "homing_direction",
            "none",
            DIRECTIONS,
            stop!(|s, v| s.homing_direction = direction(v)),
            "Which way the axis moves to home on this switch. One homing switch per axis.",
        )
        .klipper("[stepper_<axis>] homing_positive_dir")
        .v1("<axis>_homing_direction"),
        number(
            "homing_position",
            "0",
            ANY,
            stop!(|s, v| s.homing_position = Mm(v)),
            "Coordinate of the axis at the switch.",
        )
        .klipper("[stepper_<axis>] position_endstop")
        .derived("0 for home_to_min, 200 for home_to_max")
        .unit("mm")
        .v1("<axis>_min"),
        number(
            "max_travel",
            "500",
            POSITIVE,
            stop!(|s, v| s.max_travel = Mm(v)),
            "Longest homing move; not to meet the switch within it halts.",
        )
        .unit("mm")
        .typical(&(2.0, 5_000.0))
        .v1("<axis>_max_travel"),
        number(
            "fast_rate",
            "100",
            POSITIVE,
            stop!(|s, v| s.fast_rate = MmPerSecond(v)),
            "Speed of the first approach.",
        )
        .klipper("[stepper_<axis>] homing_speed")
        .unit("mm/s")
        .typical(&(0.5, 500.0))
        .v1("<axis>_fast_homing_rate_mm_s"),
        number(
            "slow_rate",
            "10",
            POSITIVE,
            stop!(|s, v| s.slow_rate = MmPerSecond(v)),
            "Speed of backing off and of the second approach.",
        )
        .klipper("[stepper_<axis>] second_homing_speed")
        .unit("mm/s")
        .typical(&(0.1, 100.0))
        .v1("<axis>_slow_homing_rate_mm_s"),
        number(
            "retract",
            "5",
            NOT_NEGATIVE,
            stop!(|s, v| s.retract = Mm(v)),
            "Distance backed off between the approaches; the second goes at most twice as far.",
        )
        .klipper("[stepper_<axis>] homing_retract_dist")
        .unit("mm")
        .typical(&(0.1, 50.0))
        .v1("<axis>_homing_retract_mm"),
        bool(
            "limit_enable",
            "false",
            stop!(|s, v| s.limit_enable = v),
            "Hitting the switch in any other move halts. Not for the switch of a slaved motor.",
        )
        .v1("<axis>_limit_enable"),
        endstop_phase::CHECK,
        endstop_phase::PHASE,
        endstop_phase::TOLERANCE,
        endstop_phase::ALIGN_ZERO,
        endstop_phase::REACTION,
        endstop_stall::HOMING,
        endstop_stall::CURRENT,
        endstop_stall::THRESHOLD,
        number(
            "debounce_ms",
            "0",
            &(0.0, 1_000.0),
            |c, _, v| c.homing.debounce = millis(v),
            "How long a switch must stay hit to count.",
        )
        .common()
        .unit("ms")
        .v1("endstop_debounce_ms"),
        axes(
            "homing_order",
            |c, _, v| {
                c.homing.order.clear();
                // With fewer G28 would leave axes as they are. No letter stands twice, so six fit.
                if v.len() >= 3 {
                    let _ = c.homing.order.extend_from_slice(v);
                }
            },
            "Axes homed one after another, as in ZXY. Without it, or with fewer than three: X with Y, then Z, then A, B, C.",
        )
        .common()
        .v1("homing_order"),
        bool(
            "home_z_first",
            "false",
            |c, _, v| c.homing.z_first = v,
            "Home Z before X and Y; homing_order is stronger.",
        )
        .common()
        .v1("home_z_first"),
        bool(
            "corexy_homing",
            "false",
            |c, _, v| c.homing.corexy = v,
            "Home one axis at a time and stop both X and Y motors at the switch.",
        )
        .derived("true when arm_solution is corexy")
        .common()
        .v1("corexy_homing"),
        bool("delta_homing", "false", |c, _, v| c.homing.delta = v, "Home all three towers with one upward move.")
            .derived("true when arm_solution is linear_delta")
            .common()
            .v1("delta_homing"),
        bool("rdelta_homing", "false", |c, _, v| c.homing.rotary_delta = v, "Home a rotary delta by its arm angles.")
            .derived("true when arm_solution is rotary_delta")
            .common()
            .v1("rdelta_homing"),
        bool(
            "scara_homing",
            "false",
            |c, _, v| c.homing.scara = v,
            "Home in motor angles, with the kinematics switched off.",
        )
        .derived("true when arm_solution is morgan")
        .common()
        .v1("scara_homing"),
        bool(
            "move_to_origin_after_home",
            "false",
            |c, _, v| c.homing.move_to_origin = v,
            "Move to machine X0 Y0 after homing.",
        )
        .derived("as delta_homing")
        .common()
        .v1("move_to_origin_after_home"),
        number(
            "home_lift",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.homing.lift = Mm(v),
            "Raise Z so far before X and Y home, or go to where Z homes, so that the tool clears clamps and parts. Not where Z homes to its maximum.",
        )
        .common()
        .klipper("[safe_z_home] z_hop")
        .unit("mm")
        .velvet(),
        safe_z("safe_z_x", |c, _, v| c.homing.safe_z[0] = Some(Mm(v)), "Z homes at this machine X, behind X and Y."),
        safe_z("safe_z_y", |c, _, v| c.homing.safe_z[1] = Some(Mm(v)), "The same of Y."),
        integer(
            "homing_samples",
            "1",
            &(1, 20),
            |c, _, v| c.homing.samples = v as u8,
            "Slow approaches to each switch; with more than one they must agree, and their mean counts.",
        )
        .common()
        .velvet(),
        number(
            "homing_tolerance",
            "0.02",
            NOT_NEGATIVE,
            |c, _, v| c.homing.tolerance = Mm(v),
            "How far they may lie apart.",
        )
        .common()
        .unit("mm")
        .velvet(),
        integer(
            "homing_retries",
            "3",
            &(0, 20),
            |c, _, v| c.homing.retries = v as u8,
            "Rounds that are added where they lie further apart; then homing has failed.",
        )
        .common()
        .velvet(),
        text(
            "home_gcode",
            "",
            96,
            |c, _, v| c.homing.gcode = super::switches::spaced(v),
            "A line executed instead of G28 without axes. G28 within it homes. Underscores stand for blanks.",
        )
        .common()
        .klipper("[homing_override] gcode")
        .velvet(),
        trim("alpha_trim_mm", "alpha_trim_mm", |c, _, v| c.homing.trim[0] = Mm(v)),
        trim("beta_trim_mm", "beta_trim_mm", |c, _, v| c.homing.trim[1] = Mm(v)),
        trim("gamma_trim_mm", "gamma_trim_mm", |c, _, v| c.homing.trim[2] = Mm(v)),
    ],
};
