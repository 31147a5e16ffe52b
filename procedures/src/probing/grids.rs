//! Leveling by a grid of touches: rectangular, and round on a delta.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::touches::Scatter;
use motion::GridShape;
use program::Words;
use units::Axis;

use super::faulty;
use super::plan::Plan;
use super::points::{Neighbour, check_reach, clear_of, find_bed, nozzle_over, probe_at, probe_beside, probe_point};
use super::search::check_homed;
use super::strategy::uncompensated;
use crate::homing;
use crate::leveling::area::{Area, area_of, part_of};
use crate::leveling::{self, grid};
use crate::probing::ProbeHands;

/// Least number of points along a side of a G29 scan.
const LEAST_SCAN: usize = 5;
/// Greatest number of points along a side of a delta's G29.
const MOST_ALONG: f64 = 50.0;
/// Number of touches of a spiral without I, and the greatest.
const SPIRAL: f64 = 50.0;
const MOST_SPIRAL: f64 = 1_000.0;
/// Turn between two touches of a spiral, radians: the golden angle, which spreads them evenly.
const GOLDEN: f64 = 2.399_963_229_728_653;
/// Distance outside of the circle, mm, by which a point may lie through rounding.
const ROUNDING: f64 = 1e-6;

/// Homes as configured, and returns the area of G31 and G32: the probe's present place may be part of it.
pub(super) fn prepare_cartesian_grid<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Result<Plan, Failure> {
    let settings = hands.config().leveling.grid;
    let here = words.get('R') == Some(1.0);
    if let Some(mode) = words.get('R') {
        hands.bed().two_corners = mode == 1.0;
    }
    let has_corners = ['X', 'Y', 'A', 'B'].into_iter().all(|letter| words.has(letter));
    let two_corners = hands.bed().two_corners || has_corners && words.get('R') != Some(0.0);
    if settings.home && !two_corners {
        homing::home_before_probing(hands)?;
    }
    hands.standstill()?;
    check_homed(hands)?;
    let area = area_in(words);
    let whole = grid::configured(&hands.config().leveling).filter(|_| !hands.bed().two_corners);
    let mut shape = match (area, whole) {
        (Some(area), Some(whole)) => {
            let part = part_of(&whole, &area);
            part.ok_or_else(|| Failure::refused(&"the area to probe lies beside the grid that is configured"))?
        }
        _ => {
            let [origin, size] = corners(hands, words, here, two_corners)?;
            cartesian_shape(hands, words, origin, size)?
        }
    };
    // The place of height zero does not depend on the part of the mesh that is measured.
    let whole = whole.unwrap_or(shape);
    if words.has('D') {
        shape = around_objects(hands, words.get('D'), &shape)?;
    }
    let reference = hands.config().leveling.mesh.zero_reference.unwrap_or(whole.place(0));
    let plan = Plan { shape, radius: None, reference, from: settings.initial_height.0, levels: true };
    check_regions(hands.texts(), &plan, &hands.config().leveling.mesh.faulty_regions)?;
    check_places(hands, &plan)?;
    Ok(plan)
}

/// Returns the area that other firmwares' words mean: Prusa's corner X and Y and size W and H, Marlin's ends
/// L R F B.
fn area_in(words: &Words<'_>) -> Option<Area> {
    let get = |letters: [char; 4]| {
        let found = letters.map(|letter| words.get(letter));
        found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default))
    };
    if let Some([x, y, w, h]) = get(['X', 'Y', 'W', 'H']) {
        return Some([[x, y], [x + w, y + h]]);
    }
    get(['L', 'R', 'F', 'B']).map(|[left, right, front, rear]| [[left, front], [right, rear]])
}

/// Returns the part of a grid that the objects of the job need, with a margin around them.
fn around_objects<'c>(
    hands: &mut impl ProbeHands<'c>,
    margin: Option<f64>,
    whole: &GridShape,
) -> Result<GridShape, Failure> {
    let margin = margin.unwrap_or(hands.config().leveling.mesh.adaptive_margin.0);
    if margin < 0.0 {
        return Err(Failure::refused(&"D is how far the mesh goes around the objects, 0 mm or more"));
    }
    let Some([low, high]) = hands.objects_area() else {
        hands.say(format_args!("// no object of the job has an outline: all of the bed is measured\n"));
        return Ok(*whole);
    };
    let wanted = [low.map(|place| place - margin), high.map(|place| place + margin)];
    let part = part_of(whole, &wanted);
    let part =
        part.ok_or_else(|| Failure::refused(&"the objects of the job lie beside the grid that is configured"))?;
    let ([nx, ny], [[left, near], [right, far]]) = (part.count, area_of(&part));
    hands.say(format_args!(
        "mesh for the objects: X{left:.1} to {right:.1}, Y{near:.1} to {far:.1}, {nx} x {ny} points\n"
    ));
    Ok(part)
}

