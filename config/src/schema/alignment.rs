//! `[z alignment]`, `[bed screws]`, `[axis twist compensation]` and `[z thermal adjust]`.

use super::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number, places, text, word};
use super::{Docs, Form, Section, Setting, Words};
use crate::machine::{MAX_POINTS, MAX_SCREWS, MAX_Z_MOTORS, MOST_TWIST_POINTS, Thread};
use heapless::Vec;
use units::Mm;

/// Threads of common screws with which way raises the bed, named as Klipper names them.
const THREADS: &Words = &Words(&["CW-M3", "CCW-M3", "CW-M4", "CCW-M4", "CW-M5", "CCW-M5", "CW-M6", "CCW-M6"]);
/// Coarse pitches of the threads (ISO 261), mm, one for each pair of words.
const PITCHES: [f64; 4] = [0.5, 0.7, 0.8, 1.0];

/// As Klipper has it, `CW` means that a clockwise turn raises the bed.
fn thread(word: usize) -> Thread {
    Thread { pitch: PITCHES.get(word / 2).copied().unwrap_or(0.5), clockwise_raises: word.is_multiple_of(2) }
}

pub const Z_ALIGNMENT: Section = Section {
    name: "z alignment",
    store: None,
    docs: Docs::new("Levels a bed or a gantry by the motors that carry it: two or more Z motors, gamma and its slaves (slaved_to), each \
              turned alone. G34 does it."),
    form: Form::Plain,
    settings: &[
        places(
            "motors",
            MAX_Z_MOTORS,
            |c, _, v| c.z_alignment.motors = list(v),
            "Where each Z motor carries the bed or the gantry: gamma first, then its slaves in their order.",
        )
        .klipper("[z_tilt] z_positions")
        .velvet(),
        places(
            "points",
            MAX_POINTS,
            |c, _, v| c.z_alignment.points = list(v),
            "Where the probe touches the bed (Klipper writes where the nozzle is then); as many as there are motors, or more.",
        )
        .klipper("[z_tilt] points")
        .velvet(),
        bool(
            "twist",
            "true",
            |c, _, v| c.z_alignment.twist = v,
            "With four motors: a twist is taken out too, as of a gantry on belts. A stiff bed has none.",
        )
        .velvet(),
        tolerance(
            "0.02",
            |c, _, v| c.z_alignment.tolerance = Mm(v),
            "Aligned when no motor is off by more. G34 T changes it.",
        )
        .klipper("[z_tilt] retry_tolerance"),
        integer(
            "retries",
            "5",
            &(0, 30),
            |c, _, v| c.z_alignment.retries = v as u8,
            "Rounds after the first one at most. G34 I changes it.",
        )
        .unit("rounds")
        .klipper("[z_tilt] retries")
        .velvet(),
        number(
            "max_adjust",
            "5",
            POSITIVE,
            |c, _, v| c.z_alignment.max_adjust = Mm(v),
            "A motor that is off by more than this is not moved: something else is wrong.",
        )
        .unit("mm")
        .typical(&(0.1, 20.0))
        .klipper("[quad_gantry_level] max_adjust")
        .velvet(),
        initial_height(|c, _, v| c.z_alignment.initial_height = Mm(v)),
    ],
};

pub const BED_SCREWS: Section = Section {
    name: "bed screws",
    store: None,
    docs: Docs::new("The screws that a person levels the bed by. G35 says how far each is to be turned."),
    form: Form::Plain,
    settings: &[
        places(
            "screws",
            MAX_SCREWS,
            |c, _, v| c.bed_screws.screws = list(v),
            "Where they are (Klipper's screws_tilt_adjust writes where the nozzle is with the probe over them). The first one stays; the others are turned.",
        )
        .klipper("[screws_tilt_adjust] screw1")
        .velvet(),
        word(
            "thread",
            "CW-M3",
            THREADS,
            |c, _, v| c.bed_screws.thread = thread(v),
            "Their thread; CW: turned clockwise it raises the bed.",
        )
        .klipper("[screws_tilt_adjust] screw_thread")
        .velvet(),
        number(
            "pitch",
            "0",
            NOT_NEGATIVE,
            |c, _, v| {
                if v > 0.0 {
                    c.bed_screws.thread.pitch = v;
                }
            },
            "Way of one turn of another thread; 0: that of thread.",
        )
        .unit("mm")
        .typical(&(0.2, 2.0))
        .velvet(),
        tolerance("0.02", |c, _, v| c.bed_screws.tolerance = Mm(v), "Level when no screw is off by more."),
        number(
            "paper_height",
            "0",
            ANY,
            |c, _, v| c.bed_screws.paper_height = Mm(v),
            "Height of the tool over the screws while a person turns them by paper (BED_SCREWS_ADJUST).",
        )
        .unit("mm")
        .klipper("[bed_screws] probe_height")
        .velvet(),
        initial_height(|c, _, v| c.bed_screws.initial_height = Mm(v)),
    ],
};

