//! Path and speed: `[motion control]`, `[planner]`, `[conveyor]`, `[input shaper]`.

use super::arms::Arms;
use crate::setting::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number, numbers, word};
use crate::setting::declare::settings;
use crate::setting::field::word_field;
use crate::setting::{Support, Words};
use units::{
    Actuator, ArcSettings, Axis, AxisSet, LineSettings, Micros, Mm, MmPerSecond, MmPerSecond2, MmPerSecond3, ShaperKind,
};

/// Kinematics: relation of actuators to Cartesian axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArmSolution {
    /// Cartesian: one motor per axis.
    #[default]
    Cartesian,
    /// CoreXY: alpha = X + Y, beta = X - Y (`hbot`, `corexy`).
    CoreXy,
    /// CoreXZ: alpha and beta share X and Z, gamma carries Y.
    CoreXz,
    /// Linear delta with three vertical towers.
    LinearDelta,
    /// Rotary delta with three shoulder motors.
    RotaryDelta,
    /// SCARA with a two-link arm.
    Morgan,
    /// Hybrid CoreXY: alpha = X - Y.
    HybridCoreXy,
    /// Hybrid CoreXZ: alpha = X - Z.
    HybridCoreXz,
    /// Deltesian: two vertical towers, a bed in Y.
    Deltesian,
    /// Polar, with a turning bed.
    Polar,
    /// Winches that pull ropes.
    Winch,
    /// Any linear combination of the axes.
    Generic,
    /// Lathe: alpha is X, beta is Z.
    Lathe,
}

impl ArmSolution {
    /// Returns the axes that a motor moves; `None` where a motor's place depends on all of them.
    #[must_use]
    pub const fn axes_of(self, motor: Actuator) -> Option<AxisSet> {
        const fn both(one: Axis, other: Axis) -> AxisSet {
            AxisSet::of(one).with(other)
        }
        Some(match (self, motor) {
            (_, Actuator::Delta) => AxisSet::of(Axis::A),
            (_, Actuator::Epsilon) => AxisSet::of(Axis::B),
            (_, Actuator::Zeta) => AxisSet::of(Axis::C),
            (Self::Cartesian, Actuator::Beta) => AxisSet::of(Axis::Y),
            (Self::CoreXy, Actuator::Alpha | Actuator::Beta) => both(Axis::X, Axis::Y),
            (Self::CoreXz, Actuator::Alpha | Actuator::Beta) => both(Axis::X, Axis::Z),
            (Self::CoreXz, Actuator::Gamma) => AxisSet::of(Axis::Y),
            (Self::Cartesian, Actuator::Alpha) => AxisSet::of(Axis::X),
            (Self::Cartesian | Self::CoreXy, Actuator::Gamma) => AxisSet::of(Axis::Z),
            _ => return None,
        })
    }
}

