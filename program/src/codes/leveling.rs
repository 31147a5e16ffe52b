//! Codes of homing, probing and leveling.

use gcode::Code;

use super::row::{CodeInfo, Waits};
use crate::fault::Part;
use crate::function::{FileFunction, Function, Geometry, LimitCode, Report, Sequence, Setting, Standing};
use crate::meaning::{homing, offsets, probing};
use crate::word::Bounds::{Above, AtLeast, Whole, Within};
use crate::word::{Unit, WordInfo, word};

const AXES: &[WordInfo] = &[
    word('X', Unit::Length, "this axis; when parking, a distance to go first, in GRBL's dialect a place"),
    word('Y', Unit::Length, "this axis; when parking, a distance to go first, in GRBL's dialect a place"),
    word('Z', Unit::Length, "this axis; when parking, a distance to go first, in GRBL's dialect a place"),
    word('A', Unit::Number, "this axis"),
    word('B', Unit::Number, "this axis"),
    word('C', Unit::Number, "this axis"),
];
pub(super) const PLACES: &[WordInfo] = &[
    word('X', Unit::Mm, "machine coordinate"),
    word('Y', Unit::Mm, "machine coordinate"),
    word('Z', Unit::Mm, "machine coordinate"),
    word('A', Unit::Number, "machine coordinate"),
    word('B', Unit::Number, "machine coordinate"),
    word('C', Unit::Number, "machine coordinate"),
];
const DECLARED: &[WordInfo] = &[
    word('X', Unit::Mm, "machine coordinate"),
    word('Y', Unit::Mm, "machine coordinate"),
    word('Z', Unit::Mm, "machine coordinate"),
    word('A', Unit::Number, "machine coordinate"),
    word('B', Unit::Number, "machine coordinate"),
    word('C', Unit::Number, "machine coordinate"),
    word('P', Unit::Flag, "Z is as high as the probe's contact closes, as M565 says"),
];
const SLAVES: &[WordInfo] = &[
    word('X', Unit::Flag, "0: measure; 1: put its slave where M666 says"),
    word('Y', Unit::Flag, "0: measure; 1: put its slave where M666 says"),
    word('Z', Unit::Flag, "0: measure; 1: put its slave where M666 says"),
];
const MESH: &[WordInfo] = &[word('P', Unit::Flag, "its name, P\"textured\"; none: the one file of Smoothieware")];
const ONE_MESH: &str = "there is one mesh, without a name";
const ALONG: &[WordInfo] = &[
    word('X', Unit::Length, "how far"),
    word('Y', Unit::Length, "how far"),
    word('Z', Unit::Length, "how far"),
    word('F', Unit::Feed, "speed of this search"),
];
const STRATEGY: &[WordInfo] = &[
    word('P', Unit::Number, "0: leveling alone; 1: calibration alone"),
    word('X', Unit::Length, "size of the area; with A and B its start, with R1 the way from here to it"),
    word('Y', Unit::Length, "size of the area; with A and B its start, with R1 the way from here to it"),
    word('A', Unit::Length, "size of the area along X, with two corners"),
    word('B', Unit::Length, "size of the area along Y, with two corners"),
    word('I', Unit::Number, "points along X, or the spread to reach"),
    word('J', Unit::Number, "points along Y, or a radius"),
    word('D', Unit::Length, "for the objects of the job alone, and so much around them"),
    word('R', Unit::Number, "1: two corners, from where the probe is; 0: none; calibrating: leave out the trims"),
    word('E', Unit::Number, "calibrating: leave out the radius"),
    word('S', Unit::Number, "a delta: 3 finds trims, 4 radius too, 6 angles, 7 the arms' length, 9 each arm's"),
    word('K', Unit::Number, "has nothing to do"),
];

