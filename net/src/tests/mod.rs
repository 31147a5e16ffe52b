//! The whole network against a desk at the other end of a wire.

mod addresses;
mod clock;
mod consoles;
mod day;
mod faults;
mod fuzz;
mod login;
mod names;
mod streams;
