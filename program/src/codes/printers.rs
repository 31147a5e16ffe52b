//! Codes of other printer firmwares that Smoothieware lacks, of three kinds: carried out; harmless here, so
//! counted while a file plays and listed at its end; harmful if ignored and not carried out, so that the file
//! pauses.

use gcode::Code;

use super::row::{CodeInfo, EVERYWHERE_BUT_INVALID, Waits};
use crate::function::{FileFunction, Function, LimitCode, Report, Sequence, Setting, Standing};
use crate::meaning::{lights, printers};
use crate::word::Bounds::{AtLeast, Whole, Within};
use crate::word::{Unit, WordInfo, word};

const NOT_KNOWN: &str = "not known";
/// Accelerations by axis, as Marlin and RepRapFirmware write them.
const BY_AXIS: &[WordInfo] = &[
    word('X', Unit::MmPerSecond2, "of this axis' motor"),
    word('Y', Unit::MmPerSecond2, "of this axis' motor"),
    word('Z', Unit::MmPerSecond2, "of this axis' motor"),
    word('E', Unit::MmPerSecond2, "of the extruder's motor"),
];

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::asks(
        Code::m(116),
        Function::Sequence(Sequence::WaitForHeaters),
        "wait until every heater has come up to its target",
    )
    .takes(&[
        word('P', Unit::Id, "only the heater with this tool_id"),
        word('A', Unit::Celsius, "until it is so warm, whatever its target"),
        word('B', Unit::Celsius, "until it is no warmer"),
    ])
    .waits(Waits::Result)
    .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(201), Function::Limit(LimitCode::Accelerations), "greatest accelerations of axes")
        .takes(BY_AXIS)
        .differs(NOT_KNOWN),
    CodeInfo::means(
        Code::m(290),
        printers::babystep,
        "shift everything that follows, and move there; see docs/dialects.md",
    )
    .takes(&[
        word('X', Unit::Length, "by so much"),
        word('Y', Unit::Length, "by so much"),
        word('Z', Unit::Length, "by so much"),
        word('S', Unit::Length, "the same as Z"),
        word('R', Unit::Number, "0: to so much, not by so much"),
        word('Q', Unit::Number, "0: the next moves go there, not this one"),
    ])
    .waits(Waits::Path)
    .differs(NOT_KNOWN),
    CodeInfo::asks(
        Code::m(290).sub(1),
        Function::Setting(Setting::ThermalAdjust),
        "shift Z against what the frame grows by with its temperature; says what holds",
    )
    .takes(&[
        word('S', Unit::Number, "0: it is not; 1: it is again"),
        word('K', Unit::Number, "by how much the tool comes away from the bed, mm for a degree")
            .bounds(&Within(-1.0, 1.0)),
        word('R', Unit::Celsius, "the temperature at which Z is right; else that of the last homing"),
    ])
    .differs(NOT_KNOWN),
    CodeInfo::asks(
        Code::m(420),
        Function::Sequence(Sequence::UseGrid),
        "level by the saved grid, or as the bed was measured; S0: not",
    )
    .takes(&[
        word('S', Unit::Number, "0: no leveling, until S1 puts the same mesh in force again"),
        word('Z', Unit::Length, "the mesh fades from Z0 up to this height; 0: it does not").bounds(&AtLeast(0.0)),
        word('L', Unit::Number, "load the mesh with this number as its name").bounds(&Whole(0.0, 99.0)),
        word('V', Unit::Flag, "show the bed as a map"),
    ])
    .waits(Waits::Standstill)
    .levels()
    .differs(NOT_KNOWN),
    CodeInfo::asks(
        Code::m(420).sub(1),
        Function::Sequence(Sequence::MeshOffset),
        "look the mesh up beside the tool; without words, say it",
    )
    .takes(&[word('X', Unit::Length, "so far beside it"), word('Y', Unit::Length, "so far beside it")])
    .waits(Waits::Standstill)
    .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(566), Function::Limit(LimitCode::Jerk), "speed changes allowed in corners")
        .takes(&[
            word('X', Unit::MmPerMinute, "of this axis; the lesser of X and Y is the square corner velocity"),
            word('Y', Unit::MmPerMinute, "of this axis; the lesser of X and Y is the square corner velocity"),
            word('Z', Unit::MmPerMinute, "has nothing to do"),
            word('E', Unit::MmPerMinute, "has nothing to do"),
            word('P', Unit::Number, "when: has nothing to do"),
        ])
        .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(572), Function::Standing(Standing::PressureAdvance), "pressure advance; without S, say it")
        .takes(&[
            word('S', Unit::Seconds, "how much").bounds(&AtLeast(0.0)),
            word('W', Unit::Seconds, "smoothed over so long").bounds(&AtLeast(0.0)),
            word('D', Unit::Number, "of this extruder"),
        ])
        .waits(Waits::Standstill)
        .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(593), Function::Standing(Standing::InputShaping), "input shaping; without words, say it")
        .takes(&[
            word('X', Unit::Flag, "of this axis; of X and Y where none is named"),
            word('Y', Unit::Flag, "of this axis"),
            word('F', Unit::Number, "frequency in Hz; 0: none").bounds(&AtLeast(0.0)),
            word('D', Unit::Number, "damping ratio").bounds(&Within(0.0, 0.99)),
            word('S', Unit::Number, "damping ratio").bounds(&Within(0.0, 0.99)),
            word('P', Unit::Flag, "its name, P\"zvd\""),
        ])
        .waits(Waits::Standstill)
        .differs(NOT_KNOWN),
    CodeInfo::means(
        Code::m(73),
        printers::progress,
        "progress and time left; as the slicer reckons, with words: left out",
    )
    .takes(&[
        word('P', Unit::Number, "per cent done"),
        word('R', Unit::Number, "minutes left"),
        word('Q', Unit::Number, "per cent done in silent mode"),
        word('S', Unit::Number, "minutes left in silent mode"),
        word('C', Unit::Number, "minutes to the next change"),
        word('D', Unit::Number, "the same in silent mode"),
        word('L', Unit::Number, "the layer"),
    ])
    .differs(NOT_KNOWN),
    quiet(16, "name of the printer that the file is for"),
    quiet(33, "long name of a file"),
    quiet(74, "weight of the part"),
    quiet(75, "start the print timer"),
    quiet(76, "pause the print timer"),
    quiet(77, "stop the print timer"),
    CodeInfo::asks(
        Code::m(78),
        Function::Sequence(Sequence::Statistics),
        "what the last job took, and what the machine has done in its life",
    )
    .takes(&[word('S', Unit::Number, "78: forget it")])
    .differs(NOT_KNOWN),
    quiet(108, "stop waiting for a temperature, or the operator; sent, it acts as it comes in"),
    quiet(111, "what to log"),
    CodeInfo::asks(
        Code::m(113),
        Function::File(FileFunction::Keepalive),
        "how often to say that a line takes its time",
    )
    .takes(&[word('S', Unit::Seconds, "every so often; 0: never").bounds(&Within(0.0, 60.0))])
    .states(EVERYWHERE_BUT_INVALID)
    .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(118), Function::Report(Report::SayToAll), "say a text on every console").differs(NOT_KNOWN),
    quiet(141, "temperature of the chamber, where no heater is named so"),
    quiet(191, "wait for the temperature of the chamber, where no heater is named so"),
    CodeInfo::means(Code::m(150), lights::colour, "colour of lights; what is not named is dark")
        .takes(&[
            word('R', Unit::Number, "red, 255 without a number").bounds(&Within(0.0, 255.0)),
            word('U', Unit::Number, "green").bounds(&Within(0.0, 255.0)),
            word('B', Unit::Number, "blue").bounds(&Within(0.0, 255.0)),
            word('W', Unit::Number, "white").bounds(&Within(0.0, 255.0)),
            word('P', Unit::Number, "brightness of all of them, 255 is full").bounds(&Within(0.0, 255.0)),
            word('I', Unit::Number, "only the light at this place, from 0").bounds(&Whole(0.0, 255.0)),
            word('S', Unit::Number, "only the strip with this number").bounds(&Whole(0.0, 15.0)),
            word('K', Unit::Flag, "what is not named stays as it is"),
            word('T', Unit::Number, "0: not seen until the next change of the strip"),
            word('Q', Unit::Number, "0: now, and not where the path has come to it"),
        ])
        .waits(Waits::Path)
        .states(EVERYWHERE_BUT_INVALID)
        .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(155), Function::File(FileFunction::AutoReport), "say temperatures by itself")
        .takes(&[word('S', Unit::Seconds, "every so often; 0: no more").bounds(&Within(0.0, 60.0))])
        .states(EVERYWHERE_BUT_INVALID)
        .differs(NOT_KNOWN),
    quiet(300, "sound a tone"),
    CodeInfo::asks(
        Code::m(302),
        Function::Limit(LimitCode::ColdExtrusion),
        "how warm a nozzle must be to extrude; without words, say it",
    )
    .takes(&[
        word('S', Unit::Celsius, "this warm; 0: cold extrusion is allowed").bounds(&AtLeast(0.0)),
        word('R', Unit::Celsius, "this warm to draw back").bounds(&AtLeast(0.0)),
        word('P', Unit::Number, "1: cold extrusion is allowed; 0: it is not"),
    ])
    .differs(NOT_KNOWN),
    quiet(355, "light of the case"),
    quiet(410, "brake, and drop what is queued; sent, it acts as it comes in"),
    quiet(425, "backlash of another machine"),
    CodeInfo::asks(
        Code::m(486),
        Function::File(FileFunction::LabelObject),
        "which object the lines that follow make; leave one out",
    )
    .differs(NOT_KNOWN),
    quiet(555, "where on the bed the part is"),
    quiet(862, "which printer the file is for").any_subcode(),
    quiet(908, "motor current as a number of its converter"),
    quiet(910, "settings of a motor driver"),
    missing(915, "level the motors of Z by pushing them against their end"),
    missing(163, "share of a mixing extruder"),
    missing(125, "park, and wait for a person"),
    missing(291, "show a text, and wait for an answer"),
    missing(605, "mode of a second carriage"),
    missing(808, "repeat a part of the file"),
];

const fn quiet(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::passed_over(Code::m(number), help).differs(NOT_KNOWN)
}

const fn missing(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::missing(Code::m(number), help).differs(NOT_KNOWN)
}
