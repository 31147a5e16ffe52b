//! Checks of the ends of travel.

use super::findings::Checks;
use units::Axis;

const SECTION: &str = "soft endstop";
const KEYS: [(&str, &str); 3] = [("x_min", "x_max"), ("y_min", "y_max"), ("z_min", "z_max")];

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let (ends, homing) = (checks.config.soft_endstops, &checks.config.homing);
    // A tower's switch is no place of an axis.
    let homes_by_axis = !(homing.delta || homing.rotary_delta || homing.scara);
    let ends = ends.least.into_iter().zip(ends.most);
    for ((axis, (min, max)), (least, most)) in Axis::PRIMARY.into_iter().zip(KEYS).zip(ends) {
        let letter = axis.letter();
        if let (Some(least), Some(most)) = (least, most)
            && least >= most
        {
            let reason = format_args!("the travel of {letter} ends at {most}, before it begins at {least}");
            checks.error((SECTION, 0, max), reason, format_args!("write {max} above {min}"));
            continue;
        }
        let home = checks.config.homing_endstop(axis).map(|stop| stop.homing_position).filter(|_| homes_by_axis);
        let Some(home) = home else { continue };
        for (key, is_beyond) in [(min, least.is_some_and(|end| home < end)), (max, most.is_some_and(|end| home > end))]
        {
            if is_beyond {
                let reason = format_args!("{letter} homes at {home}, out of its travel");
                let fix = format_args!("include it, or make sure that it is meant: ways back in are free");
                checks.warn((SECTION, 0, key), reason, fix);
            }
        }
    }
}
