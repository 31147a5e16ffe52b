//! The filament detector, and what M600 moves.

use super::Checks;
use units::Mm;

const DETECTOR: &str = "filament detector";
const CHANGE: &str = "filament change";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let detector = &config.filament_detector;
    if detector.enable {
        if detector.level_pin().is_none() && detector.wheel_pin().is_none() {
            let reason = format_args!("the filament detector has no input");
            checks.error((DETECTOR, 0, "enable"), reason, format_args!("write encoder_pin, bulge_pin or detector_pin"));
        }
        if detector.bulge_pin.is_some() && detector.detector_pin.is_some() {
            let reason = format_args!("detector_pin is not looked at beside bulge_pin");
            let fix = format_args!("delete one of them; an input switch with M600 as its command can watch the other");
            checks.warn((DETECTOR, 0, "detector_pin"), reason, fix);
        }
        if config.extruders.is_empty() {
            let reason = format_args!("there is no extruder whose filament could run out");
            checks.error((DETECTOR, 0, "enable"), reason, format_args!("delete it, or describe the extruder"));
        }
    }
    let change = &config.filament_change;
    for (key, length) in [
        ("retract", change.retract),
        ("unload_length", change.unload),
        ("load_length", change.load),
        ("purge_length", change.purge),
    ] {
        if length > Mm(0.0) && config.extruders.is_empty() {
            let reason = format_args!("there is no extruder that could move filament");
            checks.error((CHANGE, 0, key), reason, format_args!("delete it, or describe the extruder"));
        }
    }
}
