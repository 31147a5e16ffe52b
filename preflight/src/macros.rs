//! Macros: whoever has them renders a call, and the lines that come of it are read as lines of the job.
//!
//! A macro is rendered for the machine as it is now, not as it will be when the job comes to the call. So a
//! fault in lines that depend on the state of the machine stops no job, and neither does a macro that cannot
//! be rendered now: both are remarks.

use base::sessions::LineBytes;
use motion::Motion;
use program::{Dialect, Place};

use super::finding::Kind;
use super::lines::Reading;
use super::macro_calls::{Called, MacroPlace};
use super::state::{Listener, Preflight};
use super::turns::end_turn;

impl Preflight<'_> {
    /// Reads the lines of the macros that the last line has called, each in this buffer.
    pub async fn macro_lines(&mut self, line: &mut LineBytes, motion: &mut Motion, listener: &mut dyn Listener) {
        let dialect = self.dialect;
        while self.calls_macros && !self.has_ended && !self.is_endless(listener) {
            let mut place = MacroPlace::default();
            let called = loop {
                match listener.macro_line(line, &mut place) {
                    Some(called) => break called,
                    None => end_turn().await,
                }
            };
            self.turn().await;
            let mut reading = Reading::new(self, motion, listener, Place::default());
            match called {
                Called::Macro { is_sure } => reading.macro_line(line, place, is_sure).await,
                called => reading.macros_end(called),
            }
            self.dialect = dialect;
        }
        self.calls_macros = false;
        (self.within, self.is_guess) = (None, false);
    }
}

impl Reading<'_, '_> {
    /// Reads a line of a macro.
    async fn macro_line(&mut self, line: &[u8], place: MacroPlace, is_sure: bool) {
        let preflight = &mut *self.preflight;
        preflight.is_guess = !is_sure;
        preflight.within = Some(place);
        preflight.totals.lines = preflight.totals.lines.saturating_add(1);
        preflight.dialect = Dialect::Klipper;
        self.line(line, Place::default()).await;
    }

    /// Ends all macros.
    fn macros_end(&mut self, called: Called) {
        self.preflight.calls_macros = false;
        if let Called::Refused(failure) = called {
            self.failed(Kind::Macro, failure);
        }
        if let Called::Unknown(failure) = called {
            self.is_not_looked_into("the rest", failure);
        }
    }
}
