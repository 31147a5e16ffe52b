//! Codes for the meaning of coordinates: units, planes, distance modes, coordinate systems, tool offsets,
//! corners.

use gcode::Code;

use super::leveling::PLACES;
use super::motion::target_words;
use super::row::{CodeInfo, Group, Waits};
use crate::meaning::{moves, offsets, tool_table};
use crate::word::Bounds::Whole;
use crate::word::{Unit, WordInfo, word};

const LENGTHS: &[WordInfo] =
    &[word('X', Unit::Length, "by axis"), word('Y', Unit::Length, "by axis"), word('Z', Unit::Length, "by axis")];
const POSITION: &[WordInfo] = &[
    word('X', Unit::Length, "by axis"),
    word('Y', Unit::Length, "by axis"),
    word('Z', Unit::Length, "by axis"),
    word('A', Unit::Number, "by axis"),
    word('B', Unit::Number, "by axis"),
    word('C', Unit::Number, "by axis"),
    word('E', Unit::Number, "filament of the active extruder"),
];

const TOOL_NUMBER: WordInfo =
    word('H', Unit::Number, "of this tool; of the one in the spindle where it is left out, or 0")
        .bounds(&Whole(0.0, 65_535.0));

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::means(Code::g(10), offsets::set_offsets, "set a work or tool offset, or the tool table; without L, retract")
        .takes(&[
            word(
                'L',
                Unit::Number,
                "2: of a coordinate system; 20: so that the position reads as given. 1: of a tool; 10: so that the position reads as given with it; 11: the same in G59.3; 0: read `tool.tbl` anew",
            ),
            word(
                'P',
                Unit::Number,
                "coordinate system 1 to 9, 0 for the active one; with L1, L10 and L11 the tool, with extruders its number plus one",
            ),
            word('X', Unit::Length, "by axis"),
            word('Y', Unit::Length, "by axis"),
            word('Z', Unit::Length, "by axis"),
            word('A', Unit::Number, "by axis, degrees: of a tool"),
            word('B', Unit::Number, "by axis, degrees: of a tool"),
            word('C', Unit::Number, "by axis, degrees: of a tool"),
            word('R', Unit::Number, "radius of a tool (length); with L2 how far the system is turned about its origin, degrees"),
            word('I', Unit::Number, "front angle of a lathe's tool, degrees"),
            word('J', Unit::Number, "back angle"),
            word('Q', Unit::Number, "orientation of a lathe's tool, 0 to 9"),
        ])
        .waits(Waits::Path)
        .differs("L0, L10 and L11 are not known"),
    plane(17, "plane of X and Y"),
    no_plane(17),
    plane(18, "plane of X and Z"),
    no_plane(18),
    plane(19, "plane of Y and Z"),
    no_plane(19),
    CodeInfo::means(Code::g(20), offsets::length_unit, "lengths are inches").group(Group::Units),
    CodeInfo::means(Code::g(21), offsets::length_unit, "lengths are mm").group(Group::Units),
    CodeInfo::accepted(Code::g(40), "no cutter compensation; there is none").group(Group::CutterCompensation),
    no_compensation(41, "cutter compensation, left; refused: let the CAM program do it"),
    no_compensation(42, "cutter compensation, right; refused: let the CAM program do it"),
    CodeInfo::means(Code::g(43), tool_table::tool_length, "tool offset of `tool.tbl`; with extruders nothing to do")
        .group(Group::ToolLength)
        .takes(&[TOOL_NUMBER])
        .differs("accepted, and nothing is done"),
    CodeInfo::means(Code::g(43).sub(1), tool_table::tool_length, "add to the tool offset; in GRBL's dialect set it")
        .group(Group::ToolLength)
        .takes(LENGTHS),
    CodeInfo::means(Code::g(43).sub(2), tool_table::tool_length, "add to the tool offset, and but for GRBL move so")
        .group(Group::ToolLength)
        .takes(&[
            word('X', Unit::Length, "by axis"),
            word('Y', Unit::Length, "by axis"),
            word('Z', Unit::Length, "by axis"),
            TOOL_NUMBER,
        ])
        .waits(Waits::Path),
    CodeInfo::means(Code::g(49), tool_table::no_tool_length, "no tool offset").group(Group::ToolLength),
    CodeInfo::means(Code::g(52), offsets::local_origin, "shift the origin of all coordinate systems to here; 0: back")
        .takes(LENGTHS)
        .waits(Waits::Path)
        .differs("not known"),
    CodeInfo::means(
        Code::g(53),
        moves::machine_coordinates,
        "machine coordinates, for this line or for the next move when alone",
    )
    .takes(target_words!(
        word('I', Unit::Length, "as in the motion code in force"),
        word('J', Unit::Length, "as in the motion code in force"),
        word('K', Unit::Length, "as in the motion code in force"),
        word('R', Unit::Length, "as in the motion code in force")
    ))
    .waits(Waits::Path)
    .differs("a warning when it has words"),
    system(Code::g(54)),
    system(Code::g(55)),
    system(Code::g(56)),
    system(Code::g(57)),
    system(Code::g(58)),
    system(Code::g(59)),
    system(Code::g(59).sub(1)),
    system(Code::g(59).sub(2)),
    system(Code::g(59).sub(3)),
    corner(Code::g(61), "corners stay as they are").differs("not known"),
    corner(Code::g(61).sub(1), "corners stay as they are, and the machine stops in each").differs("not known"),
    corner(Code::g(64), "corners are rounded, within P; without P within the junction deviation")
        .takes(&[
            word('P', Unit::Length, "how far the rounding may leave a corner"),
            word('Q', Unit::Length, "has nothing to do: short lines are kept"),
        ])
        .differs("not known"),
    CodeInfo::means(Code::g(90), offsets::distance_mode, "coordinates are places").group(Group::Distance),
    arc_distance(90, "arcs: I, J and K are places"),
    CodeInfo::means(Code::g(91), offsets::distance_mode, "coordinates are distances").group(Group::Distance),
    arc_distance(91, "arcs: I, J and K are distances from the start"),
    CodeInfo::means(Code::g(92), offsets::g92, "make the position read as given; without words, drop that")
        .takes(POSITION)
        .waits(Waits::Standstill),
    CodeInfo::means(Code::g(92).sub(1), offsets::g92, "drop the offset of G92"),
    CodeInfo::means(Code::g(92).sub(2), offsets::g92, "drop the offset of G92"),
    CodeInfo::means(Code::g(92).sub(3), offsets::g92_offset, "set the offset of G92 itself, 0 where not named").takes(&[
        word('X', Unit::Mm, "by axis"),
        word('Y', Unit::Mm, "by axis"),
        word('Z', Unit::Mm, "by axis"),
    ]),
    CodeInfo::means(Code::g(92).sub(4), offsets::declare_position, "the machine is at these machine coordinates")
        .takes(PLACES)
        .waits(Waits::Standstill),
    CodeInfo::means(
        Code::m(120),
        offsets::save_or_restore,
        "keep units, distance modes, rates and the coordinate system",
    ),
    CodeInfo::means(Code::m(121), offsets::save_or_restore, "come back to what M120 kept"),
];

const fn plane(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::g(number), offsets::plane, help).group(Group::Plane)
}

const fn no_plane(number: u16) -> CodeInfo {
    CodeInfo::means(Code::g(number).sub(1), offsets::missing, "plane of U, V and W; refused: there are none")
        .group(Group::Plane)
        .differs("not known")
}

const CUTTER: &[WordInfo] =
    &[word('D', Unit::Id, "the tool, or its diameter"), word('L', Unit::Number, "the tip's orientation")];

const fn no_compensation(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::g(number), offsets::missing, help)
        .any_subcode()
        .takes(CUTTER)
        .group(Group::CutterCompensation)
        .differs("not known")
}

const fn arc_distance(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::g(number).sub(1), offsets::arc_distance_mode, help)
        .group(Group::ArcDistance)
        .differs("not known")
}

const fn system(code: Code) -> CodeInfo {
    CodeInfo::means(code, offsets::coordinate_system, "work coordinate system").group(Group::CoordinateSystem)
}

const fn corner(code: Code, help: &'static str) -> CodeInfo {
    CodeInfo::means(code, offsets::path_mode, help).group(Group::PathControl)
}
