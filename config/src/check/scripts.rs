//! Checks of scripts: lines of codes that run at events. An unreadable script is found before its event.

use gcode::Blocks;

use super::findings::Checks;
use crate::machine::Command;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let player = &config.player;
    for (section, key, script) in [
        ("player", "after_suspend_gcode", &player.after_suspend_gcode),
        ("player", "before_resume_gcode", &player.before_resume_gcode),
        ("player", "before_job_gcode", &player.before_job_gcode),
        ("player", "after_job_gcode", &player.after_job_gcode),
        ("player", "after_abort_gcode", &player.after_abort_gcode),
        ("tool change", "before_gcode", &config.tool_change.before_gcode),
        ("tool change", "after_gcode", &config.tool_change.after_gcode),
    ] {
        one(checks, section, key, script);
    }
}

fn one(checks: &mut Checks<'_, '_>, section: &str, key: &str, script: &Command) {
    let mut blocks = script.split('|').flat_map(|line| Blocks::new(line.as_bytes()));
    if let Some(Err(error)) = blocks.find(Result::is_err) {
        let reason = format_args!("`{script}` cannot be read: {error}");
        checks.warn((section, 0, key), reason, format_args!("write codes, with _ for blanks and | between lines"));
    }
}
