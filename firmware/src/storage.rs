//! Files on the SD card: `machine`'s storage port over the FAT file system of `embedded-sdmmc`.
//!
//! Names are compared without regard to case, long and short alike. The file system can read long names but not make them: a new file gets its name cut
//! to eight letters and three (`config-override` becomes `CONFIG-O`), and is found again under either. It cannot rename; that is refused.

use core::ops::ControlFlow;

use bsp_prime::sd::{SdCard, SdError};
use embedded_sdmmc::filesystem::ToShortFileName;
use embedded_sdmmc::{
    DirEntry, Error, LfnBuffer, Mode, RawDirectory, RawFile, RawVolume, ShortFileName, TimeSource, Timestamp,
    VolumeIdx, VolumeManager,
};
use heapless::Vec;
use machine::ports::{DirectoryEntry, FileHandle, LIST_CHUNK, NAME_BYTES, OpenMode, StorageError};

/// Files open at once.
const MAX_FILES: usize = 4;
/// Directories open at once: one being walked, its parent, and one to spare.
const MAX_DIRECTORIES: usize = 4;
/// A long name has at most 255 characters of up to three bytes.
const LONG_NAME_BYTES: usize = 255 * 3;
/// Where the card appears in paths.
const MOUNT_POINT: &str = "sd";

type Manager = VolumeManager<SdCard, NoClock, MAX_DIRECTORIES, MAX_FILES, 1>;

/// Files get this date: the board keeps no time while it is off (the coin cell is not fitted).
struct NoClock;

impl TimeSource for NoClock {
    fn get_timestamp(&self) -> Timestamp {
        Timestamp {
            year_since_1970: 51,
            zero_indexed_month: 4,
            zero_indexed_day: 17,
            hours: 18,
            minutes: 20,
            seconds: 0,
        }
    }
}

/// The card with its file system.
pub struct CardStorage {
    manager: Manager,
    volume: Option<RawVolume>,
    files: [Option<RawFile>; MAX_FILES],
}

impl CardStorage {
    /// Not mounted.
    pub fn new(card: SdCard) -> Self {
        Self { manager: Manager::new_with_limits(card, NoClock, 1), volume: None, files: [None; MAX_FILES] }
    }

    /// Finds the card and its first partition. What was open is closed, as it may be another card.
    pub fn mount(&mut self) -> Result<(), StorageError> {
        for file in self.files.iter_mut().filter_map(Option::take) {
            // The old card may be gone: that its files cannot be closed properly is no reason not to look for a new one.
            let _gone = self.manager.close_file(file);
        }
        if let Some(volume) = self.volume.take() {
            let _gone = self.manager.close_volume(volume);
        }
        self.manager.device(|card| card.identify()).map_err(|error| device_error(&error))?;
        self.volume = Some(self.manager.open_raw_volume(VolumeIdx(0)).map_err(|error| match error {
            Error::DeviceError(error) => device_error(&error),
            _ => StorageError::NoFileSystem,
        })?);
        Ok(())
    }

    pub fn open(&mut self, path: &str, mode: OpenMode) -> Result<FileHandle, StorageError> {
        let slot = self.files.iter().position(Option::is_none).ok_or(StorageError::TooManyOpen)?;
        let file = self.in_directory_of(path, |storage, directory, name| {
            let found = storage.find(directory, name)?;
            if found.as_ref().is_some_and(|entry| entry.attributes.is_directory()) {
                return Err(StorageError::WrongKind);
            }
            let name = match (found, mode) {
                (Some(entry), _) => entry.name,
                (None, OpenMode::Read) => return Err(StorageError::NotFound),
                (None, _) => shortened(name)?,
            };
            let mode = match mode {
                OpenMode::Read => Mode::ReadOnly,
                OpenMode::Write => Mode::ReadWriteCreateOrTruncate,
                OpenMode::Append => Mode::ReadWriteCreateOrAppend,
            };
            storage.manager.open_file_in_dir(directory, name, mode).map_err(storage_error)
        })?;
        if let Some(place) = self.files.get_mut(slot) {
            *place = Some(file);
        }
        Ok(FileHandle(slot as u8))
    }

