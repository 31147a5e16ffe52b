//! Homing and probing: `[endstops]`, `[soft endstop]` and `[zprobe]`.

use crate::names::{Command, Name, spaced};
use crate::pin::Pin;
use crate::setting::build::{ANY, NOT_NEGATIVE, POSITIVE, axes, bool, integer, number, numbers, pin, text, word};
use crate::setting::declare::{settings, words};
use crate::setting::{PinRole, Words};
use heapless::Vec;
use units::{Amps, Axis, AxisSet, Micros, Mm, MmPerSecond};

/// Greatest number of endstops: two per axis.
pub const MAX_ENDSTOPS: usize = 12;

words! {
    /// Direction in which an axis moves to find its endstop.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum HomingDirection {
        /// The endstop is not used for homing.
        #[default]
        None = "none",
        /// Towards the negative end of travel.
        ToMin = "home_to_min",
        /// Towards the positive end of travel.
        ToMax = "home_to_max",
    }
}

settings! {
    /// Switches that axes home to and that limit their travel, and how homing goes.
    #[derive(Clone, Debug, Default)]
    pub struct EndstopConfig {
        /// Name of the endstop in the file.
        name: Name;
        /// There is such an endstop.
        enable: bool = bool("false");
        /// Input, logically high when the switch is hit. The endstop connectors need a pull-up: ^.
        pin: Option<Pin> = pin("nc", PinRole::Input).klipper("[stepper_<axis>] endstop_pin").v1("<axis>_min_endstop");
        /// Axis of the switch; for a slaved motor's own switch the letter of that motor (A, B or C).
        axis: Option<Axis> = word("", AXES).required();
        /// Which way the axis moves to home on this switch. One homing switch per axis.
        homing_direction: HomingDirection = word("none", HomingDirection::WORDS)
            .klipper("[stepper_<axis>] homing_positive_dir").v1("<axis>_homing_direction");
        /// Coordinate of the axis at the switch.
        homing_position: Mm = number("0", ANY)
            .klipper("[stepper_<axis>] position_endstop").derived("0 for home_to_min, 200 for home_to_max")
            .unit("mm").v1("<axis>_min");
        /// Longest homing move; not to meet the switch within it halts.
        max_travel: Mm = number("500", POSITIVE).unit("mm").typical(&(2.0, 5_000.0)).v1("<axis>_max_travel");
        /// Speed of the first approach.
        fast_rate: MmPerSecond = number("100", POSITIVE)
            .klipper("[stepper_<axis>] homing_speed").unit("mm/s").typical(&(0.5, 500.0))
            .v1("<axis>_fast_homing_rate_mm_s");
        /// Speed of backing off and of the second approach.
        slow_rate: MmPerSecond = number("10", POSITIVE)
            .klipper("[stepper_<axis>] second_homing_speed").unit("mm/s").typical(&(0.1, 100.0))
            .v1("<axis>_slow_homing_rate_mm_s");
        /// Distance backed off between the approaches; the second goes at most twice as far.
        retract: Mm = number("5", NOT_NEGATIVE)
            .klipper("[stepper_<axis>] homing_retract_dist").unit("mm").typical(&(0.1, 50.0))
            .v1("<axis>_homing_retract_mm");
        /// Hitting the switch in any other move halts. Not for the switch of a slaved motor.
        limit_enable: bool = bool("false").v1("<axis>_limit_enable");
        /// Settings for the motor's phase at the hit.
        phase: EndstopPhaseConfig;
        /// Settings of sensorless homing, without a switch.
        stall: EndstopStallConfig;
    }
}

