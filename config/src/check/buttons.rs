//! Checks of the section `[button box]`.

use super::findings::Checks;
use crate::machine::{ButtonConfig, ButtonWord};

const SECTION: &str = "button box";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, button) in config.buttons.iter().enumerate().filter(|(_, button)| button.enable) {
        one(checks, place, button);
    }
}

fn one(checks: &mut Checks<'_, '_>, place: usize, button: &ButtonConfig) {
    if button.is_external {
        let reason = format_args!("panels are not supported yet, so the button does nothing");
        return checks.warn((SECTION, place, "pin"), reason, format_args!("write its pin, or enable = false"));
    }
    if button.pin.is_none() {
        let reason = format_args!("the button has no pin");
        checks.error((SECTION, place, "pin"), reason, format_args!("write its pin, or enable = false"));
    }
    let lines = [&button.press, &button.release, &button.long_press];
    if lines.iter().all(|line| line.is_empty()) {
        let reason = format_args!("the button does nothing");
        checks.error((SECTION, place, "press"), reason, format_args!("write the line it sends"));
    }
    if !button.long_press.is_empty() && ButtonWord::of(&button.press) == Some(ButtonWord::Kill) {
        let reason = format_args!("KILL would wait until the button is let go");
        checks.error(
            (SECTION, place, "long_press"),
            reason,
            format_args!("delete it: a button that halts does only that"),
        );
    }
}
