//! The log of updates in the last sector: what was asked for, what was begun, what has run. Each entry is one
//! flash word, written behind the others and never changed, so that the power may fail between any two; an
//! entry that the failure tore is passed over.
//!
//! | bytes | what |
//! |--:|---|
//! | 0 | kind |
//! | 1 | what more there is to say: an origin, a number |
//! | 4 | length of the image |
//! | 8 | the first 16 bytes of its digest, or 16 of a key |
//! | 28 | CRC-32 (ISO 3309) of the bytes before |

use crate::flash::{ERASED, Failed, Flash, Layout, POLICY_BYTES, WORD, Word};
use crate::manifest::Manifest;
use crate::policy::Policy;

/// Words that the boot stage needs at most for one update; with fewer left it empties the log first.
const NEEDED: u32 = 32;

/// Words that the boot stage needs while an image is on trial: emptying the log waits for the end of the
/// trial as long as it can.
const NEEDED_ON_TRIAL: u32 = 8;

/// Source of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Origin {
    /// `flashme.bin` on the card.
    File = 1,
    /// `firmware.previous` on the card.
    Previous = 2,
    /// A download over USB.
    Usb = 3,
    /// A debug probe, or the chip's own loader: it was found in flash.
    Probe = 4,
}

/// End of the last run of an image on trial, as the reset tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Ended {
    /// The power went, or somebody reset the board, before it had confirmed itself.
    Early = 0,
    /// The watchdog reset it.
    Watchdog = 1,
    /// The image reset itself: a panic, a fault of the processor, or as it was told.
    Itself = 2,
}

/// An image as the log knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Known {
    /// Length of the image, bytes.
    pub length: u32,
    /// The first half of its digest.
    pub digest: [u8; 16],
}

impl Known {
    /// Returns length and digest of an image.
    #[must_use]
    pub fn of(manifest: &Manifest) -> Self {
        let mut digest = [0; 16];
        digest.copy_from_slice(&manifest.digest[..16]);
        Self { length: manifest.length, digest }
    }
}

/// An entry of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// The application asks for this image.
    Requested(Origin, Known),
    /// The image in flash is being replaced by this one: what is in flash may not run.
    Began(Origin, Known),
    /// The image is in flash, and on trial unless it is the previous one or was put there by a debug probe.
    Installed(Origin, Known),
    /// An image on trial is started.
    Tried,
    /// The image has confirmed itself.
    Confirmed(Known),
    /// The requested image cannot be installed; nothing was changed.
    Refused(Refusal, Known),
    /// The image on trial has failed, so the previous one is being put back.
    Failed(Ended, Known),
    /// Half of the owner's key, the first or the second one, and whether the board is locked.
    Key(Half, bool, [u8; 16]),
    /// The policy has no key.
    NoKey,
}

/// Half of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Bytes 0 to 15.
    First,
    /// Bytes 16 to 31.
    Second,
}

/// Reason for which a request came to nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Refusal {
    /// There is no such file on the card, or no card.
    NoFile = 1,
    /// The file is another one than what was asked for, or is none that may run here.
    Flawed = 2,
}

/// State of the updates, as the log's entries tell it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// Owner's policy for images.
    pub policy: Policy,
    /// Image to be installed, and whether the install was begun: in that case the image in flash may not run.
    pub pending: Option<Pending>,
    /// The image that was installed last, and where it came from.
    pub installed: Option<(Origin, Known)>,
    /// Starts of that image without its confirmation; `None` when it is not on trial.
    pub trial: Option<u8>,
    /// The installed one is there because the one before it failed, and has not confirmed itself yet.
    pub fell_back: bool,
    /// Image that failed last, until it is installed again.
    pub failed: Option<(Ended, Known)>,
    /// The last request, if it was refused.
    pub refused: Option<(Refusal, Known)>,
    /// Whether the policy is one of these entries, or only what it was before them.
    says_policy: bool,
    half: Option<(bool, [u8; 16])>,
}

/// An install that is not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pending {
    /// Source of the image.
    pub origin: Origin,
    /// Length and digest of the image.
    pub image: Known,
    /// Whether the image in flash has been touched.
    pub has_begun: bool,
}

