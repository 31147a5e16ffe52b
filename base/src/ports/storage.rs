//! Files, as the machine needs them. Paths are absolute (`/sd/config.ini`) and at most [`PATH_BYTES`] long.

use card::sd::Counters;
use events::DateTime;

/// Longest path, bytes: as long as the longest line.
pub const PATH_BYTES: usize = 256;
/// Longest name in a directory, bytes: FAT allows 255 UTF-16 units, each at most three bytes of UTF-8.
pub const NAME_BYTES: usize = 765;
/// Greatest number of directory entries that one [`Storage::list`] call returns. Each takes 800 bytes.
pub const LIST_CHUNK: usize = 4;

/// Handle of an open file: the board has seven at once, and twelve beside ([`OpenMode::Beside`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileHandle(pub u8);

/// Mode of opening a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpenMode {
    /// The file must exist; from its start.
    Read,
    /// As `Read`, beside other users of the file, and in nobody's way: a change of the file closes it, and it
    /// is not found from then on.
    Beside,
    /// Created when missing, emptied when not.
    Write,
    /// Created when missing, written at its end.
    Append,
}

/// Reason why storage refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StorageError {
    /// No card, or none that answers to identification.
    NoCard,
    /// The card has no file system this firmware reads.
    NoFileSystem,
    /// The volume claims blocks that its partition, or the card, does not have.
    LargerThanCard,
    /// The card has FAT12, as cards of a few megabytes have.
    Fat12,
    /// The card has NTFS.
    Ntfs,
    /// The card has exFAT, which is only read.
    Exfat,
    /// The card has exFAT in a form that is not read.
    OddExfat,
    /// The card is a MultiMediaCard, or works by rules that the board does not offer.
    WrongCard,
    /// The card is locked with a password.
    Locked,
    /// The card takes no writes: its switch, or the card itself, has protected it for good.
    Protected,
    /// Written data reads back as something else: the card claims more than it has, or is worn out.
    NotKept,
    /// The file holds a secret of the machine, which nobody is shown.
    Secret,
    /// The card cannot read one of its blocks.
    Unreadable,
    /// A write has failed, and later writes are lost.
    WriteFailed,
    /// A computer has the card, over USB.
    Lent,
    /// The card stopped answering.
    NotResponding,
    /// No such file or directory.
    NotFound,
    /// The name is taken.
    Exists,
    /// A directory where a file was expected, or the other way round, or not empty.
    WrongKind,
    /// The path is too long or has an illegal character, or a directory would be moved into itself.
    BadPath,
    /// The card is full.
    Full,
    /// The card's root directory is full: on a FAT16 card it has a fixed size.
    DirectoryFull,
    /// The file is open: it is being played, written or read.
    Busy,
    /// The file is marked read-only.
    ReadOnly,
    /// The file system contradicts itself.
    Damaged,
    /// More files are open than the board allows.
    TooManyOpen,
    /// The storage does not support the operation.
    Unsupported,
    /// The card reports a read or write error.
    Device,
}

impl StorageError {
    /// Returns a sentence for a person.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoCard => "no SD card found: insert a card and reset",
            Self::LargerThanCard => {
                "the SD card is smaller than its file system: a copy of a larger card, or a forgery; format it anew"
            }
            Self::NoFileSystem => "the SD card has no FAT file system: format it as FAT32",
            Self::Fat12 => {
                "the SD card has a FAT12 file system, which is for cards of a few MB: format it as FAT16 or FAT32"
            }
            Self::Ntfs => "the SD card has an NTFS file system: format it as FAT32",
            Self::Exfat => {
                "the SD card has exFAT, which is only read here: to write to it, format it as FAT32 on a computer"
            }
            Self::OddExfat => "the SD card has exFAT in a form that is not read here: format it as FAT32",
            Self::WrongCard => "this is no SD card that the board can use: use an SDHC card",
            Self::Locked => "the SD card is locked with a password: unlock it where it was locked, or use another",
            Self::Protected => "the SD card is write-protected: move its switch, or use another card",
            Self::NotKept => {
                "the SD card does not keep what is written to it: it is worn out or a forgery; use another card"
            }
            Self::Secret => "it is a secret of the machine, which is not shown",
            Self::Unreadable => "the SD card cannot read a part of itself any more: save its files and replace it",
            Self::WriteFailed => "a write to the SD card has failed and what came after it is lost: replace the card",
            Self::Lent => "a computer uses the SD card over USB: eject it there first",
            Self::NotResponding => "the SD card stopped answering: check that it is seated, or replace it",
            Self::NotFound => "no such file",
            Self::Exists => "the name is already in use",
            Self::WrongKind => "is a directory, is not one, or is not empty",
            Self::BadPath => "the path is too long or not legal",
            Self::Full => "the SD card is full",
            Self::DirectoryFull => {
                "the directory is full: put files into other directories, or format the card as FAT32"
            }
            Self::Busy => "the file is in use: wait until it is closed, or end the job",
            Self::ReadOnly => "the file is marked read-only",
            Self::Damaged => "the SD card's file system is damaged: check the card on a computer",
            Self::TooManyOpen => "too many files are open",
            Self::Unsupported => "not supported by this storage",
            Self::Device => "the SD card reports a read or write error",
        }
    }
}