const SEARCHES: &str = "the contact is looked for each millisecond, and the place read after the stop";

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::means(
        Code::g(28),
        homing::home_or_park,
        "home all axes with a homing switch, or those named; in GRBL's dialect, park",
    )
    .takes(AXES)
    .waits(Waits::Result)
    .differs("switches are looked at each 10 ms; words that are no axes are ignored"),
    CodeInfo::means(Code::g(28).sub(1), homing::store_park, "store the park position: here, or X Y and Z")
        .takes(PLACES),
    CodeInfo::means(Code::g(28).sub(2), homing::home_or_park, "park; in GRBL's dialect, home")
        .takes(AXES)
        .waits(Waits::Result),
    CodeInfo::means(Code::g(28).sub(3), offsets::declare_position, "the machine is here, and counts as homed")
        .takes(DECLARED)
        .waits(Waits::Standstill),
    CodeInfo::asks(
        Code::g(28).sub(4),
        Function::Standing(Standing::MotorPositions),
        "the motors are at these places, and their axes count as homed",
    )
    .takes(&[word('X', Unit::Mm, "by motor"), word('Y', Unit::Mm, "by motor"), word('Z', Unit::Mm, "by motor")])
    .waits(Waits::Standstill),
    CodeInfo::means(Code::g(28).sub(5), homing::forget_homing, "forget that axes are homed").takes(AXES),
    CodeInfo::asks(Code::g(28).sub(6), Function::Report(Report::ReportHoming), "say which axes are homed")
        .waits(Waits::Question),
    CodeInfo::asks(
        Code::g(28).sub(7),
        Function::Sequence(Sequence::AlignSlave),
        "how far a slave is from its own switch; put it at its trim",
    )
    .takes(SLAVES)
    .waits(Waits::Result),
    strategy(Code::g(29), "measure the bed as the leveling strategy does"),
    strategy(Code::g(29).sub(1), "measure the bed on a spiral").waits(Waits::Result),
    CodeInfo::means(
        Code::g(30),
        homing::probe_or_park,
        "search for the bed and say the way there; with nist_G30, park",
    )
    .takes(&[
        word('P', Unit::Flag, "search, also where it parks"),
        word('X', Unit::Length, "when parking, a distance to go first, in GRBL's dialect a place"),
        word('Y', Unit::Length, "when parking, a distance to go first, in GRBL's dialect a place"),
        word('F', Unit::Feed, "speed of this search"),
        word('Z', Unit::Length, "stay there; it reads as this from now on"),
        word('L', Unit::Flag, "stay there"),
        word('R', Unit::Number, "1: the other way"),
    ])
    .waits(Waits::Result)
    .part(Part::Probe)
    .differs(SEARCHES),
    CodeInfo::means(Code::g(30).sub(1), homing::store_park, "store the second park position: here, or X Y and Z")
        .takes(PLACES)
        .differs("known only with grbl_mode and nist_G30"),
    strategy(Code::g(31), "level by a grid; three points: say the plane"),
    strategy(Code::g(32), "level the bed, or calibrate a delta"),
    CodeInfo::asks(
        Code::g(34),
        Function::Sequence(Sequence::AlignZ),
        "turn each Z motor alone until bed and gantry are parallel",
    )
    .takes(&[
        word('I', Unit::Number, "rounds after the first one, at most").bounds(&Whole(0.0, 30.0)),
        word('T', Unit::Length, "what no motor may be off by more than").bounds(&Above(0.0)),
    ])
    .waits(Waits::Result)
    .part(Part::ZAlignment)
    .levels()
    .differs("not known"),
    CodeInfo::asks(
        Code::g(35),
        Function::Sequence(Sequence::BedScrews),
        "say how far each screw of the bed is to be turned",
    )
    .waits(Waits::Result)
    .part(Part::BedScrews)
    .levels()
    .differs("not known"),
    along(2, "search until the contact closes; none is an alarm"),
    along(3, "search until the contact closes"),
    along(4, "search until the contact opens; if it does not, alarm"),
    along(5, "search until the contact opens"),
    along(0, "refused: it needs a subcode, 2 to 5").any_subcode(),
    CodeInfo::asks(Code::m(48), Function::Sequence(Sequence::ProbeRepeatability), "how well the probe repeats itself")
        .takes(&[
            word('P', Unit::Number, "how often").bounds(&Within(1.0, 1_000.0)),
            word('F', Unit::Feed, "speed of the searches").bounds(&Above(0.0)),
        ])
        .waits(Waits::Result)
        .part(Part::Probe)
        .differs("says the greatest difference alone"),
    CodeInfo::asks(Code::m(119), Function::Report(Report::ReportSwitches), "the state of end switches and probe")
        .waits(Waits::Question)
        .states(super::row::EVERYWHERE_BUT_INVALID),
    CodeInfo::asks(
        Code::m(206),
        Function::Limit(LimitCode::HomeOffsets),
        "correct homing positions, from the next homing on",
    )
    .takes(PLACES),
    CodeInfo::asks(
        Code::m(306),
        Function::Standing(Standing::HomeOffsetsFromHere),
        "correct homing positions: this place reads as given from now on; T: find a heater's model",
    )
    .takes(&[
        word('X', Unit::Length, "what this place is to read"),
        word('Y', Unit::Length, "what this place is to read"),
        word('Z', Unit::Length, "what this place is to read"),
        word('T', Unit::Id, "find the model of the heater with this tool_id, and use it: see M307"),
        word('S', Unit::Celsius, "with T: temperature to swing around, 150 where it is left out"),
        word('C', Unit::Number, "with T: swings, 3 where it is left out").bounds(&Within(3.0, 50.0)),
        word('R', Unit::Celsius, "with T: temperature of the air, where the heater is not cold"),
    ])
    .waits(Waits::Standstill)
    .differs("knows no T"),
    CodeInfo::asks(
        Code::m(211),
        Function::Limit(LimitCode::SoftEndstops),
        "the ends of travel that moves are held against; says them",
    )
    .takes(&[word('S', Unit::Flag, "0: moves are not held against them; until the next reset")])
    .differs("not known"),
    leveling(Code::m(370), Function::Sequence(Sequence::LevelingOff), "no leveling"),
    leveling(Code::m(374), Function::Sequence(Sequence::SaveGrid), "save the mesh to the card")
        .levels()
        .takes(MESH)
        .differs(ONE_MESH),
    leveling(Code::m(374).sub(1), Function::File(FileFunction::DeleteGrid), "delete the saved mesh")
        .takes(MESH)
        .differs(ONE_MESH),
    CodeInfo::asks(
        Code::m(374).sub(2),
        Function::Sequence(Sequence::ListMeshes),
        "list the meshes on the card that have a name",
    )
    .waits(Waits::Result)
    .differs("not known"),
    leveling(Code::m(375), Function::Geometry(Geometry::LoadGrid), "load the saved mesh and level by it")
        .levels()
        .takes(MESH)
        .differs(ONE_MESH),
    CodeInfo::asks(Code::m(375).sub(1), Function::Report(Report::ShowGrid), "show the grid in numbers"),
    CodeInfo::asks(
        Code::m(375).sub(2),
        Function::Report(Report::ShowMap),
        "show the bed as a map, and say what it needs",
    )
    .differs("not known"),
    leveling(Code::m(376), Function::Geometry(Geometry::FadeHeight), "where the mesh has faded; without words, say it")
        .takes(&[
            word('H', Unit::Length, "from Z0 up to this height; 0: it does not fade").bounds(&AtLeast(0.0)),
            word('T', Unit::Length, "there so much of the correction is left, the same everywhere"),
        ])
        .differs("not known"),
    CodeInfo::asks(Code::m(401), Function::Sequence(Sequence::DeployProbe), "bring the probe out, until M402")
        .waits(Waits::Result)
        .part(Part::Probe)
        .differs("not known"),
    CodeInfo::asks(Code::m(402), Function::Sequence(Sequence::StowProbe), "put the probe away")
        .waits(Waits::Result)
        .part(Part::Probe)
        .differs("not known"),
    leveling(Code::m(421), Function::Sequence(Sequence::GridPoint), "set one height of the grid")
        .takes(&[
            word('I', Unit::Number, "column, from 0"),
            word('J', Unit::Number, "row, from 0"),
            word('X', Unit::Length, "the point nearest to here, with Y"),
            word('Y', Unit::Length, "the point nearest to here, with X"),
            word('C', Unit::Flag, "the point nearest to the tool"),
            word('Z', Unit::Length, "height"),
            word('Q', Unit::Length, "by so much higher"),
        ])
        .differs("takes I, J and Z"),
    CodeInfo::asks(Code::m(557), Function::Setting(Setting::ProbePoint), "the points of three-point leveling").takes(
        &[
            word('P', Unit::Number, "which point").bounds(&Whole(0.0, 2.0)),
            word('X', Unit::Length, "where it is"),
            word('Y', Unit::Length, "where it is"),
        ],
    ),
    leveling(
        Code::m(561),
        Function::Geometry(Geometry::BedPlane),
        "level by the plane A X + B Y + C Z + D = 0; without words, no leveling",
    )
    .takes(&[
        word('A', Unit::Number, "of the plane"),
        word('B', Unit::Number, "of the plane"),
        word('C', Unit::Number, "of the plane"),
        word('D', Unit::Number, "of the plane"),
    ])
    .differs("bit patterns of single-precision numbers, which are understood too"),
    CodeInfo::asks(Code::m(565), Function::Setting(Setting::ProbeOffset), "where the probe is, seen from the tool")
        .takes(&[
            word('X', Unit::Length, "by axis"),
            word('Y', Unit::Length, "by axis"),
            word('Z', Unit::Length, "by axis"),
        ]),
    CodeInfo::asks(Code::m(670), Function::Setting(Setting::ProbeSettings), "settings of the probe")
        .takes(&[
            word('S', Unit::MmPerSecond, "slow rate").bounds(&Above(0.0)),
            word('K', Unit::MmPerSecond, "fast rate").bounds(&Above(0.0)),
            word('R', Unit::MmPerSecond, "return rate; 0: twice the slow one, at most the fast one")
                .bounds(&AtLeast(0.0)),
            word('Z', Unit::Mm, "longest way of a search").bounds(&Above(0.0)),
            word('H', Unit::Mm, "height between the points of a grid").bounds(&Above(0.0)),
            word('D', Unit::Seconds, "pause before a search").bounds(&Within(0.0, 60.0)),
            word('I', Unit::Flag, "1: the contact is the other way round, until the next I1 or reset; 0: as it is"),
        ])
        .part(Part::Probe),
    CodeInfo::asks(
        Code::m(851),
        Function::Setting(Setting::MarlinProbeOffset),
        "where the probe is, seen from the tool, as Marlin counts it",
    )
    .takes(&[
        word('X', Unit::Length, "by axis"),
        word('Y', Unit::Length, "by axis"),
        word('Z', Unit::Length, "the other way round than M565's"),
    ])
    .differs("not known"),
    paper(1, "begin a paper test: a person says when paper drags under the tool").takes(&[word(
        'P',
        Unit::Number,
        "for 0 the probe's offset, 1 where Z homes, 2 a height, 3 the bed's screws, 4 an axis's twist",
    )
    .bounds(&Whole(0.0, 4.0))]),
    paper(2, "move the tool in a paper test").takes(&[
        word('Z', Unit::Length, "by so much"),
        word('S', Unit::Number, "-1, 1: halfway to the height tried next below or above; -2, 2: to it")
            .bounds(&Within(-2.0, 2.0)),
    ]),
    paper(3, "in a paper test, the paper drags"),
    paper(4, "end a paper test, and change nothing"),
    paper(5, "in a paper test, the screw was turned until the paper drags"),
    CodeInfo::asks(
        Code::m(851).sub(6),
        Function::Setting(Setting::AxisTwist),
        "what the probe reads too high at a place along an axis",
    )
    .takes(&[
        word('X', Unit::Length, "the place, of an axis X whose rail is twisted"),
        word('Y', Unit::Length, "the place, of an axis Y"),
        word('Z', Unit::Length, "what it reads too high"),
        word('R', Unit::Flag, "forget all places first"),
    ])
    .differs("not known"),
    leveling(Code::m(852), Function::Geometry(Geometry::Skew), "skew factors")
        .takes(&[
            word('I', Unit::Number, "X and Y"),
            word('J', Unit::Number, "X and Z"),
            word('K', Unit::Number, "Y and Z"),
            word('P', Unit::Number, "by a measured square in the plane: 0 XY, 1 XZ, 2 YZ").bounds(&Whole(0.0, 2.0)),
            word('A', Unit::Length, "of that square, the diagonal AC from the origin").bounds(&Above(0.0)),
            word('B', Unit::Length, "the other diagonal, BD").bounds(&Above(0.0)),
            word('D', Unit::Length, "the side AD, along the plane's second axis").bounds(&Above(0.0)),
        ])
        .differs("not known"),
    CodeInfo::asks(
        Code::m(852).sub(1),
        Function::Geometry(Geometry::Skew),
        "say the skew factor of a measured square, and change nothing",
    )
    .takes(SQUARE)
    .differs("not known"),
    leveling(Code::m(852).sub(2), Function::Geometry(Geometry::Skew), "save the skew factors to the card")
        .takes(PROFILE)
        .differs("not known"),
    leveling(Code::m(852).sub(3), Function::Geometry(Geometry::Skew), "load saved skew factors")
        .takes(PROFILE)
        .differs("not known"),
    leveling(Code::m(852).sub(4), Function::Geometry(Geometry::Skew), "delete saved skew factors")
        .takes(PROFILE)
        .differs("not known"),
    CodeInfo::asks(
        Code::m(875),
        Function::Setting(Setting::EndstopPhase),
        "say where motors were in their cycle of four full steps when their switches closed",
    )
    .takes(FLAGS)
    .differs("not known"),
    CodeInfo::asks(
        Code::m(875).sub(1),
        Function::Setting(Setting::EndstopPhase),
        "make the mean of them the calibrated phase",
    )
    .takes(FLAGS)
    .differs("not known"),
    CodeInfo::asks(
        Code::m(875).sub(2),
        Function::Setting(Setting::EndstopPhase),
        "the calibrated phase, 0 to below 1024; below 0: what the next homing finds",
    )
    .takes(PHASES)
    .differs("not known"),
    CodeInfo::asks(
        Code::m(875).sub(3),
        Function::Setting(Setting::EndstopPhase),
        "forget the phases that were collected",
    )
    .takes(FLAGS)
    .differs("not known"),
];

