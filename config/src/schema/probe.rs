//! `[zprobe]` and the calibration strategy.

use super::build::{NOT_NEGATIVE, POSITIVE, bool, integer, number, numbers, pin, text, word};
use super::endstops::millis;
use super::leveling::line_of;
use super::{Docs, Form, PinRole, Section, Words};
use crate::machine::Leveling;
use crate::pin::PinName;
use units::{Micros, Mm, MmPerSecond};

/// The words of `leveling`, and what they mean.
const STRATEGIES: &Words = &Words(&["three point", "delta grid", "cartesian grid"]);

const fn strategy(word: usize) -> Leveling {
    match word {
        0 => Leveling::ThreePoint,
        1 => Leveling::DeltaGrid,
        _ => Leveling::CartesianGrid,
    }
}

/// The words of `factors`, and their numbers.
const FACTORS: &Words = &Words(&["3", "4", "6", "7", "9"]);
const FACTOR_COUNTS: [u8; 5] = [3, 4, 6, 7, 9];

pub const ZPROBE: Section = Section {
    name: "zprobe",
    store: None,
    docs: Docs::new("A probe that finds the bed or the work piece."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", |c, _, v| c.probe.enable = v, "There is a probe.").v1("zprobe.enable"),
        pin(
            "probe_pin",
            "nc",
            PinRole::Input,
            |c, _, v| c.probe.pin = v.and_then(PinName::digital),
            "Input, logically high when triggered. The board's probe connector is PB10.",
        )
        .klipper("[probe] pin")
        .v1("zprobe.probe_pin"),
        number(
            "slow_feedrate",
            "5",
            POSITIVE,
            |c, _, v| c.probe.slow_rate = MmPerSecond(v),
            "Speed of the search. M670 S changes it.",
        )
        .klipper("[probe] speed")
        .unit("mm/s")
        .typical(&(0.1, 50.0))
        .v1("zprobe.slow_feedrate"),
        number(
            "fast_feedrate",
            "100",
            POSITIVE,
            |c, _, v| c.probe.fast_rate = MmPerSecond(v),
            "Speed of travel between probed points. M670 K changes it.",
        )
        .unit("mm/s")
        .typical(&(1.0, 500.0))
        .v1("zprobe.fast_feedrate"),
        number(
            "return_feedrate",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.probe.return_rate = MmPerSecond(v),
            "Speed of lifting after a touch; 0: twice slow_feedrate, at most fast_feedrate. M670 R changes it.",
        )
        .klipper("[probe] lift_speed")
        .unit("mm/s")
        .typical(&(0.1, 500.0))
        .v1("zprobe.return_feedrate"),
        number(
            "probe_height",
            "5",
            NOT_NEGATIVE,
            |c, _, v| c.probe.height = Mm(v),
            "Clearance over the bed between touches. M670 H changes it.",
        )
        .unit("mm")
        .v1("zprobe.probe_height"),
        number(
            "max_travel",
            "200",
            POSITIVE,
            |c, _, v| c.probe.max_travel = Mm(v),
            "Longest search; no touch within it is a miss. M670 Z changes it.",
        )
        .unit("mm")
        .v1("zprobe.max_z"),
        bool("reverse_z", "false", |c, _, v| c.probe.reverse_z = v, "Search towards positive Z.")
            .v1("zprobe.reverse_z"),
        number(
            "dwell_before_probing",
            "0",
            &(0.0, 60.0),
            |c, _, v| c.probe.dwell = Micros((v * 1e6) as u64),
            "Pause before each search. M670 D changes it.",
        )
        .unit("s")
        .v1("zprobe.dwell_before_probing"),
        number(
            "debounce_ms",
            "0",
            &(0.0, 1_000.0),
            |c, _, v| c.probe.debounce = millis(v),
            "How long the probe must stay triggered to count; 0 stops at once.",
        )
        .unit("ms")
        .v1("zprobe.debounce_ms"),
        numbers(
            "probe_offsets",
            3,
            |c, _, v| c.probe.offsets = v.try_into().unwrap_or_default(),
            "Probe position relative to the nozzle as X,Y and how high the nozzle is as the contact closes, where the leveling strategy has none of its own. M565 and M851 \
             change it.",
        )
        .unit("mm")
        .klipper("[probe] x_offset")
        .velvet(),
        text(
            "deploy_gcode",
            "",
            96,
            |c, _, v| c.probe_scripts[0] = line_of(v),
            "Line that brings the probe out before it searches: moves, waits, modes and switches, in mm and absolute. M401 runs it too.",
        )
        .klipper("[probe] activate_gcode")
        .velvet(),
        text(
            "stow_gcode",
            "",
            96,
            |c, _, v| c.probe_scripts[1] = line_of(v),
            "Line that puts the probe away when a command that has probed ends. M402 runs it too.",
        )
        .klipper("[probe] deactivate_gcode")
        .velvet(),
        pin(
            "deployed_pin",
            "nc",
            PinRole::Input,
            |c, _, v| c.probe.deployed_pin = v.and_then(PinName::digital),
            "Input, logically high while the probe is out: nothing is probed otherwise.",
        )
        .velvet(),
        bool(
            "stowed_reads_triggered",
            "false",
            |c, _, v| c.probe.stowed_reads_triggered = v,
            "Put away, the probe reads triggered, as a magnetic one in its dock: so the machine sees whether it is out.",
        )
        .velvet(),
        integer(
            "samples",
            "1",
            &(1, 50),
            |c, _, v| c.probe.samples.count = v as u8,
            "Touches of each place where a bed is measured: grids, three points, Z motors, screws.",
        )
        .unit("touches")
        .klipper("[probe] samples")
        .velvet(),
        word(
            "samples_result",
            "average",
            &Words(&["average", "median"]),
            |c, _, v| c.probe.samples.median = v == 1,
            "What several touches come to. A median leaves out one that went wrong.",
        )
        .klipper("[probe] samples_result")
        .velvet(),
        number(
            "samples_tolerance",
            "0.1",
            NOT_NEGATIVE,
            |c, _, v| c.probe.samples.tolerance = Mm(v),
            "Touches of one place that lie further apart are made again; 0: they are not held against each other.",
        )
        .unit("mm")
        .typical(&(0.003, 1.0))
        .klipper("[probe] samples_tolerance")
        .velvet(),
        integer(
            "samples_retries",
            "3",
            &(0, 20),
            |c, _, v| c.probe.samples.retries = v as u8,
            "How often they are made again before measuring ends with an error.",
        )
        .unit("times")
        .klipper("[probe] samples_tolerance_retries")
        .velvet(),
        number(
            "samples_retract",
            "2",
            POSITIVE,
            |c, _, v| c.probe.samples.retract = Mm(v),
            "How far the probe rises between touches of one place.",
        )
        .unit("mm")
        .typical(&(0.2, 20.0))
        .klipper("[probe] sample_retract_dist")
        .velvet(),
        word(
            "leveling",
            "",
            STRATEGIES,
            |c, _, v| c.leveling.strategy = Some(strategy(v)),
            "How the bed is leveled; the strategy has a section of its own. M374 and M375 save and load its grid.",
        ),
        word(
            "calibration",
            "",
            &Words(&["delta"]),
            |c, _, _| c.delta_calibration.enable = true,
            "How G32 calibrates the machine; the strategy has a section of its own.",
        ),
    ],
};

