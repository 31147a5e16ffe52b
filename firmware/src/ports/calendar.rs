//! Date and time: the machine's port to the clock.

use base::ports::{Calendar, DateTime};
use bsp_prime::rtc;
use bsp_prime::sd::CardService;
use rtic::Mutex;

use super::BoardPorts;

impl<M, H, S, T, K: Mutex<T = &'static mut CardService>> Calendar for BoardPorts<M, H, S, T, K> {
    fn date(&self) -> DateTime {
        rtc::now()
    }

    fn set_date(&mut self, to: DateTime) -> bool {
        self.owned.rtc.set(to)
    }
}
