//! From the program's moves to those of motion: straight, arcs and splines.
//!
//! An arc is one move, exact all along. Two kinds of machine see it in parts: one whose configuration asks
//! for chords, and one whose motors bend lines, which gets short arcs so that each goes at the speed its own
//! part of the space allows.

use motion::geometry::{
    Arc, ArcError, ArcShape, Bezier, Chords, ControlPoint, Line, Nurbs, ParametricCurve, SplineMoves,
};
use motion::path::Curve;
use motion::{Corner, Mode};
use program::{Centre, Move, Rate, Shape, State};
use units::{MmPerSecond, PerAxis, Plane};

use super::Machine;
use crate::failure::{Failure, message};
use crate::grbl::numbers::Error;
use crate::motion_config::arc_settings;
use crate::ports::Ports;
use crate::safety::Event;

/// Parts of a turn on a machine that bends lines.
const PARTS_OF_TURN: f64 = 16.0;

/// What every piece of a move has in common.
#[derive(Clone, Copy)]
struct Common {
    request: motion::Move,
    from: PerAxis<f64>,
    to: PerAxis<f64>,
}

impl Common {
    /// A way of this length, mm, takes as long as the program says (G93).
    fn last(&mut self, rate: Rate, length: f64) {
        if let Rate::Duration(seconds) = rate {
            self.request.feed_rate = MmPerSecond(length / seconds);
        }
    }

    async fn go<P: Ports>(
        &mut self,
        machine: &mut Machine<'_, P>,
        target: PerAxis<f64>,
        curve: Curve,
    ) -> Result<(), Failure> {
        self.request.target = target;
        self.request.curve = curve;
        machine.submit(&self.request).await
    }
}

/// What motion is to know of a move of the program, without its curve.
pub(super) fn in_motions_terms<P: Ports>(machine: &mut Machine<'_, P>, request: &Move) -> motion::Move {
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
        program::Corner::Rounded(Some(within)) => Corner::Rounded(within),
        program::Corner::Rounded(None) => Corner::Rounded(
            machine.ports.motion(|motion| motion.config().map_or(0.0, |config| config.limits.junction_deviation.get())),
        ),
    };
    motion::Move {
        target: request.target,
        feed_rate,
        mode,
        power: request.power,
        curve: Curve::Line,
        corner,
        tag: machine.tag,
        part: machine.jobs.objects.part(),
    }
}

/// Submits the commonest move of all: straight, whole, while the look-ahead queue has room. False: nothing
/// has been done, and [`submit`] does it, or says why not.
pub(super) fn take_at_once<P: Ports>(machine: &mut Machine<'_, P>, request: &Move) -> bool {
    let is_whole = matches!(request.shape, Shape::Line { .. }) && !machine.tuning.lines.cut();
    let is_whole = is_whole && !program::objects::is_apart(&machine.program) && !machine.cut.brakes;
    let is_free = machine.safety.state() != State::Check && machine.axes.are_enabled();
    if !is_whole || !is_free || machine.may_move().is_err() || !machine.reaches(&request.target) {
        return false;
    }
    let own = in_motions_terms(machine, request);
    let is_taken = machine.ports.motion(|motion| motion.submit(&own)).is_ok();
    if is_taken {
        machine.safety.apply(Event::Started);
    }
    is_taken
}

