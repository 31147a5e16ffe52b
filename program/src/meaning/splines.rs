//! G5 (cubic), G5.1 (quadratic) and G5.2 with G5.3 (NURBS): from words to the shapes of splines.
//!
//! The words are LinuxCNC's, and Marlin's for G5. Splines lie in the plane of X and Y; every other axis moves
//! linearly along.

use core::ops::RangeInclusive;

use units::{Axis, ControlPoint, MOST_CONTROL_POINTS, Plane};

use crate::action::Shape;
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::state::modal::MotionMode;
use crate::words::Words;

/// Permitted orders of a NURBS.
const ORDERS: RangeInclusive<u8> = 2..=6;
/// Order of a NURBS without L.
const USUAL_ORDER: u8 = 3;

/// Returns a word and its partner; either both or neither must be given.
fn pair(words: &Words<'_>, first: char, second: char) -> Result<Option<(f64, f64)>, Fault> {
    match (words.get(first), words.get(second)) {
        (Some(a), Some(b)) => Ok(Some((a, b))),
        (None, None) => Ok(None),
        (a, _) => {
            let written = if a.is_some() { first } else { second };
            Err(Problem::BelongTogether(first, second).alarm(words.column_of(written)))
        }
    }
}

/// Prepares splines for a motion code: refuses codes that interrupt a NURBS.
pub(crate) fn begin_motion(program: &mut Interpreter, mode: MotionMode, column: u16) -> Result<(), Fault> {
    if mode != MotionMode::Nurbs && program.splines.open.take().is_some() {
        return Err(Problem::NurbsIsOpen.alarm(column));
    }
    let is_spline = matches!(mode, MotionMode::Cubic | MotionMode::Quadratic | MotionMode::Nurbs);
    if is_spline && program.modal.plane != Plane::Xy {
        return Err(Problem::SplinePlane.alarm(column));
    }
    if mode != MotionMode::Cubic {
        program.splines.onward = None;
    }
    Ok(())
}

/// G5: reads I J from the start to the first control point, P Q from the end to the second. Without I J the
/// curve continues the previous G5 smoothly.
pub(crate) fn cubic(program: &mut Interpreter, words: &Words<'_>) -> Result<Shape, Fault> {
    let onward = program.splines.onward.take();
    let first = pair(words, 'I', 'J')?.or(onward).ok_or(Problem::CubicStart.alarm(words.column()))?;
    let (p, q) = pair(words, 'P', 'Q')?.ok_or(Problem::CubicEnd.alarm(words.column()))?;
    program.splines.onward = Some((0.0 - p, 0.0 - q));
    Ok(Shape::Cubic([turned(program, first), turned(program, (p, q))]))
}

/// G5.1: reads I J from the start to the control point.
pub(crate) fn quadratic(program: &Interpreter, words: &Words<'_>) -> Result<Shape, Fault> {
    if !(words.has('I') || words.has('J')) {
        return Err(Problem::QuadraticPoint.alarm(words.column()));
    }
    Ok(Shape::Quadratic(turned(program, (words.get('I').unwrap_or(0.0), words.get('J').unwrap_or(0.0)))))
}

/// Returns a distance to a control point, rotated to the machine's axes.
fn turned(program: &Interpreter, (x, y): (f64, f64)) -> (f64, f64) {
    let [x, y] = program.modal.way_xy([x, y]);
    (x, y)
}

/// G5.2 and the lines that follow: adds a control point X Y with its weight P. The first point is the tool's
/// position, with a P that stands alone on the line of G5.2 as its weight. L is the order.
pub(crate) fn control_point<'b>(program: &mut Interpreter, words: &Words<'b>) -> Result<Meaning<'b>, Fault> {
    if let Some(letter) = words.other_than("XYPLFS") {
        return Err(Problem::NurbsWord(letter).alarm(words.column_of(letter)));
    }
    let weight = words.get('P').unwrap_or(1.0);
    if !(weight.is_finite() && weight > 0.0) {
        return Err(Problem::Weight.alarm(words.column_of('P')));
    }
    let has_place = words.has('X') || words.has('Y');
    let [x, y, ..] = program.position.0;
    if program.splines.open.is_none() {
        program.splines.open = Some(order_of(words)?);
        program.splines.points.clear();
        let own = if has_place { 1.0 } else { weight };
        // The list is empty, so there is room for one point.
        let _ = program.splines.points.push(ControlPoint { x, y, weight: own });
    }
    if has_place {
        let last = program.splines.points.last().map_or([x, y], |last| [last.x, last.y]);
        let [x, y] = program.modal.target_xy([words.axis(Axis::X), words.axis(Axis::Y)], last);
        let point = ControlPoint { x, y, weight };
        if program.splines.points.push(point).is_err() {
            program.splines.open = None;
            return Err(Problem::ControlPoints(MOST_CONTROL_POINTS).alarm(words.column()));
        }
    }
    NOTHING
}

/// G5.3: draws the curve that G5.2 began.
pub(crate) fn close_nurbs<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let column = context.words.column();
    program.modal.motion = MotionMode::Linear;
    let order = program.splines.open.take().ok_or(Problem::NurbsIsNotOpen.alarm(column))?;
    if program.splines.points.len() < usize::from(order) {
        return Err(Problem::TooFewPoints(order).alarm(column));
    }
    let mut target = program.position;
    if let Some(last) = program.splines.points.last() {
        (target[Axis::X], target[Axis::Y]) = (last.x, last.y);
    }
    Ok(Meaning::Action(program.draw(target, Shape::Nurbs { order }, false)))
}

fn order_of(words: &Words<'_>) -> Result<u8, Fault> {
    let Some(order) = words.get('L') else { return Ok(USUAL_ORDER) };
    let known = ORDERS.into_iter().find(|known| f64::from(*known) == order);
    known.ok_or(Problem::Order(*ORDERS.start(), *ORDERS.end()).alarm(words.column_of('L')))
}
