//! G0 to G5: moves and dwells.

use gcode::Code;

use super::row::{CodeInfo, Group, Waits};
use crate::meaning::{moves, splines};
use crate::word::{Unit, WordInfo, word};

/// Builds the words for the target and speed of a move, and more words.
macro_rules! target_words {
    ($($more:expr),*) => {
        &[
            word('X', Unit::Length, "where to"),
            word('Y', Unit::Length, "where to"),
            word('Z', Unit::Length, "where to"),
            word('A', Unit::Number, "where to"),
            word('B', Unit::Number, "where to"),
            word('C', Unit::Number, "where to"),
            word('@', Unit::Length, "where to: distance from the origin of X and Y"),
            word('^', Unit::Number, "where to: angle from X there, degrees"),
            word('E', Unit::Number, "filament of the active extruder, mm or mm3"),
            word('F', Unit::Feed, "speed from now on"),
            word('S', Unit::Number, "laser or spindle power from now on"),
            $($more),*
        ]
    };
}
pub(super) use target_words;

const LINE: &[WordInfo] = target_words!();
const ARC: &[WordInfo] = target_words!(
    word('I', Unit::Length, "from the start to the centre along X"),
    word('J', Unit::Length, "along Y"),
    word('K', Unit::Length, "along Z"),
    word('R', Unit::Length, "the radius instead; negative: the longer arc"),
    word('P', Unit::Number, "turns begun, 1 where it is left out")
);

pub const ROWS: &[CodeInfo] = &[
    moves(Code::g(0), "rapid move").takes(LINE),
    moves(Code::g(1), "working move").takes(LINE),
    moves(Code::g(2), "arc or helix, clockwise in the plane of G17 to G19").takes(ARC).differs(ARCS),
    moves(Code::g(3), "arc or helix, counter-clockwise").takes(ARC).differs(ARCS),
    CodeInfo::means(Code::g(4), moves::dwell, "dwell: P and S together")
        .takes(&[word('P', Unit::Dwell, "time"), word('S', Unit::Seconds, "time")])
        .waits(Waits::Standstill),
    moves(Code::g(5), "cubic Bezier curve in X and Y")
        .takes(target_words!(
            word('I', Unit::Length, "from the start to the first control point, along X"),
            word('J', Unit::Length, "along Y; both may be left out behind another G5"),
            word('P', Unit::Length, "from the end to the second control point, along X"),
            word('Q', Unit::Length, "along Y")
        ))
        .differs("not known"),
    moves(Code::g(5).sub(1), "quadratic Bezier curve in X and Y")
        .takes(target_words!(
            word('I', Unit::Length, "from the start to the control point, along X"),
            word('J', Unit::Length, "along Y")
        ))
        .differs("not known"),
    moves(Code::g(5).sub(2), "control points of a NURBS, from where the tool is")
        .takes(&[
            word('X', Unit::Length, "a control point"),
            word('Y', Unit::Length, "a control point"),
            word('P', Unit::Number, "its weight, 1 where it is left out"),
            word('L', Unit::Number, "order, 2 to 6"),
            word('F', Unit::Feed, "speed from now on"),
            word('S', Unit::Number, "laser or spindle power from now on"),
        ])
        .differs("not known"),
    CodeInfo::means(Code::g(5).sub(3), splines::close_nurbs, "draw the NURBS")
        .group(Group::Motion)
        .waits(Waits::Path)
        .differs("not known"),
];

const ARCS: &str = "chords; R and P turns are not known";

const fn moves(code: Code, help: &'static str) -> CodeInfo {
    CodeInfo::means(code, moves::motion, help).group(Group::Motion).waits(Waits::Path)
}