settings! {
    /// Sensorless homing: the motor's stall marks the end of the axis.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct EndstopStallConfig {
        /// Home without a switch: the axis runs against its end, and the stallGuard output of its driver says
        /// so. `pin` is that output, which on-board drivers have wired; both approaches then go at fast_rate
        /// unless slow_rate is written, and homing ends `retract` away from the end.
        "stall_homing" homing: bool = bool("false").velvet();
        /// Peak coil current while it homes so: less pushes less hard against the end, and stalls sooner.
        "stall_current" current: Option<Amps> = number("0", &(0.001, 20.0))
            .derived("that of the motor").unit("A").typical(&(0.05, 10.0)).velvet();
        /// How little load counts as a stall (SGT, -64 to 63): lower is more sensitive. Too low stalls on the
        /// way, too high never stalls. With a TMC2209 or TMC2226 (SGTHRS, 0 to 255) it is the other way
        /// round.
        "stall_threshold" threshold: i16 = integer("0", &(-64, 255))
            .klipper("[tmc2660 <stepper>] driver_SGT").velvet();
    }
}

impl EndstopStallConfig {
    /// Full steps at constant speed that pass before a StallGuard reading counts: two periods of its filter.
    pub const SETTLING_FULL_STEPS: f64 = 8.0;
    /// Additional full steps between the first place at which a stall can be seen and the end of the axis, so
    /// that one is told from the other.
    pub const APART_FULL_STEPS: f64 = 8.0;
    /// Greatest lag of the motors behind the plan, seconds: steps written ahead, and time between two looks.
    pub const SETTLING_S: f64 = 0.0025;

    /// Returns the distance from its end at which an axis must start to detect the stall there: mm, from
    /// mm/s, mm/s^2, mm/s^3.
    #[must_use]
    pub fn run_up(rate: f64, acceleration: f64, jerk: Option<f64>, full_steps_per_mm: f64) -> f64 {
        // With a jerk limit the acceleration rises and falls; where it has no time to, this is an upper
        // bound.
        let seconds = rate / acceleration + jerk.map_or(0.0, |jerk| acceleration / jerk);
        let full_steps = Self::SETTLING_FULL_STEPS + Self::APART_FULL_STEPS;
        rate * seconds / 2.0 + full_steps / full_steps_per_mm + rate * Self::SETTLING_S
    }
}

settings! {
    /// Check of the motor's phase, within its electrical cycle of four full steps, when its axis hits the
    /// switch.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct EndstopPhaseConfig {
        /// Each homing compares where the motor is in its cycle of four full steps when the switch closes
        /// with where it was calibrated, and puts the axis at the nearest place that has the calibrated
        /// phase.
        "phase_check" check: bool = bool("false").klipper("[endstop_phase stepper_<axis>]").velvet();
        /// The calibrated phase, which ENDSTOP_PHASE_CALIBRATE finds and M500 saves. 0 to 1024 is one cycle;
        /// it rises as the motor counts up. Klipper's trigger_phase a/b is 1024 a/b. Not for external
        /// drivers, whose phase nobody can read.
        "phase" calibrated: Option<f64> = number("0", &(0.0, 1_023.999))
            .derived("that of the first homing since power up")
            .klipper("[endstop_phase stepper_<axis>] trigger_phase").unit("1/256 full step").velvet();
        /// How far from the calibrated phase the switch may close, either way: less than half a cycle. Half
        /// of Klipper's endstop_accuracy.
        "phase_tolerance" tolerance: Option<Mm> = number("0", NOT_NEGATIVE)
            .derived("one full step").klipper("[endstop_phase stepper_<axis>] endstop_accuracy").unit("mm").velvet();
        /// Move the homing position by half a full step at most, so that coordinate 0 is at a full step:
        /// layers of whole full steps are then held at full steps.
        "phase_align_zero" align_zero: bool = bool("false")
            .klipper("[endstop_phase stepper_<axis>] endstop_align_zero").velvet();
        /// What follows when the switch closes further off than phase_tolerance, or the phase cannot be read:
        /// a warning, and the axis is homed to its switch alone; or an alarm, and the axis is not homed.
        /// Klipper does the latter.
        "phase_fault" halts: bool = word("warn", REACTIONS).velvet();
    }
}

