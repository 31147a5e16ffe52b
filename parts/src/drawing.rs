//! Converts the program's moves to those of motion: straight lines, arcs and splines.
//!
//! An arc is one move, exact all along. Two kinds of machine get parts of it: a machine whose configuration
//! asks for chords, and a machine whose kinematics bend straight lines, which gets short arcs so that each
//! goes at the speed that its own part of the space allows.
//!
//! Crate `machine` submits the moves; preflight only looks at them.

use core::fmt::Arguments;

use base::own_frame::apart;
use config::MachineConfig;
use motion::geometry::{
    Arc, ArcError, ArcParts, ArcShape, Bezier, Chords, Line, LineSettings, Nurbs, ParametricCurve, SplineMoves,
};
use motion::laser::Power;
use motion::path::{Bounds, Curve};
use motion::{Corner, Mode, Tag};
use program::{Centre, Interpreter, Move, Rate, Shape};
use units::{MmPerSecond, PerAxis, Plane};

/// Parts of a full turn on a machine that bends lines.
const PARTS_OF_TURN: f64 = 16.0;

/// Caller that has moves drawn: supplies settings and judges lines and curves.
pub trait Draws {
    /// Reason why a move is not made.
    type Failure;

    /// Returns the configuration.
    fn config(&self) -> &MachineConfig;
    /// Returns the interpreter, whose arc settings count.
    fn program(&self) -> &Interpreter;
    /// Returns how straight moves are divided into segments.
    fn line_settings(&self) -> LineSettings;
    /// Returns whether the kinematics bend straight lines.
    fn bends(&mut self) -> bool;

