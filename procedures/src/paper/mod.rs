//! Paper tests: a person lowers the tool until a sheet of paper just drags, and says so.
//!
//! M851.1 begins a test, M851.2 moves the tool, M851.3 accepts, M851.5 accepts a screw that was turned,
//! M851.4 gives up. Klipper's names for these are PROBE_CALIBRATE and so on, TESTZ, ACCEPT, ADJUSTED, ABORT.
//! Between them the machine runs other commands: the tool may be jogged as well.
//!
//! [`Paper`] holds the test under way. A halt ends it, and so does any event that makes the machine forget
//! its position. Nothing is changed before the last ACCEPT.

mod hands;
mod heights_tried;
mod moves;
mod purposes;
mod screws;
mod state;
mod steps;
#[cfg(test)]
mod tests;
mod twist;

pub use hands::PaperHands;
pub use state::Paper;
pub use steps::paper_test;
