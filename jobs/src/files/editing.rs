//! State of a file being edited: its session, its input and its output.

use base::paths::Path;
use base::ports::{FileHandle, Storage, StorageError};
use base::sessions::SessionId;

use super::editor::Editor;

/// File being edited with `ed`.
#[derive(Debug)]
pub struct Editing {
    /// Session whose lines are commands of the editor.
    pub from: SessionId,
    /// File as it was, which is read.
    pub input: FileHandle,
    /// File with the changes, which is written.
    pub output: FileHandle,
    /// Path of the output file.
    path: Path,
    /// The text in work.
    pub editor: Editor,
    /// Number of further lines that are text, and no commands.
    pub lines_to_get: u32,
    /// Whether the current line is printed behind each line of commands.
    pub says_line: bool,
    /// Whether it is printed behind each command.
    pub says_each: bool,
}

impl Editing {
    /// Starts at the beginning of a file.
    pub fn new(from: SessionId, input: FileHandle, output: FileHandle, path: Path) -> Self {
        let editor = Editor::new();
        Self { from, input, output, path, editor, lines_to_get: 0, says_line: true, says_each: false }
    }

    /// Ends the editing; an output that has not become whole is deleted.
    pub fn close(self, storage: &mut impl Storage, copied: Result<(), StorageError>) -> Result<(), StorageError> {
        // Errors are ignored: the input was only read.
        let _ = storage.close(self.input);
        let closed = storage.close(self.output);
        let whole = copied.and(closed);
        if whole.is_err() {
            // Half a file looks like a whole one, so deleting it is better.
            let _ = storage.remove(&self.path);
        }
        whole
    }
}
