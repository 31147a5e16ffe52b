//! Power-loss journal of a job: the facts needed to go on with it after a power cut, kept on the card while a
//! file is played.
//!
//! The journal is a file of twelve blocks that is made once and written in place, a whole block at a time, so
//! that neither allocation table nor directory is touched while a file is played. Two places, used in turns,
//! hold the constants of a job (the file, and the state of the program at its beginning); a ring of eight
//! holds its progress. Each block has a sequence number and a check value: if the power cuts off any write,
//! the entry before it is whole.

mod record;

use base::paths::{CONFIG_PATH, OVERRIDE_PATH, Path};
use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use config::MAX_SWITCHES;
use program::Kept;
use record::{BLOCK, Block, Fields, Kind, crc32};
use units::{AxisSet, Micros, PerAxis};

pub use record::{Beginning, Doing, Entry, PlayedFile};

/// Path of the journal.
pub const PATH: &str = "/sd/power-loss.journal";
/// Number of blocks of a job's file and beginning, twice.
const JOBS: u32 = 4;
/// Number of entries in the ring.
const ENTRIES: u32 = 8;
const BLOCKS: u32 = JOBS + ENTRIES;
/// Number of blocks of a played file that are in its check value, the first and the last among them.
const SAMPLES: u32 = 16;

/// A job that can go on.
#[derive(Clone, Debug)]
pub struct Offer {
    /// File of the job.
    pub file: PlayedFile,
    /// State in which the job began.
    pub beginning: Beginning,
    /// Last entry, where the job goes on.
    pub entry: Entry,
}

/// Step of the recovery of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The line of the entry has been read: was the machine on its way?
    Compare,
    /// The lines after it have been read: is Z known?
    Look,
    /// The file has been read up to that line: heat, lift, home.
    Prepare,
    /// The script has ended: go back to the part.
    GoBack,
}

/// A job under recovery.
#[derive(Clone, Debug)]
pub struct Recovery {
    /// Job that is recovered.
    pub offer: Offer,
    /// Height of the machine, Z, mm.
    pub z: f64,
    /// Whether somebody has told Z.
    pub z_is_told: bool,
    /// Whether Z is unknown: then it homes upwards before anything else moves.
    pub goes_up_blind: bool,
    /// Highest Z of the job so far, mm.
    pub highest: f64,
    /// Whether motion knows the machine's position.
    pub is_placed: bool,
    /// Whether heating has begun.
    pub has_heated: bool,
    /// State of the program before the recovery.
    pub before: Beginning,
    /// Beginning of the next line, mm.
    pub place: PerAxis<f64>,
    /// Modes of the program at that line.
    pub kept: Option<Kept>,
    /// Last request for each switch.
    pub switches: [Option<(bool, Option<f32>)>; MAX_SWITCHES],
}

/// Contents of the journal on the card.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "it is read seldom, and there is no heap")]
pub enum Found {
    /// There was no job.
    Nothing,
    /// There was a job, and it can go on.
    Offer(Offer),
    /// There was a job, but the facts known of it do not suffice.
    Broken,
}

/// Journal of the job that is played.
#[derive(Debug, Default)]
pub struct Journal {
    /// Whether M413 has switched the journal on.
    pub is_on: bool,
    file: Option<FileHandle>,
    /// Whether the journal's card was taken out.
    is_lost: bool,
    /// Sequence number of the next block.
    next: u32,
    /// Sequence number of the job's own blocks.
    job: u32,
    /// Time at which the next entry is due.
    pub due: Micros,
    /// Time at which the next look is due.
    pub look_due: Micros,
    /// The last entry written.
    pub last: Entry,
    /// Whether the machine halts: a last entry follows when the motors are at rest.
    pub halts: bool,
    /// Position that motion believed in at the last entry, or at power-on, mm.
    pub stood_at: PerAxis<f64>,
    /// Whether filament has been laid, so that the job can go on.
    pub has_laid: bool,
    /// The last look at the machine.
    pub look: Look,
    /// Whether the card has a job that can go on, and nobody goes on with it.
    pub has_offer: bool,
    /// Axes that have moved away since the last entry: `stood_at` knows their positions, but they are lost
    /// when the power goes.
    pub strayed: AxisSet,
}

