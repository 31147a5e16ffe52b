//! Codes of jobs, files on the card and saved settings.

use gcode::Code;

use super::row::{ANYWHERE, CodeInfo, EVERYWHERE_BUT_INVALID, FILES, Waits};
use crate::fault::Part;
use crate::function::{FileFunction, Function, Report, Sequence};
use crate::meaning::program;
use crate::word::Bounds::{AtLeast, Within};
use crate::word::{Unit, WordInfo, word};

/// Words of M600 for this change of filament, as in Marlin; the rest is as `[filament change]` says.
const CHANGE: [WordInfo; 9] = [
    word('E', Unit::Mm, "drawn back first"),
    word('Z', Unit::Mm, "the tool rises by this").bounds(&AtLeast(0.0)),
    word('X', Unit::Mm, "where it waits, machine X"),
    word('Y', Unit::Mm, "where it waits, machine Y"),
    word('U', Unit::Mm, "taken out"),
    word('L', Unit::Mm, "pushed in"),
    word('R', Unit::Celsius, "the hot end goes on with this").bounds(&AtLeast(0.0)),
    word('T', Unit::Number, "the tool, which has to be the one in use").bounds(&AtLeast(0.0)),
    word('B', Unit::Number, "beeps; there are none"),
];

const NOT_KNOWN: &str = "not known";
const POWER_LOSS: &[WordInfo] = &[word('S', Unit::Flag, "1: on, 0: off; without it says which")];
const GO_ON: &str = "go on with a job that was interrupted; see docs/power-loss.md";
const GO_ON_WORDS: &[WordInfo] = &[
    word('C', Unit::Flag, "forget it instead"),
    word('S', Unit::Flag, "say what there is, and what would be done"),
    word('Z', Unit::Length, "where the tool stands, where that is not known"),
];

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::either(Code::m(20), program::list_files, Function::File(FileFunction::ListFiles), "list the card")
        .states(FILES),
    CodeInfo::asks(Code::m(21), Function::File(FileFunction::Mount), "look for the card").states(FILES),
    CodeInfo::asks(Code::m(23), Function::File(FileFunction::SelectFile), "select a file to play").part(Part::Player),
    CodeInfo::asks(Code::m(24), Function::File(FileFunction::StartJob), "play the selected file, or go on with it")
        .part(Part::Player),
    CodeInfo::asks(Code::m(25), Function::File(FileFunction::PauseJob), "pause the file; what is queued still runs"),
    CodeInfo::asks(Code::m(26), Function::File(FileFunction::RestartJob), "play the file from its beginning")
        .takes(&[word('S', Unit::Number, "from this byte: 0 alone; see play --from").bounds(&AtLeast(0.0))]),
    CodeInfo::asks(Code::m(27), Function::File(FileFunction::ReportJob), "how far the file is")
        .takes(&[word('S', Unit::Seconds, "say so by itself, every so often; 0: no more").bounds(&Within(0.0, 60.0))])
        .waits(Waits::Question),
    CodeInfo::asks(
        Code::m(28),
        Function::File(FileFunction::Upload),
        "store the lines that follow in a file, up to M29; discard them when it cannot be opened",
    )
    .states(FILES)
    .differs("when the file cannot be opened, what follows is carried out"),
    CodeInfo::asks(Code::m(29), Function::File(FileFunction::EndUpload), "the file is complete").states(FILES),
    CodeInfo::either(
        Code::m(30),
        program::m30,
        Function::File(FileFunction::RemoveFile),
        "remove a file; without a name, and in GRBL's dialect, end of program",
    )
    .states(ANYWHERE),
    CodeInfo::asks(Code::m(32), Function::File(FileFunction::StartFile), "select a file and play it")
        .part(Part::Player),
    CodeInfo::asks(
        Code::m(413),
        Function::File(FileFunction::PowerLoss),
        "keep a journal of jobs, to go on after a power cut",
    )
    .takes(POWER_LOSS)
    .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(524), Function::Sequence(Sequence::AbortJob), "end the job, as abort")
        .waits(Waits::Standstill)
        .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(1000), Function::Sequence(Sequence::GoOnWithJob), GO_ON)
        .takes(GO_ON_WORDS)
        .waits(Waits::Result)
        .differs(NOT_KNOWN),
    CodeInfo::asks(Code::m(916), Function::Sequence(Sequence::GoOnWithJob), GO_ON)
        .takes(GO_ON_WORDS)
        .waits(Waits::Result)
        .differs(NOT_KNOWN),
    CodeInfo::asks(
        Code::m(500),
        Function::Sequence(Sequence::SaveSettings),
        "save what was set at run time, to /sd/config-override",
    )
    .any_subcode()
    .states(EVERYWHERE_BUT_INVALID)
    .differs("written in place"),
    CodeInfo::asks(
        Code::m(501),
        Function::File(FileFunction::LoadSettings),
        "replay saved settings; a name selects a set",
    )
    .any_subcode()
    .differs("while halted drops most lines, and says that it has loaded"),
    CodeInfo::asks(Code::m(502), Function::File(FileFunction::ForgetSettings), "delete the saved settings")
        .any_subcode()
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::asks(Code::m(503), Function::Report(Report::ShowSettings), "show what M500 would save")
        .any_subcode()
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::asks(Code::m(504), Function::Sequence(Sequence::SaveSettings), "save a set of settings under a name"),
    CodeInfo::means(Code::m(600), program::suspend, "suspend the job: pause, heaters off, after_suspend_gcode")
        .takes(&CHANGE)
        .waits(Waits::Result)
        .part(Part::Player),
    CodeInfo::means(Code::m(600).sub(1), program::suspend, "suspend the job; heaters stay on")
        .takes(&CHANGE)
        .waits(Waits::Result)
        .part(Part::Player),
    resume(601),
    resume(602).differs(NOT_KNOWN),
];

const fn resume(number: u16) -> CodeInfo {
    const HELP: &str = "resume the job: heat up, before_resume_gcode, back to where it was";
    CodeInfo::means(Code::m(number), program::resume, HELP).waits(Waits::Result).part(Part::Player)
}
