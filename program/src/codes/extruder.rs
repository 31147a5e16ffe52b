//! Codes of extruders and filament.

use gcode::Code;

use super::row::{CodeInfo, Group, Waits};
use crate::function::{Function, Report, Sequence};
use crate::meaning::{extruders, offsets};
use crate::word::Bounds::{Above, AtLeast, Whole, Within};
use crate::word::{Unit, WordInfo, word};

const TOOL_WORD: WordInfo = word('P', Unit::Number, "of this tool; of the one in use where it is left out");

/// Row of T0, T1 and so on.
pub const TOOL: CodeInfo = CodeInfo::tool("select an extruder, and its offset").waits(Waits::Path);

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::means(Code::g(11), extruders::recover, "push retracted filament forward again").waits(Waits::Path),
    CodeInfo::means(Code::m(82), offsets::extruder_distance_mode, "coordinates of the extruder are places")
        .group(Group::ExtruderDistance),
    CodeInfo::means(Code::m(83), offsets::extruder_distance_mode, "coordinates of the extruder are distances")
        .group(Group::ExtruderDistance),
    CodeInfo::either(
        Code::m(200),
        extruders::filament_diameter,
        Function::Report(Report::FilamentDiameter),
        "count E in mm3 of filament this thick; 0: in mm",
    )
    .takes(&[
        word('D', Unit::Mm, "its diameter"),
        word('S', Unit::Number, "printer firmware: 0: count in mm; 1: in mm3"),
        TOOL_WORD,
        word('T', Unit::Number, "the same as P"),
    ]),
    CodeInfo::means(Code::m(207), extruders::retraction, "how G10 retracts").takes(&[
        word('S', Unit::Mm, "length"),
        word('F', Unit::MmPerMinute, "speed").bounds(&Above(0.0)),
        word('Z', Unit::Mm, "lift"),
        word('Q', Unit::MmPerMinute, "speed of the lift").bounds(&Above(0.0)),
        TOOL_WORD,
    ]),
    CodeInfo::means(Code::m(208), extruders::recovery, "how G11 recovers").takes(&[
        word('S', Unit::Mm, "length beyond the retraction"),
        word('F', Unit::MmPerMinute, "speed").bounds(&Above(0.0)),
        TOOL_WORD,
    ]),
    CodeInfo::either(
        Code::m(221),
        extruders::flow,
        Function::Report(Report::FlowFactor),
        "scale the flow of what is extruded from now on, or the power of a laser",
    )
    .takes(&[
        word('S', Unit::Percent, "factor").bounds(&Above(0.0)),
        TOOL_WORD,
        word('T', Unit::Number, "the same as P"),
        word('D', Unit::Number, "the same as P"),
        word('R', Unit::Number, "frequency of the laser's duty, Hz").bounds(&Within(4.0, 50_000.0)),
    ])
    .differs("on a machine with extruders and a laser the power of the laser too; with a laser alone P1 as there"),
    filament_detector(404, "how the filament detector looks, and how thick filament is; without words, say it")
        .takes(&[
            word('S', Unit::Seconds, "time between looks").bounds(&Above(0.0)),
            word('P', Unit::Number, "pulses a mm").bounds(&Above(0.0)),
            word('H', Unit::Number, "1: heaters stay on"),
            word('W', Unit::Mm, "nominal diameter").bounds(&Above(0.0)),
        ])
        .differs("no W"),
    filament_width(404, 1, "forget what was measured of the filament's width"),
    filament_detector(405, "filament detector off, and the sensor of its width"),
    filament_width(405, 1, "sensor of the filament's width off, alone"),
    filament_detector(406, "filament detector on, and the sensor of its width")
        .takes(&[word('D', Unit::Number, "centimetres from that sensor to the nozzle").bounds(&Above(0.0))])
        .differs("no D"),
    filament_width(406, 1, "sensor of the filament's width on, alone"),
    filament_detector(407, "state of the filament detector, and the filament's width").waits(Waits::Question),
    filament_width(407, 1, "what the inputs of the sensor of the filament's width read").waits(Waits::Question),
    filament_width(407, 2, "whether the filament's width is said, each centimetre").takes(&[word(
        'S',
        Unit::Number,
        "1: it is; 0: it is not",
    )]),
    filament_detector(412, "filament detector; without words, say its state")
        .takes(&[word('S', Unit::Number, "1: on; 0: off")])
        .differs("not known"),
    CodeInfo::asks(
        Code::m(603),
        Function::Report(Report::FilamentLengths),
        "lengths of a change of filament; without words, say them",
    )
    .takes(&[
        word('L', Unit::Mm, "pushed in").bounds(&AtLeast(0.0)),
        word('U', Unit::Mm, "taken out").bounds(&AtLeast(0.0)),
    ])
    .differs("not known"),
    CodeInfo::asks(
        Code::g(27),
        Function::Sequence(Sequence::Park),
        "lift the tool and go aside, as [filament change] says",
    )
    .takes(&[word('P', Unit::Number, "Marlin's 0 and 2: as it does here; 1 is refused").bounds(&Whole(0.0, 2.0))])
    .waits(Waits::Result)
    .differs("not known"),
    CodeInfo::asks(Code::m(701), Function::Sequence(Sequence::LoadFilament), "push filament in")
        .takes(&[word('L', Unit::Mm, "so far; as M603 says without").bounds(&AtLeast(0.0))])
        .waits(Waits::Result)
        .differs("not known"),
    CodeInfo::asks(Code::m(702), Function::Sequence(Sequence::UnloadFilament), "take filament out")
        .takes(&[word('U', Unit::Mm, "so far; as M603 says without").bounds(&AtLeast(0.0))])
        .waits(Waits::Result)
        .differs("not known"),
];

const fn filament_detector(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::asks(Code::m(number), Function::Report(Report::FilamentDetector), help)
}

const fn filament_width(number: u16, subcode: u8, help: &'static str) -> CodeInfo {
    CodeInfo::asks(Code::m(number).sub(subcode), Function::Report(Report::FilamentWidth), help).differs("not known")
}
