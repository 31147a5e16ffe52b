//! Preflight: the demands of a file on this machine, and its duration, before anything moves.
//!
//! The same interpreter reads the lines, and a second motion object, which makes no steps, is given the same
//! moves ([`motion::Motion::pass_block`]). So findings are those that the machine would tell line by line,
//! and the time is the planner's own. The desk and the board run this very code; each brings the lines, and
//! hears the findings.
//!
//! Results that only the job itself has are left out: of probing, of inputs, of the operator's acts. A file
//! is read as on a machine that has just been switched on.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod actions;
mod cost;
mod entry;
mod finding;
pub mod forecast;
mod guesses;
mod homing;
mod kept_modes;
mod limits;
mod lines;
mod macro_calls;
mod macros;
mod modes_by_name;
mod moves;
mod power;
mod setting_changes;
mod state;
mod text;
mod totals_text;
mod turns;

#[cfg(test)]
mod tests;

pub use finding::{Finding, Kind, Severity, SubName};
pub use limits::Limit;
pub use macro_calls::{Called, MacroCall, MacroName, MacroPlace};
pub use state::AsItIs;
pub use state::{Listener, MOST_LINES, Preflight, Totals};
pub use text::{dialect_of, read};
pub use totals_text::{TOLD_LINES, Told};
pub use turns::end_turn;
