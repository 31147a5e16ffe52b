//! G0, G1 and G4, and what all motion codes share: from words to moves in machine space.

use gcode::{Block, Code};
use motion::geometry::Line;
use motion::path::Curve;
use motion::{Mode, Move, Refusal};
use units::{Axis, Micros, MmPerSecond, PerAxis};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::modal::MotionMode;
use crate::motion_config::line_settings;
use crate::ports::Ports;
use crate::state::Event;

impl<P: Ports> Controller<P> {
    /// G0 to G3, G5 to G5.2.
    pub(crate) async fn motion_code(&mut self, code: Code, block: &Block<'_>) -> Outcome {
        if let Some(mode) = MotionMode::from_g(code.number, code.subcode) {
            self.modal.motion = mode;
        }
        let done = self.motion_block(block).await;
        self.modal.machine_next = false;
        done
    }

    /// Words without a code: the last motion code goes on.
    pub(crate) async fn motion_words(&mut self, block: &Block<'_>) -> Outcome {
        self.motion_code(self.modal.motion.code(), block).await
    }

    async fn motion_block(&mut self, block: &Block<'_>) -> Outcome {
        self.take_rates(block)?;
        let mode = self.modal.motion;
        self.spline_state(mode, block)?;
        if mode == MotionMode::Nurbs {
            return self.control_point(block);
        }
        let target = self.target_of(block)?;
        let is_line = matches!(mode, MotionMode::Rapid | MotionMode::Linear);
        if target == self.position && is_line {
            return Ok(Answer::Ok);
        }
        if self.config.motion.must_be_homed && !self.all_homed() {
            return Err(Failure::alarm("Must be homed before moving"));
        }
        match mode {
            MotionMode::Rapid | MotionMode::Linear => self.line(block, target, mode).await,
            MotionMode::Cubic => self.cubic(block, target).await,
            MotionMode::Quadratic => self.quadratic(block, target).await,
            _ => self.arc(block, target, mode == MotionMode::ArcClockwise).await,
        }
    }

    async fn line(&mut self, block: &Block<'_>, target: PerAxis<f64>, mode: MotionMode) -> Outcome {
        let (rate, kind) = match mode {
            MotionMode::Rapid => (self.modal.seek_rate, Mode::Rapid),
            _ => (self.modal.feed_rate, Mode::Feed),
        };
        let names_xy = block.has('X') || block.has('Y');
        let line = if names_xy || self.config.motion.segment_z_moves {
            Line::cut(self.position, target, rate, &line_settings(&self.config))
        } else {
            Line::whole(self.position, target)
        };
        for point in line {
            self.go(point, rate, kind).await?;
        }
        self.tools.moved(block.has('Z'));
        Ok(Answer::Ok)
    }

    /// F and S words.
    pub(crate) fn take_rates(&mut self, block: &Block<'_>) -> Result<(), Failure> {
        if let Some(power) = block.get('S') {
            self.modal.power = power as f32;
        }
        let Some(per_minute) = block.get('F') else { return Ok(()) };
        if per_minute < 0.0 {
            return Err(Failure::alarm("feed rate < 0"));
        }
        let rate = MmPerSecond::from_per_minute(self.modal.to_mm(per_minute));
        if self.modal.motion == MotionMode::Rapid && !self.config.motion.compliant_seek_rate {
            self.modal.seek_rate = rate;
        } else {
            self.modal.feed_rate = rate;
        }
        Ok(())
    }

    /// Where a motion block leads, in machine space. The E position of the tool is moved on.
    pub(crate) fn target_of(&mut self, block: &Block<'_>) -> Result<PerAxis<f64>, Failure> {
        let mut target = self.position;
        for axis in Axis::PRIMARY {
            if let Some(word) = block.get(axis.letter()) {
                target[axis] = self.modal.machine(axis, word, self.position[axis]);
            }
        }
        for axis in [Axis::A, Axis::B, Axis::C] {
            let Some(word) = block.get(axis.letter()) else { continue };
            if self.tools.uses(axis) {
                let text = format_args!("axis {} is an extruder: use E", axis.letter());
                return Err(Failure::Refused(message(text)));
            }
            target[axis] = if self.modal.absolute { word } else { target[axis] + word };
        }
        if let Some(word) = block.get('E') {
            if let Some(tool) = self.tools.active() {
                self.needs("extruder", &tool.settings.name)?;
            }
            let absolute = self.modal.e_absolute;
            let tool = self.tools.active_mut().ok_or_else(|| Failure::refused("no extruder is configured for E"))?;
            let to = if absolute { word } else { tool.e + word };
            target[tool.axis] += (to - tool.e) * tool.scale();
            tool.e = to;
        }
        Ok(target)
    }

    /// Submits one straight move, waiting while the look-ahead queue is full.
    pub(crate) async fn go(&mut self, target: PerAxis<f64>, rate: MmPerSecond, mode: Mode) -> Result<(), Failure> {
        self.go_along(Curve::Line, target, rate, mode).await
    }

    /// Submits one move along a curve, waiting while the look-ahead queue is full.
    pub(crate) async fn go_along(
        &mut self,
        curve: Curve,
        target: PerAxis<f64>,
        rate: MmPerSecond,
        mode: Mode,
    ) -> Result<(), Failure> {
        self.enable_motors()?;
        let (power, corner) = (self.modal.power, self.modal.path.corner());
        let request = Move { target, feed_rate: rate, mode, power, curve, corner, tag: motion::Tag::NONE };
        loop {
            match self.ports.motion(|motion| motion.submit(&request)) {
                Ok(()) => break,
                Err(Refusal::Full | Refusal::Stopping) => self.pause().await?,
                Err(Refusal::NoFeedRate) => return Err(Failure::alarm("Undefined feed rate")),
                Err(refusal @ Refusal::Unreachable) if !self.halts_out_of_reach() => {
                    return Err(Failure::Refused(message(format_args!("{refusal}"))));
                }
                Err(refusal) => return Err(Failure::Alarm(message(format_args!("{refusal}")))),
            }
        }
        self.position = target;
        self.apply(Event::Started);
        Ok(())
    }

    /// G4: P seconds in GRBL mode, milliseconds otherwise; S seconds; both add.
    pub(crate) async fn dwell_code(&mut self, block: &Block<'_>) -> Outcome {
        let p_seconds = if self.config.general.grbl_mode { 1.0 } else { 1e-3 };
        let seconds = block.get('P').unwrap_or(0.0) * p_seconds + block.get('S').unwrap_or(0.0);
        if !(0.0..=86_400.0).contains(&seconds) {
            return Err(Failure::refused("a dwell lasts 0 to 86400 seconds"));
        }
        self.dwell(Micros((seconds * 1e6) as u64)).await?;
        Ok(Answer::Ok)
    }
}
