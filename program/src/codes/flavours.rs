//! Codes that other printer firmwares, and mills, read otherwise than Smoothieware.
//!
//! Codes without a row here mean the same in all dialects. Sources: Marlin's "G-code Index", the Duet
//! project's "GCode dictionary", Klipper's "G-Codes".

use gcode::Code;

use super::row::{CodeInfo, EVERYWHERE_BUT_INVALID, Group, Waits};
use crate::fault::Part;
use crate::function::{Function, Geometry, LimitCode, Report, Sequence, Setting, Standing};
use crate::meaning::{lights, modes, printers, spindle};
use crate::word::Bounds::{Above, AtLeast, Whole, Within};
use crate::word::{Unit, WordInfo, word};
use gcode::{Dialect, Dialects};

/// Row that applies to some dialects only.
#[derive(Clone, Copy, Debug)]
pub struct Otherwise {
    /// Dialects that the row applies to.
    pub dialects: Dialects,
    /// Reading of the code in those dialects.
    pub row: CodeInfo,
}

const MARLIN: Dialects = Dialects::of(Dialect::Marlin);
const GRBL: Dialects = Dialects::of(Dialect::Grbl);
const REPRAP: Dialects = Dialects::of(Dialect::RepRapFirmware);

const fn reads(dialects: Dialects, row: CodeInfo) -> Otherwise {
    Otherwise { dialects, row }
}

const LEVEL: &str = "measure the bed and level by it";
const LEVEL_WORDS: &[WordInfo] = &[
    word('P', Unit::Number, "Marlin: 1 measures, other numbers have nothing to do; RepRapFirmware: a name, P\"bed\""),
    word('S', Unit::Number, "RepRapFirmware: 0 measures, 1 loads a mesh, 2: no leveling, 3 saves it"),
    word('X', Unit::Length, "Prusa: where the area begins"),
    word('Y', Unit::Length, "Prusa: where the area begins"),
    word('W', Unit::Length, "Prusa: how wide it is"),
    word('H', Unit::Length, "Prusa: how deep it is"),
    word('L', Unit::Length, "Marlin: its left end; alone: load the saved grid"),
    word('R', Unit::Length, "Marlin: its right end"),
    word('F', Unit::Length, "Marlin: its front end"),
    word('B', Unit::Length, "Marlin: its rear end"),
    word('A', Unit::Flag, "Marlin: has nothing to do, what was measured is in force"),
    word('C', Unit::Flag, "Marlin: has nothing to do, all of the bed is measured at once"),
    word('D', Unit::Flag, "Marlin: no leveling"),
];
const JERK: &[WordInfo] = &[
    word('X', Unit::MmPerSecond, "jerk; the lesser of X and Y is the square corner velocity"),
    word('Y', Unit::MmPerSecond, "jerk; the lesser of X and Y is the square corner velocity"),
    word('Z', Unit::MmPerSecond, "has nothing to do"),
    word('E', Unit::MmPerSecond, "has nothing to do"),
    word('J', Unit::Mm, "junction deviation, instead").bounds(&Above(0.0)),
    word('S', Unit::MmPerSecond, "least feed rate: has nothing to do"),
    word('T', Unit::MmPerSecond, "the same of moves that do not print"),
    word('V', Unit::MmPerSecond, "square corner velocity").bounds(&AtLeast(0.0)),
    word('C', Unit::Number, "share of the way left for cruising").bounds(&Within(0.0, 0.95)),
];
const ACCELERATIONS: &[WordInfo] = &[
    word('S', Unit::MmPerSecond2, "of all moves"),
    word('P', Unit::MmPerSecond2, "of moves that print; here of all moves"),
    word('T', Unit::MmPerSecond2, "of moves that do not; Klipper: of all, if less than P"),
    word('R', Unit::MmPerSecond2, "of retractions: has nothing to do"),
];
const SPEEDS: &[WordInfo] = &[
    word('X', Unit::MmPerMinute, "of this axis"),
    word('Y', Unit::MmPerMinute, "of this axis"),
    word('Z', Unit::MmPerMinute, "of this axis"),
    word('E', Unit::MmPerMinute, "of the extruder's motor"),
    word('S', Unit::Number, "1: mm/s, not mm/min"),
];
const STRIP_WORDS: &[WordInfo] = &[
    word('R', Unit::Number, "red").bounds(&Within(0.0, 255.0)),
    word('U', Unit::Number, "green").bounds(&Within(0.0, 255.0)),
    word('B', Unit::Number, "blue").bounds(&Within(0.0, 255.0)),
    word('W', Unit::Number, "white").bounds(&Within(0.0, 255.0)),
    word('P', Unit::Number, "brightness of all of them, 255 is full").bounds(&Within(0.0, 255.0)),
    word('Y', Unit::Number, "brightness of a DotStar: has nothing to do"),
    word('S', Unit::Number, "the next so many lights; without it all").bounds(&Whole(1.0, 256.0)),
    word('F', Unit::Number, "1: the next line goes on behind these lights").bounds(&Whole(0.0, 1.0)),
    word('E', Unit::Number, "only the strip with this number").bounds(&Whole(0.0, 15.0)),
    word('X', Unit::Number, "kind of the strip, which the configuration says: has nothing to do"),
];
const IDLE: &[WordInfo] = &[
    word('S', Unit::Seconds, "turn them off after standing so long: has nothing to do"),
    word('E', Unit::Flag, "the motor of the active extruder"),
    word('X', Unit::Flag, "the motor of this axis"),
    word('Y', Unit::Flag, "the motor of this axis"),
    word('Z', Unit::Flag, "the motor of this axis"),
    word('A', Unit::Flag, "the motor of this axis"),
    word('B', Unit::Flag, "the motor of this axis"),
    word('C', Unit::Flag, "the motor of this axis"),
];

