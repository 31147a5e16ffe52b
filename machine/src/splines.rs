//! G5 (cubic), G5.1 (quadratic) and G5.2 with G5.3 (NURBS): from words to splines in machine space.
//!
//! The words are those of LinuxCNC, and of Marlin for G5. Splines lie in the plane of X and Y; every other axis goes along evenly.

use gcode::Block;
use motion::Mode;
use motion::geometry::Plane;
use motion::geometry::{Bezier, ControlPoint, MOST_POINTS, Nurbs, ORDERS, Smooth, SplineMoves};
use units::{Axis, PerAxis};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::modal::MotionMode;
use crate::ports::Ports;

/// Order of a NURBS without L.
const USUAL_ORDER: usize = 3;

/// What a spline needs to know of the lines before it.
#[derive(Debug, Default)]
pub struct Splines {
    /// From the end of the last move, if that was a G5, to where its direction goes on: the next one's I and J.
    onward: Option<(f64, f64)>,
    /// The control points since G5.2.
    open: Option<Open>,
}

#[derive(Debug)]
struct Open {
    order: usize,
    points: heapless::Vec<ControlPoint, MOST_POINTS>,
}

fn bad_word(text: &str, column: u16) -> Failure {
    Failure::Alarm(message(format_args!("{text}, column {column}")))
}

/// A word and its partner: both or none.
fn pair(block: &Block<'_>, first: char, second: char) -> Result<Option<(f64, f64)>, Failure> {
    match (block.get(first), block.get(second)) {
        (Some(a), Some(b)) => Ok(Some((a, b))),
        (None, None) => Ok(None),
        (a, _) => {
            let written = if a.is_some() { first } else { second };
            let text = format_args!("{first} and {second} belong together, column {}", block.column_of(written));
            Err(Failure::Alarm(message(text)))
        }
    }
}

impl<P: Ports> Controller<P> {
    /// What any motion code does to a spline that is under way.
    pub(crate) fn spline_state(&mut self, mode: MotionMode, block: &Block<'_>) -> Result<(), Failure> {
        if mode != MotionMode::Nurbs && self.splines.open.take().is_some() {
            return Err(bad_word("G5.2 is not closed: G5.3 must come first", block.column));
        }
        let is_spline = matches!(mode, MotionMode::Cubic | MotionMode::Quadratic | MotionMode::Nurbs);
        if is_spline && self.modal.plane != Plane::Xy {
            return Err(bad_word("splines lie in the plane of G17", block.column));
        }
        if mode != MotionMode::Cubic {
            self.splines.onward = None;
        }
        Ok(())
    }

