//! The two points that lie at given distances from three others: the forward kinematics of rods and ropes.

use crate::square_root;

type Vector = [f64; 3];

fn minus(a: Vector, b: Vector) -> Vector {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ax - bx, ay - by, az - bz]
}

fn dot(a: Vector, b: Vector) -> f64 {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    ax * bx + ay * by + az * bz
}

fn cross(a: Vector, b: Vector) -> Vector {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// Returns the two points where three spheres meet: the lower point first, then the upper one. Spheres that
/// do not meet are taken to touch in the plane of their centres.
///
/// With one centre as origin, u and v to the others and n = u x v, a point is `a u + b v + c n`. The products
/// of the point with u and v follow from the radii (that is what subtracting two sphere equations says),
/// which gives a and b; the first radius gives c.
pub fn meet(centres: [Vector; 3], radii: [f64; 3]) -> [Vector; 2] {
    let ([first, second, third], [r, s, t]) = (centres, radii);
    let (u, v) = (minus(second, first), minus(third, first));
    let n = cross(u, v);
    let (uu, uv, vv, nn) = (dot(u, u), dot(u, v), dot(v, v), dot(n, n));
    let (along_u, along_v) = (0.5 * (r * r - s * s + uu), 0.5 * (r * r - t * t + vv));
    let (a, b) = ((along_u * vv - along_v * uv) / nn, (along_v * uu - along_u * uv) / nn);
    let ([ux, uy, uz], [vx, vy, vz], [nx, ny, nz], [x, y, z]) = (u, v, n, first);
    let foot = [a * ux + b * vx, a * uy + b * vy, a * uz + b * vz];
    let height_sq = crate::greatest(r * r - dot(foot, foot), 0.0);
    let size = square_root(height_sq / nn);
    let c = if nz > 0.0 { -size } else { size };
    let [fx, fy, fz] = foot;
    let point = |c: f64| [x + fx + c * nx, y + fy + c * ny, z + fz + c * nz];
    [point(c), point(-c)]
}
