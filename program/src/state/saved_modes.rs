//! Modes that M70 saves and M72 restores, one set for each running subroutine (LinuxCNC, "M70 Save Modal
//! State"). Modes saved by M73 are restored automatically when the subroutine ends.

use heapless::Vec;
use units::{MmPerSecond, Plane};

use crate::action::Corner;
use crate::state::auxiliary::Auxiliary;
use crate::state::cycle::Retract;
use crate::state::modal::{FeedMode, Modal};

/// Capacity for the main program and every nested subroutine.
const MOST: usize = crate::flow::MOST_CALLS + 1;

/// Saved modes, without motion codes.
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

    /// Restores the modes. Spindle, coolant and overrides in `modal` stay, because outputs must be switched
    /// to change them.
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
    /// Number of running subroutines.
    depth: u8,
    /// Whether the modes are restored when the subroutine ends (M73).
    returns: bool,
    modes: SavedModes,
}

/// Saved modes of all running subroutines.
#[derive(Clone, Debug, Default)]
pub(crate) struct SavedFrames {
    frames: Vec<Frame, MOST>,
}

impl SavedFrames {
    /// M70, M73: saves the modes at this call depth, in place of modes saved there before.
    pub(crate) fn save(&mut self, depth: usize, returns: bool, modal: &Modal) {
        self.forget(depth);
        // Each depth has at most one frame, so there is room.
        let _ = self.frames.push(Frame { depth: depth as u8, returns, modes: SavedModes::of(modal) });
    }

    /// M71: forgets the modes saved at this depth.
    pub(crate) fn forget(&mut self, depth: usize) {
        self.frames.retain(|frame| usize::from(frame.depth) != depth);
    }

    /// M72: returns the modes saved at this depth.
    pub(crate) fn at(&self, depth: usize) -> Option<SavedModes> {
        self.frames.iter().find(|frame| usize::from(frame.depth) == depth).map(|frame| frame.modes)
    }

    /// Drops the modes of subroutines that have ended, down to this depth; returns those to restore, the
    /// outermost.
    pub(crate) fn end_down_to(&mut self, depth: usize) -> Option<SavedModes> {
        let mut back = None;
        while let Some(frame) = self.frames.last().copied().filter(|frame| usize::from(frame.depth) > depth) {
            self.frames.pop();
            back = frame.returns.then_some(frame.modes).or(back);
        }
        back
    }

    /// Forgets all saved modes at the end of the program.
    pub(crate) fn clear(&mut self) {
        self.frames.clear();
    }
}
