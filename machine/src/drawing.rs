//! From the program's moves to those of motion: straight, arcs and splines.
//!
//! An arc is one move, exact all along. Two kinds of machine see it in parts: one whose configuration asks
//! for chords, and one whose motors bend lines, which gets short arcs so that each goes at the speed its own
//! part of the space allows.
//!
//! The executor has moves made of what is drawn here, preflight only looks at it.

use config::MachineConfig;
use motion::geometry::{
    Arc, ArcError, ArcShape, Bezier, Chords, ControlPoint, Line, LineSettings, MOST_POINTS, Nurbs, ParametricCurve,
    SplineMoves,
};
use motion::path::{Bounds, Curve};
use motion::{Corner, Mode, Tag};
use program::{Centre, Interpreter, Move, Rate, Shape};
use units::{MmPerSecond, PerAxis, Plane};

use crate::failure::{Message, message};
use crate::grbl::numbers::Error;
use crate::motion_config::arc_settings;

/// Parts of a turn on a machine that bends lines.
const PARTS_OF_TURN: f64 = 16.0;

/// Whoever takes what is drawn.
pub(crate) trait Draws {
    /// Why a move is not made.
    type Failure;

    fn config(&self) -> &MachineConfig;
    fn program(&self) -> &Interpreter;
    /// How straight moves are cut.
    fn line_settings(&self) -> LineSettings;
    /// Whether motors bend lines.
    fn bends(&mut self) -> bool;

    /// Nothing can be drawn, for this reason.
    fn wrong(&mut self, what: Message) -> Self::Failure;
    /// A line may be made; else why not.
    fn line_may_be(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Self::Failure>;
    /// A curve that stays within these bounds may be made; else why not.
    fn curve_may_be(&mut self, from: &PerAxis<f64>, bounds: &Bounds) -> Result<(), Self::Failure>;
    /// The next piece.
    async fn take(&mut self, piece: &motion::Move) -> Result<(), Self::Failure>;
}

/// What motion is to know of a move of the program, without its curve, and of no object. `deviation` is how
/// far a rounded corner may stand off where the program does not say, mm.
pub(crate) fn in_motions_terms(request: &Move, tag: Tag, deviation: impl FnOnce() -> f64) -> motion::Move {
    let (feed_rate, mode) = match request.rate {
        Rate::Rapid(speed) => (speed, Mode::Rapid),
        Rate::Feed(speed) => (speed, Mode::Feed),
        // No speed, and so nobody takes it, until the length of its way is known: see `last`.
        // Nor what follows the spindle: the program refuses it before.
        Rate::Duration(_) | Rate::PerRevolution(_) => (MmPerSecond(0.0), Mode::Feed),
    };
    let corner = match request.corner {
        program::Corner::Sharp => Corner::Sharp,
        program::Corner::Stop => Corner::Stop,
        program::Corner::Rounded(within) => Corner::Rounded(within.unwrap_or_else(deviation)),
    };
    let (target, power, curve) = (request.target, request.power, Curve::Line);
    motion::Move { target, feed_rate, mode, power, curve, corner, tag, part: 0 }
}

/// Draws a move of the program from `from`; `piece` is the move in motion's terms.
pub(crate) async fn draw<D: Draws>(
    by: &mut D,
    from: PerAxis<f64>,
    request: &Move,
    piece: motion::Move,
) -> Result<(), D::Failure> {
    let mut drawing = Drawing { by, from, to: request.target, piece };
    match request.shape {
        Shape::Line { names_xy } => {
            drawing.last(request.rate, Line::length(&from, &request.target));
            drawing.line(names_xy).await
        }
        Shape::Arc { plane, centre, clockwise, turns, column } => {
            let arc = drawing.arc_of(plane, centre, clockwise, turns);
            let arc = arc.map_err(|error| drawing.bad_arc(&error, column))?;
            drawing.last(request.rate, arc.length());
            drawing.arc(arc, column).await
        }
        Shape::Cubic([(i, j), (p, q)]) => {
            let ([x, y, ..], [to_x, to_y, ..]) = (from.0, request.target.0);
            let points = [[x, y, 0.0], [x + i, y + j, 0.0], [to_x + p, to_y + q, 0.0], [to_x, to_y, 0.0]];
            drawing.spline(Bezier::cubic(points)).await
        }
        Shape::Quadratic((i, j)) => {
            let ([x, y, ..], [to_x, to_y, ..]) = (from.0, request.target.0);
            drawing.spline(Bezier::quadratic([[x, y, 0.0], [x + i, y + j, 0.0], [to_x, to_y, 0.0]])).await
        }
        Shape::Nurbs { order } => {
            let point = |p: &program::ControlPoint| ControlPoint { x: p.x, y: p.y, weight: p.weight };
            let points: heapless::Vec<ControlPoint, MOST_POINTS> =
                drawing.by.program().control_points().iter().map(point).collect();
            let Some(nurbs) = Nurbs::new(&points, usize::from(order)) else {
                let text = "the spline's order and its control points do not fit";
                return Err(drawing.by.wrong(message(format_args!("{text}"))));
            };
            drawing.spline(nurbs).await
        }
    }
}

/// A move being drawn.
struct Drawing<'d, D> {
    by: &'d mut D,
    from: PerAxis<f64>,
    to: PerAxis<f64>,
    /// What every piece of it has in common.
    piece: motion::Move,
}