    fn file(&self, file: FileHandle) -> Result<RawFile, StorageError> {
        self.files.get(usize::from(file.0)).copied().flatten().ok_or(StorageError::NotFound)
    }

    pub fn read(&mut self, file: FileHandle, buffer: &mut [u8]) -> Result<usize, StorageError> {
        self.manager.read(self.file(file)?, buffer).map_err(storage_error)
    }

    pub fn write(&mut self, file: FileHandle, bytes: &[u8]) -> Result<(), StorageError> {
        self.manager.write(self.file(file)?, bytes).map_err(storage_error)
    }

    pub fn seek(&mut self, file: FileHandle, offset_bytes: u32) -> Result<(), StorageError> {
        self.manager.file_seek_from_start(self.file(file)?, offset_bytes).map_err(storage_error)
    }

    pub fn size(&mut self, file: FileHandle) -> Result<u32, StorageError> {
        self.manager.file_length(self.file(file)?).map_err(storage_error)
    }

    pub fn close(&mut self, file: FileHandle) -> Result<(), StorageError> {
        let raw = self.file(file)?;
        if let Some(place) = self.files.get_mut(usize::from(file.0)) {
            *place = None;
        }
        self.manager.close_file(raw).map_err(storage_error)
    }

    pub fn list(
        &mut self,
        path: &str,
        skip: usize,
        entries: &mut Vec<DirectoryEntry, LIST_CHUNK>,
    ) -> Result<(), StorageError> {
        entries.clear();
        let directory = self.open_directory(path)?;
        let mut to_skip = skip;
        let result = self.for_each(directory, |entry, name| {
            if to_skip > 0 {
                to_skip -= 1;
                return ControlFlow::Continue(());
            }
            let mut listed = DirectoryEntry {
                name: heapless::String::new(),
                size_bytes: entry.size,
                is_directory: entry.attributes.is_directory(),
            };
            for letter in name.chars().take(NAME_BYTES) {
                if listed.name.push(letter).is_err() {
                    break;
                }
            }
            match entries.push(listed) {
                Ok(()) if !entries.is_full() => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        });
        self.close_directory(directory);
        result
    }

    pub fn remove(&mut self, path: &str) -> Result<(), StorageError> {
        self.in_directory_of(path, |storage, directory, name| {
            let entry = storage.find(directory, name)?.ok_or(StorageError::NotFound)?;
            storage.manager.delete_entry_in_dir(directory, entry.name).map_err(storage_error)
        })
    }

    pub fn make_directory(&mut self, path: &str) -> Result<(), StorageError> {
        self.in_directory_of(path, |storage, directory, name| {
            if storage.find(directory, name)?.is_some() {
                return Err(StorageError::Exists);
            }
            storage.manager.make_dir_in_dir(directory, shortened(name)?).map_err(storage_error)
        })
    }

    /// Runs `action` with the open directory that holds the last part of `path`, and that part.
    fn in_directory_of<R>(
        &mut self,
        path: &str,
        action: impl FnOnce(&mut Self, RawDirectory, &str) -> Result<R, StorageError>,
    ) -> Result<R, StorageError> {
        let (parent, name) = path.trim_end_matches('/').rsplit_once('/').ok_or(StorageError::BadPath)?;
        if name.is_empty() {
            return Err(StorageError::BadPath);
        }
        let directory = self.open_directory(parent)?;
        let result = action(self, directory, name);
        self.close_directory(directory);
        result
    }

    fn open_directory(&mut self, path: &str) -> Result<RawDirectory, StorageError> {
        let volume = self.volume.ok_or(StorageError::NoCard)?;
        let mut parts = path.split('/').filter(|part| !part.is_empty());
        if !parts.next().is_some_and(|first| first.eq_ignore_ascii_case(MOUNT_POINT)) {
            return Err(StorageError::NotFound);
        }
        let mut directory = self.manager.open_root_dir(volume).map_err(storage_error)?;
        for part in parts {
            let inner = self.enter(directory, part);
            self.close_directory(directory);
            directory = inner?;
        }
        Ok(directory)
    }

    fn enter(&mut self, directory: RawDirectory, name: &str) -> Result<RawDirectory, StorageError> {
        let entry = self.find(directory, name)?.ok_or(StorageError::NotFound)?;
        self.manager.open_dir(directory, entry.name).map_err(storage_error)
    }

    fn close_directory(&mut self, directory: RawDirectory) {
        // It was opened by the caller; closing an open directory touches no card and cannot fail.
        let _closed = self.manager.close_dir(directory);
    }

    /// The entry of this name: long, short, or short as [`shortened`] makes it.
    fn find(&mut self, directory: RawDirectory, name: &str) -> Result<Option<DirEntry>, StorageError> {
        let short = shortened(name).ok();
        let (mut exact, mut cut) = (None, None);
        self.for_each(directory, |entry, entry_name| {
            if entry_name.eq_ignore_ascii_case(name) {
                exact = Some(entry.clone());
                return ControlFlow::Break(());
            }
            if short.as_ref() == Some(&entry.name) {
                cut = Some(entry.clone());
            }
            ControlFlow::Continue(())
        })?;
        Ok(exact.or(cut))
    }

    /// Calls `action` with every entry and its name, until it breaks. `.`, `..` and the volume's label are left out.
    fn for_each(
        &mut self,
        directory: RawDirectory,
        mut action: impl FnMut(&DirEntry, &str) -> ControlFlow<()>,
    ) -> Result<(), StorageError> {
        let mut storage = [0; LONG_NAME_BYTES];
        let mut buffer = LfnBuffer::new(&mut storage);
        self.manager
            .iterate_dir_lfn(directory, &mut buffer, |entry, long| {
                if entry.attributes.is_volume() || entry.name.base_name().starts_with(b".") {
                    return ControlFlow::Continue(());
                }
                let mut short = heapless::String::<16>::new();
                // At most eight letters, a point and three: fits.
                let _fits = core::fmt::write(&mut short, format_args!("{}", entry.name));
                action(entry, long.unwrap_or(&short))
            })
            .map_err(storage_error)
    }
}

/// A name cut to eight letters and three.
fn shortened(name: &str) -> Result<ShortFileName, StorageError> {
    let (stem, extension) = name.rsplit_once('.').unwrap_or((name, ""));
    let mut short = heapless::String::<12>::new();
    let allowed = |letter: &char| letter.is_ascii() && !matches!(letter, '.' | ' ');
    let push = |short: &mut heapless::String<12>, text: &str, count| {
        // Eight, a point and three fit in twelve.
        text.chars().filter(allowed).take(count).for_each(|letter| drop(short.push(letter.to_ascii_uppercase())));
    };
    push(&mut short, stem, 8);
    if !extension.is_empty() {
        let _fits = short.push('.');
        push(&mut short, extension, 3);
    }
    short.as_str().to_short_filename().map_err(|_| StorageError::BadPath)
}

fn device_error(error: &SdError) -> StorageError {
    match error {
        SdError::NoCard | SdError::NotIdentified => StorageError::NoCard,
        SdError::NotResponding(_) => StorageError::NotResponding,
        _ => StorageError::Device,
    }
}

fn storage_error(error: Error<SdError>) -> StorageError {
    match error {
        Error::DeviceError(error) => device_error(&error),
        Error::NotFound => StorageError::NotFound,
        Error::FilenameError(_) | Error::InvalidOffset => StorageError::BadPath,
        Error::TooManyOpenDirs | Error::TooManyOpenFiles | Error::TooManyOpenVolumes => StorageError::TooManyOpen,
        Error::FileAlreadyExists | Error::DirAlreadyExists | Error::FileAlreadyOpen | Error::DirAlreadyOpen => {
            StorageError::Exists
        }
        Error::OpenedDirAsFile | Error::OpenedFileAsDir | Error::DeleteNonEmptyDir => StorageError::WrongKind,
        Error::NotEnoughSpace | Error::DiskFull | Error::AllocationError => StorageError::Full,
        Error::Unsupported | Error::ReadOnly => StorageError::Unsupported,
        Error::FormatError(_) | Error::NoSuchVolume | Error::BadBlockSize(_) => StorageError::NoFileSystem,
        _ => StorageError::Device,
    }
}
