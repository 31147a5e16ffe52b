//! Modes around a script of the configuration: scripts begin with fixed modes, regardless of the program's,
//! and leave the program's modes unchanged.

use units::{MmPerSecond, Plane};

use crate::interpreter::Interpreter;
use crate::resume;
use crate::state::modal::{FeedMode, Modal, MotionMode};

/// Modes of the program while a script runs. Offsets and coordinate systems are not included, because a
/// script may be there to set them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScriptModes {
    motion: MotionMode,
    plane: Plane,
    feed_mode: FeedMode,
    inches: bool,
    diameters: bool,
    absolute: bool,
    arc_absolute: bool,
    e_absolute: bool,
    e_places: bool,
    feed_rate: MmPerSecond,
    seek_rate: MmPerSecond,
}

impl ScriptModes {
    const fn of(modal: &Modal) -> Self {
        Self {
            motion: modal.motion,
            plane: modal.plane,
            feed_mode: modal.feed_mode,
            inches: modal.inches,
            diameters: modal.diameters,
            absolute: modal.absolute,
            arc_absolute: modal.arc_absolute,
            e_absolute: modal.e_absolute,
            e_places: modal.e_places,
            feed_rate: modal.feed_rate,
            seek_rate: modal.seek_rate,
        }
    }

    /// Saves the modes while a person works at the machine beside the program.
    #[must_use]
    pub fn beside(program: &Interpreter) -> OperatorModes {
        OperatorModes {
            modes: Self::of(&program.modal),
            system: program.modal.system,
            tool: program.tools.active,
            e: program.tools.active().map_or(0.0, |tool| tool.e),
        }
    }

    /// Begins a script: in G17, G21, G90 and G94, with relative E. (`G1 E-5` then draws back 5 mm, whether
    /// the program's E is absolute or not; as an absolute position, -5 would draw back all filament fed so
    /// far.)
    pub const fn begin(program: &mut Interpreter) -> Self {
        let modal = &mut program.modal;
        let modes = Self::of(modal);
        modal.plane = Plane::Xy;
        modal.feed_mode = FeedMode::PerMinute;
        (modal.inches, modal.diameters) = (false, false);
        (modal.absolute, modal.arc_absolute) = (true, false);
        (modal.e_absolute, modal.e_places) = (false, false);
        modes
    }

    /// Ends the script and restores the program's modes.
    pub const fn end(&self, program: &mut Interpreter) {
        let modal = &mut program.modal;
        // A series of holes ended by the script stays ended.
        if !matches!(self.motion, MotionMode::Cycle | MotionMode::Synchronised | MotionMode::Threading) {
            modal.motion = self.motion;
        }
        modal.plane = self.plane;
        modal.feed_mode = self.feed_mode;
        (modal.inches, modal.diameters) = (self.inches, self.diameters);
        (modal.absolute, modal.arc_absolute) = (self.absolute, self.arc_absolute);
        (modal.e_absolute, modal.e_places) = (self.e_absolute, self.e_places);
        (modal.feed_rate, modal.seek_rate) = (self.feed_rate, self.seek_rate);
    }
}

/// Modes, coordinate system, extruder and E of a program while a person works at the machine beside it (M0,
/// M6): modes set at the console do not affect the program, but offsets set there stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatorModes {
    modes: ScriptModes,
    system: usize,
    tool: usize,
    e: f64,
}

impl OperatorModes {
    /// Restores the program's modes, because the program goes on.
    pub fn end(&self, program: &mut Interpreter) {
        self.modes.end(program);
        program.modal.system = self.system;
        resume::take_up(program, self.tool);
        if let Some(tool) = program.tools.active_mut() {
            tool.e = self.e;
        }
    }
}