settings! {
    /// Speeds, arcs and kinematics of the machine as a whole.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct MotionControl {
        /// Speed of G1, G2 and G3 until an F word sets it; 0: refused until then.
        default_feed_rate: MmPerSecond = number("4000", NOT_NEGATIVE)
            .unit("mm/min").typical(&(60.0, 100_000.0)).v1("default_feed_rate") => MmPerSecond::from_per_minute;
        /// Speed of G0 until an F word on a G0 sets it, which in GRBL's dialect none does.
        default_seek_rate: MmPerSecond = number("4000", POSITIVE)
            .unit("mm/min").typical(&(120.0, 200_000.0)).v1("default_seek_rate") => MmPerSecond::from_per_minute;
        /// F always sets the speed of G1; G0 keeps default_seek_rate, which M203 S changes, and M220 and M121
        /// do not.
        compliant_seek_rate: bool = bool("false");
        /// How straight moves are cut.
        lines: LineSettings;
        /// How arcs are cut.
        arcs: ArcSettings;
        /// Longest piece a straight move is cut into; 0: it is not cut. Velvet evaluates the kinematics all
        /// along the path, so only a bed correction could need this.
        "mm_per_line_segment" lines.segment_length = number("0", NOT_NEGATIVE)
            .unit("mm").v1("mm_per_line_segment") => |v: f64| (v >= 1e-4).then_some(v);
        /// Pieces per second a straight move is cut into, stronger than mm_per_line_segment; 0: it is not
        /// cut. Lines are exact without; each piece has the speed that its own part of the way allows.
        "delta_segments_per_second" lines.segments_per_second = number("0", NOT_NEGATIVE)
            .derived("100 for the two deltas, else 0").unit("1/s").v1("delta_segments_per_second")
            => |v: f64| (v > 1.0).then_some(v);
        /// Above zero: arcs are cut into chords of this length, or of that of mm_max_arc_error if it is
        /// longer.
        "mm_per_arc_segment" arcs.segment_length = number("0", NOT_NEGATIVE)
            .klipper("[gcode_arcs] resolution").unit("mm").v1("mm_per_arc_segment");
        /// Above zero: arcs are cut into chords that leave them by this at most. With 0 here and in
        /// mm_per_arc_segment arcs are exact.
        "mm_max_arc_error" arcs.max_error = number("0", NOT_NEGATIVE)
            .unit("mm").typical(&(0.0001, 1.0)).v1("mm_max_arc_error");
        /// Kept for old configurations: every corner of an arc that is cut is computed exactly.
        arc_correction: u16 = integer("5", &(0, 1_000))
            .v1("arc_correction").support(&Support::Needless { why: "every point of an arc is computed exactly" });
        /// Speed limit of X, Y and Z; none: no limit.
        axis_max_speed: [Option<MmPerSecond>; 3];
        /// Speed limit of the X part of a move; 0 for none. M203 X changes it.
        "x_axis_max_speed" axis_max_speed[0] = number("60000", ANY)
            .unit("mm/min").v1("x_axis_max_speed").typical(&(300.0, 300_000.0)) => limit;
        /// Speed limit of the Y part of a move; 0 for none. M203 Y changes it.
        "y_axis_max_speed" axis_max_speed[1] = number("60000", ANY)
            .unit("mm/min").v1("y_axis_max_speed").typical(&(300.0, 300_000.0)) => limit;
        /// Speed limit of the Z part of a move; 0 for none. M203 Z changes it. The default is slow.
        "z_axis_max_speed" axis_max_speed[2] = number("300", ANY)
            .unit("mm/min").klipper("[printer] max_z_velocity").v1("z_axis_max_speed").typical(&(30.0, 300_000.0))
            => limit;
        /// Limit of the speed along the path; 0 for none. M203 P changes it.
        max_speed: Option<MmPerSecond> = number("0", ANY)
            .klipper("[printer] max_velocity").unit("mm/min").typical(&(120.0, 300_000.0)) => limit;
        /// Acceleration of a move, unless a motor's own limit is lower. M204 S changes it.
        default_acceleration: MmPerSecond2 = number("100", POSITIVE)
            .klipper("[printer] max_accel").unit("mm/s^2").typical(&(5.0, 100_000.0)).v1("acceleration");
        /// Cut moves that name neither X nor Y, too.
        segment_z_moves: bool = bool("true");
        /// M500 also saves the work offsets.
        save_wcs: bool = bool("false").v1("save_g54");
        /// M500 also saves the G92 offset.
        save_g92: bool = bool("false").v1("save_g92");
        /// A fixed G92 offset X,Y,Z set at boot.
        set_g92: Option<[f64; 3]> = numbers(3).unit("mm");
        /// With grbl_mode, G30 without P goes to the position that G30.1 stored instead of probing.
        "nist_G30" nist_g30: bool = bool("false");
        /// Refuse moves until every axis with a homing endstop has been homed.
        must_be_homed: bool = bool("false").derived("true for the two deltas, else false");
        /// How motors move the tool. rostock, kossel and delta mean linear_delta; hbot means corexy. The
        /// geometry has a section of its own. A motor that turns an arm or a bed counts degrees where others
        /// count mm.
        arm_solution: ArmSolution = word("cartesian", ARM_SOLUTIONS)
            .klipper("[printer] kinematics").v1("arm_solution") => arm_solution;
        /// Geometry of the kinematics.
        arms: Arms;
    }
}

settings! {
    /// Look-ahead: how fast corners are taken.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct PlannerConfig {
        /// How far a rounded corner would miss the exact one; sets the speed kept through it. 0 stops at
        /// every corner.
        junction_deviation: Mm = number("0.05", &(0.0, 10.0))
            .unit("mm").typical(&(0.0001, 1.0)).v1("junction_deviation");
        /// The same for moves of Z alone; negative: as junction_deviation.
        z_junction_deviation: Option<Mm> = number("-1", &(-1_000.0, 10.0))
            .unit("mm").v1("z_junction_deviation") => |v: f64| (v >= 0.0).then_some(Mm(v));
        /// Slowest speed at the start, the end and the corners of moves.
        minimum_planner_speed: MmPerSecond = number("0", &(0.0, 1_000.0))
            .unit("mm/s").typical(&(0.001, 50.0)).v1("minimum_planner_speed");
        /// Moves the planner looks ahead.
        "planner_queue_size" queue_size: u16 = integer("32", &(1, 65_535))
            .limited(&(4.0, 224.0)).unit("moves").v1("planner_queue_size");
        /// Limit of the rate of change of acceleration along the path: speed profiles are then S-curves. 0
        /// here and for every axis: trapezoids. Ramps take acceleration / jerk longer. Short moves need more
        /// planner_queue_size.
        jerk: Option<MmPerSecond3> = number("0", NOT_NEGATIVE)
            .unit("mm/s^3").typical(&(1_000.0, 10_000_000.0)).velvet() => some_jerk;
        /// Jerk limits of X, Y and Z.
        axis_jerk: [Option<MmPerSecond3>; 3];
        /// The same for the X part of a move.
        "x_axis_max_jerk" axis_jerk[0] = number("0", NOT_NEGATIVE)
            .unit("mm/s^3").typical(&(1_000.0, 10_000_000.0)).velvet() => some_jerk;
        /// The same for the Y part of a move.
        "y_axis_max_jerk" axis_jerk[1] = number("0", NOT_NEGATIVE)
            .unit("mm/s^3").typical(&(1_000.0, 10_000_000.0)).velvet() => some_jerk;
        /// The same for the Z part of a move.
        "z_axis_max_jerk" axis_jerk[2] = number("0", NOT_NEGATIVE)
            .unit("mm/s^3").typical(&(1_000.0, 10_000_000.0)).velvet() => some_jerk;
        /// Speed kept through a right angle at default_acceleration; other corners in proportion. Above 0 it
        /// takes the place of both junction deviations; M205 X goes back to them.
        square_corner_velocity: Option<MmPerSecond> = number("0", &(0.0, 1_000.0))
            .unit("mm/s").typical(&(0.1, 50.0)).klipper("[printer] square_corner_velocity").velvet()
            => |v: f64| (v > 0.0).then_some(MmPerSecond(v));
        /// Share of the way between two slow places that is cruised: the peak between is lowered for it.
        /// Calms short zigzags. For trapezoids only.
        minimum_cruise_ratio: f64 = number("0", &(0.0, 0.95)).klipper("[printer] minimum_cruise_ratio").velvet();
        /// Time for which an idle queue may collect blocks before motion starts.
        queue_delay: Micros;
    }
}

