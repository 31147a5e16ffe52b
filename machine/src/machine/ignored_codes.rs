//! Codes of a file that are not carried out.

use base::failure::{Answer, Outcome, Texts};
use base::needs::{cannot_level, makes_another_part};
use base::sessions::{Recipient, Sessions};
use config::MachineConfig;
use gcode::Block;
use jobs::player::{Jobs, Name};
use program::{CodeInfo, Dialect, Interpreter};

/// Handles a code of a file that is not carried out: pauses the file if it would make another part, else
/// counts the code.
#[cold]
pub(crate) fn settle(
    texts: &Texts,
    jobs: &mut Jobs,
    program: &Interpreter,
    block: &Block<'_>,
    dialect: Dialect,
) -> Outcome {
    let Some(code) = block.code else { return Ok(Answer::Unknown) };
    let row = program.row(block, dialect);
    if let Some(failure) = makes_another_part(texts, row, block) {
        return Err(failure);
    }
    count(jobs, Name::Code(code));
    Ok(if row.is_some() { Answer::PassedOver } else { Answer::Unknown })
}

/// Decides whether the job goes on after a code that levels the bed, which this machine cannot.
#[cold]
pub(crate) fn goes_on_unleveled(config: &MachineConfig, jobs: &mut Jobs, row: &CodeInfo) -> bool {
    let goes_on = !config.player.unleveled_pauses && cannot_level(config, row);
    if goes_on {
        count(jobs, Name::Code(row.code));
    }
    goes_on
}

/// Counts a code or a word of the job that was left out; the counts are said when the job ends.
pub(crate) fn count(jobs: &mut Jobs, name: Name) {
    if let Some(noted) = jobs.noted() {
        noted.passed_over.count(name);
    }
}

/// Tells once which codes of the job were not carried out.
pub(crate) fn say(jobs: &mut Jobs, sessions: &mut Sessions) {
    if let Some(noted) = jobs.noted().filter(|noted| !noted.passed_over.is_empty()) {
        sessions.say(Recipient::All, format_args!("// NOTE not carried out: {}\n", noted.passed_over));
    }
}
