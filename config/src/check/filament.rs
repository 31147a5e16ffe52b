//! Checks of the filament detector, the width sensor, and the moves of M600.

use super::findings::Checks;
use units::Mm;

const DETECTOR: &str = "filament detector";
const WIDTH: &str = "filament width sensor";
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
    width(checks);
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

/// Checks of the section `[filament width sensor]`.
fn width(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let sensor = &config.filament_width;
    if !sensor.enable {
        return;
    }
    if sensor.inputs[0].is_none() {
        let reason = format_args!("the filament width sensor has no input");
        checks.error((WIDTH, 0, "adc_pin"), reason, format_args!("write adc_pin, ADC1_4 to ADC1_6 on the header"));
    }
    if !config.extruders.iter().any(|extruder| extruder.tool.id == sensor.tool) {
        let reason = format_args!("there is no extruder with tool_id {}", sensor.tool.0);
        checks.error((WIDTH, 0, "tool_id"), reason, format_args!("write that of the extruder it measures for"));
    }
    let [one, other] = sensor.gauges;
    let is_flat = one.raw == other.raw || one.diameter == other.diameter;
    if sensor.mm_per_volt == 0.0 && is_flat {
        let reason = format_args!("the two gauges are the same: they say nothing of other diameters");
        checks.error((WIDTH, 0, "second_raw"), reason, format_args!("measure two gauges that differ, with M407.1"));
    }
    if sensor.mm_per_volt > 0.0 && sensor.inputs[1].is_some() {
        let reason = format_args!("with mm_per_volt there is one input");
        checks.error((WIDTH, 0, "second_adc_pin"), reason, format_args!("delete it, or calibrate with gauges"));
    }
    if sensor.delay <= Mm(0.0) {
        let reason = format_args!("where the sensor is must be known: how much filament is between it and the nozzle");
        checks.error((WIDTH, 0, "measurement_delay"), reason, format_args!("write measurement_delay, in mm"));
    }
    let (min, nominal, max) = (sensor.min_diameter, sensor.nominal, sensor.max_diameter);
    if min >= nominal {
        let reason = format_args!("filament of the nominal diameter, {} mm, would have run out", nominal.0);
        checks.error((WIDTH, 0, "min_diameter"), reason, format_args!("write less than nominal_diameter"));
    }
    if max > Mm(0.0) && max <= nominal {
        let reason = format_args!("filament of the nominal diameter, {} mm, would be too thick", nominal.0);
        checks.error((WIDTH, 0, "max_diameter"), reason, format_args!("write more than nominal_diameter, or 0"));
    }
}
