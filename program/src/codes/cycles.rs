//! G70 to G89, G98 and G99: canned cycles; G93 to G95: feed modes.

use gcode::Code;

use super::row::{CodeInfo, Group, Waits};
use crate::fault::Part;
use crate::meaning::{cycles, feed_modes, threads};
use crate::word::Bounds::{Above, AtLeast, Whole, Within};
use crate::word::{Unit, WordInfo, word};

const HOLE: &[WordInfo] = &[
    word('X', Unit::Length, "where the hole is; with G19 its depth"),
    word('Y', Unit::Length, "where the hole is; with G18 its depth"),
    word('Z', Unit::Length, "its depth; where it is with G18 and G19. After G91 the depth counts from R"),
    word('@', Unit::Length, "where the hole is: distance from the origin of X and Y"),
    word('^', Unit::Number, "angle from X there, degrees"),
    word('R', Unit::Length, "where cutting begins; after G91 from where the axis was before the first hole"),
    word('Q', Unit::Length, "depth of a peck").bounds(&Above(0.0)),
    word('P', Unit::Number, "dwell at the bottom, s; ms where `[drillingcycles] dwell_units` says P")
        .bounds(&AtLeast(0.0)),
    word('L', Unit::Number, "how many holes; after G91 X and Y apart").bounds(&Whole(1.0, 10_000.0)),
    word('F', Unit::Feed, "speed from now on"),
    word('S', Unit::Number, "laser or spindle power from now on"),
];

/// Words whose meaning depends on the motion code in force, a cycle's included.
const BY_CODE: &[WordInfo] = &[
    word('X', Unit::Length, FORCE),
    word('Y', Unit::Length, FORCE),
    word('Z', Unit::Length, FORCE),
    word('I', Unit::Length, FORCE),
    word('J', Unit::Length, FORCE),
    word('K', Unit::Length, FORCE),
    word('R', Unit::Length, FORCE),
    word('Q', Unit::Length, FORCE).bounds(&Above(0.0)),
    word('@', Unit::Length, FORCE),
    word('^', Unit::Number, FORCE),
    word('A', Unit::Number, FORCE),
    word('B', Unit::Number, FORCE),
    word('C', Unit::Number, FORCE),
    word('E', Unit::Number, FORCE),
    word('P', Unit::Number, FORCE).bounds(&AtLeast(0.0)),
    word('L', Unit::Number, FORCE).bounds(&Whole(1.0, 10_000.0)),
    word('F', Unit::Feed, "speed from now on"),
    word('S', Unit::Number, "laser or spindle power from now on"),
];

const FORCE: &str = "as in the motion code in force";

/// Words of the cycles that turn a contour.
const CONTOUR: &[WordInfo] = &[
    word('X', Unit::Length, "where it begins"),
    word('Z', Unit::Length, "where it begins"),
    word('Q', Unit::Number, "the subroutine that is the contour"),
    word('D', Unit::Length, "distance left from the contour, or the first one"),
    word('E', Unit::Length, "the last one"),
    word('I', Unit::Length, "depth of a cut"),
    word('R', Unit::Length, "how far it draws back"),
    word('P', Unit::Number, "passes"),
    word('F', Unit::Feed, "speed from now on"),
    word('S', Unit::Number, "laser or spindle power from now on"),
];