/// Checks that every point can be touched, or computed from points that can.
fn check_regions(texts: &Texts, plan: &Plan, corners: &[[f64; 2]]) -> Result<(), Failure> {
    let within = area_of(&plan.shape);
    if faulty::region_of(plan.reference, corners).is_some() {
        return Err(Failure::refused(
            &"the first point lies in one of faulty_regions: write zero_reference in [bed mesh]",
        ));
    }
    for index in 0..plan.shape.points() {
        let place = plan.shape.place(index);
        let Some(region) = faulty::region_of(place, corners) else { continue };
        if faulty::ends(place, &region, &within, corners).iter().all(Option::is_none) {
            let [x, y] = place;
            let text = format_args!("around X{x:.1} Y{y:.1} faulty_regions leave no place to touch: make them smaller");
            return Err(texts.refused(text));
        }
    }
    Ok(())
}

/// Checks that the probe reaches every point, and the place of height zero.
fn check_places<'c>(hands: &mut impl ProbeHands<'c>, plan: &Plan) -> Result<(), Failure> {
    let faulty = &hands.config().leveling.mesh.faulty_regions;
    let places = (0..plan.shape.points()).map(|index| plan.shape.place(index));
    let touched = places.filter(|place| plan.touches(*place) && faulty::region_of(*place, faulty).is_none());
    check_reach(hands, core::iter::once(plan.reference).chain(touched))
}

/// Runs G29, G31 and G32 with a cartesian grid, once its area is known.
pub fn touch_cartesian_grid<'c>(hands: &mut impl ProbeHands<'c>, plan: &Plan) -> Outcome {
    if plan.levels {
        return level_by_grid(hands, plan);
    }
    uncompensated(hands, |hands| scan(hands, plan))
}

/// Returns the area of G29 with a cartesian grid, which begins at the probe.
pub(super) fn prepare_scan<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Result<Plan, Failure> {
    hands.standstill()?;
    check_homed(hands)?;
    let (Some(x), Some(y)) = (words.get('X'), words.get('Y')) else {
        return Err(Failure::refused(&"G29 takes the size X and Y of the area to scan"));
    };
    let start = probe_here(hands);
    let shape = cartesian_shape(hands, words, start, [x, y])?;
    if shape.count.iter().any(|count| *count < LEAST_SCAN) {
        return Err(Failure::refused(&"G29 scans at least 5 x 5 points: I and J"));
    }
    let from = hands.config().leveling.grid.initial_height.0;
    let plan = Plan { shape, radius: None, reference: shape.place(0), from, levels: false };
    check_places(hands, &plan)?;
    Ok(plan)
}

/// Touches a grid and shows its heights, which are not kept.
fn scan<'c>(hands: &mut impl ProbeHands<'c>, plan: &Plan) -> Outcome {
    touch_grid(hands, plan)?;
    say_draft(hands, &plan.shape);
    Ok(Answer::Ok)
}

fn probe_here<'c>(hands: &mut impl ProbeHands<'c>) -> [f64; 2] {
    let nozzle = hands.position();
    probe_at(hands.bed(), &nozzle)
}

/// Returns the origin and the size of the area of G31 and G32: from the configuration, or as the words say.
fn corners<'c>(
    hands: &mut impl ProbeHands<'c>,
    words: &Words<'_>,
    here: bool,
    two_corners: bool,
) -> Result<[[f64; 2]; 2], Failure> {
    let grid = &hands.config().leveling.grid;
    let ([width, depth], start) = (grid.size.map(|size| size.0), grid.start.map(|start| start.0));
    if !two_corners {
        return Ok([start, [words.get('X').unwrap_or(width), words.get('Y').unwrap_or(depth)]]);
    }
    let (Some(x), Some(y), Some(a), Some(b)) = (words.get('X'), words.get('Y'), words.get('A'), words.get('B')) else {
        return Err(Failure::refused(if here {
            &"R1: X and Y are the way from here to the start, A and B the size of the area"
        } else {
            &"two corners: X and Y are the start, A and B the size of the area; R0 goes back to the configured one"
        }));
    };
    let [from_x, from_y] = if here { probe_here(hands) } else { [0.0; 2] };
    Ok([[from_x + x, from_y + y], [a, b]])
}

