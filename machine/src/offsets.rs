//! Codes that change how coordinates are read: planes, units, coordinate systems, G92, tool offsets.

use gcode::{Block, Code};
use motion::Mode;
use motion::geometry::Plane;
use units::Axis;

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::modal::{COORDINATE_SYSTEMS, PathMode};
use crate::ports::Ports;

impl<P: Ports> Controller<P> {
    /// G17 to G21, G43.1, G43.2, G49, G53 to G59.3, G61, G61.1, G64, G90, G91.
    pub(crate) async fn modal_code(&mut self, code: Code, block: &Block<'_>) -> Outcome {
        match (code.number, code.subcode) {
            (17, 0) => self.modal.plane = Plane::Xy,
            (18, 0) => self.modal.plane = Plane::Xz,
            (19, 0) => self.modal.plane = Plane::Yz,
            (20 | 21, 0) => self.modal.inches = code.number == 20,
            (43, 0) => {}
            (43, subcode) => return self.tool_offset_code(subcode == 2, block).await,
            (49, 0) => self.modal.tool_offset = [0.0; 3],
            (53, 0) if block.is_bare() => self.modal.machine_next = true,
            (53, 0) => return self.machine_move(block).await,
            (54..=59, 0) => self.modal.system = usize::from(code.number - 54),
            (59, subcode @ 1..=3) => self.modal.system = 5 + usize::from(subcode),
            (61, 0) => self.modal.path = PathMode::Exact,
            (61, 1) => self.modal.path = PathMode::ExactStop,
            (64, 0) => return self.round_corners(block),
            (90 | 91, 0) => self.modal.absolute = code.number == 90,
            _ => return Ok(Answer::Unknown),
        }
        Ok(Answer::Ok)
    }

    /// G64: P is how far the rounding of a corner may leave it; without it the junction deviation, which the speed through a sharp
    /// corner is worked out with. Q (merging of lines that are nearly one) has nothing to do here and says so.
    fn round_corners(&mut self, block: &Block<'_>) -> Outcome {
        let usual = self.ports.motion(|motion| motion.config().map(|config| config.limits.junction_deviation));
        let tolerance = match block.get('P') {
            Some(word) => self.modal.to_mm(word),
            None => usual.unwrap_or_default().get(),
        };
        if !(tolerance.is_finite() && tolerance >= 0.0) {
            let text = format_args!("P is a distance, zero or more, column {}", block.column_of('P'));
            return Err(Failure::Refused(message(text)));
        }
        self.modal.path = PathMode::Rounded(tolerance);
        if block.has('Q') {
            self.say(format_args!(
                "// NOTE: Q is not needed, short lines are kept (column {})\n",
                block.column_of('Q')
            ));
        }
        Ok(Answer::Ok)
    }

    /// `G53 X.. Y..`: a move in machine coordinates with the modal motion code, as RS-274 has it.
    async fn machine_move(&mut self, block: &Block<'_>) -> Outcome {
        self.modal.machine_next = true;
        self.motion_words(block).await
    }

    /// G43.1 and G43.2 add to the tool offset; G43.2 also moves by as much.
    async fn tool_offset_code(&mut self, moves: bool, block: &Block<'_>) -> Outcome {
        let mut target = self.position;
        for axis in Axis::PRIMARY {
            let mm = self.modal.to_mm(block.get(axis.letter()).unwrap_or(0.0));
            if let Some(offset) = self.modal.tool_offset.get_mut(axis as usize) {
                *offset += mm;
            }
            target[axis] += mm;
        }
        if moves {
            self.go(target, self.modal.seek_rate, Mode::Rapid).await?;
        }
        Ok(Answer::Ok)
    }

