//! States of a program to be restored: that before a move which the machine refuses, and that before a
//! person has worked at the machine.

use units::PerAxis;

use crate::cycles::Series;
use crate::state::modal::Modal;

/// State before the last block's moves, to be restored if the machine refuses them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Before {
    pub(crate) position: PerAxis<f64>,
    pub(crate) tool_offset: [f64; 3],
    pub(crate) shift: [f64; 3],
    pub(crate) thermal_z: f64,
    /// E of the active tool, and the lift of Z if the tool is retracted.
    pub(crate) e: f64,
    pub(crate) retracted: Option<f64>,
}

/// Modes, extruder and E of a program, to be restored after a person has worked at the machine.
#[derive(Clone, Debug)]
pub struct Kept {
    pub(crate) modal: Modal,
    pub(crate) series: Series,
    /// Place of the extruder in use.
    pub(crate) tool: usize,
    pub(crate) e: f64,
}
