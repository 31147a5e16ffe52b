//! M28 and M29: lines of a session that become a file.

use base::failure::{Answer, Failure, Outcome};
use base::paths::Path;
use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use base::sessions::{Reply, SessionId};
use gcode::{Code, Line};

use super::Files;

/// File being uploaded. Until its M29 no line of its session is carried out, whatever became of the file.
#[derive(Debug)]
pub(super) struct Upload {
    /// Session that sends the file.
    from: SessionId,
    /// Open file; none when it could not be opened, or was lost to a halt.
    file: Option<FileHandle>,
    /// Path of the file; none when it could not be opened.
    path: Option<Path>,
    /// Error of a line that could not be written.
    failed: Option<StorageError>,
}

/// Reason why an uploaded file is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotSaved {
    /// The file could not be opened, or was lost to a halt.
    Nothing,
    /// The card failed to write.
    Card(StorageError),
}

impl From<StorageError> for NotSaved {
    fn from(error: StorageError) -> Self {
        Self::Card(error)
    }
}

impl Files {
    /// M28: stores this session's lines from now on, up to its M29.
    ///
    /// # Errors
    /// When another file is being uploaded.
    pub fn begin_upload(
        &mut self,
        session: SessionId,
        name: &str,
        storage: &mut impl Storage,
        reply: &mut Reply<'_>,
    ) -> Outcome {
        if self.upload.is_some() {
            return Err(Failure::refused(&"another file is being uploaded"));
        }
        let path = self.absolute(name);
        let file = if name.is_empty() { Err(StorageError::BadPath) } else { storage.open(&path, OpenMode::Write) };
        match file {
            Ok(_) => reply.say(format_args!("Writing to file: {name}\n")),
            Err(error) => reply.say(format_args!(
                "open failed, File: {name}.\n// WARNING {}: everything up to M29 is discarded\n",
                error.text()
            )),
        }
        let path = file.is_ok().then_some(path);
        self.upload = Some(Upload { from: session, file: file.ok(), path, failed: None });
        Ok(Answer::Ok)
    }

    /// Returns whether this session's lines belong to a file.
    #[must_use]
    pub fn uploads_from(&self, session: SessionId) -> bool {
        self.upload.as_ref().is_some_and(|upload| upload.from == session)
    }

    /// Gives up the file of an upload. The sender does not know, and goes on sending lines that must not be
    /// carried out.
    pub fn spoil_upload(&mut self, storage: &mut impl Storage) {
        if let Some(file) = self.upload.as_mut().and_then(|upload| upload.file.take()) {
            // The upload is lost anyway; a failing close changes nothing.
            let _ = storage.close(file);
        }
    }

    /// Removes half a file, which must not be played some day. The name belongs to the file only while it is
    /// open: afterwards, or on another card, another file may have it.
    fn discard_upload(&mut self, storage: &mut impl Storage) {
        if let Some(Upload { file: Some(file), path: Some(path), .. }) = self.upload.take()
            && storage.close(file).is_ok()
        {
            // A file that cannot be removed now has no better moment.
            let _ = storage.remove(&path);
        }
    }

    /// Ends the upload or editing of a session whose peer has gone: later bytes are not of its file.
    pub fn session_ended(&mut self, session: SessionId, storage: &mut impl Storage) {
        if let Some(editing) = self.editing.take_if(|editing| editing.from == session) {
            // Nobody hears the answer of this session.
            let _ = editing.close(storage, Err(StorageError::NotResponding));
        }
        if self.uploads_from(session) {
            self.discard_upload(storage);
        }
    }

    /// Ends the upload if this line is its M29: the file is closed, and on its way to the card. The result is
    /// for [`upload_ended`](Self::upload_ended).
    pub fn end_upload(&mut self, decoded: &Line<'_>, storage: &mut impl Storage) -> Option<Result<(), NotSaved>> {
        if !ends_upload(decoded) {
            return None;
        }
        if let Some(error) = self.upload.as_ref()?.failed {
            self.discard_upload(storage);
            return Some(Err(NotSaved::Card(error)));
        }
        let closed = self.upload.take()?.file.map(|file| storage.close(file));
        Some(match closed {
            Some(closed) => closed.map_err(NotSaved::Card),
            None => Err(NotSaved::Nothing),
        })
    }

    /// Prints the result of an upload.
    pub fn upload_ended(&self, saved: Result<(), NotSaved>, reply: &mut Reply<'_>) {
        match saved {
            Ok(()) => reply.say(format_args!("Done saving file.\nok\n")),
            Err(NotSaved::Card(error)) => {
                reply.say(format_args!("Error:error writing to file: {}\nok\n", error.text()));
            }
            Err(NotSaved::Nothing) => reply.say(format_args!("error:nothing was saved\nok\n")),
        }
    }

