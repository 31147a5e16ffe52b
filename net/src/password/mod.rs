//! Password of the board: its record, proof of it by visitors, and the time that wrong ones cost.

mod derivation;
mod failures;
mod gate;
mod record;

pub use derivation::WORD_BYTES;
pub use gate::Gate;
pub use record::{RECORD_BYTES, Record, SALT_BYTES};
