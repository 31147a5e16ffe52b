//! The site's part in jogs while a button is held, and in stops.

use super::{EmergencyStop, Site};
use crate::calls::{Call, Method, codes};
use crate::console::Asker;
use crate::reply::Content;

impl<const N: usize> Site<N> {
    /// Takes the request to have the machine let go of a jog: its visitor has let go of the button, has gone,
    /// or was silent for too long.
    pub fn take_jog_end(&mut self, now_ms: u64) -> bool {
        self.jogs.watch(now_ms);
        self.jogs.take_end()
    }

    /// Has the machine stopped, and drops what waits for it.
    pub(crate) fn stop_at_once(&mut self) {
        self.stop = Some(EmergencyStop);
        self.console.drop_waiting();
        self.jogs.let_go();
    }

    /// Carries out a call about a jog.
    pub(crate) fn jog(&mut self, holder: Asker, call: &Call, axis: &str, now_ms: u64) -> Content {
        let outcome = match call.method {
            Method::JogStart if self.console.works_for_all() && !self.jogs.is_under_way() => {
                Err((codes::BUSY, "other lines are in work: a jog begins when the machine is done with them"))
            }
            Method::JogStart => self.jogs.start(call, axis, holder, now_ms).map(Content::Jog),
            Method::JogBeat => self.jogs.beat(call, holder, now_ms).map(|()| Content::Done),
            _ => self.jogs.stop(call).map(|()| Content::Done),
        };
        outcome.unwrap_or_else(|(code, message)| Content::Error(code, message))
    }
}
