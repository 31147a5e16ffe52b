//! What is promised of the machine while it works, measured on the real image: how soon it stops, how soon it
//! answers, where on the path its outputs change. Times are virtual, from an edge or a byte on the board's
//! wires to another one.

mod consoles;
mod effects;
mod halts;
mod questions;