pub const DELTA_CALIBRATION: Section = Section {
    name: "delta calibration strategy",
    store: None,
    docs: Docs::new("Finds the geometry of a delta by probing: endstop trims, radius, angles, arms."),
    form: Form::Plain,
    settings: &[
        number(
            "radius",
            "100",
            POSITIVE,
            |c, _, v| c.delta_calibration.radius = Mm(v),
            "Distance of the probed points from the centre. G32 J changes it.",
        )
        .unit("mm")
        .v1("leveling-strategy.delta-calibration.radius"),
        number(
            "initial_height",
            "20",
            POSITIVE,
            |c, _, v| c.delta_calibration.initial_height = Mm(v),
            "Height moved to fast before searching for the bed.",
        )
        .unit("mm")
        .v1("leveling-strategy.delta-calibration.initial_height"),
        word(
            "factors",
            "4",
            FACTORS,
            |c, _, v| c.delta_calibration.factors = FACTOR_COUNTS.get(v).copied().unwrap_or(4),
            "How many numbers G32 finds: 3 the trims, 4 the radius too, 6 also the angles of two towers, 7 the length of the arms, 9 \
             that of each. G32 S changes it.",
        )
        .klipper("DELTA_CALIBRATE")
        .velvet(),
        number(
            "tolerance",
            "0.03",
            POSITIVE,
            |c, _, v| c.delta_calibration.tolerance = Mm(v),
            "Spread of the points' heights that is good enough. G32 I changes it.",
        )
        .unit("mm")
        .v1("leveling-strategy.delta-calibration.tolerance"),
    ],
};
