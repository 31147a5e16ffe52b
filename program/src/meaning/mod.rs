//! Meaning of blocks, by topic: translates words, read in the program's state, into actions and changes of
//! state.

pub(crate) mod arcs;
pub(crate) mod cycles;
pub(crate) mod extruders;
pub(crate) mod feed_modes;
pub(crate) mod heat;
pub(crate) mod homing;
pub(crate) mod lights;
pub(crate) mod modes;
pub(crate) mod moves;
pub mod objects;
pub(crate) mod offsets;
pub(crate) mod outputs;
pub(crate) mod printers;
pub(crate) mod probing;
pub(crate) mod program;
pub(crate) mod spindle;
pub(crate) mod splines;
pub(crate) mod threads;
pub(crate) mod tool_table;