pub const AXIS_TWIST: Section = Section {
    name: "axis twist compensation",
    store: None,
    docs: Docs::new("A probe beside the tool reads wrongly along an axis whose rail is twisted. What it reads too high is taken off."),
    form: Form::Plain,
    settings: &[
        word("axis", "x", &Words(&["x", "y"]), |c, _, v| c.axis_twist.along_y = v == 1, "The axis whose rail is twisted.").velvet(),
        places(
            "points",
            MOST_TWIST_POINTS,
            |c, _, v| c.axis_twist.points = list(v),
            "Places along the axis, in rising order, and what the probe reads too high there (Klipper's z_compensations have the other sign). M851.1 P4 finds them, M500 saves them.",
        )
        .klipper("[axis_twist_compensation] z_compensations")
        .velvet(),
        place_of("start", |c, _, v| c.axis_twist.start = Mm(v), "Where along the axis it is measured first.")
            .klipper("[axis_twist_compensation] calibrate_start_x"),
        place_of("end", |c, _, v| c.axis_twist.end = Mm(v), "Where it is measured last.")
            .klipper("[axis_twist_compensation] calibrate_end_x"),
        place_of("line", |c, _, v| c.axis_twist.line = Mm(v), "On which line of the other axis it is measured.")
            .klipper("[axis_twist_compensation] calibrate_y"),
        integer("samples", "3", &(2, 8), |c, _, v| c.axis_twist.samples = v as u8, "At how many places it is measured.")
            .unit("places")
            .velvet(),
        initial_height(|c, _, v| c.axis_twist.initial_height = Mm(v)),
    ],
};

pub const Z_THERMAL: Section = Section {
    name: "z thermal adjust",
    store: None,
    docs: Docs::new("A frame that grows with its temperature moves the tool against the bed. Z is shifted against that, from where it homed."),
    form: Form::Plain,
    settings: &[
        text(
            "sensor",
            "",
            24,
            |c, _, v| c.z_thermal.sensor = crate::machine::Name::try_from(v).unwrap_or_default(),
            "The temperature control whose sensor is on the frame.",
        )
        .klipper("[z_thermal_adjust] sensor_type")
        .velvet(),
        number(
            "coefficient",
            "0",
            &(-1.0, 1.0),
            |c, _, v| c.z_thermal.coefficient = v,
            "By how much the tool comes away from the bed for each degree; 0: not known, and nothing is shifted. M290.1 K changes it.",
        )
        .unit("mm/K")
        .klipper("[z_thermal_adjust] temp_coeff")
        .velvet(),
        number("smooth_time", "2", &(0.0, 600.0), |c, _, v| c.z_thermal.smooth_s = v, "Readings are smoothed over so long.")
            .unit("s")
            .klipper("[z_thermal_adjust] smooth_time")
            .velvet(),
        number("max_adjust", "0.5", POSITIVE, |c, _, v| c.z_thermal.max_adjust = Mm(v), "Z is shifted by no more.")
            .unit("mm")
            .typical(&(0.01, 2.0))
            .klipper("[z_thermal_adjust] max_z_adjustment")
            .velvet(),
    ],
};

const fn place_of(key: &'static str, set: super::Set<f64>, summary: &'static str) -> Setting {
    number(key, "0", ANY, set, summary).unit("mm").velvet()
}

const fn tolerance(default: &'static str, set: super::Set<f64>, summary: &'static str) -> Setting {
    number("tolerance", default, POSITIVE, set, summary).unit("mm").typical(&(0.001, 1.0)).velvet()
}

const fn initial_height(set: super::Set<f64>) -> Setting {
    number("initial_height", "10", POSITIVE, set, "Height moved to fast before searching for the bed.")
        .unit("mm")
        .velvet()
}

/// As many as the schema lets through.
fn list<const N: usize>(places: &[[f64; 2]]) -> Vec<[f64; 2], N> {
    Vec::from_slice(places).unwrap_or_default()
}
