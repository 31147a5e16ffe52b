//! Klipper's `printer.cfg` as it lies on the card: an index of its sections, and options that are read in
//! pieces when they are asked for. Beside it what macros keep while the machine runs: variables that were
//! changed, macros under way, delayed G-code.
//!
//! The text itself stays on the card: what is edited there counts after the next [`Store::reload`]. The
//! crate knows no machine; macros are rendered by crate `macros`.

#![cfg_attr(not(test), no_std)]

mod bytes;
mod calls;
mod delayed;
mod index;
mod lines;
mod looks;
mod option;
mod saved_variables;
mod scan;
mod settings;
mod store;
#[cfg(test)]
mod test_card;
#[cfg(test)]
mod tests;
mod variables;

pub use calls::Call;
pub use index::{Section, Use};
pub use looks::{LookedAt, Looks};
pub use option::{Name, Options, Value};
pub use saved_variables::{NotSaved, name_at as saved_name, read as read_saved, save};
pub use scan::{Loaded, Trouble};
pub use settings::{Setting, default_of, defaults_of, read as read_setting, stand_in};
pub use store::{CODE_BYTES, LINES_BYTES, Memory, SCRATCH, Scratch, Store};
pub use variables::{ROOM as VARIABLES_BYTES, Variables};
