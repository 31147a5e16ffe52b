//! The site's part in an operator's factors of rapids and of the spindle, which wait for no line.

use base::ports::Factors;
use program::State;

use super::Site;
use crate::calls::{Call, Quantity, codes};

impl<const N: usize> Site<N> {
    /// Takes factors that are to act at once.
    pub const fn take_factors(&mut self) -> Option<Factors> {
        self.factors.take()
    }

    /// Notes the factors of a call. Returns whether it has one of feed rates as well.
    ///
    /// # Errors
    /// Code and text: a factor is out of its range, there is none, or the machine is halted.
    pub(crate) fn set_factors(&mut self, call: &Call) -> Result<bool, (i32, &'static str)> {
        let [feed, rapid, spindle] = [Quantity::Feed, Quantity::Rapid, Quantity::Spindle].map(|of| call.number(of));
        if rapid.is_some_and(|share| !(0.05..=1.0).contains(&share)) {
            return Err((codes::PARAMETERS, "rapid is a share from 0.05 to 1"));
        }
        if spindle.is_some_and(|share| !(0.1..=2.0).contains(&share)) {
            return Err((codes::PARAMETERS, "spindle is a share from 0.1 to 2"));
        }
        if rapid.is_none() && spindle.is_none() {
            return Ok(true);
        }
        if self.snapshot.state == State::Alarm {
            return Err((codes::REFUSED, "the machine is halted: release it first"));
        }
        let before = self.factors.unwrap_or_default();
        self.factors = Some(Factors { rapid: rapid.or(before.rapid), spindle: spindle.or(before.spindle) });
        Ok(feed.is_some())
    }
}
