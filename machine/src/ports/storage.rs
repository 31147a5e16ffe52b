//! Files, as the machine needs them. Paths are absolute (`/sd/config.ini`) and at most [`PATH_BYTES`] long.

/// Longest path: as long as the longest line.
pub const PATH_BYTES: usize = 256;
/// Longest name in a directory: FAT allows 255 UTF-16 units, each at most three bytes of UTF-8.
pub const NAME_BYTES: usize = 765;
/// How many directory entries one [`Storage::list`] call returns. Each takes 800 bytes.
pub const LIST_CHUNK: usize = 4;

/// An open file. The board decides how many can be open at once; five suffice for this crate, and four more
/// that are open beside ([`OpenMode::Beside`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileHandle(pub u8);

/// How to open a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpenMode {
    /// The file must exist; from its start.
    Read,
    /// As `Read`, beside whoever else has it open, and in nobody's way: who changes the file closes it, and
    /// it is not found from then on.
    Beside,
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
    /// The volume claims blocks that its partition, or the card, does not have.
    LargerThanCard,
    /// It has FAT12, as cards of a few megabytes have.
    Fat12,
    /// It has NTFS.
    Ntfs,
    /// It has exFAT, which is only read.
    Exfat,
    /// It has exFAT in a form that is not read.
    OddExfat,
    /// It is a MultiMediaCard, or works by rules that the board does not offer.
    WrongCard,
    /// It is locked with a password.
    Locked,
    /// It takes no writes: its switch, or it itself, has protected it for good.
    Protected,
    /// What is written reads back as something else: it claims more than it has, or is worn out.
    NotKept,
    /// It cannot read one of its blocks.
    Unreadable,
    /// A write has failed, and what was written behind it is lost.
    WriteFailed,
    /// A computer has it, over USB.
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

/// What a card is, and what it has done since power-on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CardFacts {
    /// SDSC, SDHC or SDXC.
    pub kind: &'static str,
    /// Its product name.
    pub name: [u8; 5],
    /// Its maker's number.
    pub maker: u8,
    /// Blocks of 512 bytes.
    pub blocks: u32,
    /// The clock of its bus, kHz.
    pub bus_khz: u32,
    /// It takes no writes.
    pub is_protected: bool,
    /// Blocks read.
    pub reads: u32,
    /// Blocks written.
    pub writes: u32,
    /// Transfers that were tried again.
    pub repeated: u32,
    /// Of these, because something arrived damaged.
    pub damaged: u32,
    /// The longest transfer that was read, us.
    pub slowest_read_us: u32,
    /// The longest that was written, us.
    pub slowest_write_us: u32,
}

/// What is free, while it is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FreeSpace {
    /// Where the count goes on.
    pub next: u32,
    /// Bytes that are free, as far as it was counted.
    pub bytes: u64,
    /// Bytes that files can have altogether.
    pub total_bytes: u64,
}

/// What has happened to the card by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardEvent {
    /// One was put in, and is not mounted.
    Inserted,
    /// It was taken out, or has failed altogether.
    Removed {
        /// With something that was to be written.
        loses: bool,
    },
    /// A write has failed for good, and those behind it are lost.
    WriteFailed(StorageError),
    /// Much arrived damaged, so its bus is slower from now on, kHz.
    Slower(u32),
}

/// What a file is marked with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FileAttributes {
    /// Not to be written or removed.
    pub read_only: bool,
    /// Not listed by DOS.
    pub hidden: bool,
    /// Part of an operating system.
    pub system: bool,
    /// Changed since the last backup.
    pub archive: bool,
}

/// When a file was written, by the clock of whoever wrote it.
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
    /// What files written here are dated, as the board keeps no time while it is off (the coin cell is not
    /// fitted).
    pub const NO_CLOCK: Self = Self { year: 2021, month: 5, day: 18, hour: 18, minute: 20 };
}

/// One entry of a directory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DirectoryEntry {
    /// Its long name, or the short one if it has no other.
    pub name: heapless::String<NAME_BYTES>,
    /// Size in bytes; 0 for a directory.
    pub size_bytes: u32,
    /// Is it a directory?
    pub is_directory: bool,
    /// What it is marked with.
    pub attributes: FileAttributes,
    /// When it was written last.
    pub written: FileTime,
}

/// A file system. Names are the same without regard to case, and keep the case they were made with. A file is
/// open once at a time, and beside ([`OpenMode::Beside`]) as often as there is room.
pub trait Storage {
    /// Finds the card and its file system. Called at boot; may be called again after a card change.
    fn mount(&mut self) -> Result<(), StorageError>;

    /// The card is gone: what was open on it is nowhere, and nothing of it goes to the next card.
    fn forget_card(&mut self) {}

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

    /// Closes a file. What was written is on its way to the card: see [`is_kept`](Self::is_kept).
    fn close(&mut self, file: FileHandle) -> Result<(), StorageError>;

    /// Reads up to [`LIST_CHUNK`] entries of a directory, skipping the first `skip`; an empty answer is the
    /// end.
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

    /// Renames or moves a file or directory that is not open; nothing may have the new name. After a power
    /// cut, once mounted again, it has one of both names.
    fn rename(&mut self, from: &str, to: &str) -> Result<(), StorageError>;

    /// This file is played from where it is: it is read ahead, so that a card that stalls holds nobody up.
    /// One at a time; another one instead of the one before.
    fn read_ahead(&mut self, _file: FileHandle) {}

    /// Whether reading on in a file takes no waiting for the card. What is missing is asked for.
    fn is_at_hand(&mut self, _file: FileHandle) -> bool {
        true
    }

    /// Whether the card is at rest, and takes as many blocks as most changes write without making anybody
    /// wait. It is kept so for a moment: who asks goes ahead, or asks again.
    fn is_ready(&mut self) -> bool {
        true
    }

    /// Whether all that was written is on the card.
    ///
    /// # Errors
    /// Why something is not; until the next change begins.
    fn is_kept(&mut self) -> Result<bool, StorageError> {
        Ok(true)
    }

    /// What the card is; none without one, or where nothing is known of it.
    fn card_facts(&mut self) -> Option<CardFacts> {
        None
    }

    /// Counts on what is free, for some milliseconds at most; true when all of it is counted.
    fn count_free(&mut self, _free: &mut FreeSpace) -> Result<bool, StorageError> {
        Err(StorageError::Unsupported)
    }

    /// What has happened to the card and nobody has heard of.
    fn take_event(&mut self) -> Option<CardEvent> {
        None
    }

    /// Between the steps of a change that takes several, each some block writes of up to a quarter of a
    /// second: whoever makes it is alive. A board tells its watchdog.
    fn between_steps(&mut self) {}
}
