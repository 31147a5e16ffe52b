//! `[motion control]`, `[planner]`, `[conveyor]`.

use super::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number, numbers, word};
use super::{Docs, Form, Section, Support, Words};
use crate::machine::ArmSolution;
use units::{Micros, Mm, MmPerSecond, MmPerSecond2, MmPerSecond3};

/// The words of `arm_solution`, and what they mean.
const ARM_SOLUTIONS: &Words = &Words(&[
    "cartesian",
    "linear_delta",
    "rostock",
    "kossel",
    "delta",
    "rotary_delta",
    "hbot",
    "corexy",
    "corexz",
    "morgan",
    "hybrid_corexy",
    "hybrid_corexz",
    "deltesian",
    "polar",
    "winch",
    "generic_cartesian",
    "lathe",
]);

const fn arm_solution(word: usize) -> ArmSolution {
    match word {
        1..=4 => ArmSolution::LinearDelta,
        5 => ArmSolution::RotaryDelta,
        6 | 7 => ArmSolution::CoreXy,
        8 => ArmSolution::CoreXz,
        9 => ArmSolution::Morgan,
        10 => ArmSolution::HybridCoreXy,
        11 => ArmSolution::HybridCoreXz,
        12 => ArmSolution::Deltesian,
        13 => ArmSolution::Polar,
        14 => ArmSolution::Winch,
        15 => ArmSolution::Generic,
        16 => ArmSolution::Lathe,
        _ => ArmSolution::Cartesian,
    }
}

/// A limit in mm/min, where zero and less mean none.
fn limit(mm_per_minute: f64) -> Option<MmPerSecond> {
    (mm_per_minute > 0.0).then(|| MmPerSecond::from_per_minute(mm_per_minute))
}

