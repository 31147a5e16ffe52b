//! The SD card as the machine's storage.

use base::ports::{CardEvent, CardFacts, FileTime, StorageError};
use base::watchdog::Reporter;
use bsp_prime::rtc;
use bsp_prime::sd::CardService;
use bsp_prime::time;
use card::fat::Block;
use card::sd::{Event, Read, Run, SdError, State};
use embedded_sdmmc::{TimeSource, Timestamp};
use rtic::Mutex;
use storage::Card;

use crate::lock_free::REPORTS;
use crate::workspace;

/// Duration of a block's transfer from which the card counts as slow, us.
const SLOW_US: u64 = 10_000;

/// The card with its file system.
pub type CardStorage<K> = storage::CardStorage<'static, Slot<K>, Dated>;

/// Returns the card storage, not mounted.
pub fn card_storage<K: Mutex<T = &'static mut CardService>>(card: K) -> CardStorage<K> {
    CardStorage::new(Slot(card), Dated, workspace::of_files())
}

/// The card in its slot, behind its lock. Each call holds it for microseconds; a call that has to wait sleeps
/// between two checks, until the controller's interrupt or the next run of the step feed.
pub struct Slot<K>(K);

impl<K: Mutex<T = &'static mut CardService>> Slot<K> {
    /// Runs an action on the card under its lock.
    pub fn with<R>(&mut self, action: impl FnOnce(&mut CardService) -> R) -> R {
        self.0.lock(|card| action(card))
    }

    /// Waits until `ask` gives an answer.
    fn wait<R>(&mut self, mut ask: impl FnMut(&mut CardService) -> Option<R>) -> R {
        let since = time::now().0;
        loop {
            let now = time::now().0;
            let answer = self.0.lock(|card| {
                let answer = ask(card);
                if answer.is_none() {
                    card.advance(now);
                }
                answer
            });
            match answer {
                Some(answer) => {
                    // Each command has its limit: a slow card must not look like a hanging executor.
                    if now.saturating_sub(since) > SLOW_US {
                        REPORTS.report(Reporter::Executor);
                    }
                    return answer;
                }
                None => cortex_m::asm::wfi(),
            }
        }
    }
}

impl<K: Mutex<T = &'static mut CardService>> Card for Slot<K> {
    type Error = SdError;

    fn identify(&mut self) -> Result<(), SdError> {
        // Automatic checks start with the first mount: cards come and go while the machine runs.
        let is_lent = self.0.lock(|card| {
            card.look_by_itself();
            if !card.is_lent() {
                card.identify();
            }
            card.is_lent()
        });
        if is_lent {
            return Err(SdError::Lent);
        }
        self.wait(|card| match card.state() {
            State::Ready(_) => Some(Ok(())),
            State::Absent(error) => Some(Err(error)),
            State::Identifying => None,
        })
    }

    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), SdError> {
        self.wait(|card| match card.read(number, block) {
            Ok(Read::Done) => Some(Ok(())),
            Ok(Read::NotYet) => None,
            Err(error) => Some(Err(error)),
        })
    }

    fn read_at_hand(&mut self, number: u32, block: &mut Block) -> Result<bool, SdError> {
        let now = time::now().0;
        self.0.lock(|card| {
            let read = card.read(number, block)?;
            if read == Read::NotYet {
                card.advance(now);
            }
            Ok(read == Read::Done)
        })
    }

    fn write(&mut self, number: u32, block: &Block) -> Result<(), SdError> {
        self.wait(|card| match card.write(number, block) {
            Ok(true) => Some(Ok(())),
            Ok(false) => {
                // The write needs more than the room left, so held writes have to go.
                card.hold(false);
                None
            }
            Err(error) => Some(Err(error)),
        })
    }

    fn blocks(&mut self) -> Result<u32, SdError> {
        match self.0.lock(|card| card.state()) {
            State::Ready(card) => Ok(card.blocks),
            State::Absent(error) => Err(error),
            State::Identifying => Err(SdError::NoCard),
        }
    }

    fn hold(&mut self) {
        self.0.lock(|card| card.hold(true));
    }

    fn is_ready(&mut self, room: usize) -> bool {
        let now = time::now().0;
        self.0.lock(|card| {
            card.advance(now);
            card.is_ready(room)
        })
    }

    fn is_kept(&mut self) -> Result<bool, SdError> {
        self.0.lock(|card| card.is_kept())
    }

    fn between_steps(&mut self) {
        REPORTS.report(Reporter::Executor);
    }

    fn forgive(&mut self) {
        self.0.lock(|card| card.forgive());
    }

    fn facts(&mut self) -> Option<CardFacts> {
        self.0.lock(|card| {
            let State::Ready(info) = card.state() else { return None };
            Some(CardFacts {
                kind: info.kind.name(),
                name: info.cid.name(),
                maker: info.cid.maker(),
                blocks: info.blocks,
                bus_khz: card.bus_hz() / 1_000,
                is_protected: info.is_protected,
                counters: card.counters(),
            })
        })
    }

    fn take_event(&mut self) -> Option<CardEvent> {
        self.0.lock(|card| card.take_event()).map(|event| match event {
            Event::Inserted => CardEvent::Inserted,
            Event::Removed(_, loses) => CardEvent::Removed { loses },
            Event::WriteFailed(error) => CardEvent::WriteFailed(Self::reason(&error)),
            Event::Slower(hz) => CardEvent::Slower(hz / 1_000),
        })
    }

    fn follow(&mut self, run: Run) -> bool {
        let now = time::now().0;
        self.0.lock(|card| {
            let is_taken = card.follow(run);
            card.advance(now);
            is_taken
        })
    }

    fn has_room(&mut self, blocks: usize) -> bool {
        self.0.lock(|card| card.room() >= blocks)
    }

    fn let_go(&mut self) {
        let now = time::now().0;
        self.0.lock(|card| {
            card.hold(false);
            card.advance(now);
        });
    }

    fn unfollow(&mut self) {
        self.0.lock(|card| card.unfollow());
    }

    fn reason(error: &SdError) -> StorageError {
        match error {
            SdError::NoCard => StorageError::NoCard,
            SdError::NotResponding(_) | SdError::StaysBusy(_) => StorageError::NotResponding,
            SdError::Unsupported(card::sd::Unsupported::Locked) => StorageError::Locked,
            SdError::Unsupported(_) => StorageError::WrongCard,
            SdError::Protected => StorageError::Protected,
            SdError::NotKept => StorageError::NotKept,
            SdError::Unreadable => StorageError::Unreadable,
            SdError::WriteFailed => StorageError::WriteFailed,
            SdError::Lent => StorageError::Lent,
            SdError::Damaged(_) | SdError::Refused(..) | SdError::Host | SdError::OutOfRange => StorageError::Device,
        }
    }
}

/// Source of file dates: the clock, once it has been set.
#[derive(Clone, Copy)]
pub struct Dated;

impl TimeSource for Dated {
    fn get_timestamp(&self) -> Timestamp {
        let FileTime { year, month, day, hour, minute } = FileTime::of(rtc::now());
        Timestamp {
            // The date must not be before 1980, and months and days are counted from one.
            year_since_1970: (year - 1970) as u8,
            zero_indexed_month: month.saturating_sub(1),
            zero_indexed_day: day.saturating_sub(1),
            hours: hour,
            minutes: minute,
            seconds: 0,
        }
    }
}