const GAINS: &[WordInfo] = &[
    word('E', Unit::Id, "which hot end; 0 where it is left out"),
    word('P', Unit::Number, "proportional"),
    word('I', Unit::Number, "integral, per second"),
    word('D', Unit::Number, "derivative, seconds"),
    word('C', Unit::Number, "by what is extruded: has nothing to do"),
    word('L', Unit::Number, "by what is extruded: has nothing to do"),
    word('F', Unit::Number, "by the fan: has nothing to do"),
];
const TUNE: &[WordInfo] = &[
    word('E', Unit::Id, "which hot end; -1: the bed; 0 where it is left out"),
    word('S', Unit::Celsius, "temperature to swing around, 150 where it is left out"),
    word('C', Unit::Number, "swings, 3 where it is left out").bounds(&Within(3.0, 50.0)),
    word('U', Unit::Flag, "use what is found, as always"),
    word('D', Unit::Flag, "has nothing to do"),
];
const TUNE_TOOL: &[WordInfo] = &[
    word('T', Unit::Id, "the heater of this tool"),
    word('S', Unit::Celsius, "temperature to swing around, 150 where it is left out"),
    word('P', Unit::Number, "largest output: has nothing to do"),
];

/// Rows of codes with another meaning in some dialects, and those dialects.
pub static READ_OTHERWISE: &[Otherwise] = &[
    reads(
        REPRAP,
        CodeInfo::means(Code::g(10), printers::tool_settings, "temperature and offset of a tool; without P, retract")
            .takes(&[
                word('P', Unit::Id, "which tool"),
                word('S', Unit::Celsius, "its temperature"),
                word('R', Unit::Celsius, "when it is not in use: has nothing to do"),
                word('L', Unit::Number, "as in Smoothieware"),
                word('X', Unit::Length, "offset"),
                word('Y', Unit::Length, "offset"),
                word('Z', Unit::Length, "offset"),
            ])
            .waits(Waits::Path),
    ),
    reads(Dialects::PRINTERS, level(Code::g(29))),
    reads(REPRAP, sets_up(Code::g(31), "refused: where the probe triggers")),
    reads(MARLIN, CodeInfo::missing(Code::g(61), "go to the place that G60 has saved")),
    // G-codes of Prusa's firmware for the MK2 and MK3.
    reads(
        GRBL,
        CodeInfo::means(Code::m(48), spindle::overrides, "the operator's overrides of feed and spindle count")
            .group(Group::Overrides)
            .waits(Waits::Standstill),
    ),
    reads(
        GRBL,
        CodeInfo::means(Code::m(73), modes::saved_modes, "save the modes until the subroutine ends")
            .group(Group::SavedModes),
    ),
    reads(MARLIN, level(Code::g(80))),
    reads(Dialects::PRINTERS, motors_off(18)),
    reads(Dialects::PRINTERS, motors_off(84)),
    reads(
        MARLIN,
        CodeInfo::asks(
            Code::m(114),
            Function::Report(Report::ReportPosition),
            "where the program is, and the motors' steps",
        )
        .takes(&[
            word('R', Unit::Flag, "where the motors are"),
            word('D', Unit::Flag, "all of it: of the work, of the machine, leveled, the motors' own"),
        ])
        .waits(Waits::Question)
        .states(EVERYWHERE_BUT_INVALID),
    ),
    reads(
        REPRAP,
        CodeInfo::asks(
            Code::m(116),
            Function::Sequence(Sequence::WaitForTargets),
            "wait until every heater has come to its target, from above too",
        )
        .takes(&[
            word('P', Unit::Id, "only the heater with this tool_id"),
            word('S', Unit::Celsius, "how near: has nothing to do"),
        ])
        .waits(Waits::Result),
    ),
    reads(MARLIN, CodeInfo::passed_over(Code::m(120), "watch the end switches: they are, where configured")),
    reads(MARLIN, CodeInfo::passed_over(Code::m(121), "do not watch the end switches: they are, where configured")),
    reads(REPRAP, sets_up(Code::m(143), "refused: the highest temperature of a heater by its number")),
    reads(
        REPRAP,
        CodeInfo::means(Code::m(150), lights::colour, "colour of lights; what is not named is dark")
            .takes(STRIP_WORDS)
            .waits(Waits::Path)
            .states(EVERYWHERE_BUT_INVALID),
    ),
    reads(
        REPRAP,
        CodeInfo::either(
            Code::m(203),
            printers::axis_speeds,
            Function::Limit(LimitCode::AxisSpeeds),
            "greatest speeds of axes, a minute",
        )
        .takes(SPEEDS),
    ),
    reads(
        Dialects::PRINTERS,
        CodeInfo::means(Code::m(204), printers::accelerations, "acceleration").takes(ACCELERATIONS),
    ),
    reads(
        Dialects::PRINTERS,
        CodeInfo::asks(Code::m(205), Function::Limit(LimitCode::Jerk), "speed changes allowed in corners").takes(JERK),
    ),
    reads(MARLIN.with(Dialect::RepRapFirmware), sets_up(Code::m(206), "refused: shifts the work at once")),
    reads(REPRAP, sets_up(Code::m(208), "refused: the travel of axes")),
    reads(
        MARLIN,
        CodeInfo::means(Code::m(218), printers::hotend_offset, "offset of a tool").takes(&[
            word('T', Unit::Id, "which tool"),
            word('X', Unit::Length, "by axis"),
            word('Y', Unit::Length, "by axis"),
            word('Z', Unit::Length, "by axis"),
        ]),
    ),
    reads(
        MARLIN,
        CodeInfo::either(
            Code::m(301),
            printers::by_its_letters,
            Function::Setting(Setting::PidGains),
            "the PID gains of a hot end",
        )
        .takes(GAINS),
    ),
    reads(REPRAP, sets_up(Code::m(301), "refused: the PID gains of a heater by its number")),
    reads(MARLIN, tune(TUNE)),
    reads(REPRAP, tune(TUNE_TOOL)),
    reads(MARLIN.with(Dialect::RepRapFirmware), sets_up(Code::m(305), "refused: a thermistor by its number")),
    reads(MARLIN, sets_up(Code::m(306), "refused: Marlin's model of a heater")),
    reads(
        MARLIN,
        CodeInfo::either(
            Code::m(665),
            printers::by_its_letters,
            Function::Geometry(Geometry::ArmSettings),
            "geometry of a delta",
        )
        .takes(&[word('L', Unit::Mm, "length of the rods"), word('R', Unit::Mm, "radius of the delta")]),
    ),
    reads(REPRAP, sets_up(Code::m(665), "refused: the geometry of a delta")),
    reads(REPRAP, sets_up(Code::m(666), "refused: the switches of a delta")),
    reads(REPRAP, sets_up(Code::m(307), "refused: RepRapFirmware's model of a heater")),
    reads(REPRAP, sets_up(Code::m(558), "refused: the kind of probe")),
    reads(REPRAP, sets_up(Code::m(569), "refused: which way a drive turns")),
    reads(REPRAP, sets_up(Code::m(574), "refused: the end switches")),
    reads(REPRAP, ends_job(0)),
    reads(REPRAP, ends_job(1)),
    reads(REPRAP, ends_job(2)),
    reads(REPRAP, sets_up(Code::m(557), "refused: the grid to probe")),
    reads(
        REPRAP,
        CodeInfo::means(Code::m(568), printers::tool_settings, "temperature of a tool")
            .takes(&[
                word('P', Unit::Id, "which tool"),
                word('S', Unit::Celsius, "its temperature"),
                word('R', Unit::Celsius, "when it is not in use: has nothing to do"),
                word('A', Unit::Number, "whether it is in use: has nothing to do"),
            ])
            .waits(Waits::Path),
    ),
    reads(
        REPRAP,
        CodeInfo::means(Code::m(226), printers::pause_print, "suspend the job; heaters stay on, as M600.1")
            .waits(Waits::Result)
            .part(Part::Player),
    ),
    // Prusa's code, which its slicer writes for every firmware. Marlin itself gives the code no meaning.
    reads(
        Dialects::PRINTERS,
        CodeInfo::means(Code::m(601), printers::pause_print, "suspend the job; heaters stay on, as M600.1")
            .waits(Waits::Result)
            .part(Part::Player),
    ),
    // Marlin's values are potentiometer numbers, and the other firmwares have no such code: a current must
    // not change by it.
    reads(Dialects::PRINTERS, CodeInfo::passed_over(Code::m(907), "motor current as a number of a potentiometer")),
    reads(Dialects::PRINTERS, CodeInfo::passed_over(Code::m(909), "says the numbers of a potentiometer")),
];

