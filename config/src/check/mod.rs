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
mod findings;
mod heat;
mod homing;
mod laser;
mod led_strips;
mod leveling;
mod motors;
mod names;
mod network;
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

use crate::ledger::Ledger;
use crate::machine::MachineConfig;
use crate::report::{At, Reporter};
use crate::setting::Support;
use findings::Checks;

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
    network::check(&mut checks);
    outputs::check(&mut checks);
    temperature_switches::check(&mut checks);
    fans::check(&mut checks);
    led_strips::check(&mut checks);
    laser::check(&mut checks);
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
            checks.reporter.not_supported(severity, at, advice);
        }
    }
}