/// Way in which the image that runs came into flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// The image has run before, and confirmed itself.
    Known,
    /// A debug probe or the chip's own loader put it there; it has not run for long yet.
    Probe,
    /// A new image from this source, in its so many-th start without a confirmation.
    Trial(Origin, u8),
    /// The previous image, put back because the new one ended like this.
    FellBack(Ended),
}

impl State {
    /// Returns the way in which this image, the one that runs, came into flash.
    #[must_use]
    pub fn arrival(&self, running: Known) -> Arrival {
        let Some((origin, _)) = self.installed.filter(|(_, installed)| *installed == running) else {
            return Arrival::Probe;
        };
        match (self.trial, self.failed) {
            (Some(starts), _) => Arrival::Trial(origin, starts),
            (None, Some((ended, _))) if self.fell_back => Arrival::FellBack(ended),
            _ => Arrival::Known,
        }
    }

    /// Starts of this image without its confirmation; `None` where another one is on trial, or none. An image
    /// that a debug probe has put into the place of one on trial is not on trial.
    #[must_use]
    pub fn trial_of(&self, image: Known) -> Option<u8> {
        self.trial.filter(|_| self.installed.is_some_and(|(_, installed)| installed == image))
    }

    /// Whether the log says the policy itself, and not only its copy.
    #[cfg(test)]
    pub fn says_policy(&self) -> bool {
        self.says_policy
    }

    fn after(self, entry: Entry) -> Self {
        match entry {
            Entry::Requested(origin, image) => {
                Self { pending: Some(Pending { origin, image, has_begun: false }), refused: None, ..self }
            }
            Entry::Began(origin, image) => {
                Self { pending: Some(Pending { origin, image, has_begun: true }), trial: None, ..self }
            }
            Entry::Installed(origin, image) => Self {
                pending: None,
                installed: Some((origin, image)),
                trial: matches!(origin, Origin::File | Origin::Usb).then_some(0),
                fell_back: self.fell_back && origin == Origin::Previous,
                failed: self.failed.filter(|(_, failed)| *failed != image),
                ..self
            },
            Entry::Tried => Self { trial: self.trial.map(|starts| starts.saturating_add(1)), ..self },
            Entry::Confirmed(_) => Self { trial: None, fell_back: false, ..self },
            Entry::Refused(why, image) => Self { pending: None, refused: Some((why, image)), ..self },
            // Still on trial: the power may fail before the previous one is begun with.
            Entry::Failed(ended, image) => Self { fell_back: true, failed: Some((ended, image)), ..self },
            Entry::Key(Half::First, is_locked, bytes) => Self { half: Some((is_locked, bytes)), ..self },
            Entry::Key(Half::Second, is_locked, bytes) => match self.half {
                Some((first_locked, first)) if first_locked == is_locked => {
                    let mut key = [0; 32];
                    key[..16].copy_from_slice(&first);
                    key[16..].copy_from_slice(&bytes);
                    Self { policy: Policy { key: Some(key), is_locked }, says_policy: true, half: None, ..self }
                }
                _ => self,
            },
            Entry::NoKey => Self { policy: Policy::default(), says_policy: true, half: None, ..self },
        }
    }
}

/// Flash words that are written one behind the other.
#[derive(Clone, Copy)]
struct Words {
    /// Place of the first word, from the beginning of the flash.
    at: u32,
    /// Number of words in all.
    count: u32,
    /// Number of words that are written.
    used: u32,
}

impl Words {
    /// Reads the entries. Torn ones and such that nobody knows are passed over; the next one goes behind the
    /// last word that is not erased.
    fn read(&mut self, flash: &mut impl Flash, before: State) -> State {
        let mut state = before;
        for place in 0..self.count {
            match flash.read(self.at + place * WORD as u32) {
                Ok(ERASED) => {}
                Ok(word) => {
                    self.used = place + 1;
                    state = Entry::of(&word).map_or(state, |entry| state.after(entry));
                }
                Err(_) => self.used = place + 1,
            }
        }
        state
    }

    fn append(&mut self, flash: &mut impl Flash, entry: Entry) -> Result<(), Failed> {
        while self.used < self.count {
            let at = self.at + self.used * WORD as u32;
            self.used += 1;
            if flash.program(at, &entry.word()).is_ok() {
                return Ok(());
            }
        }
        Err(Failed)
    }
}

