//! The log: prints the events of the ring over RTT, at the lowest priority.

use bsp_prime::identity::Identity;
use bsp_prime::{kept, rtc, time};
use events::{DateTime, Event};

/// Position of the log in the ring of events.
pub struct Told(u32);

impl Told {
    /// Starts the log at the next event.
    pub fn from_here() -> Self {
        Self(kept::events().next())
    }

    /// Prints the events since the last call.
    pub fn tell(&mut self) {
        let ring = kept::events();
        let end = ring.next();
        if self.0 == end {
            return;
        }
        for entry in ring.between(self.0, end) {
            defmt::info!("{}", entry.event);
        }
        self.0 = end;
    }
}

/// Records the first event of this start.
pub fn record_start(identity: &Identity) {
    let date = Some(rtc::now()).filter(DateTime::is_set);
    kept::events().record(time::now(), &Event::Started { cause: identity.reset_cause, date });
}
