//! The conventions of `board-facts`, held against the real image: levels of pins, words on buses, registers.
//! Never the simulated carriage: it is wired by the same table.

mod buses;
mod directions;
mod inputs;
mod levels;
mod motors;
mod power;
