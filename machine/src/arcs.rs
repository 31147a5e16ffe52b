//! G2 and G3: from words to arcs in machine space.
//!
//! An arc is one move, exact all along. Two kinds of machine see it in parts: one whose configuration asks for chords, and one whose
//! motors bend lines, which gets short arcs so that each goes at the speed its own part of the space allows.

use gcode::Block;
use motion::Mode;
use motion::geometry::{Arc, ArcError, ArcShape, Chords, MOST_TURNS};
use units::{Axis, PerAxis};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::motion_config::arc_settings;
use crate::ports::Ports;

/// Parts of a turn on a machine that bends lines.
const PARTS_OF_TURN: f64 = 16.0;

/// The word of the centre's distance along an axis.
const fn centre_word(axis: Axis) -> char {
    match axis {
        Axis::X => 'I',
        Axis::Y => 'J',
        _ => 'K',
    }
}

impl<P: Ports> Controller<P> {
    /// An arc to `target`.
    pub(crate) async fn arc(&mut self, block: &Block<'_>, target: PerAxis<f64>, clockwise: bool) -> Outcome {
        let shape = self.arc_shape(block, &target, clockwise)?;
        let (first, _) = shape.plane.axes();
        let word = if block.has('R') { 'R' } else { centre_word(first) };
        let arc = Arc::new(self.position, target, &shape).map_err(|error| bad_arc(block, word, &error))?;
        let (rate, settings) = (self.modal.feed_rate, arc_settings(&self.config));
        if settings.cut() {
            let chords = Chords::new(arc, &settings).map_err(|error| bad_arc(block, word, &error))?;
            for point in chords {
                self.go(point, rate, Mode::Feed).await?;
            }
        } else {
            let bends =
                self.ports.motion(|motion| motion.config().is_some_and(|config| !config.kinematics.is_linear()));
            let parts = if bends { libm::ceil(PARTS_OF_TURN * arc.turns()) as u32 } else { 1 };
            for (end, curve) in arc.parts(parts) {
                self.go_along(curve, end, rate, Mode::Feed).await?;
            }
        }
        self.tools.moved(block.has('Z'));
        Ok(Answer::Ok)
    }

    /// I J K (from the start) or R, and P.
    fn arc_shape(&self, block: &Block<'_>, target: &PerAxis<f64>, clockwise: bool) -> Result<ArcShape, Failure> {
        let plane = self.modal.plane;
        let (first, second) = plane.axes();
        let shape = match block.get('R') {
            Some(radius) => ArcShape::by_radius(&self.position, target, plane, self.modal.to_mm(radius), clockwise)
                .map_err(|error| bad_arc(block, 'R', &error))?,
            None => {
                let centre = |axis: Axis| self.modal.to_mm(block.get(centre_word(axis)).unwrap_or(0.0));
                ArcShape {
                    plane,
                    to_centre_first: centre(first),
                    to_centre_second: centre(second),
                    clockwise,
                    turns: 1,
                }
            }
        };
        let turns = block.get('P').unwrap_or(1.0);
        if !(turns >= 1.0 && turns <= f64::from(MOST_TURNS) && libm::floor(turns) == turns) {
            let text =
                format_args!("P is the number of turns, a whole number above zero, column {}", block.column_of('P'));
            return Err(Failure::Alarm(message(text)));
        }
        Ok(ArcShape { turns: turns as u32, ..shape })
    }
}

fn bad_arc(block: &Block<'_>, word: char, error: &ArcError) -> Failure {
    Failure::Alarm(message(format_args!("{error}, column {}", block.column_of(word))))
}