    /// G10 L1, L2 and L20.
    pub(crate) fn set_offsets(&mut self, block: &Block<'_>) -> Outcome {
        match block.get('L') {
            Some(1.0) => return self.set_tool_offset(block),
            Some(2.0 | 20.0) => {}
            _ => return Err(Failure::refused("G10 takes L1, L2 or L20")),
        }
        let here = block.get('L') == Some(20.0);
        let system = match block.get('P').unwrap_or(0.0) {
            0.0 => self.modal.system,
            p if p >= 1.0 && p <= COORDINATE_SYSTEMS as f64 => p as usize - 1,
            _ => return Err(Failure::refused("G10: P selects coordinate system 1 to 9, or 0 for the active one")),
        };
        for axis in Axis::PRIMARY {
            let Some(word) = block.get(axis.letter()) else { continue };
            let mm = self.modal.to_mm(word);
            if here {
                self.modal.set_system_here(system, axis, mm, self.position[axis]);
            } else if let Some(offset) = self.modal.systems.get_mut(system).and_then(|all| all.get_mut(axis as usize)) {
                *offset = if self.modal.absolute { mm } else { *offset + mm };
            }
        }
        Ok(Answer::Ok)
    }

    /// G92 family.
    pub(crate) async fn g92(&mut self, subcode: u8, block: &Block<'_>) -> Outcome {
        match subcode {
            0 if !block.is_bare() => self.set_work_position(block).await,
            0..=2 => {
                self.modal.g92 = [0.0; 3];
                if let Some(tool) = self.tools.active_mut().filter(|_| subcode == 0) {
                    tool.e = 0.0;
                }
                Ok(Answer::Ok)
            }
            3 => {
                for axis in Axis::PRIMARY {
                    if let (Some(mm), Some(g92)) = (block.get(axis.letter()), self.modal.g92.get_mut(axis as usize)) {
                        *g92 = mm;
                    }
                }
                Ok(Answer::Ok)
            }
            _ => self.declare_position(block, false).await,
        }
    }

    async fn set_work_position(&mut self, block: &Block<'_>) -> Outcome {
        for axis in Axis::PRIMARY {
            if let Some(word) = block.get(axis.letter()) {
                let mm = self.modal.to_mm(word);
                self.modal.set_g92(axis, mm, self.position[axis]);
            }
        }
        if let Some(e) = block.get('E') {
            let tool = self.tools.active_mut().ok_or_else(|| Failure::refused("no extruder is configured for E"))?;
            tool.e = e;
        }
        if [Axis::A, Axis::B, Axis::C].into_iter().any(|axis| block.has(axis.letter())) {
            return self.declare_position(block, true).await;
        }
        Ok(Answer::Ok)
    }

    /// Declares machine positions (G92.4), or those of A B C alone (G92 A..).
    pub(crate) async fn declare_position(&mut self, block: &Block<'_>, only_auxiliary: bool) -> Outcome {
        self.wait_idle().await?;
        let mut position = self.position;
        for axis in Axis::ALL.into_iter().filter(|axis| !(only_auxiliary && axis.is_primary())) {
            if let Some(word) = block.get(axis.letter()) {
                position[axis] = if axis.is_primary() { self.modal.to_mm(word) } else { word };
            }
        }
        self.set_machine_position(position)?;
        Ok(Answer::Ok)
    }

    /// Tells the planner where the machine is. Only while idle.
    pub(crate) fn set_machine_position(&mut self, position: units::PerAxis<f64>) -> Result<(), Failure> {
        self.ports
            .motion(|motion| motion.set_position(position))
            .map_err(|refusal| Failure::Refused(crate::failure::message(format_args!("{refusal}"))))?;
        self.position = position;
        Ok(())
    }

    /// M120 and M121.
    pub(crate) fn save_or_restore(&mut self, number: u16) -> Outcome {
        if number == 120 {
            let saved = self.modal.save();
            self.saved.push(saved).map_err(|_| Failure::refused("M120 was used 8 times without M121"))?;
        } else {
            let saved = self.saved.pop().ok_or_else(|| Failure::refused("M121 without M120"))?;
            self.modal.restore(&saved);
        }
        Ok(Answer::Ok)
    }

    /// M3 and M5 also set the modal S value.
    pub(crate) fn power_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        match (number, block.get('S')) {
            (5, _) => self.modal.power = 0.0,
            (_, Some(power)) => self.modal.power = power as f32,
            _ => {}
        }
        Ok(Answer::Ok)
    }
}
