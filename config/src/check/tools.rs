//! Checks of tools and extruders.

use super::findings::Checks;

const EXTRUDER: &str = "extruder";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (place, extruder) in config.extruders.iter().enumerate().filter(|(_, extruder)| extruder.enable) {
        let motor = extruder.actuator().map(|actuator| (actuator, &config.actuators[actuator]));
        match motor {
            Some((actuator, motor)) if !motor.present => {
                let reason =
                    format_args!("tool {} turns motor {}, which is not there", extruder.tool.id, actuator.name());
                checks.error(
                    (EXTRUDER, place, "tool_id"),
                    reason,
                    format_args!("describe [actuator] {}", actuator.name()),
                );
            }
            Some((actuator, motor)) if motor.slaved_to.is_some() => {
                let reason =
                    format_args!("tool {} turns motor {}, which is a slave", extruder.tool.id, actuator.name());
                checks.error((EXTRUDER, place, "tool_id"), reason, format_args!("use a motor of its own"));
            }
            _ => {}
        }
        let mut earlier = config.extruders.iter().enumerate().take(place);
        if let Some((twin, other)) = earlier.find(|(_, other)| other.enable && other.tool.id == extruder.tool.id) {
            let reason = format_args!("'{}' has tool_id {} as well", other.name, extruder.tool.id);
            let fix = format_args!("give each its own, 0 to 2");
            checks.error_of_both((EXTRUDER, place, "tool_id"), twin, reason, fix);
        }
    }
}
