//! A file being edited: who edits it, what it is read from and written to.

use super::Path;
use super::editor::Editor;
use crate::ports::{FileHandle, Storage, StorageError};
use crate::sessions::SessionId;

/// A file being edited.
#[derive(Debug)]
pub struct Editing {
    /// Whose lines are commands of the editor.
    pub from: SessionId,
    pub input: FileHandle,
    pub output: FileHandle,
    /// The file that is written.
    path: Path,
    pub editor: Editor,
    /// So many lines more are text, and no commands.
    pub lines_to_get: u32,
    /// The line is said behind each line of commands.
    pub says_line: bool,
    /// Behind each command.
    pub says_each: bool,
}

impl Editing {
    pub fn new(from: SessionId, input: FileHandle, output: FileHandle, path: Path) -> Self {
        let editor = Editor::new();
        Self { from, input, output, path, editor, lines_to_get: 0, says_line: true, says_each: false }
    }

    /// Ends it; a file that has not become whole is deleted.
    pub fn close(self, storage: &mut impl Storage, copied: Result<(), StorageError>) -> Result<(), StorageError> {
        // It was only read.
        let _ = storage.close(self.input);
        let closed = storage.close(self.output);
        let whole = copied.and(closed);
        if whole.is_err() {
            // Half a file looks like one: gone is better.
            let _ = storage.remove(&self.path);
        }
        whole
    }
}
