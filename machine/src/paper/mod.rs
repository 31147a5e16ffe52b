//! Paper tests: a person lowers the tool until a sheet of paper just drags, and says so.
//!
//! M851.1 begins one, M851.2 moves the tool, M851.3 accepts, M851.5 accepts a screw that was turned, M851.4
//! gives up. Klipper's names for these are PROBE_CALIBRATE and so on, TESTZ, ACCEPT, ADJUSTED, ABORT. Between
//! them the machine does what else it is told: the tool may be jogged as well.
//!
//! [`Paper`] says which test is under way. A halt ends it, and so does whatever makes the machine forget
//! where it is. Nothing is changed before the last ACCEPT.

mod moves;
mod purposes;
mod screws;
mod state;
mod steps;
mod tried;
mod twist;

pub(crate) use state::Paper;
pub(crate) use steps::paper_test;
