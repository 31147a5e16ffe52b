//! Files, as the machine needs them. Paths are absolute (`/sd/config.ini`) and at most [`PATH_BYTES`] long.

/// Longest path.
pub const PATH_BYTES: usize = 128;
/// Longest name in a directory.
pub const NAME_BYTES: usize = 64;
/// How many directory entries one [`Storage::list`] call returns.
pub const LIST_CHUNK: usize = 8;

/// An open file. The board decides how many can be open at once; four suffice for this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileHandle(pub u8);

/// How to open a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpenMode {
    /// The file must exist; from its start.
    Read,
    /// Created when missing, emptied when not.
    Write,
    /// Created when missing, written at its end.
    Append,
}

/// Why storage refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StorageError {
    /// No card, or none that answers to identification.
    NoCard,
    /// The card has no file system this firmware reads.
    NoFileSystem,
    /// The card stopped answering.
    NotResponding,
    /// No such file or directory.
    NotFound,
    /// The name is taken.
    Exists,
    /// A directory where a file was expected, or the other way round, or not empty.
    WrongKind,
    /// The path is too long or has an illegal character.
    BadPath,
    /// The card is full.
    Full,
    /// More files are open than the board allows.
    TooManyOpen,
    /// This storage cannot do that.
    Unsupported,
    /// The card reports a read or write error.
    Device,
}

impl StorageError {
    /// A sentence for a person.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoCard => "no SD card found: insert a card and reset",
            Self::NoFileSystem => "the SD card has no FAT file system: format it as FAT32",
            Self::NotResponding => "the SD card stopped answering: check that it is seated, or replace it",
            Self::NotFound => "no such file",
            Self::Exists => "the name is already in use",
            Self::WrongKind => "is a directory, is not one, or is not empty",
            Self::BadPath => "the path is too long or not legal",
            Self::Full => "the SD card is full",
            Self::TooManyOpen => "too many files are open",
            Self::Unsupported => "not supported by this storage",
            Self::Device => "the SD card reports a read or write error",
        }
    }
}

/// One entry of a directory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DirectoryEntry {
    /// Name, cut to [`NAME_BYTES`].
    pub name: heapless::String<NAME_BYTES>,
    /// Size in bytes; 0 for a directory.
    pub size_bytes: u32,
    /// Is it a directory?
    pub is_directory: bool,
}

/// A file system.
pub trait Storage {
    /// Finds the card and its file system. Called at boot; may be called again after a card change.
    fn mount(&mut self) -> Result<(), StorageError>;

    /// Opens a file.
    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError>;

    /// Reads on from the present offset; 0 is the end of the file.
    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError>;

    /// Writes all of `bytes`.
    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError>;

    /// Moves the offset, counted from the start.
    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError>;

    /// Size of an open file in bytes.
    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError>;

    /// Closes a file; what was written is on the card afterwards.
    fn close(&mut self, file: FileHandle) -> Result<(), StorageError>;

    /// Reads up to [`LIST_CHUNK`] entries of a directory, skipping the first `skip`; an empty answer is the end.
    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError>;

    /// Removes a file or an empty directory.
    fn remove(&mut self, path: &str) -> Result<(), StorageError>;

    /// Makes a directory.
    fn make_directory(&mut self, path: &str) -> Result<(), StorageError>;

    /// Renames or moves.
    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError>;
}
