//! What brings lines calls these.

use gcode::MAX_LINE_LENGTH;
use motion::Motion;
use program::{Next, Place};

use super::finding::{Finding, Kind};
use super::lines::Reading;
use super::state::{Listener, MOST_LINES, Preflight};
use crate::failure::message;
use crate::jobs::is_comment;

impl Preflight<'_> {
    /// A subroutine was called that has a file of its own, which is read now; or it has none.
    pub fn enter_file(&mut self, there_is_one: bool) {
        if there_is_one { self.program.enter_file() } else { self.program.search_sub() }
    }

    /// The next line, which begins and ends at these places of its file. Says which one follows it.
    pub async fn line(
        &mut self,
        line: &[u8],
        (here, after): (Place, Place),
        motion: &mut Motion,
        listener: &mut dyn Listener,
    ) -> Next {
        self.line = here.line + 1;
        self.totals.lines = self.totals.lines.saturating_add(1);
        self.begun = self.begun.saturating_add(u32::from(!is_comment(line)));
        self.program.at_line(self.line);
        self.turn().await;
        Reading { preflight: self, motion, listener, after }.line(line, here).await
    }

    /// The next line, which begins at this place, is longer than any.
    pub fn too_long(&mut self, here: Place, listener: &mut dyn Listener) {
        self.totals.stops += 1;
        let what = message(format_args!("the line is longer than {MAX_LINE_LENGTH} letters"));
        listener.found(&Finding { line: here.line + 1, kind: Kind::Text, what });
    }

    /// Whether more lines have been carried out than any file needs, which is said.
    pub fn is_endless(&self, listener: &mut dyn Listener) -> bool {
        let is_endless = self.totals.lines > MOST_LINES;
        if is_endless {
            let text = format_args!("more than {MOST_LINES} lines are carried out: what follows is not looked at");
            listener.found(&Finding { line: self.line, kind: Kind::Unforeseen, what: message(text) });
        }
        is_endless
    }

    /// The file has ended: the last moves are made.
    pub async fn end(&mut self, motion: &mut Motion, listener: &mut dyn Listener) {
        let mut reading = Reading { preflight: self, motion, listener, after: Place::default() };
        reading.standstill().await;
        reading.end_of_file();
    }
}
