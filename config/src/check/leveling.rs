//! Checks of leveling and skew correction.

use super::findings::Checks;
use crate::machine::Leveling;

/// The least distance of two points of a grid, mm.
const LEAST_DISTANCE: f64 = 1.0;
/// The greatest skew factor.
const MOST_SKEW: f64 = 0.1;

const CARTESIAN: &str = "cartesian grid leveling strategy";
const MESH: &str = "bed mesh";
const SKEW: &str = "skew correction";

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let leveling = &checks.config.leveling;
    mesh(checks);
    if leveling.strategy == Some(Leveling::CartesianGrid) && !leveling.grid.two_corners {
        let keys = ["x_size", "y_size"];
        for ((key, size), count) in keys.into_iter().zip(leveling.grid.size).zip(leveling.grid.count) {
            distance(checks, (CARTESIAN, key), size.0, count);
        }
    }
    if leveling.strategy == Some(Leveling::DeltaGrid) {
        let (size, count) = (2.0 * leveling.delta.radius.0, leveling.delta.count);
        distance(checks, ("delta grid leveling strategy", "radius"), size, count);
    }
    let keys = [("xy", "xy_measured"), ("xz", "xz_measured"), ("yz", "yz_measured")];
    for ((factor, measured), skew) in keys.into_iter().zip(leveling.skew) {
        let Some(lengths) = skew.measured else { continue };
        if skew.factor != 0.0 {
            let reason = format_args!("both {factor} and {measured} say how the axes lean");
            checks.error((SKEW, 0, measured), reason, format_args!("keep one of them"));
        }
        if !is_usable(lengths) {
            let reason = format_args!("no nearly square figure has these diagonals and this side");
            checks.error(
                (SKEW, 0, measured),
                reason,
                format_args!("write AC,BD,AD in mm: both diagonals, then the side along the second axis"),
            );
        }
    }
}

/// Checks that the interpolation takes the grid's points, and that the faulty regions are valid.
fn mesh(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let (leveling, mesh) = (&config.leveling, &config.leveling.mesh);
    let [nx, ny] = leveling.grid.count;
    let counts: &[(&str, &str, u8)] = match leveling.strategy {
        Some(Leveling::CartesianGrid) => &[(CARTESIAN, "grid_x_size", nx), (CARTESIAN, "grid_y_size", ny)],
        Some(Leveling::DeltaGrid) => &[("delta grid leveling strategy", "size", leveling.delta.count)],
        _ => &[],
    };
    let most = mesh.interpolation.most_points();
    if let Some((section, key, count)) = counts.iter().find(|(_, _, count)| usize::from(*count) > most) {
        let reason =
            format_args!("the interpolation that [bed mesh] asks for takes at most {most} points: here are {count}");
        checks.error((section, 0, key), reason, format_args!("write {most} or less, or interpolation = spline"));
    }
    let (regions, rest) = mesh.faulty_regions.as_chunks::<2>();
    if !rest.is_empty() {
        let reason = format_args!("one of the corners stands alone");
        let fix = format_args!("write two opposite corners of each region: 10,10 30,25");
        return checks.error((MESH, 0, "faulty_regions"), reason, fix);
    }
    for [a, b] in regions {
        if a[0] == b[0] || a[1] == b[1] {
            let reason = format_args!("from {},{} to {},{} is no region", a[0], a[1], b[0], b[1]);
            checks.error((MESH, 0, "faulty_regions"), reason, format_args!("write two opposite corners of it"));
        }
        let within = |place: &[f64; 2]| (0..2).all(|axis| is_between(place, a, b, axis));
        if mesh.zero_reference.as_ref().is_some_and(within) {
            let reason = format_args!("it lies in a region that is not touched");
            let fix = format_args!("move it out of faulty_regions");
            checks.error((MESH, 0, "zero_reference"), reason, fix);
        }
    }
}

fn is_between(place: &[f64; 2], a: &[f64; 2], b: &[f64; 2], axis: usize) -> bool {
    let get = |of: &[f64; 2]| of.get(axis).copied().unwrap_or(0.0);
    let (low, high) = if get(a) < get(b) { (get(a), get(b)) } else { (get(b), get(a)) };
    (low..=high).contains(&get(place))
}

fn distance(checks: &mut Checks<'_, '_>, (section, key): (&str, &str), size: f64, count: u8) {
    let least = LEAST_DISTANCE * f64::from(count.saturating_sub(1));
    if size.abs() < least {
        let reason = format_args!("{count} points on {} mm lie nearer than {LEAST_DISTANCE} mm", size.abs());
        checks.error((section, 0, key), reason, format_args!("write how large the area is, {least} mm at least"));
    }
}

/// The machine can take back what these lengths say: they are those of a parallelogram with diagonals AC and
/// BD and one side AD, and the cotangent of the angle between its sides is within bounds.
fn is_usable([ac, bd, ad]: [f64; 3]) -> bool {
    let side_sq = (ac * ac + bd * bd) / 2.0 - ad * ad;
    if !(ac > 0.0 && bd > 0.0 && ad > 0.0 && side_sq > 0.0) {
        return false;
    }
    // Squares, which need no root.
    let difference = ac * ac - bd * bd;
    let cosine_sq = difference * difference / (16.0 * side_sq * ad * ad);
    cosine_sq < 1.0 && cosine_sq / (1.0 - cosine_sq) <= MOST_SKEW * MOST_SKEW
}
