//! Checks that need the whole file: missing settings, contradictions, two owners of one pin.
//!
//! Each check names the setting to change, and stands at the line that wrote it when the file did.

mod alignment;
mod arms;
mod buttons;
mod combined_sensors;
mod endstop_phase;
mod fans;
mod filament;
mod heat;
mod homing;
mod led_strips;
mod leveling;
mod motors;
mod names;
mod on_stall;
mod outputs;
mod pins;
mod planner;
mod scripts;
mod shapers;
mod soft_endstops;
mod spi_sensors;
mod stall_homing;
mod stealth_drivers;
mod temperature_switches;
mod tools;
mod uart;
mod update;

pub(crate) use stall_homing::GOOD_FULL_STEPS_PER_S;

use crate::diagnostic::Severity;
use crate::ledger::{Ledger, Path};
use crate::machine::MachineConfig;
use crate::report::{At, Reporter};
use crate::schema::Support;
use core::fmt;

/// Checks the whole, and lowers what is too high where Smoothieware does so.
pub(crate) fn check(config: &mut MachineConfig, ledger: &Ledger, reporter: &mut Reporter<'_>) {
    motors::limit(config, ledger, reporter);
    let mut checks = Checks { config, ledger, reporter };
    wishes(&mut checks);
    names::check(&mut checks);
    planner::check(&mut checks);
    shapers::check(&mut checks);
    motors::check(&mut checks);
    homing::check(&mut checks);
    endstop_phase::check(&mut checks);
    stall_homing::check(&mut checks);
    on_stall::check(&mut checks);
    soft_endstops::check(&mut checks);
    leveling::check(&mut checks);
    alignment::check(&mut checks);
    heat::check(&mut checks);
    combined_sensors::check(&mut checks);
    spi_sensors::check(&mut checks);
    filament::check(&mut checks);
    tools::check(&mut checks);
    scripts::check(&mut checks);
    uart::check(&mut checks);
    update::check(&mut checks);
    outputs::check(&mut checks);
    temperature_switches::check(&mut checks);
    fans::check(&mut checks);
    led_strips::check(&mut checks);
    buttons::check(&mut checks);
    pins::check(&mut checks);
}

/// Refuses what Velvet cannot do yet, where its function is not disabled.
fn wishes(checks: &mut Checks<'_, '_>) {
    for &(path, span) in checks.ledger.wishes() {
        let Some(&Support::NotYet { severity, advice }) = path.setting().map(|setting| setting.support) else {
            continue;
        };
        if pins::is_in_use(checks, path) {
            let key = path.text(checks.config);
            let at = At::new(span, &key, path.module(checks.config));
            not_supported(checks.reporter, severity, at, advice);
        }
    }
}

/// The finding about a setting that Velvet cannot act on yet.
pub(crate) fn not_supported(reporter: &mut Reporter<'_>, severity: Severity, at: At<'_>, advice: &str) {
    reporter.report(severity, at, format_args!("not supported yet"), format_args!("{advice}"));
}

/// Data that the checks read, and the output for their findings.
pub(crate) struct Checks<'a, 'r> {
    pub(crate) config: &'a MachineConfig,
    pub(crate) ledger: &'a Ledger,
    pub(crate) reporter: &'a mut Reporter<'r>,
}

impl Checks<'_, '_> {
    /// An error about a setting: what it belongs to stays off.
    fn error(&mut self, setting: Named<'_>, reason: fmt::Arguments<'_>, fix: fmt::Arguments<'_>) {
        report(self.config, self.ledger, self.reporter, Severity::Error, setting, reason, fix);
    }

    /// An error about two instances of a section: nobody can tell which of them is wrong.
    fn error_of_both(&mut self, setting: Named<'_>, other: usize, reason: fmt::Arguments<'_>, fix: fmt::Arguments<'_>) {
        let (section, place, key) = setting;
        let (Some(path), Some(other)) = (Path::named(section, place, key), Path::named(section, other, key)) else {
            return;
        };
        if self.ledger.is_unreadable(path) || self.ledger.is_unreadable(other) {
            return;
        }
        let span = self.ledger.place(path, self.config);
        let text = path.text(self.config);
        let at = At::new(span, &text, path.module(self.config)).and(other.module(self.config));
        self.reporter.report(Severity::Error, at, reason, fix);
    }

    /// Whether the setting's line could not be understood, which has been said.
    fn is_unreadable(&self, (section, place, key): Named<'_>) -> bool {
        Path::named(section, place, key).is_some_and(|path| self.ledger.is_unreadable(path))
    }

    /// A warning about a setting.
    fn warn(&mut self, setting: Named<'_>, reason: fmt::Arguments<'_>, fix: fmt::Arguments<'_>) {
        report(self.config, self.ledger, self.reporter, Severity::Warning, setting, reason, fix);
    }
}

/// A setting by section, place of its instance, and key.
pub(crate) type Named<'a> = (&'a str, usize, &'a str);

fn report(
    config: &MachineConfig,
    ledger: &Ledger,
    reporter: &mut Reporter<'_>,
    severity: Severity,
    (section, place, key): Named<'_>,
    reason: fmt::Arguments<'_>,
    fix: fmt::Arguments<'_>,
) {
    let Some(path) = Path::named(section, place, key) else {
        debug_assert!(false, "the schema has no [{section}] {key}");
        return;
    };
    if ledger.is_unreadable(path) || (severity == Severity::Warning && ledger.is_doubted(path)) {
        return;
    }
    let span = ledger.place(path, config);
    reporter.report(severity, At::new(span, &path.text(config), path.module(config)), reason, fix);
}