    /// Stores a line of the uploading session as it is. False when that failed, which has been printed; else
    /// the line is still to be answered.
    pub fn upload_line(&mut self, line: &[u8], storage: &mut impl Storage, reply: &mut Reply<'_>) -> bool {
        let Some(Upload { file, failed, .. }) = &mut self.upload else { return true };
        let Some(file) = *file else { return true };
        // Nothing is written behind a lost line.
        if failed.is_none() {
            *failed = storage.write(file, line).and_then(|()| storage.write(file, b"\n")).err();
        }
        if let Some(error) = failed {
            reply.say(format_args!("Error:error writing to file: {}\n", error.text()));
        }
        failed.is_none()
    }
}

/// Returns whether a line is M29 and nothing else: `M117 done, now M29` is text, and `M29 P1` a line of the
/// file.
fn ends_upload(line: &Line<'_>) -> bool {
    let Line::Code(blocks) = line else { return false };
    let first = blocks.clone().next().and_then(Result::ok);
    first.is_some_and(|block| block.is(Code::m(29)) && block.is_bare())
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::{Card, Desk};
    use gcode::Decoder;

    const ME: SessionId = SessionId(0);

    fn send(files: &mut Files, card: &mut Card, desk: &mut Desk, line: &str) -> String {
        let decoded = Decoder::new().decode(line.as_bytes()).unwrap();
        desk.hears(|reply| match files.end_upload(&decoded, card) {
            Some(closed) => files.upload_ended(closed, reply),
            None if files.upload_line(line.as_bytes(), card, reply) => reply.say(format_args!("ok\n")),
            None => {}
        })
    }

    fn begin(files: &mut Files, card: &mut Card, desk: &mut Desk, name: &str) -> String {
        desk.hears(|reply| assert_eq!(files.begin_upload(ME, name, card, reply), Ok(Answer::Ok)))
    }

    #[test]
    fn lines_are_stored_as_they_come_until_a_bare_m29() {
        let (mut files, mut card, mut desk) = (Files::default(), Card::default(), Desk::new());
        assert_eq!(begin(&mut files, &mut card, &mut desk, "up.g"), "Writing to file: up.g\n");
        assert!(files.uploads_from(ME) && !files.uploads_from(SessionId(1)));
        for line in ["G1 X1 ; a comment", "M117 and M29", "M112", "M29 P1"] {
            assert_eq!(send(&mut files, &mut card, &mut desk, line), "ok\n", "{line}");
        }
        assert_eq!(send(&mut files, &mut card, &mut desk, "M29"), "Done saving file.\nok\n");
        assert!(!files.uploads_from(ME));
        assert_eq!(card.text("/sd/up.g"), "G1 X1 ; a comment\nM117 and M29\nM112\nM29 P1\n");
    }

    #[test]
    fn what_cannot_be_stored_is_swallowed_to_its_end() {
        let (mut files, mut card, mut desk) = (Files::default(), Card::default(), Desk::new());
        let said = begin(&mut files, &mut card, &mut desk, "");
        assert!(said.starts_with("open failed, File: .\n// WARNING ") && said.ends_with("is discarded\n"), "{said}");
        assert_eq!(send(&mut files, &mut card, &mut desk, "G28"), "ok\n");
        assert_eq!(send(&mut files, &mut card, &mut desk, "M29"), "error:nothing was saved\nok\n");
        begin(&mut files, &mut card, &mut desk, "up.g");
        files.spoil_upload(&mut card);
        assert!(files.uploads_from(ME), "its sender goes on");
        assert_eq!(send(&mut files, &mut card, &mut desk, "M29"), "error:nothing was saved\nok\n");
        assert_eq!(card.open_files(), 0);
    }

    #[test]
    fn a_file_that_has_lost_a_line_is_none() {
        let (mut files, mut card, mut desk) = (Files::default(), Card::default(), Desk::new());
        begin(&mut files, &mut card, &mut desk, "up.g");
        assert_eq!(send(&mut files, &mut card, &mut desk, "G1 X1"), "ok\n");
        card.is_full = true;
        let said = send(&mut files, &mut card, &mut desk, "G1 X2");
        assert!(said.starts_with("Error:error writing to file: "), "{said}");
        card.is_full = false;
        assert_eq!(send(&mut files, &mut card, &mut desk, "G1 X3"), said, "nothing goes behind what is lost");
        assert_eq!(send(&mut files, &mut card, &mut desk, "M29"), said + "ok\n");
        assert_eq!(card.remove("/sd/up.g"), Err(StorageError::NotFound));
        assert!(!files.uploads_from(ME) && card.open_files() == 0);
    }

    #[test]
    fn one_file_at_a_time_and_none_of_a_session_that_has_gone() {
        let (mut files, mut card, mut desk) = (Files::default(), Card::default(), Desk::new());
        begin(&mut files, &mut card, &mut desk, "up.g");
        desk.hears(|reply| {
            let refused = files.begin_upload(SessionId(1), "other.g", &mut card, reply);
            assert_eq!(refused, Err(Failure::refused(&"another file is being uploaded")));
        });
        files.session_ended(SessionId(1), &mut card);
        assert!(files.uploads_from(ME));
        files.session_ended(ME, &mut card);
        assert!(!files.uploads_from(ME));
        assert_eq!(card.open_files(), 0);
    }
}
