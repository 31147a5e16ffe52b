//! Codes of mills and lathes: spindle, outputs and inputs by number, saved modes.

use gcode::Code;

use super::row::{CodeInfo, Group, Waits};
use crate::meaning::{modes, offsets, outputs, spindle, threads};
use crate::word::Bounds::{Above, AtLeast, Whole, Within};
use crate::word::{Unit, WordInfo, word};

const NOT_KNOWN: &str = "not known";
const NUMBER: WordInfo = word('P', Unit::Number, "`io_number` of the switch").bounds(&Whole(0.0, 63.0));
const ON_OR_OFF: &[WordInfo] = &[word('P', Unit::Number, "0: no; 1 where it is left out").bounds(&Whole(0.0, 1.0))];

const FOLLOWS: &[WordInfo] = &[
    word('X', Unit::Length, "where to"),
    word('Y', Unit::Length, "where to"),
    word('Z', Unit::Length, "where to"),
    word('A', Unit::Number, "where to"),
    word('B', Unit::Number, "where to"),
    word('C', Unit::Number, "where to"),
    word('K', Unit::Length, "travel of a turn").bounds(&Above(0.0)),
    word('I', Unit::Number, "G33.1: how many times faster the spindle turns on the way back"),
];

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::means(Code::g(7), offsets::diameter_mode, "words of X are diameters, as on a lathe")
        .group(Group::Diameter)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::g(8), offsets::diameter_mode, "words of X are radii")
        .group(Group::Diameter)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::g(96), spindle::speed_mode, "surface speed: S is its speed; refused: no speed control yet")
        .takes(&[
            word('S', Unit::Number, "m/min, after G20 feet/min").bounds(&AtLeast(0.0)),
            word('D', Unit::Number, "the spindle turns no faster than that (1/min)").bounds(&Above(0.0)),
        ])
        .group(Group::SpindleSpeed)
        .waits(Waits::Path)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::g(97), spindle::speed_mode, "spindle speed: S is its speed")
        .takes(&[word('S', Unit::Number, "1/min").bounds(&AtLeast(0.0))])
        .group(Group::SpindleSpeed)
        .waits(Waits::Path)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::g(33), threads::follow, "move as the spindle turns; refused: it needs a spindle encoder")
        .takes(FOLLOWS)
        .group(Group::Motion)
        .waits(Waits::Path)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::g(33).sub(1), threads::follow, "tap, there and back; refused: it needs a spindle encoder")
        .takes(FOLLOWS)
        .group(Group::Motion)
        .waits(Waits::Path)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::m(19), spindle::orient, "turn the spindle to an angle; refused: it needs a spindle encoder")
        .takes(&[
            word('R', Unit::Number, "degrees").bounds(&Within(0.0, 360.0)),
            word('P', Unit::Number, "0: the shorter way, 1: clockwise, 2: the other way").bounds(&Whole(0.0, 2.0)),
            word('Q', Unit::Seconds, "no longer than that").bounds(&Above(0.0)),
        ])
        .group(Group::Spindle)
        .waits(Waits::Standstill)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::m(49), spindle::overrides, "the operator's overrides of feed and spindle do not count")
        .group(Group::Overrides)
        .waits(Waits::Standstill)
        .differs(NOT_KNOWN),
    one_override(50, "whether the operator's override of feed rates counts"),
    one_override(51, "whether the operator's override of the spindle's speed counts"),
    CodeInfo::means(Code::m(52), spindle::feed_inputs, "adaptive feed; refused but for P0: it needs an input")
        .takes(ON_OR_OFF)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::m(53), spindle::feed_inputs, "feed hold works; P0 is refused: it always does")
        .takes(ON_OR_OFF)
        .differs(NOT_KNOWN),
    output(42, "set an output by its number")
        .takes(&[NUMBER, word('S', Unit::Number, "its value, as S of its own code; 0: off").bounds(&AtLeast(0.0))]),
    output(62, "switch an output on, where the path has come this far").takes(&[NUMBER]),
    output(63, "switch an output off, where the path has come this far").takes(&[NUMBER]),
    output(64, "switch an output on").takes(&[NUMBER]).waits(Waits::Standstill),
    output(65, "switch an output off").takes(&[NUMBER]).waits(Waits::Standstill),
    CodeInfo::means(Code::m(66), outputs::await_input, "read an input into #5399, or wait for it")
        .takes(&[
            word('P', Unit::Number, "`io_number` of the switch").bounds(&Whole(0.0, 63.0)),
            word('E', Unit::Number, "an analog input; refused: there are none"),
            word('L', Unit::Number, "0: read it; wait until it 1: rises, 2: falls, 3: is on, 4: is off")
                .bounds(&Whole(0.0, 4.0)),
            word('Q', Unit::Seconds, "wait no longer than that; #5399 is -1 then").bounds(&Within(0.0, 86_400.0)),
        ])
        .waits(Waits::Result)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::m(226), outputs::await_level, "wait for an input")
        .takes(&[
            NUMBER,
            word('S', Unit::Number, "1: until it is on, 0: until it is off, -1: until it changes")
                .bounds(&Whole(-1.0, 1.0)),
            word('Q', Unit::Seconds, "no longer than that; #5399 is -1 then").bounds(&Within(0.0, 86_400.0)),
        ])
        .waits(Waits::Result)
        .differs(NOT_KNOWN),
    output(67, "set an output to a value, where the path has come this far").takes(VALUE),
    output(68, "set an output to a value").takes(VALUE).waits(Waits::Standstill),
    saved(70, "save the modes"),
    saved(71, "forget what M70 or M73 has saved"),
    saved(72, "come back to the modes that M70 has saved"),
];

const VALUE: &[WordInfo] = &[
    word('E', Unit::Number, "`io_number` of a switch that takes S").bounds(&Whole(0.0, 63.0)),
    word('Q', Unit::Number, "its value, as S is; 0: off").bounds(&AtLeast(0.0)),
];

const fn one_override(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::m(number), spindle::overrides, help)
        .takes(ON_OR_OFF)
        .group(Group::Overrides)
        .waits(Waits::Standstill)
        .differs(NOT_KNOWN)
}

const fn output(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::m(number), outputs::output, help).waits(Waits::Path).differs(NOT_KNOWN)
}

const fn saved(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::m(number), modes::saved_modes, help).group(Group::SavedModes).differs(NOT_KNOWN)
}