pub const MOTION_CONTROL: Section = Section {
    name: "motion control",
    docs: Docs::new("Speeds, arcs and kinematics of the machine as a whole."),
    form: Form::Plain,
    settings: &[
        number(
            "default_feed_rate",
            "4000",
            NOT_NEGATIVE,
            |c, _, v| c.motion.default_feed_rate = MmPerSecond::from_per_minute(v),
            "Speed of G1, G2 and G3 until an F word sets it; 0: refused until then.",
        )
        .unit("mm/min").typical(&(60.0, 100_000.0))
        .v1("default_feed_rate"),
        number(
            "default_seek_rate",
            "4000",
            POSITIVE,
            |c, _, v| c.motion.default_seek_rate = MmPerSecond::from_per_minute(v),
            "Speed of G0 until an F word on a G0 sets it, which in GRBL's dialect none does.",
        )
        .unit("mm/min").typical(&(120.0, 200_000.0))
        .v1("default_seek_rate"),
        bool(
            "compliant_seek_rate",
            "false",
            |c, _, v| c.motion.compliant_seek_rate = v,
            "F always sets the speed of G1; G0 keeps default_seek_rate, which M203 S changes, and M220 and M121 do not.",
        ),
        number(
            "mm_per_line_segment",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.motion.mm_per_line_segment = (v >= 1e-4).then_some(Mm(v)),
            "Longest piece a straight move is cut into; 0: it is not cut. Velvet evaluates the kinematics all along the \
             path, so only a bed correction could need this.",
        )
        .unit("mm")
        .v1("mm_per_line_segment"),
        number(
            "delta_segments_per_second",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.motion.segments_per_second = (v > 1.0).then_some(v),
            "Pieces per second a straight move is cut into, stronger than mm_per_line_segment; 0: it is not cut. Lines are \
             exact without; each piece has the speed that its own part of the way allows.",
        )
        .derived("100 for the two deltas, else 0")
        .unit("1/s")
        .v1("delta_segments_per_second"),
        number(
            "mm_per_arc_segment",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.motion.mm_per_arc_segment = (v > 0.0).then_some(Mm(v)),
            "Above zero: arcs are cut into chords of this length, or of that of mm_max_arc_error if it is longer.",
        )
        .klipper("[gcode_arcs] resolution")
        .unit("mm")
        .v1("mm_per_arc_segment"),
        number(
            "mm_max_arc_error",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.motion.mm_max_arc_error = (v > 0.0).then_some(Mm(v)),
            "Above zero: arcs are cut into chords that leave them by this at most. With 0 here and in mm_per_arc_segment arcs are \
             exact.",
        )
        .unit("mm").typical(&(0.0001, 1.0))
        .v1("mm_max_arc_error"),
        integer(
            "arc_correction",
            "5",
            &(0, 1_000),
            |c, _, v| c.motion.arc_correction = v as u16,
            "Kept for old configurations: every corner of an arc that is cut is computed exactly.",
        )
        .v1("arc_correction")
        .support(&Support::Needless { why: "every point of an arc is computed exactly" }),
        axis_limit("x_axis_max_speed", "60000", |c, _, v| c.motion.axis_max_speed[0] = limit(v), "X")
            .v1("x_axis_max_speed").typical(&(300.0, 300_000.0)),
        axis_limit("y_axis_max_speed", "60000", |c, _, v| c.motion.axis_max_speed[1] = limit(v), "Y")
            .v1("y_axis_max_speed").typical(&(300.0, 300_000.0)),
        axis_limit("z_axis_max_speed", "300", |c, _, v| c.motion.axis_max_speed[2] = limit(v), "Z").klipper("[printer] max_z_velocity")
            .v1("z_axis_max_speed").typical(&(30.0, 300_000.0)),
        number(
            "max_speed",
            "0",
            ANY,
            |c, _, v| c.motion.max_speed = limit(v),
            "Limit of the speed along the path; 0 for none. M203 P changes it.",
        ).klipper("[printer] max_velocity")
        .unit("mm/min").typical(&(120.0, 300_000.0)),
        number(
            "default_acceleration",
            "100",
            POSITIVE,
            |c, _, v| c.motion.default_acceleration = MmPerSecond2(v),
            "Acceleration of a move, unless a motor's own limit is lower. M204 S changes it.",
        ).klipper("[printer] max_accel")
        .unit("mm/s^2").typical(&(5.0, 100_000.0))
        .v1("acceleration"),
        bool(
            "segment_z_moves",
            "true",
            |c, _, v| c.motion.segment_z_moves = v,
            "Cut moves that name neither X nor Y, too.",
        ),
        bool("save_wcs", "false", |c, _, v| c.motion.save_wcs = v, "M500 also saves the work offsets.").v1("save_g54"),
        bool("save_g92", "false", |c, _, v| c.motion.save_g92 = v, "M500 also saves the G92 offset.").v1("save_g92"),
        numbers(
            "set_g92",
            3,
            |c, _, v| c.motion.set_g92 = <[f64; 3]>::try_from(v).ok(),
            "A fixed G92 offset X,Y,Z set at boot.",
        )
        .unit("mm"),
        bool(
            "nist_G30",
            "false",
            |c, _, v| c.motion.nist_g30 = v,
            "With grbl_mode, G30 without P goes to the position that G30.1 stored instead of probing.",
        ),
        bool(
            "must_be_homed",
            "false",
            |c, _, v| c.motion.must_be_homed = v,
            "Refuse moves until every axis with a homing endstop has been homed.",
        )
        .derived("true for the two deltas, else false"),
        word(
            "arm_solution",
            "cartesian",
            ARM_SOLUTIONS,
            |c, _, v| c.motion.arm_solution = arm_solution(v),
            "How motors move the tool. rostock, kossel and delta mean linear_delta; hbot means corexy. The geometry has a section \
             of its own. A motor that turns an arm or a bed counts degrees where others count mm.",
        ).klipper("[printer] kinematics")
        .v1("arm_solution"),
    ],
};

/// Row for the speed limit of X, Y or Z; M203 changes the limits.
const fn axis_limit(
    key: &'static str,
    default: &'static str,
    set: super::Set<f64>,
    axis: &'static str,
) -> super::Setting {
    let summary = match axis.as_bytes() {
        b"X" => "Speed limit of the X part of a move; 0 for none. M203 X changes it.",
        b"Y" => "Speed limit of the Y part of a move; 0 for none. M203 Y changes it.",
        _ => "Speed limit of the Z part of a move; 0 for none. M203 Z changes it. The default is slow.",
    };
    number(key, default, ANY, set, summary).unit("mm/min")
}

