//! Checks of the arm solution: geometry, and motors that must be alike.

use super::findings::Checks;
use crate::machine::ArmSolution;
use units::Actuator;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let arms = checks.config.motion.arms;
    match checks.config.motion.arm_solution {
        ArmSolution::CoreXy => {
            alike(checks, Actuator::Alpha, Actuator::Beta, "so a corexy draws circles as ellipses");
        }
        ArmSolution::LinearDelta => {
            alike(checks, Actuator::Alpha, Actuator::Beta, "so a delta draws nothing straight");
            alike(checks, Actuator::Alpha, Actuator::Gamma, "so a delta draws nothing straight");
            let delta = arms.linear_delta;
            let shortest = delta.arm_offset.into_iter().fold(delta.arm_length, |least, offset| {
                if delta.arm_length + offset < least { delta.arm_length + offset } else { least }
            });
            if shortest <= delta.arm_radius {
                let reason = format_args!("rods of {shortest} mm cannot span {} mm", delta.arm_radius);
                checks.error(("linear delta", 0, "arm_length"), reason, format_args!("it is longer than arm_radius"));
            }
        }
        ArmSolution::Generic => generic(checks, &arms.generic),
        ArmSolution::Winch => winch(checks, &arms.anchors),
        _ => {}
    }
}

fn alike(checks: &mut Checks<'_, '_>, first: Actuator, second: Actuator, consequence: &str) {
    let (a, b) = (&checks.config.actuators[first], &checks.config.actuators[second]);
    if a.present && b.present && a.steps_per_mm != b.steps_per_mm {
        let reason = format_args!("{} and {} have different steps_per_mm, {consequence}", first.name(), second.name());
        checks.warn(("actuator", second as usize, "steps_per_mm"), reason, format_args!("write the same for both"));
    }
}

fn generic(checks: &mut Checks<'_, '_>, rows: &[[f64; 3]; 3]) {
    let [[a, b, c], [d, e, f], [g, h, i]] = *rows;
    let determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
    let gamma_is_fitted = checks.config.actuators[Actuator::Gamma].present;
    if gamma_is_fitted && (-1e-6..=1e-6).contains(&determinant) {
        checks.error(
            ("motion control", 0, "arm_solution"),
            format_args!("the rows of [generic cartesian] do not tell X, Y and Z apart"),
            format_args!("write alpha, beta and gamma so that none follows from the others"),
        );
    }
}

fn winch(checks: &mut Checks<'_, '_>, anchors: &[Option<[f64; 3]>; units::MAX_ACTUATORS]) {
    let count = anchors.iter().take_while(|anchor| anchor.is_some()).count();
    if count < 3 || anchors.iter().skip(count).any(Option::is_some) {
        checks.error(
            ("motion control", 0, "arm_solution"),
            format_args!("[winch] needs the places of three winches at least, without a gap"),
            format_args!("write alpha, beta and gamma as X,Y,Z"),
        );
    }
}
