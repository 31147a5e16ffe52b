//! Modes around a script of the configuration: it begins with the same ones whatever the program has left,
//! and leaves the program's as they were.

use units::{MmPerSecond, Plane};

use crate::interpreter::Interpreter;
use crate::modal::{FeedMode, Modal, MotionMode};

/// The program's modes while a script runs. Offsets and coordinate systems are none of them: a script may be
/// there to set them.
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

    /// A person works at the machine beside the program.
    #[must_use]
    pub fn beside(program: &Interpreter) -> OperatorModes {
        OperatorModes {
            modes: Self::of(&program.modal),
            system: program.modal.system,
            e: program.tools.active().map_or(0.0, |tool| tool.e),
        }
    }

    /// A script begins: in G17, G21, G90 and G94, with E in distances. (`G1 E-5` draws back 5 mm then,
    /// whether the program counts E in places or not; read as a place it would be all the filament that was
    /// fed.)
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

    /// The script has ended.
    pub const fn end(&self, program: &mut Interpreter) {
        let modal = &mut program.modal;
        // A series of holes that the script has ended stays ended.
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

/// The modes, the coordinate system and E of a program while a person works at the machine beside it (M0,
/// M6): what he types is not the program's. Offsets that he sets stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatorModes {
    modes: ScriptModes,
    system: usize,
    e: f64,
}

impl OperatorModes {
    /// The program goes on.
    pub fn end(&self, program: &mut Interpreter) {
        self.modes.end(program);
        program.modal.system = self.system;
        if let Some(tool) = program.tools.active_mut() {
            tool.e = self.e;
        }
    }
}