settings! {
    /// Settings under `[endstops] common`.
    #[derive(Clone, Debug, Default)]
    pub struct HomingConfig {
        /// How long a switch must stay hit to count.
        "debounce_ms" debounce: Micros = number("0", &(0.0, 1_000.0))
            .common().unit("ms").v1("endstop_debounce_ms") => millis;
        /// Axes homed one after another, as in ZXY. Without it, or with fewer than three: X with Y, then Z,
        /// then A, B, C.
        "homing_order" = axes().common().v1("homing_order") => HomingConfig::set_order;
        /// Home Z before X and Y; homing_order is stronger.
        "home_z_first" z_first: bool = bool("false").common().v1("home_z_first");
        /// Home one axis at a time and stop both X and Y motors at the switch.
        "corexy_homing" corexy: bool = bool("false")
            .derived("true when arm_solution is corexy").common().v1("corexy_homing");
        /// Home all three towers with one upward move.
        "delta_homing" delta: bool = bool("false")
            .derived("true when arm_solution is linear_delta").common().v1("delta_homing");
        /// Home a rotary delta by its arm angles.
        "rdelta_homing" rotary_delta: bool = bool("false")
            .derived("true when arm_solution is rotary_delta").common().v1("rdelta_homing");
        /// Home in motor angles, with the kinematics switched off.
        "scara_homing" scara: bool = bool("false")
            .derived("true when arm_solution is morgan").common().v1("scara_homing");
        /// Move to machine X0 Y0 after homing.
        "move_to_origin_after_home" move_to_origin: bool = bool("false")
            .derived("as delta_homing").common().v1("move_to_origin_after_home");
        /// Raise Z so far before X and Y home, or go to where Z homes, so that the tool clears clamps and
        /// parts. Not where Z homes to its maximum.
        "home_lift" lift: Mm = number("0", NOT_NEGATIVE).common().klipper("[safe_z_home] z_hop").unit("mm").velvet();
        /// Machine X and Y where Z homes; `None`: at the current position.
        safe_z: [Option<Mm>; 2];
        /// Z homes at this machine X, behind X and Y.
        "safe_z_x" safe_z[0] = number("0", ANY)
            .derived("wherever the tool is").common().klipper("[safe_z_home] home_xy_position").unit("mm").velvet();
        /// The same of Y.
        "safe_z_y" safe_z[1] = number("0", ANY)
            .derived("wherever the tool is").common().klipper("[safe_z_home] home_xy_position").unit("mm").velvet();
        /// Slow approaches to each switch; with more than one they must agree, and their mean counts.
        "homing_samples" samples: u8 = integer("1", &(1, 20)).common().velvet();
        /// How far they may lie apart.
        "homing_tolerance" tolerance: Mm = number("0.02", NOT_NEGATIVE).common().unit("mm").velvet();
        /// Rounds that are added where they lie further apart; then homing has failed.
        "homing_retries" retries: u8 = integer("3", &(0, 20)).common().velvet();
        /// A line executed instead of G28 without axes. G28 within it homes. Underscores stand for blanks.
        "home_gcode" gcode: Command = text("", 96).common().klipper("[homing_override] gcode").velvet() => spaced;
        /// A line executed for Z by G28 with Z or without axes, behind the others: that of a probe where Z
        /// has no switch. Underscores stand for blanks.
        "home_z_gcode" z_gcode: Command = text("", 96).common().velvet() => spaced;
        /// Trims of the first three actuators.
        trim: [Mm; 3];
        /// How much the switch of this tower or arm sits too low; negative where it sits too high. M666
        /// changes it.
        "alpha_trim_mm" trim[0] = number("0", ANY).common().unit("mm").v1("alpha_trim_mm");
        /// How much the switch of this tower or arm sits too low; negative where it sits too high. M666
        /// changes it.
        "beta_trim_mm" trim[1] = number("0", ANY).common().unit("mm").v1("beta_trim_mm");
        /// How much the switch of this tower or arm sits too low; negative where it sits too high. M666
        /// changes it.
        "gamma_trim_mm" trim[2] = number("0", ANY).common().unit("mm").v1("gamma_trim_mm");
        /// Axes one after another in this order; empty: XY together, then Z, then A B C.
        order: Vec<Axis, 6>;
    }
}

