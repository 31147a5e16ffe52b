//! G0, G1 and G4, and what all motion codes share: from words to places in machine space.

use units::{Axis, Micros, MmPerSecond, PerAxis};

use crate::action::{Action, Move, Rate, Shape};
use crate::fault::{Fault, Part, Problem};
use crate::interpreter::{Context, Interpreter, Meaning, NOTHING};
use crate::modal::MotionMode;
use crate::words::Words;

/// Longest dwell, s: a day.
const LONGEST_DWELL: f64 = 86_400.0;

impl Interpreter {
    /// G0 to G3, G5 to G5.2, and words without a code.
    pub(crate) fn motion<'b>(&mut self, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        let code = context.words.code();
        if let Some(mode) = MotionMode::from_g(code.number, code.subcode) {
            self.modal.motion = mode;
        }
        let done = self.motion_block(&context.words);
        self.modal.machine_next = false;
        done
    }

    /// A move by the motion code in force.
    pub(crate) fn motion_block<'b>(&mut self, words: &Words<'b>) -> Result<Meaning<'b>, Fault> {
        self.take_rates(words)?;
        let mode = self.modal.motion;
        self.begin_motion(mode, words.column())?;
        if mode == MotionMode::Nurbs {
            return self.control_point(words);
        }
        let (target, e) = self.target_of(words)?;
        let shape = match mode {
            MotionMode::Rapid | MotionMode::Linear => Shape::Line { names_xy: words.has('X') || words.has('Y') },
            MotionMode::Cubic => self.cubic(words)?,
            MotionMode::Quadratic => self.quadratic(words)?,
            MotionMode::ArcClockwise => self.arc(words, true)?,
            MotionMode::ArcCounterClockwise => self.arc(words, false)?,
            MotionMode::Nurbs => return NOTHING,
        };
        if let (Some(e), Some(tool)) = (e, self.tools.active_mut()) {
            tool.e = e;
        }
        if matches!(shape, Shape::Line { .. }) && target == self.position {
            return NOTHING;
        }
        Ok(Meaning::Action(self.draw(target, shape, words.has('Z'))))
    }

    /// The move there, which the program has then made.
    pub(crate) fn draw<'b>(&mut self, target: PerAxis<f64>, shape: Shape, names_z: bool) -> Action<'b> {
        let rate = match self.modal.motion {
            MotionMode::Rapid => Rate::Rapid(self.modal.seek_rate),
            _ => Rate::Feed(self.modal.feed_rate),
        };
        self.position = target;
        self.tools.moved(names_z);
        Action::Move(Move { target, shape, rate, power: self.modal.power, corner: self.modal.corner })
    }

    /// A rapid move in a straight line, which the program has then made.
    pub(crate) fn rapid_to<'b>(&mut self, target: PerAxis<f64>) -> Action<'b> {
        self.position = target;
        let rate = Rate::Rapid(self.modal.seek_rate);
        let shape = Shape::Line { names_xy: true };
        Action::Move(Move { target, shape, rate, power: self.modal.power, corner: self.modal.corner })
    }

    /// F and S words.
    fn take_rates(&mut self, words: &Words<'_>) -> Result<(), Fault> {
        if let Some(power) = words.number('S') {
            self.modal.power = power as f32;
        }
        let Some(rate) = words.feed('F') else { return Ok(()) };
        if rate < 0.0 {
            return Err(Problem::NegativeFeedRate.alarm(words.column_of('F')));
        }
        if self.modal.motion == MotionMode::Rapid && !self.compliant_seek_rate {
            self.modal.seek_rate = MmPerSecond(rate);
        } else {
            self.modal.feed_rate = MmPerSecond(rate);
        }
        Ok(())
    }

    /// Where a motion block leads, in machine space, and where E then is.
    fn target_of(&self, words: &Words<'_>) -> Result<(PerAxis<f64>, Option<f64>), Fault> {
        let mut target = self.position;
        for axis in Axis::PRIMARY {
            if let Some(mm) = words.length(axis.letter()) {
                target[axis] = self.modal.machine(axis, mm, self.position[axis]);
            }
        }
        for axis in [Axis::A, Axis::B, Axis::C] {
            let Some(word) = words.number(axis.letter()) else { continue };
            if self.tools.uses(axis) {
                return Err(Problem::ExtruderAxis(axis).refused(words.column_of(axis.letter())));
            }
            target[axis] = if self.modal.absolute { word } else { target[axis] + word };
        }
        let Some(word) = words.number('E') else { return Ok((target, None)) };
        let tool = self.tools.active().ok_or(Problem::NoExtruder.refused(words.column_of('E')))?;
        if tool.settings.is_off {
            return Err(Problem::PartIsOff(Part::Extruder(tool.settings.id)).refused(words.column_of('E')));
        }
        let to = if self.modal.e_absolute { word } else { tool.e + word };
        target[tool.settings.axis] += (to - tool.e) * tool.scale();
        Ok((target, Some(to)))
    }

    /// G4: P in the dialect's unit, S in seconds; both add.
    pub(crate) fn dwell<'b>(&mut self, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        let words = &context.words;
        let unit = context.dialect.dwell_unit();
        let seconds = words.get('P').unwrap_or(0.0) * unit + words.get('S').unwrap_or(0.0);
        if !(0.0..=LONGEST_DWELL).contains(&seconds) {
            return Err(Problem::DwellRange.refused(words.column()));
        }
        Ok(Meaning::Action(Action::Dwell(Micros((seconds * 1e6) as u64))))
    }

    /// M3 and M5: the S of moves that follow.
    pub(crate) fn power<'b>(&mut self, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        match (context.words.code().number, context.words.get('S')) {
            (5, _) => self.modal.power = 0.0,
            (_, Some(power)) => self.modal.power = power as f32,
            _ => {}
        }
        NOTHING
    }
}