const fn sets_up(code: Code, help: &'static str) -> CodeInfo {
    CodeInfo::means(code, printers::sets_up, help)
}

const fn ends_job(number: u16) -> CodeInfo {
    CodeInfo::means(Code::m(number), printers::end_job, "end of the job; heaters off")
        .group(Group::Stopping)
        .waits(Waits::Standstill)
        .states(EVERYWHERE_BUT_INVALID)
}

const fn tune(words: &'static [WordInfo]) -> CodeInfo {
    const HELP: &str = "find the PID gains of a heater";
    CodeInfo::either(Code::m(303), printers::by_its_letters, Function::Sequence(Sequence::TunePid), HELP)
        .takes(words)
        .waits(Waits::Result)
}

const fn level(code: Code) -> CodeInfo {
    CodeInfo::either(code, printers::level, Function::Sequence(Sequence::ProbeStrategy), LEVEL)
        .takes(LEVEL_WORDS)
        .waits(Waits::Result)
        .part(Part::Probe)
        .levels()
}

const fn motors_off(number: u16) -> CodeInfo {
    CodeInfo::either(
        Code::m(number),
        printers::motors_off,
        Function::Standing(Standing::MotorsOff),
        "motors off, all or those named",
    )
    .takes(IDLE)
    .waits(Waits::Standstill)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codes::{FIRST_G_READ_OTHERWISE, find_in};

    #[test]
    fn every_row_is_found_in_its_dialects_alone() {
        for other in READ_OTHERWISE {
            for dialect in Dialect::ALL {
                let found = find_in(other.row.code, dialect).is_some_and(|row| core::ptr::eq(row, &other.row));
                assert_eq!(found, other.dialects.has(dialect), "{} {}", other.row.code, dialect.name());
            }
            assert!(other.row.code.letter != gcode::Letter::G || other.row.code.number >= FIRST_G_READ_OTHERWISE);
            assert!(other.row.help.len() > 8 && other.row.help.len() <= 90);
        }
    }
}
