//! Codes of heaters and switches. The configuration assigns these codes; the rows below say how such codes
//! are read, and match the sample configurations.

use gcode::Code;

use super::row::{ANYWHERE, CodeInfo, EVERYWHERE_BUT_INVALID, Group, Waits};
use crate::fault::Part;
use crate::function::{Function, Report, Sequence, Setting, Standing};
use crate::meaning::{printers, spindle};
use crate::word::Bounds::{Above, AtLeast, Within};
use crate::word::{Unit, WordInfo, word};

const TARGET_WORDS: &[WordInfo] = &[
    word('S', Unit::Celsius, "the target; 1 and 2 stand for the presets"),
    word('T', Unit::Id, "of this tool; of the one in use where it is left out"),
];

const TARGET_AND_WAIT_WORDS: &[WordInfo] = &[
    word('S', Unit::Celsius, "the target; what is warmer is warm enough; 1 and 2 stand for the presets"),
    word('R', Unit::Celsius, "the target, where it is also to cool down to it"),
    word('T', Unit::Id, "of this tool; of the one in use where it is left out"),
];

/// Row for a code that sets a heater's target.
pub const TARGET: CodeInfo = target(Code::m(104));
/// Row for a code that sets a heater's target and waits.
pub const TARGET_AND_WAIT: CodeInfo = target_and_wait(Code::m(109));
/// Row for a code that reports temperatures.
pub const TEMPERATURE: CodeInfo =
    CodeInfo::asks(Code::m(105), Function::Report(Report::ReportTemperatures), "say temperatures")
        .waits(Waits::Question)
        .states(EVERYWHERE_BUT_INVALID);
/// Row for a code that sets a switch.
pub const SWITCH: CodeInfo = switch(Code::m(106));
/// Row for a code that arms a rule of `[temperature switch]`.
pub const ARM: CodeInfo = CodeInfo::claimed(Code::m(1001), "arm a rule, as [temperature switch] says")
    .takes(&[word('S', Unit::Number, "0: disarm it")])
    .waits(Waits::Path)
    .states(EVERYWHERE_BUT_INVALID);

