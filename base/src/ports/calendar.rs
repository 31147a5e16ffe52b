//! The clock that keeps the date.

use events::DateTime;

/// Access to the clock that keeps the date.
pub trait Calendar {
    /// Returns the date, from [`DateTime::UNSET`] on until somebody sets it.
    fn date(&self) -> DateTime;

    /// Sets the date. False when the clock does not run.
    fn set_date(&mut self, date: DateTime) -> bool;
}