/// Axis letters without values; naming no axis means all axes.
const FLAGS: &[WordInfo] = &[
    word('X', Unit::Flag, "of this axis"),
    word('Y', Unit::Flag, "of this axis"),
    word('Z', Unit::Flag, "of this axis"),
    word('A', Unit::Flag, "of this axis"),
    word('B', Unit::Flag, "of this axis"),
    word('C', Unit::Flag, "of this axis"),
];

const PHASES: &[WordInfo] = &[
    word('X', Unit::Number, "in 1/256 full steps").bounds(&Within(-1.0, 1_023.999)),
    word('Y', Unit::Number, "in 1/256 full steps").bounds(&Within(-1.0, 1_023.999)),
    word('Z', Unit::Number, "in 1/256 full steps").bounds(&Within(-1.0, 1_023.999)),
    word('A', Unit::Number, "in 1/256 full steps").bounds(&Within(-1.0, 1_023.999)),
    word('B', Unit::Number, "in 1/256 full steps").bounds(&Within(-1.0, 1_023.999)),
    word('C', Unit::Number, "in 1/256 full steps").bounds(&Within(-1.0, 1_023.999)),
];

const PROFILE: &[WordInfo] = &[word('P', Unit::Number, "the name, in quotes: the file is NAME.skew")];

