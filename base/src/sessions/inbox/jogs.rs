//! The end of jogs, asked for by a transport instead of by a byte.

use core::sync::atomic::Ordering;

use gcode::realtime::Realtime;

use super::Inbox;

impl Inbox {
    /// Notes which bytes were received before the peer let go.
    pub(super) fn note_stop(&self) {
        self.stopped_at.store(self.received.load(Ordering::Relaxed), Ordering::Relaxed);
    }

    /// Ends the jogs of all lines received so far, begun or not, as the byte 0x85 does in GRBL's dialect.
    /// Only the transport that fills the inbox may call this.
    pub fn cancel_jogs(&self) {
        self.note_stop();
        self.request(Realtime::JogCancel);
    }
}