/// State seen at the last look.
#[derive(Clone, Copy, Debug, Default)]
pub struct Look {
    /// Height of Z, mm.
    pub z: f64,
    /// Length of filament, mm.
    pub filament: f64,
}

impl Journal {
    /// Creates a journal without a job.
    pub fn new(is_on: bool) -> Self {
        Self { is_on, ..Self::default() }
    }

    /// Returns whether a job is noted.
    pub const fn is_noting(&self) -> bool {
        self.file.is_some()
    }

    /// Finds the number of the next block, before a job begins, by reading the whole file.
    ///
    /// # Errors
    /// Those of the card.
    pub fn count(&mut self, storage: &mut impl Storage) -> Result<(), StorageError> {
        self.close(storage);
        self.next = newest(storage)?.wrapping_add(1);
        Ok(())
    }

    /// Begins a job, once the blocks are [counted](Self::count): writes the constants of the job.
    ///
    /// # Errors
    /// Those of the card; nothing is noted then.
    pub fn begin(
        &mut self,
        file: &PlayedFile,
        beginning: &Beginning,
        storage: &mut impl Storage,
    ) -> Result<(), StorageError> {
        self.file = Some(storage.open(PATH, OpenMode::Append)?);
        // A file that is played replaces the job on offer.
        self.put_entry(Kind::Ended, storage)?;
        self.has_offer = false;
        let (mut block, place) = ([0; BLOCK], self.next % 2 * 2);
        self.job = self.next;
        let mut fields = Fields::write(&mut block, Kind::File, self.job);
        file.clone().go_through(&mut fields);
        fields.seal();
        self.put(place, &block, storage)?;
        let mut fields = Fields::write(&mut block, Kind::Beginning, self.job);
        fields.bytes(&mut beginning.clone());
        fields.seal();
        self.put(place + 1, &block, storage)?;
        self.next = self.next.wrapping_add(1);
        Ok(())
    }

    /// Goes on with a job that was found.
    ///
    /// # Errors
    /// Those of the card.
    pub fn go_on(&mut self, offer: &Offer, storage: &mut impl Storage) -> Result<(), StorageError> {
        self.count(storage)?;
        self.file = Some(storage.open(PATH, OpenMode::Append)?);
        (self.job, self.last, self.has_laid) = (offer.entry.job, offer.entry, true);
        Ok(())
    }

    /// Stops writing, since the card does not answer: earlier entries stay.
    pub fn lose(&mut self) {
        self.is_lost |= self.file.take().is_some();
    }

    /// Goes on with the journal when the card is back, if it has the same journal.
    pub fn reopen(&mut self, storage: &mut impl Storage) {
        if !self.is_lost {
            return;
        }
        self.is_lost = false;
        if newest(storage).is_ok_and(|newest| newest.wrapping_add(1) == self.next) {
            self.file = storage.open(PATH, OpenMode::Append).ok();
        }
    }

    /// Notes the progress of the job in a block.
    ///
    /// # Errors
    /// Those of the card; nothing more is noted then.
    pub fn note(&mut self, entry: Entry, storage: &mut impl Storage) -> Result<(), StorageError> {
        let kind = if entry.stands { Kind::Stopped } else { Kind::Running };
        self.last = Entry { job: self.job, ..entry };
        self.put_entry(kind, storage)
    }

    /// Notes that the job is over.
    pub fn end(&mut self, storage: &mut impl Storage) {
        if self.file.is_some() {
            // The card may be gone, so a failure says nothing.
            let _ = self.put_entry(Kind::Ended, storage);
            self.close(storage);
            self.has_offer = false;
        }
    }

    /// Closes the journal; earlier entries stay.
    pub fn close(&mut self, storage: &mut impl Storage) {
        if let Some(file) = self.file.take() {
            // All blocks have been written.
            let _ = storage.close(file);
            self.has_offer = self.has_laid;
        }
    }

    fn put_entry(&mut self, kind: Kind, storage: &mut impl Storage) -> Result<(), StorageError> {
        let mut block = [0; BLOCK];
        let mut fields = Fields::write(&mut block, kind, self.next);
        self.last.go_through(&mut fields);
        fields.seal();
        self.put(JOBS + self.next % ENTRIES, &block, storage)?;
        self.next = self.next.wrapping_add(1);
        Ok(())
    }

