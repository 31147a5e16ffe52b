//! The log: prints the events of the ring over RTT, at the lowest priority.

use base::ports::DateTime;
use bsp_prime::identity::{Identity, ResetCause};
use bsp_prime::{kept, rtc, time};
use events::{Cause, Date, Event};

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
    let cause = match identity.reset_cause {
        ResetCause::PowerOn => Cause::PowerOn,
        ResetCause::BrownOut => Cause::BrownOut,
        ResetCause::Pin => Cause::Pin,
        ResetCause::Software => Cause::Software,
        ResetCause::Watchdog => Cause::Watchdog,
        ResetCause::WindowWatchdog | ResetCause::Unknown => Cause::Unknown,
    };
    kept::events().record(time::now(), &Event::Started { cause, date: date() });
}

/// Returns the date, once the clock has been set.
fn date() -> Option<Date> {
    let rtc::Reading { year, month, day, hour, minute, second } = rtc::now();
    (year != DateTime::UNSET.year).then_some(Date { year, month, day, hour, minute, second })
}