/// Submits a move of the program.
pub(super) async fn submit<P: Ports>(machine: &mut Machine<'_, P>, request: &Move) -> Result<(), Failure> {
    let from = machine.ports.motion(|motion| motion.commanded_position());
    let own = in_motions_terms(machine, request);
    let mut common = Common { request: own, from, to: request.target };
    match request.shape {
        Shape::Line { names_xy } => {
            common.last(request.rate, Line::length(&common.from, &common.to));
            line(machine, &mut common, names_xy).await
        }
        Shape::Arc { plane, centre, clockwise, turns, column } => {
            let arc = arc(&common, plane, centre, clockwise, turns);
            let arc = arc.map_err(|error| bad_arc(column, &error))?;
            common.last(request.rate, arc.length());
            draw_arc(machine, &mut common, arc, column).await
        }
        Shape::Cubic([(i, j), (p, q)]) => {
            let ([x, y, ..], [to_x, to_y, ..]) = (from.0, request.target.0);
            let points = [[x, y, 0.0], [x + i, y + j, 0.0], [to_x + p, to_y + q, 0.0], [to_x, to_y, 0.0]];
            draw(machine, &mut common, Bezier::cubic(points)).await
        }
        Shape::Quadratic((i, j)) => {
            let ([x, y, ..], [to_x, to_y, ..]) = (from.0, request.target.0);
            draw(machine, &mut common, Bezier::quadratic([[x, y, 0.0], [x + i, y + j, 0.0], [to_x, to_y, 0.0]])).await
        }
        Shape::Nurbs { order } => {
            let point = |p: &program::ControlPoint| ControlPoint { x: p.x, y: p.y, weight: p.weight };
            let points: heapless::Vec<ControlPoint, { motion::geometry::MOST_POINTS }> =
                machine.program.control_points().iter().map(point).collect();
            let nurbs = Nurbs::new(&points, usize::from(order));
            let nurbs = nurbs.ok_or_else(|| Failure::alarm("the spline's order and its control points do not fit"))?;
            draw(machine, &mut common, nurbs).await
        }
    }
}

async fn line<P: Ports>(machine: &mut Machine<'_, P>, common: &mut Common, names_xy: bool) -> Result<(), Failure> {
    machine.stays_within(&common.from, &common.to)?;
    let lines = machine.tuning.lines;
    let line = if names_xy || machine.config.motion.segment_z_moves {
        Line::cut(common.from, common.to, common.request.feed_rate, &lines)
    } else {
        Line::whole(common.from, common.to)
    };
    for point in line {
        common.go(machine, point, Curve::Line).await?;
    }
    Ok(())
}

fn arc(common: &Common, plane: Plane, centre: Centre, clockwise: bool, turns: u32) -> Result<Arc, ArcError> {
    let shape = match centre {
        Centre::Radius(radius) => ArcShape::by_radius(&common.from, &common.to, plane, radius, clockwise)?,
        Centre::At(first, second) => {
            ArcShape { plane, to_centre_first: first, to_centre_second: second, clockwise, turns }
        }
    };
    Arc::new(common.from, common.to, &ArcShape { turns, ..shape })
}

async fn draw_arc<P: Ports>(
    machine: &mut Machine<'_, P>,
    common: &mut Common,
    arc: Arc,
    column: u16,
) -> Result<(), Failure> {
    machine.curve_stays_within(&common.from, &arc.bounds())?;
    let settings = arc_settings(machine.config);
    if settings.cut() {
        for point in Chords::new(arc, &settings).map_err(|error| bad_arc(column, &error))? {
            common.go(machine, point, Curve::Line).await?;
        }
        return Ok(());
    }
    let bends = machine.ports.motion(|motion| motion.config().is_some_and(|config| !config.kinematics.is_linear()));
    let parts = if bends { libm::ceil(PARTS_OF_TURN * arc.turns()) as u32 } else { 1 };
    for (end, curve) in arc.parts(parts) {
        common.go(machine, end, curve).await?;
    }
    Ok(())
}

fn bad_arc(column: u16, error: &ArcError) -> Failure {
    Failure::Alarm(message(format_args!("{error}, column {column}")).numbered(Error::Target))
}

async fn draw<P: Ports>(
    machine: &mut Machine<'_, P>,
    common: &mut Common,
    spline: impl ParametricCurve + Copy,
) -> Result<(), Failure> {
    let moves = SplineMoves::new(spline, common.from, common.to);
    machine.curve_stays_within(&common.from, &moves.bounds())?;
    for (end, curve) in moves {
        common.go(machine, end, curve).await?;
    }
    Ok(())
}
