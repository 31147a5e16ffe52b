//! `[zprobe]` and the calibration strategy.

use super::build::{NOT_NEGATIVE, POSITIVE, bool, number, pin, word};
use super::endstops::millis;
use super::{Form, PinRole, Section};
use crate::machine::Leveling;
use crate::pin::PinName;
use units::{Micros, Mm, MmPerSecond};

/// The words of `leveling`, and what they mean.
const STRATEGIES: &[&str] = &["three point", "delta grid", "cartesian grid"];

const fn strategy(word: usize) -> Leveling {
    match word {
        0 => Leveling::ThreePoint,
        1 => Leveling::DeltaGrid,
        _ => Leveling::CartesianGrid,
    }
}

pub const ZPROBE: Section = Section {
    name: "zprobe",
    summary: "A probe that finds the bed or the work piece.",
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
        .typical(0.1, 50.0)
        .v1("zprobe.slow_feedrate"),
        number(
            "fast_feedrate",
            "100",
            POSITIVE,
            |c, _, v| c.probe.fast_rate = MmPerSecond(v),
            "Speed of travel between probed points. M670 K changes it.",
        )
        .unit("mm/s")
        .typical(1.0, 500.0)
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
        .typical(0.1, 500.0)
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
            (0.0, 60.0),
            |c, _, v| c.probe.dwell = Micros((v * 1e6) as u64),
            "Pause before each search. M670 D changes it.",
        )
        .unit("s")
        .v1("zprobe.dwell_before_probing"),
        number(
            "debounce_ms",
            "0",
            (0.0, 1_000.0),
            |c, _, v| c.probe.debounce = millis(v),
            "How long the probe must stay triggered to count; 0 stops at once.",
        )
        .unit("ms")
        .v1("zprobe.debounce_ms"),
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
            &["delta"],
            |c, _, _| c.delta_calibration.enable = true,
            "How G32 calibrates the machine; the strategy has a section of its own.",
        ),
    ],
};

pub const DELTA_CALIBRATION: Section = Section {
    name: "delta calibration strategy",
    summary: "Finds the endstop trims and the radius of a delta by probing.",
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
