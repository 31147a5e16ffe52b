//! A look at a file on the card while the machine does other things: `check`, and the time that is left of a
//! job.
//!
//! The work ([`work`]) is a future of its own beside the executor's, and gets a turn of a tenth of a
//! millisecond whenever the executor waits and has nothing planned, or as much as fits. What it needs of the
//! machine, bytes of the file, it asks for here, and the executor brings it at its waiting points
//! (`executor/foresee.rs`). So no line, no console and no move waits for it any longer than for that turn.

mod ahead;
mod course;
mod foresight;
mod work;

pub(crate) use ahead::Ahead;
pub use foresight::{Answer, Foresight, Purpose, Stage, Wanted};
pub(crate) use work::beside;
