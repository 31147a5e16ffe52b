//! The program as a whole, and the machine.

use gcode::Code;

use super::row::{ANYWHERE, CodeInfo, EVERYWHERE_BUT_INVALID, Group, Waits};
use crate::action::Function;
use crate::meaning::program;

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::means(Code::m(2), program::end, "end of program: G54, G61, G90, speed factor 100 %")
        .group(Group::Stopping)
        .waits(Waits::Standstill)
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::accepted(Code::m(110), "count lines from N on").states(ANYWHERE),
    CodeInfo::means(Code::m(112), program::halt_now, "emergency stop, at once, whatever waits")
        .states(ANYWHERE)
        .differs("not known"),
    CodeInfo::asks(Code::m(114), Function::ReportPosition, "where the program is")
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

const fn position(subcode: u8, help: &'static str) -> CodeInfo {
    CodeInfo::asks(Code::m(114).sub(subcode), Function::ReportPosition, help)
        .waits(Waits::Question)
        .states(EVERYWHERE_BUT_INVALID)
}
