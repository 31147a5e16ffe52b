//! Files of the card: uploads, downloads, lists, changes.
//!
//! The card is one visitor's at a time, and only while it is at rest: nobody waits for it here. What has to
//! wait stays where it is: the bytes of an upload and the head of a request in their socket, a call with its
//! visitor.

mod asked;
mod directory;
mod keeping;
mod lines;
mod metadata;
mod picture;
mod place;
mod reading;
mod refusal;
mod turn;
mod upload;
mod work;

use base::paths::{CARD, Path};
use base::ports::{FreeSpace, Storage};

use keeping::{Part, UPLOADS};
use metadata::Scan;
use turn::Turn;
use upload::Upload;

pub use asked::{Ask, Question, SOURCE, TARGET, Telling, Text, write_item};
pub use refusal::Refusal;
pub use work::{FileBody, FileWork, Stored, may_want_card};

/// Time after which a visitor who does not go on loses his turn, milliseconds: at the card, and with a folder
/// that is listed or a file that is searched.
const CARD_PATIENCE_MS: u32 = 100;
const LIST_PATIENCE_MS: u32 = 2_000;
/// Least time between two times that visitors are told that others have changed files, milliseconds.
const OTHERS_MS: u64 = 2_000;
/// Time for which the part of an upload that broke off is kept, milliseconds: an hour.
const KEPT_MS: u64 = 3_600_000;

/// Applicant for the card: a connection, or a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visitor {
    /// Connection at this place.
    Connection(u8),
    /// Question of this number.
    Question(u8),
    /// The site's own housekeeping.
    Site,
}

impl Visitor {
    const fn number(self) -> u8 {
        match self {
            Self::Connection(place) => place,
            Self::Question(number) => 0x40 | number,
            Self::Site => 0x80,
        }
    }
}

/// Last change of files, which visitors are told of.
#[derive(Clone, Debug, Default)]
pub struct Change {
    /// Kind of change, in Moonraker's words.
    pub action: &'static str,
    /// Path on the card of what is changed.
    path: Path,
    /// Number of the change.
    pub number: u32,
}

impl Change {
    /// Returns the path as visitors name it.
    #[must_use]
    pub fn shown(&self) -> &str {
        place::shown(&self.path)
    }
}

/// Space of the card, as far as it is counted.
#[derive(Debug, Default)]
struct Space {
    count: FreeSpace,
    is_counting: bool,
    /// Whether files have changed since the count began.
    is_stale: bool,
    /// Free and whole space as counted last, bytes.
    known: Option<(u64, u64)>,
}

/// Files of the card in the hands of the site's visitors.
#[derive(Debug, Default)]
pub struct Files {
    uploads: [Option<Upload>; UPLOADS],
    /// Parts of uploads that broke off, and since when.
    kept: [Option<(Part, u64)>; UPLOADS],
    card: Turn,
    /// Turn of who has blocks of a file read: the card keeps few that were read for nobody.
    reads: Turn,
    lists: Turn,
    scans: Turn,
    /// Search of a visitor.
    scan: Option<(u8, Scan)>,
    space: Space,
    /// Whether what former uploads left behind is cleared away.
    is_clear: bool,
    /// The last change of files.
    pub change: Change,
    /// Changes that the card has counted when the site was last done, and whether others than visitors of the
    /// site have made some that nobody was told of, and when it was told last.
    counted: u32,
    has_others: bool,
    told_ms: u64,
}

impl Files {
    /// Returns whether the card is at rest, and the visitor's turn has come.
    pub fn has_card(&mut self, visitor: Visitor, now_ms: u64, card: &mut impl Storage) -> bool {
        let visitor = visitor.number();
        let is_his = self.card.take(visitor, now_ms, CARD_PATIENCE_MS) && card.is_ready();
        if is_his {
            self.card.end(visitor);
        }
        is_his
    }

    /// Notes a change of files, which all visitors are told of.
    fn note(&mut self, action: &'static str, path: &str) {
        let number = self.change.number.wrapping_add(1);
        self.change = Change { action, path: Path::try_from(path).unwrap_or_default(), number };
        self.space.is_stale = true;
    }

    /// Looks for changes that others than visitors of the site have made, before the site does anything.
    pub fn look_for_others(&mut self, now_ms: u64, card: &mut impl Storage) {
        self.has_others |= card.changes() != self.counted;
        if self.has_others && now_ms.saturating_sub(self.told_ms) >= OTHERS_MS {
            (self.has_others, self.told_ms) = (false, now_ms);
            self.note("root_update", CARD);
        }
    }

    /// Counts the changes that the site has made itself.
    pub fn count_own(&mut self, card: &mut impl Storage) {
        self.counted = card.changes();
    }

    /// Does the site's own work on files: clears away what a power cut has left of uploads, and counts the
    /// free space. Returns whether there is more to do.
    pub fn run(&mut self, now_ms: u64, card: &mut impl Storage) -> bool {
        let is_old = |kept: &Option<(Part, u64)>| kept.is_some_and(|(_, at_ms)| now_ms >= at_ms + KEPT_MS);
        let old = self.kept.iter().position(is_old);
        let has_work = !self.is_clear || old.is_some() || self.space.is_counting;
        if !has_work || !self.has_card(Visitor::Site, now_ms, card) {
            return has_work;
        }
        if !self.is_clear {
            self.recover(now_ms, card);
            self.want_space();
            return true;
        }
        if let Some(place) = old
            && let Some(kept) = self.kept.get_mut(place)
        {
            // What cannot be removed now is removed before the next upload.
            let _ = keeping::recover(place, false, card);
            *kept = None;
            return true;
        }
        let Space { count, is_counting, known, .. } = &mut self.space;
        match card.count_free(count) {
            Ok(false) => {}
            Ok(true) => (*is_counting, *known) = (false, Some((count.bytes, count.total_bytes))),
            Err(_) => *is_counting = false,
        }
        *is_counting
    }

    /// Clears away what a power cut has left of uploads, but for what their senders can go on with.
    fn recover(&mut self, now_ms: u64, card: &mut impl Storage) {
        if core::mem::replace(&mut self.is_clear, true) {
            return;
        }
        let Self { uploads, kept, .. } = self;
        for (place, kept) in kept.iter_mut().enumerate() {
            if uploads.get(place).is_some_and(Option::is_none) {
                // A card that cannot be written to has nothing of an upload, and says so when there is one.
                *kept = keeping::recover(place, true, card).ok().flatten().map(|part| (part, now_ms));
            }
        }
    }

    /// Has the free space counted, if it is not known. What was counted last is told meanwhile.
    fn want_space(&mut self) {
        let Space { count, is_counting, is_stale, known } = &mut self.space;
        if (known.is_none() || *is_stale) && !*is_counting {
            (*count, *is_counting, *is_stale) = (FreeSpace::default(), true, false);
        }
    }
}
