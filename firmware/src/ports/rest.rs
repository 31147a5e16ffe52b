//! Time, rest of the executor, and memory of the event ring.

use base::ports::{Clock, EventLog, Rest, Wake};
use bsp_prime::kept;
use bsp_prime::time;
use events::EventRing;
use units::Micros;

use super::{BoardPorts, Locks};
use crate::{executor, usb};

impl<L: Locks> Clock for BoardPorts<L> {
    fn now(&self) -> Micros {
        time::now()
    }
}

impl<L: Locks> Rest for BoardPorts<L> {
    fn rest(&mut self, wake: Wake) {
        // The log is told of what is new in the ring, and USB of room for packets that wait; the network has
        // its turn.
        self.told.tell();
        usb::look_for_room();
        let has_more = self.owned.network.poll(time::now(), &mut self.storage);
        executor::rest(if has_more { Wake::AtOnce } else { wake });
    }
}

impl<L: Locks> EventLog for BoardPorts<L> {
    fn events(&self) -> EventRing<'_> {
        kept::events()
    }
}