pub const ROWS: &[CodeInfo] = &[
    target(Code::m(104)).needed(),
    CodeInfo::asks(Code::m(105), Function::Report(Report::ReportTemperatures), "say temperatures")
        .waits(Waits::Question)
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::claimed(Code::m(106), "switch the fan on, as [switch] says")
        .takes(&[word('S', Unit::Number, "0 to 255")])
        .waits(Waits::Path)
        .states(EVERYWHERE_BUT_INVALID)
        .differs("waits until the moves before it have ended"),
    CodeInfo::claimed(Code::m(107), "switch the fan off, as [switch] says")
        .waits(Waits::Path)
        .states(EVERYWHERE_BUT_INVALID)
        .differs("waits until the moves before it have ended"),
    target_and_wait(Code::m(109)).needed(),
    target(Code::m(140)),
    target_and_wait(Code::m(190)),
    CodeInfo::asks(Code::m(143), Function::Setting(Setting::MaximumTemperature), "the highest temperature of a heater")
        .takes(&[word('S', Unit::Id, "its tool_id"), word('P', Unit::Celsius, "the temperature").bounds(&Above(0.0))])
        .differs("an id that nobody has is ignored"),
    CodeInfo::asks(
        Code::m(123),
        Function::Report(Report::ReportFans),
        "power of each fan, and turns a minute, as [fan] describes them",
    )
    .waits(Waits::Question)
    .states(EVERYWHERE_BUT_INVALID)
    .differs("not known"),
    CodeInfo::asks(Code::m(301), Function::Setting(Setting::PidGains), "the PID gains of a heater")
        .takes(&[
            word('S', Unit::Id, "its tool_id"),
            word('P', Unit::Number, "proportional"),
            word('I', Unit::Number, "integral, per second"),
            word('D', Unit::Number, "derivative, seconds"),
            word('X', Unit::Number, "largest integral"),
            word('Y', Unit::Number, "largest output"),
            word('Z', Unit::Number, "1: proportional on measurement"),
        ])
        .differs("an id that nobody has is ignored"),
    CodeInfo::either(
        Code::m(304),
        printers::by_its_letters,
        Function::Setting(Setting::PidGains),
        "the PID gains of the bed, as M301 without S",
    )
    .takes(&[
        word('P', Unit::Number, "proportional"),
        word('I', Unit::Number, "integral, per second"),
        word('D', Unit::Number, "derivative, seconds"),
    ])
    .differs("not known"),
    CodeInfo::asks(
        Code::m(307),
        Function::Setting(Setting::HeaterModel),
        "the model that a heater is controlled by, from now on",
    )
    .takes(&[
        word('S', Unit::Id, "its tool_id"),
        word('P', Unit::Number, "power at full output, W").bounds(&Above(0.0)),
        word('C', Unit::Number, "heat capacity, J/K").bounds(&Above(0.0)),
        word('K', Unit::Number, "loss to the air, W/K").bounds(&AtLeast(0.0)),
        word('F', Unit::Number, "more with the fan full on, W/K").bounds(&AtLeast(0.0)),
        word('D', Unit::Number, "how late the sensor tells, seconds").bounds(&Above(0.0)),
        word('H', Unit::Number, "what filament takes, J/mm3/K").bounds(&AtLeast(0.0)),
    ])
    .differs("not known"),
    CodeInfo::asks(
        Code::m(305),
        Function::Setting(Setting::Sensor),
        "the thermistor of a heater; without words, say all",
    )
    .takes(&[
        word('S', Unit::Id, "its tool_id; alone: as configured again"),
        word('B', Unit::Number, "beta, kelvin").bounds(&Above(0.0)),
        word('R', Unit::Number, "resistance at X, ohms").bounds(&Above(0.0)),
        word('X', Unit::Celsius, "temperature of R"),
        word('I', Unit::Number, "first coefficient of Steinhart and Hart"),
        word('J', Unit::Number, "second coefficient"),
        word('K', Unit::Number, "third coefficient"),
        word('P', Unit::Number, "number of a sensor that is known by name, with its r1 and r2: see thermistors"),
    ])
    .differs("an id that nobody has is ignored; also while the heater is on"),
    CodeInfo::asks(
        Code::m(303),
        Function::Sequence(Sequence::TunePid),
        "find the PID gains of a heater; without P, say which there are",
    )
    .takes(&[
        word('P', Unit::Id, "its tool_id"),
        word('S', Unit::Celsius, "temperature to swing around, 150 where it is left out"),
        word('C', Unit::Number, "swings, 3 where it is left out").bounds(&Within(3.0, 50.0)),
    ])
    .waits(Waits::Result)
    .differs("finds gains of Ziegler and Nichols, which overshoot, and doubles them"),
    CodeInfo::means(
        Code::m(3),
        spindle::power,
        "spindle on with the S in force, where [switch] says so; laser: constant power",
    )
    .takes(&[word('S', Unit::Number, "speed or power from now on")])
    .group(Group::Spindle)
    .waits(Waits::Path)
    .part(Part::Laser)
    .differs("the S of its own line, else default_on_value; a laser burns without M3"),
    CodeInfo::means(
        Code::m(4),
        spindle::power,
        "spindle on the other way, where [switch] says so; laser: power by the speed",
    )
    .takes(&[word('S', Unit::Number, "speed or power from now on")])
    .group(Group::Spindle)
    .waits(Waits::Path)
    .part(Part::Laser)
    .needed()
    .differs("not known"),
    CodeInfo::means(Code::m(5), spindle::power, "spindle off, where [switch] says so, or laser; S stays for M3")
        .group(Group::Spindle)
        .waits(Waits::Path)
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::asks(
        Code::m(452),
        Function::Standing(Standing::Laser),
        "laser: which S is full power, and whether moves have power; without words, say it",
    )
    .takes(&[
        word('S', Unit::Number, "1: moves have power; 0: S is the power at rest, for a minute at most"),
        word('R', Unit::Number, "the S of full power").bounds(&Within(0.001, 1e6)),
        word('L', Unit::Number, "the S of the least power").bounds(&AtLeast(0.0)),
    ])
    .part(Part::Laser)
    .differs("not known"),
    CodeInfo::means(Code::m(7), spindle::coolant, "mist on, where [switch] says so").waits(Waits::Path),
    CodeInfo::means(Code::m(8), spindle::coolant, "flood on, where [switch] says so").waits(Waits::Path),
    CodeInfo::means(Code::m(9), spindle::coolant, "coolant off, where [switch] says so")
        .waits(Waits::Path)
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::claimed(Code::m(80), "power supply on, where [switch] says so")
        .waits(Waits::Path)
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::claimed(Code::m(81), "power supply off, where [switch] says so")
        .waits(Waits::Path)
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::claimed(Code::m(280), "turn a servo, where [switch] says so")
        .takes(&[
            word('S', Unit::Number, "percent of the time, or an angle where the servo's pulses are described"),
            word('P', Unit::Number, "width of its pulses in us; of printer firmware: which servo, M280.1 for P1"),
        ])
        .waits(Waits::Path),
    CodeInfo::asks(Code::m(115), Function::Report(Report::ReportFirmware), "what firmware this is")
        .waits(Waits::Question)
        .states(ANYWHERE),
];

const WAITS_FOR_MOVES: &str = "waits until the moves before it have ended; more than max_temp is cut in silence";

const fn target(code: Code) -> CodeInfo {
    CodeInfo::claimed(code, "set a heater's target, as [temperature control] says")
        .takes(TARGET_WORDS)
        .waits(Waits::Path)
        .differs(WAITS_FOR_MOVES)
}

const fn target_and_wait(code: Code) -> CodeInfo {
    CodeInfo::claimed(code, "set a heater's target and wait until it is reached")
        .takes(TARGET_AND_WAIT_WORDS)
        .waits(Waits::Result)
        .differs("more than max_temp is cut in silence")
}

const fn switch(code: Code) -> CodeInfo {
    CodeInfo::claimed(code, "switch an output, as [switch] says")
        .takes(const { &[word('S', Unit::Number, "how far")] })
        .waits(Waits::Path)
        .differs("waits until the moves before it have ended")
}