/// The log in flash.
pub struct Log<'l> {
    layout: &'l Layout,
    /// The state after the last entry.
    pub state: State,
    words: Words,
    /// Copies of the policy, written before the log is erased: see [`Layout::policy_at`].
    copies: Words,
    /// Policy stored in the copy.
    copied: Policy,
}

impl<'l> Log<'l> {
    /// Reads the log. The policy is the one of the copy as long as the log has none.
    pub fn read(flash: &mut impl Flash, layout: &'l Layout) -> Self {
        let mut copies = Words { at: layout.policy_at(), count: POLICY_BYTES / WORD as u32, used: 0 };
        let copied = copies.read(flash, State::default()).policy;
        let mut words = Words { at: layout.log_at(), count: layout.sector_bytes / WORD as u32, used: 0 };
        let state = words.read(flash, State { policy: copied, ..State::default() });
        Self { layout, state, words, copies, copied }
    }

    /// Appends an entry to the log.
    ///
    /// # Errors
    /// The flash does not take it, or the log is full.
    pub fn append(&mut self, flash: &mut impl Flash, entry: Entry) -> Result<(), Failed> {
        self.words.append(flash, entry)?;
        self.state = self.state.after(entry);
        Ok(())
    }

    /// Makes room: erases the log and writes what still matters. Only while nothing is pending, and not in a
    /// trial unless it is high time. A power failure in between costs how this image came here, and that
    /// another one has failed. The policy has a copy by then, unless the copy's 32 words are used up: they
    /// hold sixteen policies, each different from the one before, and only an install of an image of the full
    /// size erases them.
    ///
    /// # Errors
    /// The flash does not take it.
    pub fn tidy(&mut self, flash: &mut impl Flash) -> Result<(), Failed> {
        let is_on_trial = self.state.trial.is_some_and(|starts| starts < crate::TRIALS);
        let needed = if is_on_trial { NEEDED_ON_TRIAL } else { NEEDED };
        if self.words.used + needed <= self.words.count || self.state.pending.is_some() {
            return Ok(());
        }
        let old = self.state;
        if self.copied != old.policy
            && entries_of(&old.policy).try_for_each(|entry| self.copies.append(flash, entry)).is_ok()
        {
            self.copied = old.policy;
        }
        flash.erase(self.layout.log)?;
        (self.state, self.words.used) = (State { policy: self.copied, ..State::default() }, 0);
        self.write_policy(flash, &old.policy)?;
        if let Some((ended, image)) = old.failed {
            self.append(flash, Entry::Failed(ended, image))?;
        }
        let Some((origin, image)) = old.installed else { return Ok(()) };
        self.append(flash, Entry::Installed(origin, image))?;
        match old.trial {
            Some(starts) => (0..starts.min(crate::TRIALS)).try_for_each(|_| self.append(flash, Entry::Tried)),
            None if old.fell_back => Ok(()),
            None => self.append(flash, Entry::Confirmed(image)),
        }
    }

    /// Confirms that the running image does well. Nothing is written when the log says so already.
    ///
    /// # Errors
    /// The flash does not take it, or the log is full.
    pub fn confirm(&mut self, flash: &mut impl Flash, running: Known) -> Result<(), Failed> {
        match self.state.arrival(running) {
            Arrival::Known => Ok(()),
            Arrival::Probe => self.append(flash, Entry::Installed(Origin::Probe, running)),
            Arrival::Trial(..) | Arrival::FellBack(_) => self.append(flash, Entry::Confirmed(running)),
        }
    }

    /// Writes the owner's policy where it is another one than before.
    ///
    /// # Errors
    /// The flash does not take it.
    pub fn set_policy(&mut self, flash: &mut impl Flash, policy: &Policy) -> Result<(), Failed> {
        if self.state.policy == *policy { Ok(()) } else { self.write_policy(flash, policy) }
    }