impl HomingConfig {
    fn set_order(&mut self, axes: &[Axis]) {
        self.order.clear();
        // With fewer G28 would leave axes as they are. No letter stands twice, so six fit.
        if axes.len() >= 3 {
            let _ = self.order.extend_from_slice(axes);
        }
    }

    /// Returns whether homing these axes ends over the origin: only with both X and Y, as an axis that is not
    /// homed stays in place. A rotary delta stays where its arms meet their switches.
    #[must_use]
    pub fn ends_over_origin(&self, homed: AxisSet) -> bool {
        self.move_to_origin && !self.rotary_delta && homed.has(Axis::X) && homed.has(Axis::Y)
    }
}

settings! {
    /// The ends of travel in machine coordinates: no move of a homed axis starts that would leave them.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct SoftEndstops {
        /// Moves are held against the ends of travel. M211 S changes it until the next reset.
        enable: bool = bool("true").v1("soft_endstop.enable").velvet();
        /// A move that would leave the travel halts the machine; otherwise it is refused, and a file waits
        /// there.
        halt: bool = bool("false").derived("as grbl_mode").v1("soft_endstop.halt").velvet();
        /// Least machine position of X, Y and Z, where written.
        least: [Option<Mm>; 3];
        /// The least machine position of the axis.
        "x_min" least[0] = number("0", ANY)
            .derived("from homing_position and max_travel").unit("mm").v1("soft_endstop.x_min")
            .klipper("[stepper_<axis>] position_min").velvet();
        /// Greatest machine position of X, Y and Z, where written.
        most: [Option<Mm>; 3];
        /// The greatest machine position of the axis.
        "x_max" most[0] = number("0", ANY)
            .derived("from homing_position and max_travel").unit("mm").v1("soft_endstop.x_max")
            .klipper("[stepper_<axis>] position_max").velvet();
        /// The least machine position of the axis.
        "y_min" least[1] = number("0", ANY)
            .derived("from homing_position and max_travel").unit("mm").v1("soft_endstop.y_min")
            .klipper("[stepper_<axis>] position_min").velvet();
        /// The greatest machine position of the axis.
        "y_max" most[1] = number("0", ANY)
            .derived("from homing_position and max_travel").unit("mm").v1("soft_endstop.y_max")
            .klipper("[stepper_<axis>] position_max").velvet();
        /// The least machine position of the axis.
        "z_min" least[2] = number("0", ANY)
            .derived("from homing_position and max_travel").unit("mm").v1("soft_endstop.z_min")
            .klipper("[stepper_<axis>] position_min").velvet();
        /// The greatest machine position of the axis.
        "z_max" most[2] = number("0", ANY)
            .derived("from homing_position and max_travel").unit("mm").v1("soft_endstop.z_max")
            .klipper("[stepper_<axis>] position_max").velvet();
    }
}