/// Returns an area and its points: as many as are configured, or as the words say.
fn cartesian_shape<'c>(
    hands: &impl ProbeHands<'c>,
    words: &Words<'_>,
    origin: [f64; 2],
    size: [f64; 2],
) -> Result<GridShape, Failure> {
    let [nx, ny] = hands.config().leveling.grid.count.map(f64::from);
    let counts = [words.get('I').unwrap_or(nx), words.get('J').unwrap_or(ny)];
    let is_count = |count: &f64| *count >= 2.0 && libm::floor(*count) == *count;
    if !counts.iter().all(is_count) || counts[0] * counts[1] > nx * ny {
        let text = format_args!("I and J are points along X and Y, 2 or more, together at most {}", nx * ny);
        return Err(hands.texts().refused(text));
    }
    if size.contains(&0.0) {
        return Err(Failure::refused(&"the area to probe has no size: x_size and y_size, or X and Y"));
    }
    let step = [size[0] / (counts[0] - 1.0), size[1] / (counts[1] - 1.0)];
    Ok(GridShape { origin, step, count: counts.map(|count| count as usize) })
}

/// Runs G31 with a delta grid.
pub(super) fn level_by_delta_grid<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    let settings = hands.config().leveling.delta;
    if words.has('D') {
        return Err(Failure::refused(&"D measures a part of a cartesian grid: on a delta J makes the circle smaller"));
    }
    let radius = grid_radius(hands, words)?;
    if settings.home {
        homing::home_before_probing(hands)?;
    }
    hands.standstill()?;
    check_homed(hands)?;
    let count = delta_count(hands.texts(), words, settings.count)?;
    let mut plan = round_plan(radius, count, settings.initial_height.0);
    let mesh = &hands.config().leveling.mesh;
    plan.reference = mesh.zero_reference.unwrap_or(plan.reference);
    check_regions(hands.texts(), &plan, &mesh.faulty_regions)?;
    check_places(hands, &plan)?;
    level_by_grid(hands, &plan)
}

/// Returns the number of points along a side: as configured, or fewer.
fn delta_count(texts: &Texts, words: &Words<'_>, configured: u8) -> Result<u8, Failure> {
    let Some(count) = words.get('I') else { return Ok(configured) };
    let odd = (3..=configured).step_by(2).find(|odd| f64::from(*odd) == count);
    odd.ok_or_else(|| {
        texts.refused(format_args!(
            "I is the number of points along a side, odd, from 3 to grid_size, which is {configured}"
        ))
    })
}

/// Returns the grid around the middle whose points within the circle the probe touches.
fn round_plan(radius: f64, count: u8, from: f64) -> Plan {
    Plan {
        shape: grid::around(radius, count),
        radius: Some(radius + ROUNDING),
        reference: [0.0; 2],
        from,
        levels: true,
    }
}

/// G29 with a delta grid, which homes as G31 does: a map of I points along each side; G29.1: I points along a
/// spiral. The heights are not kept.
pub(super) fn scan_delta<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>, spiral: bool) -> Outcome {
    let settings = hands.config().leveling.delta;
    let radius = grid_radius(hands, words)?;
    let usual = if spiral { SPIRAL } else { f64::from(settings.count) };
    let (count, most) = (words.get('I').unwrap_or(usual), if spiral { MOST_SPIRAL } else { MOST_ALONG });
    if !(2.0..=most).contains(&count) {
        return Err(hands.texts().refused(format_args!("I is the number of points, 2 to {most}")));
    }
    if settings.home {
        homing::home_before_probing(hands)?;
    }
    hands.standstill()?;
    check_homed(hands)?;
    let from = settings.initial_height.0;
    uncompensated(hands, |hands| match spiral {
        true => scan_spiral(hands, radius, count, from),
        false => scan(hands, &round_plan(radius, count as u8, from)),
    })
}

/// Touches this many points along a spiral out to the radius.
fn scan_spiral<'c>(hands: &mut impl ProbeHands<'c>, radius: f64, count: f64, from: f64) -> Outcome {
    let (offsets, probe) = (*hands.bed(), hands.tuning().probe);
    let bed = find_bed(hands, nozzle_over(&offsets, [0.0; 2]), from)?[Axis::Z];
    for n in 0..count as u32 {
        let (distance, angle) = (radius * libm::sqrt(f64::from(n) / (count - 1.0)), GOLDEN * f64::from(n));
        let at = [distance * libm::cos(angle), distance * libm::sin(angle)];
        let contact = probe_point(hands, nozzle_over(&offsets, at), clear_of(&probe, bed))?;
        hands.say(format_args!("X:{:.4} Y:{:.4} Z:{:.4}\n", at[0], at[1], contact[Axis::Z] - bed));
        hands.drain();
    }
    Ok(Answer::Ok)
}

