//! Codes of motors, their limits, and the machine's geometry.

use gcode::Code;

use super::row::{CodeInfo, EVERYWHERE_BUT_INVALID, Waits};
use crate::function::{Function, Geometry, LimitCode, Report, Sequence, Setting, Standing};
use crate::meaning::{extruders, printers};
use crate::word::Bounds::{Above, AtLeast, Whole, Within};
use crate::word::{Unit, WordInfo, word};

/// Builds a word for each axis, all of one unit.
macro_rules! by_axis {
    ($unit:expr, $text:literal $(, $more:expr)*) => {
        const { &[
            word('X', $unit, $text),
            word('Y', $unit, $text),
            word('Z', $unit, $text),
            word('A', $unit, $text),
            word('B', $unit, $text),
            word('C', $unit, $text),
            $($more),*
        ] }
    };
}

const TOOL_WORD: WordInfo = word('P', Unit::Number, "E is of this tool; of the one in use where it is left out");

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::asks(Code::m(17), Function::Setting(Setting::MotorsOn), "motors on").waits(Waits::Standstill),
    off(18),
    off(84),
    CodeInfo::asks(Code::m(92), Function::Standing(Standing::StepsPerMm), "steps for each mm")
        .takes(&[
            word('X', Unit::StepsPerLength, "of this motor"),
            word('Y', Unit::StepsPerLength, "of this motor"),
            word('Z', Unit::StepsPerLength, "of this motor"),
            word('A', Unit::Number, "of this motor"),
            word('B', Unit::Number, "of this motor"),
            word('C', Unit::Number, "of this motor"),
            word('E', Unit::Number, "of an extruder's motor"),
            TOOL_WORD,
        ])
        .waits(Waits::Standstill),
    CodeInfo::either(
        Code::m(203),
        extruders::flow_limit,
        Function::Limit(LimitCode::AxisSpeeds),
        "greatest speeds of axes; without words, say them",
    )
    .takes(&[
        word('X', Unit::MmPerSecond, "of this axis"),
        word('Y', Unit::MmPerSecond, "of this axis"),
        word('Z', Unit::MmPerSecond, "of this axis"),
        word('E', Unit::MmPerSecond, "of an extruder's motor"),
        word('S', Unit::MmPerSecond, "of G0"),
        word('P', Unit::Number, "of the tool along its path; beside E or V, which extruder"),
        word('V', Unit::Number, "of the flow of G1 where E counts in mm3, mm3/s; 0: none").bounds(&AtLeast(0.0)),
    ]),
    CodeInfo::asks(
        Code::m(203).sub(1),
        Function::Limit(LimitCode::MotorSpeeds),
        "greatest speeds of motors; without words, say them",
    )
    .takes(by_axis!(
        Unit::MmPerSecond,
        "of this motor",
        word('E', Unit::MmPerSecond, "of an extruder's motor"),
        TOOL_WORD
    )),
    CodeInfo::asks(Code::m(204), Function::Limit(LimitCode::Accelerations), "accelerations").takes(by_axis!(
        Unit::MmPerSecond2,
        "of this motor; 0: as S",
        word('S', Unit::MmPerSecond2, "where a motor has none of its own"),
        word('E', Unit::MmPerSecond2, "of an extruder's motor"),
        TOOL_WORD
    )),
    CodeInfo::asks(Code::m(205), Function::Limit(LimitCode::CornerSettings), "junction deviation and least speed")
        .takes(&[
            word('X', Unit::Mm, "junction deviation; sets square_corner_velocity aside"),
            word('Z', Unit::Mm, "the same for moves of Z alone; below 0: as X"),
            word('S', Unit::MmPerSecond, "least speed"),
            word('V', Unit::MmPerSecond, "square corner velocity; sets junction deviations aside")
                .bounds(&AtLeast(0.0)),
            word('C', Unit::Number, "share of the way between slow places that is left for cruising")
                .bounds(&Within(0.0, 0.95)),
        ]),
    CodeInfo::asks(
        Code::m(220),
        Function::Limit(LimitCode::SpeedFactor),
        "scale the speeds of what follows; typed beside a job, of all it makes, at once",
    )
    .takes(&[
        word('S', Unit::Percent, "factor, 10 to 1000"),
        word('B', Unit::Flag, "keep the factor for R"),
        word('R', Unit::Flag, "back to what was kept"),
    ]),
    CodeInfo::asks(Code::m(665), Function::Geometry(Geometry::ArmSettings), "geometry of arms")
        .takes(by_axis!(
            Unit::Number,
            "as arm_solution says",
            word('D', Unit::Number, "as arm_solution says"),
            word('E', Unit::Number, "as arm_solution says"),
            word('H', Unit::Number, "as arm_solution says"),
            word('I', Unit::Number, "added to the length of tower 1's rods"),
            word('J', Unit::Number, "added to the length of tower 2's rods"),
            word('K', Unit::Number, "added to the length of tower 3's rods"),
            word('L', Unit::Number, "as arm_solution says"),
            word('R', Unit::Number, "as arm_solution says"),
            word('S', Unit::Number, "pieces of a line a second"),
            word('U', Unit::Number, "length of the pieces of a line")
        ))
        .waits(Waits::Standstill),
    CodeInfo::asks(
        Code::m(665).sub(1),
        Function::Sequence(Sequence::MeasuredPart),
        "a distance measured on a part that a delta has printed; without words, those that are kept",
    )
    .takes(&[
        word('X', Unit::Length, "one end, as it was printed"),
        word('Y', Unit::Length, "one end"),
        word('I', Unit::Length, "the other end's X"),
        word('J', Unit::Length, "the other end's Y"),
        word('S', Unit::Length, "how far apart they were measured").bounds(&Above(0.0)),
    ])
    .waits(Waits::Standstill)
    .differs("not known"),
    CodeInfo::asks(
        Code::m(665).sub(2),
        Function::Sequence(Sequence::MeasuredPart),
        "calibrate a delta by the distances that are kept",
    )
    .takes(&[
        word('S', Unit::Number, "how much is found, as with G32; 9 without it"),
        word('R', Unit::Number, "leave out the trims"),
        word('E', Unit::Number, "leave out the radius"),
    ])
    .waits(Waits::Standstill)
    .differs("not known"),
    CodeInfo::asks(Code::m(665).sub(3), Function::Sequence(Sequence::MeasuredPart), "forget the measured distances")
        .differs("not known"),
    CodeInfo::asks(
        Code::m(665).sub(4),
        Function::Sequence(Sequence::MeasuredPart),
        "lengths of Klipper's calibration part; without words, they are the distances kept",
    )
    .takes(&[
        word(
            'P',
            Unit::Number,
            "0: centre distances, 1: outer distances, 2: widths of the centre pillar, 3: of the outer ones",
        )
        .bounds(&Whole(0.0, 3.0)),
        word('A', Unit::Length, "the first of them").bounds(&Above(0.0)),
        word('B', Unit::Length, "the second").bounds(&Above(0.0)),
        word('C', Unit::Length, "the third").bounds(&Above(0.0)),
        word('D', Unit::Length, "the fourth").bounds(&Above(0.0)),
        word('E', Unit::Length, "the fifth").bounds(&Above(0.0)),
        word('F', Unit::Length, "the sixth").bounds(&Above(0.0)),
        word('S', Unit::Number, "the part was printed so much larger").bounds(&Above(0.0)),
    ])
    .waits(Waits::Standstill)
    .differs("not known"),
    CodeInfo::asks(Code::m(666), Function::Limit(LimitCode::Trims), "trims of towers or arms, from the next homing on")
        .takes(&[word('X', Unit::Mm, "by motor"), word('Y', Unit::Mm, "by motor"), word('Z', Unit::Mm, "by motor")]),
    CodeInfo::asks(Code::m(900), Function::Standing(Standing::PressureAdvance), "pressure advance; without K, say it")
        .takes(&[
            word('K', Unit::Seconds, "how much").bounds(&AtLeast(0.0)),
            word('W', Unit::Seconds, "smoothed over so long").bounds(&AtLeast(0.0)),
            TOOL_WORD,
        ])
        .waits(Waits::Standstill)
        .differs("not known"),
    CodeInfo::asks(Code::m(122), Function::Report(Report::DriverStatus), "the same as M911")
        .takes(by_axis!(Unit::Flag, "this motor", word('P', Unit::Number, "which motor, from 0")))
        .states(EVERYWHERE_BUT_INVALID)
        .differs(NOT_KNOWN),
    CodeInfo::asks(
        Code::m(569),
        Function::Standing(Standing::StealthMode),
        "how drivers outside drive motors, all or those named",
    )
    .takes(by_axis!(Unit::Flag, "this motor", word('S', Unit::Number, "1: stealthChop at any speed; 0: spreadCycle")))
    .waits(Waits::Standstill)
    .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(906), Function::Setting(Setting::MotorMilliamps), "motor currents in mA")
        .takes(by_axis!(Unit::Milliamps, "of this motor")),
    CodeInfo::asks(Code::m(907), Function::Setting(Setting::MotorAmps), "motor currents in A")
        .takes(by_axis!(Unit::Amps, "of this motor")),
    microsteps(Code::m(909), "microsteps of motors, until the next reset"),
    microsteps(Code::m(909).sub(1), "microsteps of motors and the steps of each mm with them, until the next reset"),
    CodeInfo::asks(Code::m(911), Function::Report(Report::DriverStatus), "what the motor drivers say of themselves")
        .takes(by_axis!(Unit::Flag, "this motor", word('P', Unit::Number, "which motor, from 0")))
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::asks(
        Code::m(911).sub(1),
        Function::Setting(Setting::DriverChopper),
        "how drivers regulate currents, a line each",
    )
    .takes(by_axis!(Unit::Flag, "this motor", word('P', Unit::Number, "which motor, from 0")))
    .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::asks(
        Code::m(911).sub(2),
        Function::Standing(Standing::DriverRegister),
        "write a driver's register; without R, say which",
    )
    .takes(&[
        word('P', Unit::Number, "which motor, from 0; all where it is left out"),
        word('R', Unit::Number, "its register, from 1; 255: all again"),
        word('V', Unit::Number, "the value"),
    ])
    .waits(Waits::Standstill),
    CodeInfo::asks(Code::m(911).sub(3), Function::Setting(Setting::DriverOption), "set one thing of a driver")
        .takes(
            const {
                &[
                    word('P', Unit::Number, "which motor, from 0; all where it is left out"),
                    word(
                        'S',
                        Unit::Number,
                        "0 constant off time, 1 spreadCycle, 2 random off time, 4 interpolation, 5 coolStep \
                    on or off, 6 passive fast decay, 7 stallGuard2, 8 how coolStep works, 9 stallGuard2 while it homes",
                    ),
                    word('U', Unit::Number, "off time"),
                    word('V', Unit::Number, "blanking time, clocks"),
                    word('W', Unit::Number, "hysteresis start, or fast decay time"),
                    word('X', Unit::Number, "hysteresis end, or offset of the sine"),
                    word('Y', Unit::Number, "hysteresis decrement, or 1: the comparator ends the decay"),
                    word('Z', Unit::Number, "1: on, 0: off"),
                    word('O', Unit::Number, "threshold"),
                    word('Q', Unit::Number, "1: filtered"),
                    word('H', Unit::Number, "lower threshold"),
                    word('I', Unit::Number, "width of the band above it"),
                    word('J', Unit::Number, "speed of decrease, 0 to 3"),
                    word('K', Unit::Number, "speed of increase, 0 to 3"),
                    word('L', Unit::Number, "1: down to a quarter of the current, not to half"),
                ]
            },
        )
        .differs("S3, double edges, can be switched off; J and K of S8 are exchanged"),
    CodeInfo::asks(
        Code::m(912),
        Function::Setting(Setting::ForgetDriverTroubles),
        "tell again what is wrong with drivers, if it still is",
    )
    .takes(by_axis!(Unit::Flag, "this motor", word('P', Unit::Number, "which motor, from 0")))
    .differs(NOT_KNOWN),
    CodeInfo::asks(
        Code::m(913),
        Function::Standing(Standing::StealthThresholds),
        "up to which speed stealthChop drives motors; without words, say it",
    )
    .takes(by_axis!(Unit::MmPerSecond, "of this motor; 0: never"))
    .waits(Waits::Standstill)
    .differs(NOT_KNOWN),
    CodeInfo::asks(
        Code::m(914),
        Function::Setting(Setting::HomingThresholds),
        "what counts as a stall where an axis homes without a switch",
    )
    .takes(by_axis!(Unit::Number, "of this motor, as stall_threshold of its endstop"))
    .differs(NOT_KNOWN),
];

const NOT_KNOWN: &str = "not known";

const fn microsteps(code: Code, help: &'static str) -> CodeInfo {
    CodeInfo::asks(code, Function::Standing(Standing::Microsteps), help)
        .takes(by_axis!(Unit::Number, "of this motor, a power of two up to 256"))
        .waits(Waits::Standstill)
}

const fn off(number: u16) -> CodeInfo {
    CodeInfo::either(
        Code::m(number),
        printers::motors_off,
        Function::Standing(Standing::MotorsOff),
        "motors off, all or those named",
    )
    .takes(by_axis!(
        Unit::Flag,
        "this motor",
        word('E', Unit::Flag, "the motor of the active extruder"),
        word('S', Unit::Seconds, "M18 alone: nothing is done; M84: has nothing to do")
    ))
    .waits(Waits::Standstill)
}