    /// Writes the policy that only the copy says, before an install erases that.
    ///
    /// # Errors
    /// The flash does not take it.
    pub fn restore_policy(&mut self, flash: &mut impl Flash) -> Result<(), Failed> {
        let policy = self.state.policy;
        let is_there = self.state.says_policy || policy == Policy::default();
        if is_there { Ok(()) } else { self.write_policy(flash, &policy) }
    }

    fn write_policy(&mut self, flash: &mut impl Flash, policy: &Policy) -> Result<(), Failed> {
        entries_of(policy).try_for_each(|entry| self.append(flash, entry))
    }
}

/// Returns the entries that record this policy.
fn entries_of(policy: &Policy) -> impl Iterator<Item = Entry> + use<> {
    let entries = match policy.key {
        None => [Some(Entry::NoKey), None],
        Some(key) => {
            let (mut first, mut second) = ([0; 16], [0; 16]);
            first.copy_from_slice(&key[..16]);
            second.copy_from_slice(&key[16..]);
            [(Half::First, first), (Half::Second, second)]
                .map(|(half, bytes)| Some(Entry::Key(half, policy.is_locked, bytes)))
        }
    };
    entries.into_iter().flatten()
}

impl Entry {
    /// Returns the word that stores the entry.
    fn word(&self) -> Word {
        let none = Known { length: 0, digest: [0; 16] };
        let (kind, more, image) = match *self {
            Self::Requested(origin, image) => (1, origin as u8, image),
            Self::Began(origin, image) => (2, origin as u8, image),
            Self::Installed(origin, image) => (3, origin as u8, image),
            Self::Tried => (4, 0, none),
            Self::Confirmed(image) => (5, 0, image),
            Self::Refused(why, image) => (6, why as u8, image),
            Self::Failed(ended, image) => (7, ended as u8, image),
            Self::Key(Half::First, is_locked, digest) => (8, u8::from(is_locked), Known { length: 0, digest }),
            Self::Key(Half::Second, is_locked, digest) => (9, u8::from(is_locked), Known { length: 0, digest }),
            Self::NoKey => (10, 0, none),
        };
        let mut word = [0; WORD];
        word[0] = kind;
        word[1] = more;
        word[4..8].copy_from_slice(&image.length.to_le_bytes());
        word[8..24].copy_from_slice(&image.digest);
        let sum = crc32(&word[..28]);
        word[28..].copy_from_slice(&sum.to_le_bytes());
        word
    }

    /// Decodes the entry in a word; `None` when its check sum is wrong or its kind unknown.
    fn of(word: &Word) -> Option<Self> {
        let number =
            |at: usize| word.get(at..).and_then(|rest| rest.first_chunk()).map(|bytes| u32::from_le_bytes(*bytes));
        if number(28)? != crc32(word.get(..28)?) {
            return None;
        }
        let digest: [u8; 16] = *word.get(8..)?.first_chunk()?;
        let image = Known { length: number(4)?, digest };
        let [kind, more, ..] = *word;
        Some(match kind {
            1 => Self::Requested(Origin::of(more)?, image),
            2 => Self::Began(Origin::of(more)?, image),
            3 => Self::Installed(Origin::of(more)?, image),
            4 => Self::Tried,
            5 => Self::Confirmed(image),
            6 => Self::Refused(Refusal::of(more)?, image),
            7 => Self::Failed(Ended::of(more)?, image),
            8 => Self::Key(Half::First, more == 1, digest),
            9 => Self::Key(Half::Second, more == 1, digest),
            10 => Self::NoKey,
            _ => return None,
        })
    }
}

impl Origin {
    fn of(number: u8) -> Option<Self> {
        [Self::File, Self::Previous, Self::Usb, Self::Probe].into_iter().find(|origin| *origin as u8 == number)
    }
}

impl Ended {
    fn of(number: u8) -> Option<Self> {
        [Self::Early, Self::Watchdog, Self::Itself].into_iter().find(|ended| *ended as u8 == number)
    }
}

impl Refusal {
    fn of(number: u8) -> Option<Self> {
        [Self::NoFile, Self::Flawed].into_iter().find(|why| *why as u8 == number)
    }
}

/// CRC-32 of ISO 3309. A few bytes, a few times at a start: no table.
fn crc32(bytes: &[u8]) -> u32 {
    let crc = bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1)))
    });
    !crc
}
