//! G5 (cubic), G5.1 (quadratic) and G5.2 with G5.3 (NURBS): from words to the shapes of splines.
//!
//! The words are those of LinuxCNC, and of Marlin for G5. Splines lie in the plane of X and Y; every other
//! axis goes along evenly.

use core::ops::RangeInclusive;

use heapless::Vec;
use units::{Axis, Plane};

use crate::action::{ControlPoint, MOST_POINTS, Shape};
use crate::fault::{Fault, Problem};
use crate::interpreter::{Context, Interpreter, Meaning, NOTHING};
use crate::modal::MotionMode;
use crate::words::Words;

/// Orders of a NURBS.
pub(crate) const ORDERS: RangeInclusive<u8> = 2..=6;
/// Order of a NURBS without L.
const USUAL_ORDER: u8 = 3;

/// What a spline needs to know of the lines before it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Splines {
    /// From the end of the last move, if that was a G5, to where its direction goes on: the next one's I and
    /// J.
    onward: Option<(f64, f64)>,
    /// Order of the NURBS whose control points come in.
    open: Option<u8>,
    /// Its control points; those of the last one until the next begins.
    points: Vec<ControlPoint, MOST_POINTS>,
}

impl Splines {
    /// The control points of the NURBS that was closed last.
    pub fn closed(&self) -> &[ControlPoint] {
        &self.points
    }
}

/// A word and its partner: both or none.
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

impl Interpreter {
    /// What any motion code does to a spline that is under way.
    pub(crate) fn begin_motion(&mut self, mode: MotionMode, column: u16) -> Result<(), Fault> {
        if mode != MotionMode::Nurbs && self.splines.open.take().is_some() {
            return Err(Problem::NurbsIsOpen.alarm(column));
        }
        let is_spline = matches!(mode, MotionMode::Cubic | MotionMode::Quadratic | MotionMode::Nurbs);
        if is_spline && self.modal.plane != Plane::Xy {
            return Err(Problem::SplinePlane.alarm(column));
        }
        if mode != MotionMode::Cubic {
            self.splines.onward = None;
        }
        Ok(())
    }

    /// G5: I J from the start to the first control point, P Q from the end to the second. Without I J it goes
    /// on as the last G5 ended.
    pub(crate) fn cubic(&mut self, words: &Words<'_>) -> Result<Shape, Fault> {
        let onward = self.splines.onward.take();
        let first = pair(words, 'I', 'J')?.or(onward).ok_or(Problem::CubicStart.alarm(words.column()))?;
        let (p, q) = pair(words, 'P', 'Q')?.ok_or(Problem::CubicEnd.alarm(words.column()))?;
        self.splines.onward = Some((0.0 - p, 0.0 - q));
        Ok(Shape::Cubic([first, (p, q)]))
    }

    /// G5.1: I J from the start to the control point.
    pub(crate) fn quadratic(&mut self, words: &Words<'_>) -> Result<Shape, Fault> {
        if !(words.has('I') || words.has('J')) {
            return Err(Problem::QuadraticPoint.alarm(words.column()));
        }
        Ok(Shape::Quadratic((words.get('I').unwrap_or(0.0), words.get('J').unwrap_or(0.0))))
    }

    /// G5.2 and the lines that follow it: a control point X Y with its weight P. The first one is where the
    /// tool is; P alone on the line of G5.2 is its weight. L is the order.
    pub(crate) fn control_point<'b>(&mut self, words: &Words<'b>) -> Result<Meaning<'b>, Fault> {
        if let Some(letter) = words.other_than("XYPLFS") {
            return Err(Problem::NurbsWord(letter).alarm(words.column_of(letter)));
        }
        let weight = words.get('P').unwrap_or(1.0);
        if !(weight.is_finite() && weight > 0.0) {
            return Err(Problem::Weight.alarm(words.column_of('P')));
        }
        let has_place = words.has('X') || words.has('Y');
        let [x, y, ..] = self.position.0;
        if self.splines.open.is_none() {
            self.splines.open = Some(order_of(words)?);
            self.splines.points.clear();
            let own = if has_place { 1.0 } else { weight };
            // There is room for one.
            let _ = self.splines.points.push(ControlPoint { x, y, weight: own });
        }
        if has_place {
            let last = self.splines.points.last().map_or((x, y), |last| (last.x, last.y));
            let place = |axis: Axis, now: f64| words.axis(axis).map_or(now, |mm| self.modal.machine(axis, mm, now));
            let point = ControlPoint { x: place(Axis::X, last.0), y: place(Axis::Y, last.1), weight };
            if self.splines.points.push(point).is_err() {
                self.splines.open = None;
                return Err(Problem::ControlPoints.alarm(words.column()));
            }
        }
        NOTHING
    }

    /// G5.3: draws what G5.2 began.
    pub(crate) fn close_nurbs<'b>(&mut self, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        let column = context.words.column();
        self.modal.motion = MotionMode::Linear;
        let order = self.splines.open.take().ok_or(Problem::NurbsIsNotOpen.alarm(column))?;
        if self.splines.points.len() < usize::from(order) {
            return Err(Problem::TooFewPoints(order).alarm(column));
        }
        let mut target = self.position;
        if let Some(last) = self.splines.points.last() {
            (target[Axis::X], target[Axis::Y]) = (last.x, last.y);
        }
        Ok(Meaning::Action(self.draw(target, Shape::Nurbs { order }, false)))
    }
}

fn order_of(words: &Words<'_>) -> Result<u8, Fault> {
    let Some(order) = words.get('L') else { return Ok(USUAL_ORDER) };
    let known = ORDERS.into_iter().find(|known| f64::from(*known) == order);
    known.ok_or(Problem::Order.alarm(words.column_of('L')))
}
