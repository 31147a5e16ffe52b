//! Moves: held against the travel, then given to motion as the executor does, with nobody waiting.

use motion::geometry::{Arc, ArcError, ArcShape, Bezier, Chords, ControlPoint, Line, MOST_POINTS, Nurbs};
use motion::geometry::{ParametricCurve, SplineMoves};
use motion::path::Curve;
use motion::{Mode, Refusal};
use program::{Centre, Move, Rate, Shape};
use units::{Axis, MmPerSecond, PerAxis, Plane};

use super::finding::Kind;
use super::lines::{Reading, Said};
use crate::failure::message;
use crate::motion_config::arc_settings;

/// Parts of a turn on a machine that bends lines.
const PARTS_OF_TURN: f64 = 16.0;

impl Reading<'_, '_> {
    pub(super) async fn movement(&mut self, request: &Move) -> Result<(), Said> {
        let from = self.motion.commanded_position();
        let made = self.draw(request, &from).await;
        if made.is_err() {
            self.preflight.program.take_back();
            return made;
        }
        self.count(&from, request);
        Ok(())
    }

    async fn draw(&mut self, request: &Move, from: &PerAxis<f64>) -> Result<(), Said> {
        self.may_move(request, from)?;
        let mut own = self.in_motions_terms(request);
        let mut last = |length: f64| {
            if let Rate::Duration(seconds) = request.rate {
                own.feed_rate = MmPerSecond(length / seconds);
            }
        };
        match request.shape {
            Shape::Line { names_xy } => {
                last(Line::length(from, &request.target));
                self.stays_within(from, &request.target)?;
                let lines = self.preflight.tuning.lines;
                let line = if names_xy || self.preflight.config.motion.segment_z_moves {
                    Line::cut(*from, request.target, own.feed_rate, &lines)
                } else {
                    Line::whole(*from, request.target)
                };
                for point in line {
                    self.submit(&mut own, point, Curve::Line).await?;
                }
                Ok(())
            }
            Shape::Arc { plane, centre, clockwise, turns, column } => {
                let arc = arc(from, &request.target, plane, centre, clockwise, turns);
                let arc = arc.map_err(|error| self.bad_arc(&error, column))?;
                last(arc.length());
                self.arc(&mut own, arc, from, column).await
            }
            Shape::Cubic([(i, j), (p, q)]) => {
                let ([x, y, ..], [to_x, to_y, ..]) = (from.0, request.target.0);
                let points = [[x, y, 0.0], [x + i, y + j, 0.0], [to_x + p, to_y + q, 0.0], [to_x, to_y, 0.0]];
                self.spline(&mut own, Bezier::cubic(points), from, request).await
            }
            Shape::Quadratic((i, j)) => {
                let ([x, y, ..], [to_x, to_y, ..]) = (from.0, request.target.0);
                let points = [[x, y, 0.0], [x + i, y + j, 0.0], [to_x, to_y, 0.0]];
                self.spline(&mut own, Bezier::quadratic(points), from, request).await
            }
            Shape::Nurbs { order } => {
                let point = |p: &program::ControlPoint| ControlPoint { x: p.x, y: p.y, weight: p.weight };
                let points: heapless::Vec<ControlPoint, MOST_POINTS> =
                    self.preflight.program.control_points().iter().map(point).collect();
                match Nurbs::new(&points, usize::from(order)) {
                    Some(nurbs) => self.spline(&mut own, nurbs, from, request).await,
                    None => {
                        let text = "the spline's order and its control points do not fit";
                        Err(self.say(Kind::Word, message(format_args!("{text}"))))
                    }
                }
            }
        }
    }

    async fn arc(&mut self, own: &mut motion::Move, arc: Arc, from: &PerAxis<f64>, column: u16) -> Result<(), Said> {
        self.curve_stays_within(from, &arc.bounds())?;
        let settings = arc_settings(self.preflight.config);
        if settings.cut() {
            let chords = Chords::new(arc, &settings).map_err(|error| self.bad_arc(&error, column))?;
            for point in chords {
                self.submit(own, point, Curve::Line).await?;
            }
            return Ok(());
        }
        let bends = self.motion.config().is_some_and(|config| !config.kinematics.is_linear());
        let parts = if bends { libm::ceil(PARTS_OF_TURN * arc.turns()) as u32 } else { 1 };
        for (end, curve) in arc.parts(parts) {
            self.submit(own, end, curve).await?;
        }
        Ok(())
    }

