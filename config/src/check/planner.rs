//! Look-ahead settings that exclude each other.

use super::findings::Checks;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let planner = checks.config.planner;
    let has_jerk = planner.jerk.is_some() || planner.axis_jerk.iter().any(Option::is_some);
    if has_jerk && planner.minimum_cruise_ratio > 0.0 {
        checks.error(
            ("planner", 0, "minimum_cruise_ratio"),
            format_args!("it is for trapezoids, and a jerk makes S-curves of them"),
            format_args!("leave it out, or set every jerk to 0"),
        );
    }
}
