//! Instances that nothing enables: settings under a name that was probably meant to be another.

use super::findings::Checks;
use crate::diagnostic::Severity;
use crate::ledger::Path;
use crate::report::At;
use crate::schema::{Fallback, SECTIONS};
use crate::suggest;
use crate::text::nearest;

/// Instances of a section at most.
const MOST: usize = 32;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    for section in SECTIONS.iter().filter(|section| suggest::is_supported(section)) {
        let Some(instances) = section.instances() else { continue };
        let name = |place| (instances.name)(checks.config, place);
        for place in (0..MOST).take_while(|place| !name(*place).is_empty()) {
            let Some(path) = Path::named(section.name, place, "enable") else { break };
            let is_said = checks.ledger.span(path).is_some() || checks.ledger.is_unreadable(path);
            let is_enabled_anyway = path.setting().is_some_and(|setting| setting.fallback() == Fallback::Value("true"));
            if is_said || is_enabled_anyway || checks.ledger.first_of(path.section, path.place).is_none() {
                continue;
            }
            let others = (0..MOST).filter(|other| *other != place).map(name).filter(|other| !other.is_empty());
            let (own, key) = (name(place), path.text(checks.config));
            let at = At::new(checks.ledger.place(path, checks.config), &key, path.module(checks.config));
            let reason = format_args!("{} '{own}' is not enabled, so its lines do nothing", instances.noun);
            match nearest(own, others) {
                Some(other) => {
                    let fix = format_args!("did you mean {other}? else write {own}.enable = true or false");
                    checks.reporter.report(Severity::Warning, at, reason, fix);
                }
                None => {
                    let fix = format_args!("write {own}.enable = true, or false");
                    checks.reporter.report(Severity::Warning, at, reason, fix);
                }
            }
        }
    }
}