    fn put(&mut self, place: u32, block: &Block, storage: &mut impl Storage) -> Result<(), StorageError> {
        let file = self.file.ok_or(StorageError::NotFound)?;
        let put = storage.seek(file, place * BLOCK as u32).and_then(|()| storage.write(file, block));
        if put.is_err() {
            self.close(storage);
            self.is_lost = true;
        }
        put
    }
}

/// The journal's file while it is made: some sixty block writes, each of which may take a card a quarter of a
/// second.
#[derive(Debug)]
pub struct Blank {
    file: FileHandle,
    left: u32,
}

impl Blank {
    /// Begins the file; `None` if it exists already.
    ///
    /// # Errors
    /// Those of the card.
    pub fn begin(storage: &mut impl Storage) -> Result<Option<Self>, StorageError> {
        if let Ok(file) = storage.open(PATH, OpenMode::Read) {
            let size = storage.size(file);
            storage.close(file)?;
            if size == Ok(BLOCKS * BLOCK as u32) {
                return Ok(None);
            }
        }
        Ok(Some(Self { file: storage.open(PATH, OpenMode::Write)?, left: BLOCKS }))
    }

    /// Writes a further block. Returns true when that was the last.
    ///
    /// # Errors
    /// Those of the card.
    pub fn write(&mut self, storage: &mut impl Storage) -> Result<bool, StorageError> {
        // The blank is a variable: the reference of a constant would have it lie in flash.
        let blank = [0; BLOCK];
        storage.write(self.file, &blank)?;
        self.left = self.left.saturating_sub(1);
        Ok(self.left == 0)
    }

    /// Closes the file, whole or not.
    ///
    /// # Errors
    /// Those of the card.
    pub fn close(self, storage: &mut impl Storage) -> Result<(), StorageError> {
        storage.close(self.file)
    }
}