impl<D: Draws> Drawing<'_, D> {
    /// A way of this length, mm, takes as long as the program says (G93).
    fn last(&mut self, rate: Rate, length: f64) {
        if let Rate::Duration(seconds) = rate {
            self.piece.feed_rate = MmPerSecond(length / seconds);
        }
    }

    async fn go(&mut self, target: PerAxis<f64>, curve: Curve) -> Result<(), D::Failure> {
        (self.piece.target, self.piece.curve) = (target, curve);
        self.by.take(&self.piece).await
    }

    async fn line(&mut self, names_xy: bool) -> Result<(), D::Failure> {
        self.by.line_may_be(&self.from, &self.to)?;
        let lines = self.by.line_settings();
        let line = if names_xy || self.by.config().motion.segment_z_moves {
            Line::cut(self.from, self.to, self.piece.feed_rate, &lines)
        } else {
            Line::whole(self.from, self.to)
        };
        for point in line {
            self.go(point, Curve::Line).await?;
        }
        Ok(())
    }

    fn arc_of(&self, plane: Plane, centre: Centre, clockwise: bool, turns: u32) -> Result<Arc, ArcError> {
        let shape = match centre {
            Centre::Radius(radius) => ArcShape::by_radius(&self.from, &self.to, plane, radius, clockwise)?,
            Centre::At(first, second) => {
                ArcShape { plane, to_centre_first: first, to_centre_second: second, clockwise, turns }
            }
        };
        Arc::new(self.from, self.to, &ArcShape { turns, ..shape })
    }

    async fn arc(&mut self, arc: Arc, column: u16) -> Result<(), D::Failure> {
        self.by.curve_may_be(&self.from, &arc.bounds())?;
        let settings = arc_settings(self.by.config());
        if settings.cut() {
            for point in Chords::new(arc, &settings).map_err(|error| self.bad_arc(&error, column))? {
                self.go(point, Curve::Line).await?;
            }
            return Ok(());
        }
        let parts = if self.by.bends() { libm::ceil(PARTS_OF_TURN * arc.turns()) as u32 } else { 1 };
        for (end, curve) in arc.parts(parts) {
            self.go(end, curve).await?;
        }
        Ok(())
    }

    fn bad_arc(&mut self, error: &ArcError, column: u16) -> D::Failure {
        self.by.wrong(message(format_args!("{error}, column {column}")).numbered(Error::Target))
    }

    async fn spline(&mut self, spline: impl ParametricCurve + Copy) -> Result<(), D::Failure> {
        let moves = SplineMoves::new(spline, self.from, self.to);
        self.by.curve_may_be(&self.from, &moves.bounds())?;
        for (end, curve) in moves {
            self.go(end, curve).await?;
        }
        Ok(())
    }
}