/// Data of a card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CardFacts {
    /// Type: SDSC, SDHC or SDXC.
    pub kind: &'static str,
    /// Product name of the card.
    pub name: [u8; 5],
    /// Number of the card's maker.
    pub maker: u8,
    /// Blocks of 512 bytes.
    pub blocks: u32,
    /// Clock of the card's bus, kHz.
    pub bus_khz: u32,
    /// Whether the card takes no writes.
    pub is_protected: bool,
    /// Blocks moved, transfers repeated and longest times since power-on.
    pub counters: Counters,
}

/// Count of the free space, in progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FreeSpace {
    /// Place where the count goes on.
    pub next: u32,
    /// Free bytes counted so far.
    pub bytes: u64,
    /// Bytes that files can have altogether.
    pub total_bytes: u64,
}

/// Event of the card by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardEvent {
    /// A card was put in, and is not mounted.
    Inserted,
    /// The card was taken out, or has failed altogether.
    Removed {
        /// Whether unwritten data is lost with it.
        loses: bool,
    },
    /// A write has failed for good, and later writes are lost.
    WriteFailed(StorageError),
    /// Much arrived damaged, so the card's bus is slower from now on, kHz.
    Slower(u32),
}

/// Attributes of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FileAttributes {
    /// Whether writing and removing are forbidden.
    pub read_only: bool,
    /// Whether DOS does not list the file.
    pub hidden: bool,
    /// Whether the file is part of an operating system.
    pub system: bool,
    /// Whether the file has changed since the last backup.
    pub archive: bool,
}

/// Time at which a file was written, by the writer's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileTime {
    /// Year, 1980 to 2107.
    pub year: u16,
    /// Month, 1 to 12; 0 if there is no date.
    pub month: u8,
    /// Day, 1 to 31; 0 if there is no date.
    pub day: u8,
    /// Hour, 0 to 23.
    pub hour: u8,
    /// Minute, 0 to 59.
    pub minute: u8,
}

impl FileTime {
    /// Date of files written here without a clock, as the board keeps no time while it is off (the coin cell
    /// is not fitted).
    pub const NO_CLOCK: Self = Self { year: 2021, month: 5, day: 18, hour: 18, minute: 20 };

    /// Returns the time of a file written at a date. An unset clock says nothing about today.
    #[must_use]
    pub const fn of(date: DateTime) -> Self {
        let DateTime { year, month, day, hour, minute, .. } = date;
        if date.is_set() { Self { year, month, day, hour, minute } } else { Self::NO_CLOCK }
    }
}

/// Entry of a directory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DirectoryEntry {
    /// Long name, or the short one if there is no other.
    pub name: heapless::String<NAME_BYTES>,
    /// Size in bytes; 0 for a directory.
    pub size_bytes: u32,
    /// Whether the entry is a directory.
    pub is_directory: bool,
    /// Attributes of the entry.
    pub attributes: FileAttributes,
    /// Time of the last write.
    pub written: FileTime,
}

/// Properties of a file or directory that is found by its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileFacts {
    /// Size in bytes; 0 for a directory.
    pub size_bytes: u32,
    /// Whether it is a directory.
    pub is_directory: bool,
    /// Whether writing and removing are forbidden.
    pub is_read_only: bool,
    /// Time of the last write.
    pub written: FileTime,
    /// Number that changes with the content, as far as the file's size, date and place on the card tell.
    pub tag: u64,
}

/// Access to a file system. Names are the same without regard to case, and keep the case they were made with.
/// A file is open once at a time, and beside ([`OpenMode::Beside`]) as often as there is room.
pub trait Storage {
    /// Finds the card and its file system. Called at boot; may be called again after a card change.
    fn mount(&mut self) -> Result<(), StorageError>;

    /// Forgets the card, which is gone: files that were open on it are nowhere, and nothing of it goes to the
    /// next card.
    fn forget_card(&mut self) {}

    /// Opens a file or creates it.
    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError>;

    /// Reads on from the present offset; 0 is the end of the file.
    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError>;

    /// Writes all of `bytes`.
    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError>;

    /// Moves the offset, counted from the start.
    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError>;

    /// Returns the size of an open file in bytes.
    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError>;

    /// Closes a file. Written data is on its way to the card: see [`is_kept`](Self::is_kept).
    fn close(&mut self, file: FileHandle) -> Result<(), StorageError>;

    /// Reads up to [`LIST_CHUNK`] entries of a directory, skipping the first `skip`; an empty answer is the
    /// end.
    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError>;

    /// Returns the entry of a directory behind the first `skip`; none behind the last one. To go on by one
    /// entry is as cheap as [`list`](Self::list), and so is asking for the same entry again.
    fn entry(&mut self, path: &str, skip: usize) -> Result<Option<DirectoryEntry>, StorageError> {
        let mut entries = heapless::Vec::new();
        self.list(path, skip, &mut entries)?;
        Ok(entries.into_iter().next())
    }