/// Makes the file, if there is none, before anything else goes on: `alive` is called between blocks.
///
/// # Errors
/// Those of the card.
pub fn prepare<S: Storage>(storage: &mut S, alive: impl Fn(&mut S)) -> Result<(), StorageError> {
    let Some(mut blank) = Blank::begin(storage)? else { return Ok(()) };
    let written = loop {
        alive(storage);
        match blank.write(storage) {
            Ok(false) => {}
            Ok(true) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    alive(storage);
    written.and(blank.close(storage))
}

/// Passes each whole block to `take`; returns the number of broken ones.
fn each(storage: &mut impl Storage, mut take: impl FnMut(Kind, u32, &mut Fields<'_>)) -> Result<u32, StorageError> {
    let file = match storage.open(PATH, OpenMode::Read) {
        Err(StorageError::NotFound) => return Ok(0),
        opened => opened?,
    };
    let (mut block, mut broken) = ([0; BLOCK], 0);
    let read = loop {
        match storage.read(file, &mut block) {
            Ok(BLOCK) => {}
            Ok(_) => break Ok(()),
            Err(error) => break Err(error),
        }
        match Fields::read(&mut block.clone()) {
            Some((kind, sequence, mut fields)) => take(kind, sequence, &mut fields),
            None => broken += u32::from(block.iter().any(|byte| *byte != 0)),
        }
    };
    // The file was only read, so closing it loses nothing.
    let _ = storage.close(file);
    read.map(|()| broken)
}

fn newest(storage: &mut impl Storage) -> Result<u32, StorageError> {
    let mut newest = 0;
    each(storage, |_, sequence, _| newest = newest.max(sequence))?;
    Ok(newest)
}

/// Looks for a job that can go on.
///
/// # Errors
/// Those of the card.
pub fn find(storage: &mut impl Storage) -> Result<Found, StorageError> {
    let mut entry: Option<(u32, Entry, bool)> = None;
    let broken = each(storage, |kind, sequence, fields| {
        if !matches!(kind, Kind::Running | Kind::Stopped | Kind::Ended) {
            return;
        }
        if entry.as_ref().is_none_or(|(newest, ..)| sequence > *newest) {
            let mut read = Entry { stands: kind == Kind::Stopped, ..Entry::default() };
            read.go_through(fields);
            entry = Some((sequence, read, kind == Kind::Ended));
        }
    })?;
    let Some((_, entry, has_ended)) = entry else {
        // The very first write of all may have been cut off: then there was no job yet.
        return Ok(if broken > 1 { Found::Broken } else { Found::Nothing });
    };
    let (mut file, mut beginning, mut later) = (None, None, false);
    each(storage, |kind, sequence, fields| match kind {
        Kind::File | Kind::Beginning if sequence > entry.job => later = true,
        Kind::File if sequence == entry.job => {
            let mut read = PlayedFile::default();
            read.go_through(fields);
            file = Some(read);
        }
        Kind::Beginning if sequence == entry.job => {
            let mut read = [0; program::BEGINNING_BYTES];
            fields.bytes(&mut read);
            beginning = Some(read);
        }
        _ => {}
    })?;
    Ok(match (file, beginning) {
        // A later job had begun, and had not made a line yet.
        _ if has_ended || later => Found::Nothing,
        (Some(file), Some(beginning)) => Found::Offer(Offer { file, beginning, entry }),
        _ => Found::Broken,
    })
}

/// Notes that other moves have moved these axes, a bit each, away from the job that was found.
///
/// # Errors
/// Those of the card.
pub fn stray(offer: &Offer, strayed: u8, storage: &mut impl Storage) -> Result<(), StorageError> {
    let mut journal = Journal::default();
    journal.go_on(offer, storage)?;
    journal.note(Entry { strayed, ..offer.entry }, storage)?;
    journal.close(storage);
    Ok(())
}

/// Forgets the job that was found.
///
/// # Errors
/// Those of the card.
pub fn forget(offer: &Offer, storage: &mut impl Storage) -> Result<(), StorageError> {
    let mut journal = Journal::default();
    journal.go_on(offer, storage)?;
    journal.put_entry(Kind::Ended, storage)?;
    journal.close(storage);
    Ok(())
}

/// Returns a check value over samples of an open file, whose position is undefined afterwards.
///
/// # Errors
/// Those of the card.
pub fn check_value(file: FileHandle, size: u32, storage: &mut impl Storage) -> Result<u32, StorageError> {
    let (mut sum, mut block) = (crc32(0, &size.to_le_bytes()), [0; BLOCK]);
    let last = size.saturating_sub(1) / BLOCK as u32;
    for sample in 0..SAMPLES {
        let number = u64::from(last) * u64::from(sample) / u64::from(SAMPLES - 1);
        storage.seek(file, number as u32 * BLOCK as u32)?;
        let count = storage.read(file, &mut block)?;
        sum = crc32(sum, block.get(..count).unwrap_or(&[]));
    }
    Ok(sum)
}

/// Returns a check value over the configuration and the saved settings, without comments and blanks.
///
/// # Errors
/// Those of the card.
pub fn machine_value(storage: &mut impl Storage) -> Result<u32, StorageError> {
    let mut sum = 0;
    for path in [CONFIG_PATH, OVERRIDE_PATH] {
        let file = match storage.open(path, OpenMode::Read) {
            Err(StorageError::NotFound) => continue,
            opened => opened?,
        };
        let (mut block, mut in_comment) = ([0; BLOCK], false);
        let read = loop {
            let count = match storage.read(file, &mut block) {
                Ok(0) => break Ok(()),
                Ok(count) => count,
                Err(error) => break Err(error),
            };
            for byte in block.get(..count).unwrap_or(&[]) {
                in_comment = matches!(byte, b'#' | b';') || in_comment && *byte != b'\n';
                if !in_comment && !byte.is_ascii_whitespace() {
                    sum = crc32(sum, &[*byte]);
                }
            }
        };
        // The file was only read, so closing it loses nothing.
        let _ = storage.close(file);
        read?;
    }
    Ok(sum)
}

/// Returns the time at which a file was written, as its directory says; 0 if unknown.
///
/// # Errors
/// Those of the card.
pub fn written(path: &Path, storage: &mut impl Storage) -> Result<u32, StorageError> {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    let (mut skip, mut entries) = (0, heapless::Vec::new());
    loop {
        storage.list(folder, skip, &mut entries)?;
        if let Some(entry) = entries.iter().find(|entry| entry.name.eq_ignore_ascii_case(name)) {
            let at = entry.written;
            let day = (u32::from(at.year) * 13 + u32::from(at.month)) * 32 + u32::from(at.day);
            return Ok((day * 24 + u32::from(at.hour)) * 60 + u32::from(at.minute));
        }
        if entries.is_empty() {
            return Ok(0);
        }
        skip += entries.len();
    }
}

#[cfg(test)]
mod tests;