/// The input shaper of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InputShaperConfig {
    /// Kind of the shaper.
    pub shaper: ShaperKind,
    /// Resonance frequency in hertz; none: the axis is not shaped.
    pub frequency_hz: Option<f64>,
    /// Damping ratio of the resonance.
    pub damping_ratio: f64,
}

settings! {
    /// When queued moves start.
    rows Conveyor of PlannerConfig {
        /// How long an idle machine gathers moves before it starts them; a full queue starts at once.
        "queue_delay_time_ms" queue_delay = integer("100", &(0, i32::MAX as i64))
            .unit("ms").limited(&(0.0, 60_000.0)).v1("queue_delay_time_ms")
            => |v: i64| Micros::from_millis(v.unsigned_abs());
    }
}

word_field!(ShaperKind);

const SHAPERS: &Words = &Words(ShaperKind::WORDS);

/// Shapers of X, Y and Z.
type Shapers = [InputShaperConfig; 3];

settings! {
    /// Moves X, Y and Z so that resonances of the frame cancel themselves. All axes then lag behind the plan
    /// by the longest shaper's mean delay, about 0.2 (zv) to 0.8 (3hump_ei) periods of its resonance.
    rows InputShapers of Shapers {
        /// Shaper of X.
        "shaper_type_x" [0].shaper = word("mzv", SHAPERS).klipper("[input_shaper] shaper_type").velvet();
        /// Resonance of X; 0: X is not shaped.
        "shaper_freq_x" [0].frequency_hz = number("0", &(0.0, 1_000.0))
            .unit("Hz").typical(&(5.0, 200.0)).klipper("[input_shaper] shaper_freq_<axis>").velvet() => some_frequency;
        /// Damping ratio of the resonance of X.
        "damping_ratio_x" [0].damping_ratio = number("0.1", &(0.0, 0.99))
            .klipper("[input_shaper] damping_ratio_<axis>").velvet();
        /// Shaper of Y.
        "shaper_type_y" [1].shaper = word("mzv", SHAPERS).klipper("[input_shaper] shaper_type").velvet();
        /// Resonance of Y; 0: Y is not shaped.
        "shaper_freq_y" [1].frequency_hz = number("0", &(0.0, 1_000.0))
            .unit("Hz").typical(&(5.0, 200.0)).klipper("[input_shaper] shaper_freq_<axis>").velvet() => some_frequency;
        /// Damping ratio of the resonance of Y.
        "damping_ratio_y" [1].damping_ratio = number("0.1", &(0.0, 0.99))
            .klipper("[input_shaper] damping_ratio_<axis>").velvet();
        /// Shaper of Z.
        "shaper_type_z" [2].shaper = word("mzv", SHAPERS).klipper("[input_shaper] shaper_type").velvet();
        /// Resonance of Z; 0: Z is not shaped.
        "shaper_freq_z" [2].frequency_hz = number("0", &(0.0, 1_000.0))
            .unit("Hz").typical(&(5.0, 200.0)).klipper("[input_shaper] shaper_freq_<axis>").velvet() => some_frequency;
        /// Damping ratio of the resonance of Z.
        "damping_ratio_z" [2].damping_ratio = number("0.1", &(0.0, 0.99))
            .klipper("[input_shaper] damping_ratio_<axis>").velvet();
    }
}

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

fn some_jerk(jerk: f64) -> Option<MmPerSecond3> {
    (jerk > 0.0).then_some(MmPerSecond3(jerk))
}

fn some_frequency(hertz: f64) -> Option<f64> {
    (hertz > 0.0).then_some(hertz)
}
