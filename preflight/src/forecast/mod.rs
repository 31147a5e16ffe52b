//! A look at a file on the card while the machine does other things: `check`, and the time that is left of a
//! job.
//!
//! The work ([`work`]) gets a turn of a tenth of a millisecond whenever the executor waits and has nothing
//! planned, or as much as fits. Only this work is a future, to be able to stop in the middle of a line. Bytes
//! of the file are asked for here, and the machine brings them while it waits (its `features/forecast`). So
//! no line, no console and no move waits for the work any longer than for that turn.

mod open_files;
mod shared;
mod timeline;
mod work;

pub use open_files::ForecastFiles;
pub use shared::{Answer, Purpose, SharedForecast, Stage, Wanted};
pub use work::{Desk, Forecaster, Work, read_file};
