//! Promised times of the machine at work, measured on the real image: time to stop, time to answer, place on
//! the path at which its outputs change. Times are virtual, from an edge or a byte on the board's wires to
//! another edge or byte.

mod consoles;
mod effects;
mod halts;
mod questions;
