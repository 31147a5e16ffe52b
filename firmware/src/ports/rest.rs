//! Time, rest of the executor, and memory of the event ring.

use base::ports::{Clock, EventLog, Rest, Wake};
use bsp_prime::kept;
use bsp_prime::sd::CardService;
use bsp_prime::time;
use events::EventRing;
use rtic::Mutex;
use units::Micros;

use super::BoardPorts;
use crate::{executor, usb};

impl<M, H, S, T, K: Mutex<T = &'static mut CardService>> Clock for BoardPorts<M, H, S, T, K> {
    fn now(&self) -> Micros {
        time::now()
    }
}

impl<M, H, S, T, K: Mutex<T = &'static mut CardService>> Rest for BoardPorts<M, H, S, T, K> {
    fn rest(&mut self, wake: Wake) {
        // The log is told of what is new in the ring, and USB of room for packets that wait.
        self.told.tell();
        usb::look_for_room();
        executor::rest(wake);
    }
}

impl<M, H, S, T, K: Mutex<T = &'static mut CardService>> EventLog for BoardPorts<M, H, S, T, K> {
    fn events(&self) -> EventRing<'_> {
        kept::events()
    }
}
