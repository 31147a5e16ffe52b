//! Times in answers to people.

use core::fmt;

/// Seconds as `hh:mm:ss`.
#[derive(Clone, Copy, Debug)]
pub struct Clock(pub f64);

impl fmt::Display for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let whole = libm::round(self.0) as u64;
        write!(f, "{:02}:{:02}:{:02}", whole / 3_600, whole / 60 % 60, whole % 60)
    }
}
