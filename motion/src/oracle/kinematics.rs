//! Motor positions of every kind of kinematics, from the drawing: lengths, circles and angles, with the
//! standard library's functions.

use units::Actuator;

use crate::kinematics::{Kinematics, Morgan, RotaryDelta};

/// Position of a motor in mm (degrees) with the tool at `axes`.
pub fn motor(kinematics: &Kinematics, actuator: Actuator, axes: &[f64; 6]) -> f64 {
    let [x, y, z, ..] = *axes;
    let index = actuator as usize;
    if let Kinematics::Winch(ropes) = kinematics
        && let Some([ax, ay, az]) = ropes.anchors().get(index)
    {
        return (x - ax).hypot(y - ay).hypot(z - az);
    }
    if index >= 3 {
        return axes[index];
    }
    let three = match kinematics {
        Kinematics::CoreXy => [x + y, x - y, z],
        Kinematics::CoreXz(gear) => [gear.x * x + gear.z * z, gear.x * x - gear.z * z, y],
        Kinematics::HybridCoreXy => [x - y, y, z],
        Kinematics::HybridCoreXz => [x - z, y, z],
        Kinematics::Lathe => [x, z, 0.0],
        Kinematics::Generic(map) => map.rows().map(|[a, b, c]| a * x + b * y + c * z),
        Kinematics::LinearDelta(delta) => {
            let shape = delta.geometry();
            let nominal: f64 = [210.0, 330.0, 90.0][index];
            let (sine, cosine) = (nominal + shape.tower_angle[index]).to_radians().sin_cos();
            let radius = shape.arm_radius + shape.tower_offset[index];
            let flat = (x - radius * cosine).hypot(y - radius * sine);
            return z + ((shape.arm_length + shape.arm_offset[index]).powi(2) - flat.powi(2)).sqrt();
        }
        Kinematics::RotaryDelta(delta) => return shoulder(delta, index, [x, y, z]),
        Kinematics::Morgan(arm) => scara(arm, [x, y, z]),
        Kinematics::Deltesian(towers) => {
            let rise = |arm: f64, tower: f64| z + (arm.powi(2) - (x - tower).powi(2)).sqrt();
            let ([l, r], [left, right]) = (towers.arm_length, towers.arm_x_length);
            [rise(l, -left), rise(r, right), y]
        }
        Kinematics::Polar => [x.hypot(y), y.atan2(x).to_degrees(), z],
        _ => [x, y, z],
    };
    three[index]
}

/// The elbow is where the upper arm's circle meets the rod's, in the plane of the arm; the outer of the two
/// places.
fn shoulder(delta: &RotaryDelta, index: usize, [x, y, z]: [f64; 3]) -> f64 {
    let mirror = if delta.mirror_xy { -1.0 } else { 1.0 };
    let (x, y) = (mirror * x, mirror * y);
    let z = z - (delta.z_offset - delta.tool_offset - delta.effector_offset);
    // Turned so that the arm points to -Y.
    let (sine, cosine) = (120.0 * index as f64).to_radians().sin_cos();
    let (x, y) = (x * cosine + y * sine, y * cosine - x * sine);
    let inradius = |side: f64| side / (2.0 * 3.0_f64.sqrt());
    let (shoulder_y, joint_y) = (-inradius(delta.base), y - inradius(delta.effector));
    // Two circles around (shoulder_y, 0) and (joint_y, z).
    let (r, s_sq) = (delta.arm, delta.rod.powi(2) - x * x);
    let (dy, dz) = (joint_y - shoulder_y, z);
    let span = dy.hypot(dz);
    let along = (r * r - s_sq + span * span) / (2.0 * span);
    let sideways = (r * r - along * along).sqrt();
    let both = [1.0, -1.0].map(|side: f64| {
        let (ey, ez) = ((along * dy + side * sideways * dz) / span, (along * dz - side * sideways * dy) / span);
        (ey, (-ez).atan2(-ey).to_degrees())
    });
    // The elbow points outwards, to -Y.
    if both[0].0 < both[1].0 { both[0].1 } else { both[1].1 }
}

/// SCARA angles by the law of cosines.
fn scara(arm: &Morgan, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (x, y) = (x * arm.scaling[0] - arm.tower[0], y * arm.scaling[1] - arm.tower[1]);
    let r = x.hypot(y);
    let at_tower = ((arm.arm1.powi(2) + r * r - arm.arm2.powi(2)) / (2.0 * arm.arm1 * r)).acos();
    let inner = y.atan2(x) - at_tower;
    let (ex, ey) = (arm.arm1 * inner.cos(), arm.arm1 * inner.sin());
    let outer = (y - ey).atan2(x - ex);
    [inner.to_degrees(), outer.to_degrees(), z]
}
