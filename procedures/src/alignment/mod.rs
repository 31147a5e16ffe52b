//! Alignment of the bed or the gantry: motors that are turned alone (G34), screws that a person turns (G35),
//! and a slave that is put where its own switch says (G28.7).
//!
//! A height is where the probe touches the bed, mm of Z: higher where the bed is nearer to the tool.

mod fit;
mod own_switch;
mod screws;
mod single_motors;
mod words;
mod z_motors;

pub use own_switch::align_slave;
pub use screws::advise;
pub use words::Corner;
pub use z_motors::align;