fn grid_radius<'c>(hands: &impl ProbeHands<'c>, words: &Words<'_>) -> Result<f64, Failure> {
    let radius = words.as_length('J').unwrap_or(hands.config().leveling.delta.radius.0);
    if radius >= 1.0 { Ok(radius) } else { Err(Failure::refused(&"J is a radius, 1 mm or more")) }
}

/// Touches the bed at every point of a grid and levels by the heights.
fn level_by_grid<'c>(hands: &mut impl ProbeHands<'c>, plan: &Plan) -> Outcome {
    leveling::take_off(hands)?;
    hands.bed().scatter = Scatter::default();
    touch_grid(hands, plan)?;
    if plan.radius.is_some() {
        hands.motion(|motion| grid::extrapolate(&plan.shape, motion.draft()));
    }
    leveling::adopt_grid(hands, &plan.shape)?;
    leveling::show_grid(hands)?;
    let scatter = hands.bed().scatter;
    hands.say(format_args!("{scatter}\n"));
    leveling::say_findings(hands)
}

/// Writes the heights of the bed over that at the reference into the draft; NaN at points that must not be
/// touched.
fn touch_grid<'c>(hands: &mut impl ProbeHands<'c>, plan: &Plan) -> Result<(), Failure> {
    let (offsets, probe) = (*hands.bed(), hands.tuning().probe);
    let bed = find_bed(hands, nozzle_over(&offsets, plan.reference), plan.from)?[Axis::Z];
    let height = clear_of(&probe, bed);
    let mut before = Neighbour { at: plan.reference, contact: bed };
    let [nx, ny] = plan.shape.count;
    for row in 0..ny {
        for step in 0..nx {
            // Rows are touched there and back, so that no way is made twice.
            let column = if row % 2 == 0 { step } else { nx - 1 - step };
            let index = row * nx + column;
            let [x, y] = plan.shape.place(index);
            let mut found = f64::NAN;
            if plan.touches([x, y]) {
                let contact = touch_point(hands, plan, [x, y], height, &before)?;
                before = Neighbour { at: [x, y], contact };
                found = contact - bed;
            }
            if found.is_finite() {
                hands.say(format_args!("DEBUG: X{x:.3}, Y{y:.3}, Z{found:.3}\n"));
                hands.drain();
            }
            hands.motion(|motion| {
                if let Some(slot) = motion.draft().get_mut(index) {
                    *slot = found as f32;
                }
            });
        }
    }
    Ok(())
}

/// Returns the height of the bed at a point of the grid; computed from the edges of a region that must not be
/// touched.
fn touch_point<'c>(
    hands: &mut impl ProbeHands<'c>,
    plan: &Plan,
    place: [f64; 2],
    height: f64,
    before: &Neighbour,
) -> Result<f64, Failure> {
    let corners = &hands.config().leveling.mesh.faulty_regions;
    let Some(region) = faulty::region_of(place, corners) else {
        return Ok(probe_beside(hands, place, height, before)?[Axis::Z]);
    };
    let ends = faulty::ends(place, &region, &area_of(&plan.shape), corners);
    let mut heights = [None; 4];
    for (end, found) in ends.iter().zip(&mut heights) {
        if let Some([x, y]) = *end {
            let contact = probe_beside(hands, [x, y], height, before)?[Axis::Z];
            hands.say(format_args!("// beside a faulty region: X{x:.3}, Y{y:.3}\n"));
            hands.drain();
            *found = Some(contact);
        }
    }
    faulty::between(place, &ends, &heights).ok_or_else(|| Failure::refused(&"no place to touch beside a faulty region"))
}

/// Reports the draft, a line for each row.
fn say_draft<'c>(hands: &mut impl ProbeHands<'c>, shape: &GridShape) {
    let [nx, ny] = shape.count;
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for row in 0..ny {
        for column in 0..nx {
            let height = hands.motion(|motion| motion.draft().get(row * nx + column).copied());
            let height = height.unwrap_or(f32::NAN);
            if height.is_finite() {
                least = if height < least { height } else { least };
                most = if height > most { height } else { most };
                hands.say(format_args!("{height:7.4} "));
            } else {
                hands.say(format_args!("      - "));
            }
        }
        hands.say(format_args!("\n"));
        hands.drain();
    }
    hands.say(format_args!("Maximum delta: {:.4}\n", most - least));
}