    async fn spline(
        &mut self,
        own: &mut motion::Move,
        spline: impl ParametricCurve + Copy,
        from: &PerAxis<f64>,
        request: &Move,
    ) -> Result<(), Said> {
        let moves = SplineMoves::new(spline, *from, request.target);
        self.curve_stays_within(from, &moves.bounds())?;
        for (end, curve) in moves {
            self.submit(own, end, curve).await?;
        }
        Ok(())
    }

    fn bad_arc(&mut self, error: &ArcError, column: u16) -> Said {
        self.say(Kind::Word, message(format_args!("{error}, column {column}")))
    }

    async fn submit(&mut self, own: &mut motion::Move, target: PerAxis<f64>, curve: Curve) -> Result<(), Said> {
        (own.target, own.curve) = (target, curve);
        loop {
            match self.motion.submit(own) {
                Ok(()) => break,
                Err(Refusal::Full | Refusal::Stopping) if self.pass() => self.preflight.turn().await,
                Err(refusal) => {
                    return Err(self.say(Kind::Unreachable, message(format_args!("{refusal}"))));
                }
            }
        }
        self.preflight.moves = true;
        Ok(())
    }

    fn in_motions_terms(&self, request: &Move) -> motion::Move {
        let (feed_rate, mode) = match request.rate {
            Rate::Rapid(speed) => (speed, Mode::Rapid),
            Rate::Feed(speed) => (speed, Mode::Feed),
            Rate::Duration(_) | Rate::PerRevolution(_) => (MmPerSecond(0.0), Mode::Feed),
        };
        let deviation = || self.motion.config().map_or(0.0, |config| config.limits.junction_deviation.get());
        let corner = match request.corner {
            program::Corner::Sharp => motion::Corner::Sharp,
            program::Corner::Stop => motion::Corner::Stop,
            program::Corner::Rounded(within) => motion::Corner::Rounded(within.unwrap_or_else(deviation)),
        };
        let (target, power, tag) = (request.target, request.power, self.preflight.tag());
        motion::Move { target, feed_rate, mode, power, curve: Curve::Line, corner, tag, part: 0 }
    }

    // --- what is wrong with a move ---

    fn may_move(&mut self, request: &Move, from: &PerAxis<f64>) -> Result<(), Said> {
        let preflight = &mut *self.preflight;
        let moves = Axis::PRIMARY.into_iter().any(|axis| request.target[axis] != from[axis]);
        if moves && !preflight.facts().all_homed() {
            if preflight.config.motion.must_be_homed {
                return Err(self.say(Kind::Unreachable, message(format_args!("Must be homed before moving"))));
            }
            if !core::mem::replace(&mut preflight.once.not_homed, true) {
                let text = "it moves before it homes: such moves are not held against the travel";
                self.say(Kind::NotHomed, message(format_args!("{text}")));
            }
        }
        self.look_for_cold(request, from);
        self.look_for_speed(request, from);
        Ok(())
    }