    /// Returns the properties of a file or directory.
    fn facts(&mut self, _path: &str) -> Result<FileFacts, StorageError> {
        Err(StorageError::Unsupported)
    }

    /// Removes a file or an empty directory.
    fn remove(&mut self, path: &str) -> Result<(), StorageError>;

    /// Makes a new directory.
    fn make_directory(&mut self, path: &str) -> Result<(), StorageError>;

    /// Renames or moves a file or directory that is not open; nothing may have the new name. After a power
    /// cut, once mounted again, it has one of both names.
    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError>;

    /// Has a file that is being played read ahead from its offset, so that a card that stalls holds nobody
    /// up. For one file at a time; another one takes its place.
    fn read_ahead(&mut self, _file: FileHandle) {}

    /// Returns whether reading on in a file takes no waiting for the card. Missing blocks are asked for.
    fn is_at_hand(&mut self, _file: FileHandle) -> bool {
        true
    }

    /// Returns whether the card is at rest, and takes as many blocks as most changes write without making
    /// anybody wait. The card is kept so for a moment: the caller goes ahead, or asks again.
    fn is_ready(&mut self) -> bool {
        true
    }

    /// Returns whether all that was written is on the card.
    ///
    /// # Errors
    /// The error of a failed write, until the next change begins.
    fn is_kept(&mut self) -> Result<bool, StorageError> {
        Ok(true)
    }

    /// Returns whether to write so many bytes behind what was written takes no waiting, though others wait.
    fn can_write_on(&mut self, _file: FileHandle, _bytes: usize) -> bool {
        false
    }

    /// Returns a number that rises whenever an entry of a folder is made, emptied, renamed or removed.
    fn changes(&mut self) -> u32 {
        0
    }

    /// Lets what was written go to the card now, as nothing of the same change follows.
    fn let_go(&mut self) {}

    /// Returns data of the card; none without one, or where nothing is known of it.
    fn card_facts(&mut self) -> Option<CardFacts> {
        None
    }

    /// Counts free space for some milliseconds at most; true when all of it is counted.
    fn count_free(&mut self, _free: &mut FreeSpace) -> Result<bool, StorageError> {
        Err(StorageError::Unsupported)
    }

    /// Takes the next event of the card.
    fn take_event(&mut self) -> Option<CardEvent> {
        None
    }

    /// Reports life between the steps of a change that takes several, each some block writes of up to a
    /// quarter of a second. A board tells its watchdog.
    fn between_steps(&mut self) {}
}

/// Ports whose files are in the hands of an owner of their own.
pub trait FilesPort {
    /// The owner of the files.
    type Files: Storage;

    /// Runs an action on the files.
    fn files<R>(&mut self, action: impl FnOnce(&mut Self::Files) -> R) -> R;
}

impl<P: FilesPort> Storage for P {
    fn mount(&mut self) -> Result<(), StorageError> {
        self.files(Storage::mount)
    }

    fn forget_card(&mut self) {
        self.files(Storage::forget_card);
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        self.files(|files| files.open(path, mode))
    }

    fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        self.files(|files| files.read(file, buffer))
    }

    fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        self.files(|files| files.write(file, bytes))
    }

    fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        self.files(|files| files.seek(file, offset_bytes))
    }

    fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        self.files(|files| files.size(file))
    }

    fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        self.files(|files| files.close(file))
    }

    fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut heapless::Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        self.files(|files| files.list(path, skip, entries))
    }

    fn entry(&mut self, path: &str, skip: usize) -> Result<Option<DirectoryEntry>, StorageError> {
        self.files(|files| files.entry(path, skip))
    }

    fn facts(&mut self, path: &str) -> Result<FileFacts, StorageError> {
        self.files(|files| files.facts(path))
    }

    fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        self.files(|files| files.remove(path))
    }

    fn make_directory(&mut self, path: &str) -> Result<(), StorageError> {
        self.files(|files| files.make_directory(path))
    }

    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError> {
        self.files(|files| files.rename(from, to))
    }

    fn read_ahead(&mut self, file: FileHandle) {
        self.files(|files| files.read_ahead(file));
    }

    fn is_at_hand(&mut self, file: FileHandle) -> bool {
        self.files(|files| files.is_at_hand(file))
    }

    fn is_ready(&mut self) -> bool {
        self.files(Storage::is_ready)
    }

    fn is_kept(&mut self) -> Result<bool, StorageError> {
        self.files(Storage::is_kept)
    }

    fn card_facts(&mut self) -> Option<CardFacts> {
        self.files(Storage::card_facts)
    }

    fn count_free(&mut self, free: &mut FreeSpace) -> Result<bool, StorageError> {
        self.files(|files| files.count_free(free))
    }

    fn take_event(&mut self) -> Option<CardEvent> {
        self.files(Storage::take_event)
    }

    fn between_steps(&mut self) {
        self.files(Storage::between_steps);
    }
}

#[cfg(test)]
mod tests;
