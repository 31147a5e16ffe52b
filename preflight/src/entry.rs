//! Entry points of a preflight for the code that brings lines.

use base::failure::{ShortText, short};
use gcode::MAX_LINE_LENGTH;
use jobs::player::is_comment;
use motion::{GridShape, Motion};
use program::{Dialect, Next, Place};

use super::finding::Kind;
use super::lines::Reading;
use super::setting_changes;
use super::state::{Listener, Preflight};
use super::text::read;

impl Preflight<'_> {
    /// Enters the subroutine that was called: its own file, which is read now, if there is one.
    pub fn enter_file(&mut self, there_is_one: bool) {
        if !there_is_one {
            return self.program.search_sub();
        }
        self.program.enter_file();
        // The caller opens no more files than fit.
        let _ = self.files.push(core::mem::take(&mut self.called));
    }

    /// Leaves the file of a subroutine; the file before goes on.
    pub fn leave_file(&mut self) {
        self.files.pop();
    }

    /// Reads the settings that a machine has saved (M500), before the job. Returns the line that loads a
    /// mesh, if any does.
    pub fn load_settings(&mut self, text: &[u8], motion: &mut Motion, listener: &mut dyn Listener) -> Option<u32> {
        let dialect = core::mem::replace(&mut self.dialect, Dialect::Smoothie);
        self.reads_settings = true;
        // Files of subroutines have no part in it.
        let _ = read(self, text, &|_| None, motion, listener);
        (self.dialect, self.reads_settings) = (dialect, false);
        self.forget_the_file();
        self.loads_mesh
    }

    /// Levels by a mesh that the machine has saved: with a name (M374 P), or as Smoothieware keeps its grid.
    ///
    /// # Errors
    /// When the mesh does not fit this machine.
    pub fn load_mesh(
        &mut self,
        shape: &GridShape,
        heights: &[f32],
        has_a_name: bool,
        motion: &mut Motion,
    ) -> Result<(), ShortText> {
        setting_changes::level_by(self, motion, shape, heights, has_a_name)
    }

    /// Reads the next line, which begins and ends at these places of its file. Returns the line that follows
    /// it.
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
        let mut reading = Reading::new(self, motion, listener, after);
        reading.line(line, here).await;
        let next = reading.next;
        if let Next::FirstOf(name) = &next {
            self.called.clone_from(name);
        }
        next
    }

    /// Reports the next line, which begins at this place, as longer than any.
    pub fn too_long(&mut self, here: Place, listener: &mut dyn Listener) {
        self.totals.stops += 1;
        let what = short(format_args!("the line is longer than {MAX_LINE_LENGTH} letters"));
        listener.found(&self.finding(here.line + 1, Kind::Damage, what));
    }

    /// Ends the file: the last moves are made.
    pub async fn end(&mut self, motion: &mut Motion, listener: &mut dyn Listener) {
        let mut reading = Reading::new(self, motion, listener, Place::default());
        reading.standstill().await;
        reading.end_of_file();
    }
}