    fn stays_within(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Said> {
        let preflight = &mut *self.preflight;
        let homed = preflight.homed;
        let travel = preflight.travel.up_to_date(preflight.config, &preflight.tuning);
        travel.check(from, to, homed).map_err(|out| self.say(Kind::OutOfTravel, message(format_args!("{out}"))))
    }

    fn curve_stays_within(&mut self, from: &PerAxis<f64>, bounds: &motion::path::Bounds) -> Result<(), Said> {
        let preflight = &mut *self.preflight;
        let homed = preflight.homed;
        let travel = preflight.travel.up_to_date(preflight.config, &preflight.tuning);
        let checked = travel.check_bounds(from, bounds, homed);
        checked.map_err(|out| self.say(Kind::OutOfTravel, message(format_args!("{out}"))))
    }

    /// Filament that a nozzle pushes while its heater has no target.
    fn look_for_cold(&mut self, request: &Move, from: &PerAxis<f64>) {
        let Some(tool) = self.preflight.program.tools().active() else { return };
        let (axis, id) = (tool.settings.axis, tool.settings.id);
        let is_said = self.preflight.once.cold.get(axis as usize).copied().unwrap_or(true);
        if is_said || request.target[axis] <= from[axis] {
            return;
        }
        let config = self.preflight.config;
        let Some((heater, settings)) = config.heaters().find(|(_, heater)| heater.tool_id == id) else { return };
        let is_off = self.preflight.targets.get(heater.index()).is_some_and(|t| *t <= crate::heat::OFF_BELOW);
        if is_off && settings.heater_pin.is_some() {
            if let Some(said) = self.preflight.once.cold.get_mut(axis as usize) {
                *said = true;
            }
            self.say(Kind::Cold, message(format_args!("filament is fed while {} is off", settings.name)));
        }
    }

    /// A speed of an axis, or of the path, above its limit.
    fn look_for_speed(&mut self, request: &Move, from: &PerAxis<f64>) {
        let (Rate::Feed(asked), Shape::Line { .. }) = (request.rate, request.shape) else { return };
        let Some(limits) = self.motion.config().map(|config| config.limits) else { return };
        let length = Line::length(from, &request.target);
        if length <= 0.0 {
            return;
        }
        let axis_limits = limits.axis_speed.into_iter().map(|limit| limit.map(MmPerSecond::get));
        let motors = limits.actuator_rate.0.into_iter().skip(Axis::PRIMARY.len()).map(|rate| Some(rate.get()));
        for (place, (axis, limit)) in Axis::ALL.into_iter().zip(axis_limits.chain(motors)).enumerate() {
            let own = libm::fabs(request.target[axis] - from[axis]) / length * asked.get();
            let Some(limit) = limit.filter(|limit| own > limit * 1.000_001) else { continue };
            let Some(said) = self.preflight.once.speed.get_mut(place) else { continue };
            if !core::mem::replace(said, true) {
                let letter = axis.letter();
                let text = format_args!("{letter} is asked for {own:.1} mm/s and limited to {limit:.1} mm/s");
                self.say(Kind::Speed, message(text));
            }
        }
    }

    /// What the move adds to the totals.
    fn count(&mut self, from: &PerAxis<f64>, request: &Move) {
        let axis = self.preflight.program.tools().active().map(|tool| tool.settings.axis);
        let totals = &mut self.preflight.totals;
        let fed = axis.map_or(0.0, |axis| request.target[axis] - from[axis]);
        let square = |axis: Axis| (request.target[axis] - from[axis]) * (request.target[axis] - from[axis]);
        let length = libm::sqrt(Axis::PRIMARY.into_iter().map(square).sum());
        totals.filament += fed;
        *if fed > 0.0 { &mut totals.printed } else { &mut totals.travelled } += length;
        if fed > 0.0 && length > 0.0 || axis.is_none() {
            let [least, most] = totals.extents.get_or_insert([*from, *from]);
            for axis in Axis::PRIMARY {
                for place in [from[axis], request.target[axis]] {
                    least[axis] = if place < least[axis] { place } else { least[axis] };
                    most[axis] = if place > most[axis] { place } else { most[axis] };
                }
            }
        }
    }
}

fn arc(
    from: &PerAxis<f64>,
    to: &PerAxis<f64>,
    plane: Plane,
    centre: Centre,
    clockwise: bool,
    turns: u32,
) -> Result<Arc, ArcError> {
    let shape = match centre {
        Centre::Radius(radius) => ArcShape::by_radius(from, to, plane, radius, clockwise)?,
        Centre::At(first, second) => {
            ArcShape { plane, to_centre_first: first, to_centre_second: second, clockwise, turns }
        }
    };
    Arc::new(*from, *to, &ArcShape { turns, ..shape })
}
