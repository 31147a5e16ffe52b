//! Date and time: the machine's port to the clock.

use base::ports::{Calendar, DateTime};
use bsp_prime::rtc::Reading;
use bsp_prime::sd::CardService;
use rtic::Mutex;

use super::BoardPorts;
use crate::storage::date;

impl<M, H, S, T, K: Mutex<T = &'static mut CardService>> Calendar for BoardPorts<M, H, S, T, K> {
    fn date(&self) -> DateTime {
        date()
    }

    fn set_date(&mut self, to: DateTime) -> bool {
        let DateTime { year, month, day, hour, minute, second } = to;
        self.owned.rtc.set(Reading { year, month, day, hour, minute, second })
    }
}