    fn xy(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.modal.to_mm(x), self.modal.to_mm(y))
    }

    /// G5: I J from the start to the first control point, P Q from the end to the second. Without I J it goes on as the last G5 ended.
    pub(crate) async fn cubic(&mut self, block: &Block<'_>, target: PerAxis<f64>) -> Outcome {
        let onward = self.splines.onward.take();
        let first = pair(block, 'I', 'J')?.map(|words| self.xy(words)).or(onward);
        let Some((i, j)) = first else {
            return Err(bad_word("G5 needs I and J where no other G5 goes before", block.column));
        };
        let Some(second) = pair(block, 'P', 'Q')? else {
            return Err(bad_word("G5 needs P and Q", block.column));
        };
        let (p, q) = self.xy(second);
        let ([x, y, ..], [to_x, to_y, ..]) = (self.position.0, target.0);
        let points = [[x, y, 0.0], [x + i, y + j, 0.0], [to_x + p, to_y + q, 0.0], [to_x, to_y, 0.0]];
        self.draw(Bezier::cubic(points), target, block.has('Z')).await?;
        self.splines.onward = Some((-p, -q));
        Ok(Answer::Ok)
    }

    /// G5.1: I J from the start to the control point.
    pub(crate) async fn quadratic(&mut self, block: &Block<'_>, target: PerAxis<f64>) -> Outcome {
        if !(block.has('I') || block.has('J')) {
            return Err(bad_word("G5.1 needs I or J", block.column));
        }
        let (i, j) = self.xy((block.get('I').unwrap_or(0.0), block.get('J').unwrap_or(0.0)));
        let ([x, y, ..], [to_x, to_y, ..]) = (self.position.0, target.0);
        let points = [[x, y, 0.0], [x + i, y + j, 0.0], [to_x, to_y, 0.0]];
        self.draw(Bezier::quadratic(points), target, block.has('Z')).await?;
        Ok(Answer::Ok)
    }

    /// G5.2 and the lines that follow it: a control point X Y with its weight P. The first one is where the tool is; P alone on the line of
    /// G5.2 is its weight. L is the order.
    pub(crate) fn control_point(&mut self, block: &Block<'_>) -> Outcome {
        let strange = block.words().find(|(letter, _)| !matches!(letter, 'X' | 'Y' | 'P' | 'L' | 'F' | 'S'));
        if let Some((letter, _)) = strange {
            let text = format_args!("G5.2 takes X Y P L only, column {}", block.column_of(letter));
            return Err(Failure::Alarm(message(text)));
        }
        let weight = block.get('P').unwrap_or(1.0);
        if !(weight.is_finite() && weight > 0.0) {
            return Err(bad_word("P is a weight above zero", block.column_of('P')));
        }
        let has_place = block.has('X') || block.has('Y');
        let [x, y, ..] = self.position.0;
        let mut open = match self.splines.open.take() {
            Some(open) => open,
            None => {
                let mut open = Open { order: order_of(block)?, points: heapless::Vec::new() };
                let own = if has_place { 1.0 } else { weight };
                // There is room for one.
                let _ = open.points.push(ControlPoint { x, y, weight: own });
                open
            }
        };
        if has_place {
            let last = open.points.last().map_or((x, y), |last| (last.x, last.y));
            let word =
                |axis: Axis, now: f64| block.get(axis.letter()).map_or(now, |word| self.modal.machine(axis, word, now));
            let point = ControlPoint { x: word(Axis::X, last.0), y: word(Axis::Y, last.1), weight };
            if open.points.push(point).is_err() {
                let text = format_args!("G5.2 takes {MOST_POINTS} control points at most, column {}", block.column);
                return Err(Failure::Alarm(message(text)));
            }
        }
        self.splines.open = Some(open);
        Ok(Answer::Ok)
    }

    /// G5.3: draws what G5.2 began.
    pub(crate) async fn close_nurbs(&mut self, block: &Block<'_>) -> Outcome {
        self.modal.motion = MotionMode::Linear;
        let Some(open) = self.splines.open.take() else {
            return Err(bad_word("G5.3 without G5.2", block.column));
        };
        let Some(nurbs) = Nurbs::new(&open.points, open.order) else {
            let text =
                format_args!("a spline of order {} needs as many control points, column {}", open.order, block.column);
            return Err(Failure::Alarm(message(text)));
        };
        if self.config.motion.must_be_homed && !self.all_homed() {
            return Err(Failure::alarm("Must be homed before moving"));
        }
        let mut target = self.position;
        if let Some(last) = open.points.last() {
            (target[Axis::X], target[Axis::Y]) = (last.x, last.y);
        }
        self.draw(nurbs, target, false).await?;
        Ok(Answer::Ok)
    }

    async fn draw(&mut self, spline: impl Smooth + Copy, target: PerAxis<f64>, names_z: bool) -> Result<(), Failure> {
        for (end, curve) in SplineMoves::new(spline, self.position, target) {
            self.go_along(curve, end, self.modal.feed_rate, Mode::Feed).await?;
        }
        self.tools.moved(names_z);
        Ok(())
    }
}

fn order_of(block: &Block<'_>) -> Result<usize, Failure> {
    let Some(order) = block.get('L') else { return Ok(USUAL_ORDER) };
    let known = ORDERS.into_iter().find(|known| *known as f64 == order);
    known.ok_or_else(|| {
        let (least, most) = (ORDERS.start(), ORDERS.end());
        Failure::Alarm(message(format_args!("L is the order, {least} to {most}, column {}", block.column_of('L'))))
    })
}
