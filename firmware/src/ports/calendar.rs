//! Date and time: the machine's port to the clock.

use base::ports::{Calendar, DateTime};
use bsp_prime::rtc;

use super::{BoardPorts, Locks};

impl<L: Locks> Calendar for BoardPorts<L> {
    fn date(&self) -> DateTime {
        rtc::now()
    }

    fn set_date(&mut self, to: DateTime) -> bool {
        self.owned.rtc.set(to)
    }
}