pub const ROWS: &[CodeInfo] = &[
    contour(70, "finish a turned contour; refused: let the CAM program turn it"),
    contour(71, "rough a contour along Z; refused: let the CAM program turn it"),
    contour(72, "rough a contour along X; refused: let the CAM program turn it"),
    cycle(73, "drill peck by peck, drawn back 0.254 mm after each: Z R Q").differs("not known"),
    cycle(74, "tap a left-hand thread, as G84 with M4 for M3: Z R").differs("not known"),
    CodeInfo::means(Code::g(76), threads::cycle, "cut a thread pass by pass, in G18; refused: no spindle encoder")
        .takes(&[
            word('P', Unit::Length, "travel of a turn").bounds(&Above(0.0)),
            word('Z', Unit::Length, "where it ends"),
            word('I', Unit::Length, "crest seen from the drive line, which X is now; below 0: external"),
            word('J', Unit::Length, "first cut").bounds(&Above(0.0)),
            word('K', Unit::Length, "height of the thread, above J"),
            word('R', Unit::Number, "degression: 1 cuts of one depth, 2 of one area").bounds(&AtLeast(1.0)),
            word('Q', Unit::Number, "angle of the compound slide, degrees").bounds(&Within(0.0, 80.0)),
            word('H', Unit::Number, "passes more at full depth").bounds(&Whole(0.0, 100.0)),
            word('E', Unit::Length, "length of the tapers").bounds(&AtLeast(0.0)),
            word('L', Unit::Number, "tapers, 1: at the beginning, 2: at the end, 3: both").bounds(&Whole(0.0, 3.0)),
        ])
        .group(Group::Motion)
        .waits(Waits::Path)
        .differs("not known"),
    CodeInfo::means(Code::g(80), cycles::cancel, "no cycle and no motion code is in force")
        .takes(&[
            word('F', Unit::Feed, "speed from now on"),
            word('S', Unit::Number, "laser or spindle power from now on"),
        ])
        .group(Group::Motion)
        .waits(Waits::Path)
        .differs("words without a code go on with G0 or G1; behind G99 it goes up in every dialect"),
    cycle(81, "drill a hole: Z R, and X Y where it is not here").differs(AS_SMOOTHIE),
    cycle(82, "drill a hole and dwell: Z R P").differs(AS_SMOOTHIE),
    cycle(83, "drill peck by peck, out of the hole after each: Z R Q").differs(PECKS),
    cycle(84, "tap with a floating holder: down, spindle the other way, P, and out at the feed rate: Z R")
        .differs("not known"),
    cycle(85, "bore: down, and out to R at the feed rate: Z R").differs("not known"),
    cycle(86, "bore: down, wait, and out with the spindle standing: Z R P").differs("not known"),
    CodeInfo::means(Code::g(87), cycles::missing, "back boring; refused: it needs an oriented spindle stop")
        .takes(BY_CODE)
        .group(Group::Motion)
        .differs("not known"),
    cycle(88, "bore: down, wait, spindle stop, and out by the operator's hand: Z R P").differs("not known"),
    cycle(89, "bore and dwell: down, wait, and out at the feed rate: Z R P").differs("not known"),
    retract(98, "cycles leave a hole to where the axis was before the first one"),
    retract(99, "cycles leave a hole to R"),
    feed(93, "inverse time: F of G1, G2 and G3 is how many such moves a minute has"),
    feed(94, "feed rate: F is length a minute"),
    feed(95, "feed rate: F is length a turn of the spindle; refused with the move: no encoder"),
];

const AS_SMOOTHIE: &str = "one code for G81, G82 and G83, and only behind G98 or G99; X or Y needed";
const PECKS: &str = "from R down at the feed rate in every peck, and not to Z where Q divides the depth";

const fn cycle(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::g(number), cycles::cycle, help)
        .takes(HOLE)
        .group(Group::Motion)
        .waits(Waits::Path)
        .part(Part::DrillingCycles)
}

const fn contour(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::g(number), cycles::missing, help)
        .any_subcode()
        .takes(CONTOUR)
        .group(Group::Motion)
        .differs("not known")
}

const fn retract(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::g(number), cycles::retract_mode, help)
        .takes(BY_CODE)
        .group(Group::RetractMode)
        .waits(Waits::Path)
        .differs("begins the cycles, and remembers Z then")
}

const fn feed(number: u16, help: &'static str) -> CodeInfo {
    CodeInfo::means(Code::g(number), feed_modes::feed_mode, help)
        .takes(BY_CODE)
        .group(Group::FeedMode)
        .waits(Waits::Path)
        .differs("not known")
}
