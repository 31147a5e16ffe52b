//! Jobs, files on the card, saved settings.

use gcode::Code;

use super::row::{ANYWHERE, CodeInfo, EVERYWHERE_BUT_INVALID, FILES, Waits};
use crate::action::Function;
use crate::fault::Part;
use crate::meaning::program;

pub const ROWS: &[CodeInfo] = &[
    CodeInfo::either(Code::m(20), program::list_files, Function::ListFiles, "list the card").states(FILES),
    CodeInfo::asks(Code::m(21), Function::Mount, "look for the card").states(FILES),
    CodeInfo::asks(Code::m(23), Function::SelectFile, "select a file to play").part(Part::Player),
    CodeInfo::asks(Code::m(24), Function::StartJob, "play the selected file, or go on with it").part(Part::Player),
    CodeInfo::asks(Code::m(25), Function::PauseJob, "pause the file; what is queued still runs"),
    CodeInfo::asks(Code::m(26), Function::RestartJob, "play the file from its beginning"),
    CodeInfo::asks(Code::m(27), Function::ReportJob, "how far the file is").waits(Waits::Question),
    CodeInfo::asks(
        Code::m(28),
        Function::Upload,
        "store the lines that follow in a file, up to M29; discard them when it cannot be opened",
    )
    .states(FILES)
    .differs("when the file cannot be opened, what follows is carried out"),
    CodeInfo::asks(Code::m(29), Function::EndUpload, "the file is complete").states(FILES),
    CodeInfo::either(
        Code::m(30),
        program::m30,
        Function::RemoveFile,
        "remove a file; without a name, and in GRBL's dialect, end of program",
    )
    .states(ANYWHERE),
    CodeInfo::asks(Code::m(32), Function::StartFile, "select a file and play it").part(Part::Player),
    CodeInfo::asks(Code::m(500), Function::SaveSettings, "save what was set at run time, to /sd/config-override")
        .any_subcode()
        .states(EVERYWHERE_BUT_INVALID)
        .differs("written in place"),
    CodeInfo::asks(Code::m(501), Function::LoadSettings, "replay saved settings; a name selects a set")
        .any_subcode()
        .differs("also while halted"),
    CodeInfo::asks(Code::m(502), Function::ForgetSettings, "delete the saved settings")
        .any_subcode()
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::asks(Code::m(503), Function::ShowSettings, "show what M500 would save")
        .any_subcode()
        .states(EVERYWHERE_BUT_INVALID),
    CodeInfo::asks(Code::m(504), Function::SaveSettings, "save a set of settings under a name"),
    CodeInfo::means(Code::m(600), program::suspend, "suspend the job: pause, heaters off, after_suspend_gcode")
        .waits(Waits::Result)
        .part(Part::Player),
    CodeInfo::means(Code::m(600).sub(1), program::suspend, "suspend the job; heaters stay on")
        .waits(Waits::Result)
        .part(Part::Player),
    CodeInfo::means(
        Code::m(601),
        program::resume,
        "resume the job: heat up, before_resume_gcode, back to where it was",
    )
    .waits(Waits::Result)
    .part(Part::Player),
];