const SQUARE: &[WordInfo] = &[
    word('A', Unit::Length, "the diagonal AC from the origin").bounds(&Above(0.0)),
    word('B', Unit::Length, "the other diagonal, BD").bounds(&Above(0.0)),
    word('D', Unit::Length, "the side AD, along the plane's second axis").bounds(&Above(0.0)),
];

const fn strategy(code: Code, help: &'static str) -> CodeInfo {
    CodeInfo::asks(code, Function::Sequence(Sequence::ProbeStrategy), help)
        .takes(STRATEGY)
        .waits(Waits::Result)
        .part(Part::Probe)
        .levels()
}

const fn along(subcode: u8, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::g(38).sub(subcode), probing::probe_along, help)
        .takes(ALONG)
        .waits(Waits::Result)
        .part(Part::Probe)
        .differs("in GRBL mode too, words are distances and Z goes alone; without a probe it is ignored")
}

const fn paper(subcode: u8, help: &'static str) -> CodeInfo {
    CodeInfo::asks(Code::m(851).sub(subcode), Function::Sequence(Sequence::PaperTest), help)
        .waits(Waits::Result)
        .differs("not known")
}

const fn leveling(code: Code, function: Function, help: &'static str) -> CodeInfo {
    CodeInfo::asks(code, function, help).waits(Waits::Standstill)
}
