//! State of a program between its lines: modes, offsets, tools, and what the configuration says to them.

pub(crate) mod auxiliary;
pub(crate) mod claims;
pub(crate) mod cycle;
pub(crate) mod kept;
pub(crate) mod left_out_objects;
pub(crate) mod modal;
pub(crate) mod park;
pub(crate) mod pixels;
pub(crate) mod rotation;
pub(crate) mod saved_modes;
pub(crate) mod setup;
pub(crate) mod splines;
pub(crate) mod tool_table;
pub(crate) mod tools;
