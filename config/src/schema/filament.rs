//! `[filament detector]` and `[filament change]`.

use super::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number, pin};
use super::{Docs, Form, PinRole, Section};
use crate::pin::PinName;
use units::{Micros, Mm, MmPerSecond};

pub const FILAMENT_DETECTOR: Section = Section {
    name: "filament detector",
    store: None,
    docs: Docs::new("Notices that filament has run out or is stuck, and suspends the job."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", |c, _, v| c.filament_detector.enable = v, "There is a detector.")
            .v1("filament_detector.enable"),
        pin(
            "encoder_pin",
            "nc",
            PinRole::Input,
            |c, _, v| c.filament_detector.encoder_pin = v.and_then(PinName::digital),
            "Input that a wheel turned by the filament pulses. No pulse while the extruder pushes: it is stuck.",
        )
        .klipper("[filament_motion_sensor] switch_pin")
        .v1("filament_detector.encoder_pin"),
        pin(
            "bulge_pin",
            "nc",
            PinRole::Input,
            |c, _, v| c.filament_detector.bulge_pin = v.and_then(PinName::digital),
            "Input, logically high where filament is too thick.",
        )
        .v1("filament_detector.bulge_pin"),
        pin(
            "detector_pin",
            "nc",
            PinRole::Input,
            |c, _, v| c.filament_detector.detector_pin = v.and_then(PinName::digital),
            "Input, logically high where there is no filament. Only without bulge_pin.",
        )
        .klipper("[filament_switch_sensor] switch_pin"),
        integer(
            "seconds_per_check",
            "2",
            &(1, 3600),
            |c, _, v| c.filament_detector.check_every = Micros::from_millis(v as u64 * 1000),
            "Between two looks at the pulses. M404 S changes it.",
        )
        .unit("s")
        .v1("filament_detector.seconds_per_check"),
        number(
            "pulses_per_mm",
            "1",
            POSITIVE,
            |c, _, v| c.filament_detector.pulses_per_mm = v,
            "Pulses of a millimetre of filament. M404 P changes it.",
        )
        .unit("pulses/mm")
        .v1("filament_detector.pulses_per_mm"),
        bool(
            "leave_heaters_on",
            "false",
            |c, _, v| c.filament_detector.leave_heaters_on = v,
            "Heaters stay on when it suspends the job. M404 H changes it.",
        )
        .v1("filament_detector.leave_heaters_on"),
    ],
};

pub const FILAMENT_CHANGE: Section = Section {
    name: "filament change",
    store: None,
    docs: Docs::new("How M600, M701 and M702 move filament and the tool. Lengths of 0 leave it to a person."),
    form: Form::Plain,
    settings: &[
        number(
            "retract",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.filament_change.retract = Mm(v),
            "Pulled back when M600 has suspended the job, so that nothing oozes on the way.",
        )
        .unit("mm")
        .velvet(),
        number("lift", "0", NOT_NEGATIVE, |c, _, v| c.filament_change.lift = Mm(v), "How far the tool rises then.")
            .unit("mm")
            .velvet(),
        number(
            "park_x",
            "",
            ANY,
            |c, _, v| c.filament_change.park[0] = Some(Mm(v)),
            "Where it waits, X of the machine.",
        )
        .derived("where the job stopped")
        .unit("mm")
        .velvet(),
        number(
            "park_y",
            "",
            ANY,
            |c, _, v| c.filament_change.park[1] = Some(Mm(v)),
            "Where it waits, Y of the machine.",
        )
        .derived("where the job stopped")
        .unit("mm")
        .velvet(),
        number(
            "park_feedrate",
            "100",
            POSITIVE,
            |c, _, v| c.filament_change.park_rate = MmPerSecond(v),
            "How fast it goes there.",
        )
        .unit("mm/s")
        .typical(&(0.5, 300.0))
        .velvet(),
        number(
            "unload_length",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.filament_change.unload = Mm(v),
            "Pulled out of the machine. M603 U changes it.",
        )
        .unit("mm")
        .velvet(),
        number(
            "unload_feedrate",
            "25",
            POSITIVE,
            |c, _, v| c.filament_change.unload_rate = MmPerSecond(v),
            "How fast.",
        )
        .unit("mm/s")
        .typical(&(0.5, 300.0))
        .velvet(),
        number(
            "load_length",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.filament_change.load = Mm(v),
            "Pushed in up to the nozzle. M603 L changes it.",
        )
        .unit("mm")
        .velvet(),
        number("load_feedrate", "25", POSITIVE, |c, _, v| c.filament_change.load_rate = MmPerSecond(v), "How fast.")
            .unit("mm/s")
            .typical(&(0.5, 300.0))
            .velvet(),
        number(
            "purge_length",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.filament_change.purge = Mm(v),
            "Pressed through the nozzle after that.",
        )
        .unit("mm")
        .velvet(),
        number("purge_feedrate", "3", POSITIVE, |c, _, v| c.filament_change.purge_rate = MmPerSecond(v), "How fast.")
            .unit("mm/s")
            .typical(&(0.5, 300.0))
            .velvet(),
    ],
};
