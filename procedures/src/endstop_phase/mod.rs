//! Endstop phase: the motor's electrical phase when its endstop closes, which repeats far better than the
//! switch.
//!
//! A stepper is held in an electrical cycle of four full steps. A place of its axis is always at the same
//! place of that cycle, the phase, as long as rotor, pulley and switch stay where they are. So where the
//! switch closes a little sooner or later, the nearest place with the calibrated phase is where it would have
//! closed without noise ([`at_switch`]); and a phase that is far off says that something has moved. A motor
//! that loses steps loses whole cycles, which the phase does not show: those are counted.
//!
//! A driver on the board says where in the cycle it is, and its answer holds after power was off too: its
//! counter begins at zero then, and the rotor goes where the current holds it. Of an external driver only the
//! steps sent to it are known, not its place before the first: its phases are compared with that of the first
//! homing since power up.

mod axes;
mod codes;
mod cycle;
mod hands;
mod homing;
mod reading;
mod readings;
mod records;

pub use axes::checked;
pub use codes::{endstop_phase, write};
pub use hands::PhaseHands;
pub use homing::{Came, at_switch};
pub use reading::{Pass, switch_closed};
pub use records::EndstopPhases;