pub const PLANNER: Section = Section {
    name: "planner",
    docs: Docs::new("Look-ahead: how fast corners are taken."),
    form: Form::Plain,
    settings: &[
        number(
            "junction_deviation",
            "0.05",
            &(0.0, 10.0),
            |c, _, v| c.planner.junction_deviation = Mm(v),
            "How far a rounded corner would miss the exact one; sets the speed kept through it. 0 stops at every corner.",
        ).unit("mm").typical(&(0.0001, 1.0))
        .v1("junction_deviation"),
        number(
            "z_junction_deviation",
            "-1",
            &(-1_000.0, 10.0),
            |c, _, v| c.planner.z_junction_deviation = (v >= 0.0).then_some(Mm(v)),
            "The same for moves of Z alone; negative: as junction_deviation.",
        )
        .unit("mm")
        .v1("z_junction_deviation"),
        number(
            "minimum_planner_speed",
            "0",
            &(0.0, 1_000.0),
            |c, _, v| c.planner.minimum_planner_speed = MmPerSecond(v),
            "Slowest speed at the start, the end and the corners of moves.",
        )
        .unit("mm/s").typical(&(0.001, 50.0))
        .v1("minimum_planner_speed"),
        integer(
            "planner_queue_size",
            "32",
            &(1, 65_535),
            |c, _, v| c.planner.queue_size = v as u16,
            "Moves the planner looks ahead.",
        )
        .limited(&(4.0, 224.0))
        .unit("moves")
        .v1("planner_queue_size"),
        number(
            "jerk",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.planner.jerk = some_jerk(v),
            "Limit of the rate of change of acceleration along the path: speed profiles are then S-curves. 0 here and for every axis: \
             trapezoids. Ramps take acceleration / jerk longer. Short moves need more planner_queue_size.",
        )
        .unit("mm/s^3").typical(&(1_000.0, 10_000_000.0))
        .velvet(),
        axis_jerk("x_axis_max_jerk", |c, _, v| c.planner.axis_jerk[0] = some_jerk(v), "The same for the X part of a move."),
        axis_jerk("y_axis_max_jerk", |c, _, v| c.planner.axis_jerk[1] = some_jerk(v), "The same for the Y part of a move."),
        axis_jerk("z_axis_max_jerk", |c, _, v| c.planner.axis_jerk[2] = some_jerk(v), "The same for the Z part of a move."),
        number(
            "square_corner_velocity",
            "0",
            &(0.0, 1_000.0),
            |c, _, v| c.planner.square_corner_velocity = (v > 0.0).then_some(MmPerSecond(v)),
            "Speed kept through a right angle at default_acceleration; other corners in proportion. Above 0 it takes the place of both \
             junction deviations; M205 X goes back to them.",
        )
        .unit("mm/s").typical(&(0.1, 50.0))
        .klipper("[printer] square_corner_velocity")
        .velvet(),
        number(
            "minimum_cruise_ratio",
            "0",
            &(0.0, 0.95),
            |c, _, v| c.planner.minimum_cruise_ratio = v,
            "Share of the way between two slow places that is cruised: the peak between is lowered for it. Calms short zigzags. For \
             trapezoids only.",
        )
        .klipper("[printer] minimum_cruise_ratio")
        .velvet(),
    ],
};

fn some_jerk(jerk: f64) -> Option<MmPerSecond3> {
    (jerk > 0.0).then_some(MmPerSecond3(jerk))
}

const fn axis_jerk(key: &'static str, set: super::Set<f64>, summary: &'static str) -> super::Setting {
    number(key, "0", NOT_NEGATIVE, set, summary).unit("mm/s^3").typical(&(1_000.0, 10_000_000.0)).velvet()
}

pub const CONVEYOR: Section = Section {
    name: "conveyor",
    docs: Docs::new("When queued moves start."),
    form: Form::Plain,
    settings: &[integer(
        "queue_delay_time_ms",
        "100",
        &(0, i32::MAX as i64),
        |c, _, v| c.planner.queue_delay = Micros::from_millis(v.unsigned_abs()),
        "How long an idle machine gathers moves before it starts them; a full queue starts at once.",
    )
    .unit("ms")
    .limited(&(0.0, 60_000.0))
    .v1("queue_delay_time_ms")],
};