    /// Makes the failure for a move that cannot be drawn.
    fn wrong(&mut self, what: Arguments<'_>) -> Self::Failure;
    /// Checks that a line may be made.
    fn line_may_be(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Self::Failure>;
    /// Checks that a curve within these bounds may be made.
    fn curve_may_be(&mut self, from: &PerAxis<f64>, bounds: &Bounds) -> Result<(), Self::Failure>;
}

/// Converts a move of the program to motion's terms, without its curve, and of no object. `deviation` is the
/// greatest distance of a rounded corner where the program does not say, mm; `factors` are M220's; `power` is
/// a laser's, which a rapid has not.
pub fn in_motions_terms(
    request: &Move,
    tag: Tag,
    [feed, rapid]: [f64; 2],
    power: Power,
    deviation: impl FnOnce() -> f64,
) -> motion::Move {
    let (feed_rate, mode) = match request.rate {
        Rate::Rapid(speed) => (speed * rapid, Mode::Rapid),
        Rate::Feed(speed) => (speed * feed, Mode::Feed),
        // No speed, and so nobody takes it, until the length of its way is known: see `last`.
        // Nor what follows the spindle: the program refuses it before.
        Rate::Duration(_) | Rate::PerRevolution(_) => (MmPerSecond(0.0), Mode::Feed),
    };
    let corner = match request.corner {
        program::Corner::Sharp => Corner::Sharp,
        program::Corner::Stop => Corner::Stop,
        program::Corner::Rounded(within) => Corner::Rounded(within.unwrap_or_else(deviation)),
    };
    let power = if mode == Mode::Rapid { Power::OFF } else { power };
    let (target, curve) = (request.target, Curve::Line);
    motion::Move { target, feed_rate, mode, power, curve, corner, tag, part: 0 }
}

/// Draws a move of the program from `from`; `piece` is the move in motion's terms. The pieces are to be made
/// one after the other.
///
/// # Errors
/// When no such curve exists, or the move may not be made; then no piece of it is.
pub fn draw<D: Draws>(
    by: &mut D,
    from: PerAxis<f64>,
    request: &Move,
    piece: motion::Move,
) -> Result<Drawn, D::Failure> {
    let mut drawing = Drawing { by, from, to: request.target, piece };
    let shape = match request.shape {
        Shape::Line { names_xy } => {
            drawing.last(request.rate, Line::length(&from, &request.target));
            drawing.line(names_xy)
        }
        Shape::Arc { plane, centre, clockwise, turns, column } => {
            let arc = drawing.arc_of(plane, centre, clockwise, turns);
            let arc = arc.map_err(|error| drawing.bad_arc(&error, column))?;
            drawing.last(request.rate, arc.length());
            drawing.arc(arc, column)
        }
        Shape::Cubic([(i, j), (p, q)]) => {
            let ([x, y, ..], [to_x, to_y, ..]) = (from.0, request.target.0);
            let points = [[x, y, 0.0], [x + i, y + j, 0.0], [to_x + p, to_y + q, 0.0], [to_x, to_y, 0.0]];
            apart(|| drawing.spline(Bezier::cubic(points)).map(Pieces::Bezier))
        }
        Shape::Quadratic((i, j)) => {
            let ([x, y, ..], [to_x, to_y, ..]) = (from.0, request.target.0);
            let points = [[x, y, 0.0], [x + i, y + j, 0.0], [to_x, to_y, 0.0]];
            apart(|| drawing.spline(Bezier::quadratic(points)).map(Pieces::Bezier))
        }
        Shape::Nurbs { order } => apart(|| {
            let Some(nurbs) = Nurbs::new(drawing.by.program().control_points(), usize::from(order)) else {
                let text = "the spline's order and its control points do not fit";
                return Err(drawing.by.wrong(format_args!("{text}")));
            };
            drawing.spline(nurbs).map(Pieces::Nurbs)
        }),
    };
    Ok(Drawn { pieces: shape?, piece: drawing.piece })
}

/// Moves of motion that make up a move of the program.
pub struct Drawn {
    pieces: Pieces,
    /// Common part of all pieces.
    piece: motion::Move,
}

#[expect(clippy::large_enum_variant, reason = "there is one at a time, where it is used up")]
enum Pieces {
    Line(Line),
    Chords(Chords),
    Arc(ArcParts),
    Bezier(SplineMoves<Bezier>),
    Nurbs(SplineMoves<Nurbs>),
}

impl Iterator for Drawn {
    type Item = motion::Move;

    fn next(&mut self) -> Option<motion::Move> {
        let straight = |target| (target, Curve::Line);
        let (target, curve) = match &mut self.pieces {
            Pieces::Line(line) => line.next().map(straight),
            Pieces::Chords(chords) => chords.next().map(straight),
            Pieces::Arc(parts) => parts.next(),
            Pieces::Bezier(moves) => moves.next(),
            Pieces::Nurbs(moves) => moves.next(),
        }?;
        Some(motion::Move { target, curve, ..self.piece })
    }
}

/// A move being drawn.
struct Drawing<'d, D> {
    by: &'d mut D,
    from: PerAxis<f64>,
    to: PerAxis<f64>,
    piece: motion::Move,
}

impl<D: Draws> Drawing<'_, D> {
    /// Sets the feed rate so that a path of this length, mm, takes as long as the program says (G93).
    fn last(&mut self, rate: Rate, length: f64) {
        if let Rate::Duration(seconds) = rate {
            self.piece.feed_rate = MmPerSecond(length / seconds);
        }
    }

    fn line(&mut self, names_xy: bool) -> Result<Pieces, D::Failure> {
        self.by.line_may_be(&self.from, &self.to)?;
        let lines = self.by.line_settings();
        Ok(Pieces::Line(if names_xy || self.by.config().motion.segment_z_moves {
            Line::cut(self.from, self.to, self.piece.feed_rate, &lines)
        } else {
            Line::whole(self.from, self.to)
        }))
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

    fn arc(&mut self, arc: Arc, column: u16) -> Result<Pieces, D::Failure> {
        self.by.curve_may_be(&self.from, &arc.bounds())?;
        let settings = self.by.config().motion.arcs;
        if settings.cut() {
            let chords = Chords::new(arc, &settings).map_err(|error| self.bad_arc(&error, column))?;
            return Ok(Pieces::Chords(chords));
        }
        let parts = if self.by.bends() { libm::ceil(PARTS_OF_TURN * arc.turns()) as u32 } else { 1 };
        Ok(Pieces::Arc(arc.parts(parts)))
    }

    fn bad_arc(&mut self, error: &ArcError, column: u16) -> D::Failure {
        self.by.wrong(format_args!("{error}, column {column}"))
    }

    fn spline<S: ParametricCurve + Copy>(&mut self, spline: S) -> Result<SplineMoves<S>, D::Failure> {
        let moves = SplineMoves::new(spline, self.from, self.to);
        self.by.curve_may_be(&self.from, &moves.bounds())?;
        Ok(moves)
    }
}
