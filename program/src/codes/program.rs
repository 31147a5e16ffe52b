//! Codes of the program as a whole, and of the machine.

use gcode::Code;

use super::row::{ANYWHERE, CodeInfo, EVERYWHERE_BUT_INVALID, Group, Waits};
use crate::function::{Function, Report};
use crate::meaning::{program, tool_table};
use crate::word::Bounds::Whole;
use crate::word::{Unit, word};

const NOT_KNOWN: &str = "not known";

pub const ROWS: &[CodeInfo] = &[
    pause(0),
    pause(1),
    CodeInfo::means(Code::m(2), program::end, "end of program: G54, G61, G90, speed factor 100 %")
        .group(Group::Stopping)
        .waits(Waits::Standstill)
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::means(Code::m(6), program::change_tool, "have the operator put in the tool of T")
        .takes(&[word('T', Unit::Id, "the tool")])
        .group(Group::ToolChange)
        .waits(Waits::Standstill)
        .differs("selects a heater's tool"),
    CodeInfo::means(Code::m(61), tool_table::set_current_tool, "this tool is in the spindle already")
        .takes(&[word('Q', Unit::Number, "its number, 0 for none").bounds(&Whole(0.0, 65_535.0))])
        .group(Group::ToolChange)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::m(60), program::pause, "wait until the operator goes on (~ or M24)")
        .group(Group::Stopping)
        .waits(Waits::Standstill)
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::m(98), program::call, "call the subroutine O P, L times")
        .takes(&[
            word('P', Unit::Number, "its number").bounds(&Whole(0.0, 99_999_999.0)),
            word('L', Unit::Number, "how often, 1 where it is left out").bounds(&Whole(0.0, 9_999.0)),
        ])
        .differs(NOT_KNOWN),
    CodeInfo::means(Code::m(99), program::end_call, "end a subroutine; begin a main program anew").differs(NOT_KNOWN),
    CodeInfo::accepted(Code::m(110), "count lines from N on").states(ANYWHERE),
    CodeInfo::means(Code::m(112), program::halt_now, "emergency stop, at once, whatever waits")
        .states(ANYWHERE)
        .differs("not known"),
    CodeInfo::asks(Code::m(114), Function::Report(Report::ReportPosition), "where the program is")
        .waits(Waits::Question)
        .states(EVERYWHERE_BUT_INVALID),
    position(1, "where the motors are, work coordinates"),
    position(2, "where the motors are, machine coordinates"),
    position(3, "the motors' own positions"),
    position(4, "where the program is, machine coordinates"),
    position(5, "where the program is, leveling and skew added"),
    CodeInfo::means(Code::m(117), program::message, "show a text to the operator"),
    CodeInfo::means(Code::m(400), program::finish, "wait until nothing moves").waits(Waits::Standstill),
    CodeInfo::means(Code::m(999), program::release, "clear a halt").states(EVERYWHERE_BUT_INVALID),
];

/// Returns the row of a program stop, M0 or M1.
const fn pause(number: u16) -> CodeInfo {
    const HELP: &str = "wait until the operator goes on (~ or M24); text behind it is shown to the operator";
    const WORDS: &[crate::word::WordInfo] =
        &[word('S', Unit::Seconds, "or so long"), word('P', Unit::Number, "or so long, ms")];
    CodeInfo::means(Code::m(number), program::pause, HELP)
        .takes(WORDS)
        .group(Group::Stopping)
        .waits(Waits::Standstill)
        .differs(NOT_KNOWN)
}

const fn position(subcode: u8, help: &'static str) -> CodeInfo {
    CodeInfo::asks(Code::m(114).sub(subcode), Function::Report(Report::ReportPosition), help)
        .waits(Waits::Question)
        .states(EVERYWHERE_BUT_INVALID)
}