settings! {
    /// A probe that finds the bed or the work piece.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct ProbeConfig {
        /// There is a probe.
        enable: bool = bool("false").v1("zprobe.enable");
        /// Input, logically high when triggered. The board's probe connector is PB10.
        "probe_pin" pin: Option<Pin> = pin("nc", PinRole::Input).klipper("[probe] pin").v1("zprobe.probe_pin");
        /// Speed of the search. M670 S changes it.
        "slow_feedrate" slow_rate: MmPerSecond = number("5", POSITIVE)
            .klipper("[probe] speed").unit("mm/s").typical(&(0.1, 50.0)).v1("zprobe.slow_feedrate");
        /// Speed of travel between probed points. M670 K changes it.
        "fast_feedrate" fast_rate: MmPerSecond = number("100", POSITIVE)
            .unit("mm/s").typical(&(1.0, 500.0)).v1("zprobe.fast_feedrate");
        /// Speed of lifting after a touch; 0: twice slow_feedrate, at most fast_feedrate. M670 R changes it.
        "return_feedrate" return_rate: MmPerSecond = number("0", NOT_NEGATIVE)
            .klipper("[probe] lift_speed").unit("mm/s").typical(&(0.1, 500.0)).v1("zprobe.return_feedrate");
        /// Clearance over the bed between touches. M670 H changes it.
        "probe_height" height: Mm = number("5", NOT_NEGATIVE).unit("mm").v1("zprobe.probe_height");
        /// Longest search; no touch within it is a miss. M670 Z changes it.
        max_travel: Mm = number("200", POSITIVE).unit("mm").v1("zprobe.max_z");
        /// Search towards positive Z.
        reverse_z: bool = bool("false").v1("zprobe.reverse_z");
        /// Pause before each search. M670 D changes it.
        "dwell_before_probing" dwell: Micros = number("0", &(0.0, 60.0)).unit("s").v1("zprobe.dwell_before_probing");
        /// How long the probe must stay triggered to count; 0 stops at once.
        "debounce_ms" debounce: Micros = number("0", &(0.0, 1_000.0)).unit("ms").v1("zprobe.debounce_ms") => millis;
        /// Probe position relative to the nozzle as X,Y and how high the nozzle is as the contact closes,
        /// where the leveling strategy has none of its own. M565 and M851 change it.
        "probe_offsets" offsets: [f64; 3] = numbers(3).unit("mm").klipper("[probe] x_offset").velvet();
        rows ProbeContact:
        /// Input, logically high while the probe is out: nothing is probed otherwise.
        deployed_pin: Option<Pin> = pin("nc", PinRole::Input).velvet();
        /// Put away, the probe reads triggered, as a magnetic one in its dock: so the machine sees whether it
        /// is out.
        stowed_reads_triggered: bool = bool("false").velvet();
        /// Repeated touches of one place.
        samples: SamplesConfig;
    }
}

/// Lines that deploy the probe and stow the probe.
type Scripts = [Command; 2];

settings! {
    /// Deploying and stowing.
    rows ProbeScripts of Scripts {
        /// Line that brings the probe out before it searches: moves, waits, modes and switches, in mm and
        /// absolute, or a RUN_TEMPLATE. M401 runs it too.
        "deploy_gcode" [0] = text("", 96).klipper("[probe] activate_gcode").velvet();
        /// Line that puts the probe away when a command that has probed ends. M402 runs it too.
        "stow_gcode" [1] = text("", 96).klipper("[probe] deactivate_gcode").velvet();
    }
}

settings! {
    /// Repeated touches of one place: `[zprobe]` `samples` and related settings.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct SamplesConfig {
        /// Touches of each place where a bed is measured: grids, three points, Z motors, screws.
        "samples" count: u8 = integer("1", &(1, 50)).unit("touches").klipper("[probe] samples").velvet();
        /// What several touches come to. A median leaves out one that went wrong.
        "samples_result" median: bool = word("average", &Words(&["average", "median"]))
            .klipper("[probe] samples_result").velvet();
        /// Touches of one place that lie further apart are made again; 0: they are not held against each
        /// other.
        "samples_tolerance" tolerance: Mm = number("0.1", NOT_NEGATIVE)
            .unit("mm").typical(&(0.003, 1.0)).klipper("[probe] samples_tolerance").velvet();
        /// How often they are made again before measuring ends with an error.
        "samples_retries" retries: u8 = integer("3", &(0, 20))
            .unit("times").klipper("[probe] samples_tolerance_retries").velvet();
        /// How far the probe rises between touches of one place.
        "samples_retract" retract: Mm = number("2", POSITIVE)
            .unit("mm").typical(&(0.2, 20.0)).klipper("[probe] sample_retract_dist").velvet();
    }
}

impl ProbeConfig {
    /// Returns the default speed of the lift after a touch.
    #[must_use]
    pub fn usual_return_rate(&self) -> MmPerSecond {
        let twice = self.slow_rate * 2.0;
        if twice < self.fast_rate { twice } else { self.fast_rate }
    }
}

const AXES: &Words = &Words(&["X", "Y", "Z", "A", "B", "C"]);
/// Reactions to a phase that is off.
const REACTIONS: &Words = &Words(&["warn", "halt"]);

/// A duration that was counted in milliseconds.
fn millis(value: f64) -> Micros {
    Micros((value * 1_000.0) as u64)
}
