//! What M70 saves and M72 restores: the modes, one set for each subroutine that runs (LinuxCNC, "M70 Save
//! Modal State"). After M73 they come back by themselves when it ends.

use heapless::Vec;
use units::{MmPerSecond, Plane};

use crate::action::Corner;
use crate::auxiliary::Auxiliary;
use crate::cycle::Retract;
use crate::modal::{FeedMode, Modal};

/// The main program, and every subroutine that can be called.
const MOST: usize = crate::flow::MOST_CALLS + 1;

/// Modes as they were. Motion codes are none of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SavedModes {
    plane: Plane,
    corner: Corner,
    feed_mode: FeedMode,
    retract: Retract,
    arc_absolute: bool,
    inches: bool,
    diameters: bool,
    absolute: bool,
    e_absolute: bool,
    feed_rate: MmPerSecond,
    power: f32,
    system: usize,
    tool_offset: [f64; 3],
    has_tool_length: bool,
    pub(crate) auxiliary: Auxiliary,
}

impl SavedModes {
    fn of(modal: &Modal) -> Self {
        Self {
            plane: modal.plane,
            corner: modal.corner,
            feed_mode: modal.feed_mode,
            retract: modal.retract,
            arc_absolute: modal.arc_absolute,
            inches: modal.inches,
            diameters: modal.diameters,
            absolute: modal.absolute,
            e_absolute: modal.e_absolute,
            feed_rate: modal.feed_rate,
            power: modal.power,
            system: modal.system,
            tool_offset: modal.own_tool_offset(),
            has_tool_length: modal.has_tool_length,
            auxiliary: modal.auxiliary,
        }
    }

    /// The modes are these again. What turns and flows stays in `modal` as it is: it is not only a mode.
    pub(crate) fn restore(&self, modal: &mut Modal) {
        modal.plane = self.plane;
        modal.corner = self.corner;
        modal.feed_mode = self.feed_mode;
        modal.retract = self.retract;
        modal.arc_absolute = self.arc_absolute;
        modal.inches = self.inches;
        modal.diameters = self.diameters;
        modal.absolute = self.absolute;
        modal.e_absolute = self.e_absolute;
        modal.feed_rate = self.feed_rate;
        modal.power = self.power;
        modal.system = self.system;
        modal.set_tool_offset(self.tool_offset);
        modal.has_tool_length = self.has_tool_length;
    }
}

#[derive(Clone, Copy, Debug)]
struct Frame {
    /// How many subroutines run.
    depth: u8,
    /// M73: they come back when it ends.
    returns: bool,
    modes: SavedModes,
}

/// All that is saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct SavedFrames {
    frames: Vec<Frame, MOST>,
}

impl SavedFrames {
    /// M70, M73: saves at this depth; what was saved there is forgotten.
    pub(crate) fn save(&mut self, depth: usize, returns: bool, modal: &Modal) {
        self.forget(depth);
        // There is one for each depth.
        let _ = self.frames.push(Frame { depth: depth as u8, returns, modes: SavedModes::of(modal) });
    }

    /// M71.
    pub(crate) fn forget(&mut self, depth: usize) {
        self.frames.retain(|frame| usize::from(frame.depth) != depth);
    }

    /// M72: what was saved at this depth.
    pub(crate) fn at(&self, depth: usize) -> Option<SavedModes> {
        self.frames.iter().find(|frame| usize::from(frame.depth) == depth).map(|frame| frame.modes)
    }

    /// Subroutines have ended down to this depth: what comes back now, the outermost's.
    pub(crate) fn end_down_to(&mut self, depth: usize) -> Option<SavedModes> {
        let mut back = None;
        while let Some(frame) = self.frames.last().copied().filter(|frame| usize::from(frame.depth) > depth) {
            self.frames.pop();
            back = frame.returns.then_some(frame.modes).or(back);
        }
        back
    }

    /// The program has ended.
    pub(crate) fn clear(&mut self) {
        self.frames.clear();
    }
}
