//! Sharing of the card among its users: order of access, and state of the card.

use super::block_transfer::{Move, Moving};
use super::error::SdError;
use super::host::{Block, Direction, Host, Place};
use super::identify::Identify;
use super::read_ahead::{Ahead, Run};
use super::recent_blocks::Groups;
use super::registers::CardInfo;
use super::write_queue::Queue;

mod advance;

/// Time within which a user asks again for a quiet card; until then no write begins.
const ASKED_US: u64 = 2_000;

/// State of the card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No usable card, and the reason.
    Absent(SdError),
    /// The card is being identified.
    Identifying,
    /// The card is ready for use.
    Ready(CardInfo),
}

/// Result of a read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Read {
    /// The block has been read.
    Done,
    /// The block has been asked for: ask again.
    NotYet,
}

/// Event to be reported, once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A card was put in.
    Inserted,
    /// The card has gone; whether unwritten blocks are lost with it.
    Removed(SdError, bool),
    /// A write has failed for good; the blocks behind it are dropped.
    WriteFailed(SdError),
    /// Too many transfers arrived damaged: the bus is slower from now on, Hz.
    Slower(u32),
}

/// State of a transfer of the user who has the card lent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lent {
    /// No transfer was begun.
    Idle,
    /// The transfer goes on.
    Busy,
    /// All of the transfer is done.
    Done,
    /// The transfer has failed.
    Failed(SdError),
}

/// Statistics of the card since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Number of blocks read.
    pub reads: u32,
    /// Number of blocks written.
    pub writes: u32,
    /// Transfers that were tried again.
    pub repeated: u32,
    /// Repeated transfers whose data arrived damaged.
    pub damaged: u32,
    /// Longest duration of a read, us.
    pub slowest_read_us: u32,
    /// Longest duration of a write, us.
    pub slowest_write_us: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    /// Read into this group.
    Group(usize),
    Ahead,
    Write,
    /// Read back of the last block written, to be compared with this slot.
    ReadBack(usize),
    Lent,
}

#[derive(Clone, Debug)]
enum Active {
    Nothing,
    Identify(Identify),
    Move(Moving, Purpose, u64),
    /// Check by CMD13; the number of checks so far.
    Look(u8),
}

/// Card shared by its users.
#[derive(Debug)]
pub struct Service<H> {
    host: H,
    state: State,
    active: Active,
    queue: Queue,
    ahead: Ahead,
    groups: Groups,
    /// Block that a user wants to read.
    wanted: Option<u32>,
    /// Block that could not be read, and the error.
    unread: Option<(u32, SdError)>,
    /// Blocks that could not be read together: each is read alone.
    alone: Option<Run>,
    /// Writes are kept back.
    is_held: bool,
    asked_until_us: u64,
    /// Number of read-ahead commands since the last write.
    turns: u8,
    /// Last block written: number and slot.
    last_written: Option<(u32, usize)>,
    write_failure: Option<SdError>,
    untold: Untold,
    now_us: u64,
    /// Time of the last check of the card, or of the slot.
    looked_us: u64,
    looks_by_itself: bool,
    is_lent: bool,
    lent: Option<Move>,
    lent_is: Lent,
    bus_hz: u32,
    damaged: u32,
    /// The card is to be identified as soon as no other work goes on.
    begins_anew: bool,
    /// The service itself, and no user, starts that identification.
    is_found_by_itself: bool,
    counters: Counters,
}

/// Events not yet reported.
#[derive(Clone, Copy, Debug, Default)]
struct Untold {
    is_inserted: bool,
    removed: Option<(SdError, bool)>,
    write_failed: Option<SdError>,
    slower: Option<u32>,
}

impl<H: Host> Service<H> {
    /// Creates a service without a card: see [`identify`](Self::identify).
    pub const fn new(host: H) -> Self {
        Self {
            host,
            state: State::Absent(SdError::NoCard),
            active: Active::Nothing,
            queue: Queue::new(),
            ahead: Ahead::new(),
            groups: Groups::new(),
            wanted: None,
            unread: None,
            alone: None,
            is_held: false,
            asked_until_us: 0,
            turns: 0,
            last_written: None,
            write_failure: None,
            untold: Untold { is_inserted: false, removed: None, write_failed: None, slower: None },
            now_us: 0,
            looked_us: 0,
            looks_by_itself: false,
            is_lent: false,
            lent: None,
            lent_is: Lent::Idle,
            bus_hz: 0,
            damaged: 0,
            begins_anew: false,
            is_found_by_itself: false,
            counters: Counters {
                reads: 0,
                writes: 0,
                repeated: 0,
                damaged: 0,
                slowest_read_us: 0,
                slowest_write_us: 0,
            },
        }
    }

    /// Returns the host controller.
    pub const fn host(&mut self) -> &mut H {
        &mut self.host
    }

    // --- the card ---

    /// Returns the state of the card.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Returns the statistics of the card.
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// Returns the clock of the card's bus, Hz.
    pub const fn bus_hz(&self) -> u32 {
        self.bus_hz
    }

    /// Looks for a card anew. Queued blocks are lost: see [`is_kept`](Self::is_kept).
    pub fn identify(&mut self) {
        self.forget_all();
        self.write_failure = None;
        self.state = State::Identifying;
        (self.begins_anew, self.is_found_by_itself) = (true, false);
        self.damaged = 0;
    }

    /// Makes the service look for cards that are put in, and check that the present one is still there.
    pub const fn look_by_itself(&mut self) {
        self.looks_by_itself = true;
    }

    /// Returns the next event not yet reported.
    pub fn take_event(&mut self) -> Option<Event> {
        let untold = &mut self.untold;
        if let Some((error, loses)) = untold.removed.take() {
            return Some(Event::Removed(error, loses));
        }
        if let Some(error) = untold.write_failed.take() {
            return Some(Event::WriteFailed(error));
        }
        if core::mem::take(&mut untold.is_inserted) {
            return Some(Event::Inserted);
        }
        untold.slower.take().map(Event::Slower)
    }

    // --- reading ---

    /// Reads a block, or asks for it.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn read(&mut self, number: u32, block: &mut Block) -> Result<Read, SdError> {
        self.check(number)?;
        match self.unread {
            // The error is reported as often as the block is asked for in a row.
            Some((unread, error)) if unread == number => return Err(error),
            _ => self.unread = None,
        }
        let at_hand = self.queue.find(number).or_else(|| self.ahead.find(number)).or_else(|| self.groups.find(number));
        // A reader that reads on does not want the blocks before.
        let _passed = self.ahead.take(number);
        match at_hand {
            Some(slot) => {
                self.host.load(slot, block);
                Ok(Read::Done)
            }
            None => {
                if !self.ahead.brings(number) && !self.is_coming(number) {
                    self.wanted = Some(number);
                }
                Ok(Read::NotYet)
            }
        }
    }

    /// Returns whether a group with this block is under way: another request would read it twice, and into
    /// the place of the other group.
    fn is_coming(&self, number: u32) -> bool {
        matches!(&self.active, Active::Move(moving, Purpose::Group(_), _)
            if number.wrapping_sub(moving.what.first) < moving.what.count)
    }

    /// Whether a block can be read at once, or cannot be read at all. Asks for nothing.
    pub fn is_at_hand(&mut self, number: u32) -> bool {
        self.check(number).is_err()
            || self.unread.is_some_and(|(unread, _)| unread == number)
            || self.queue.find(number).is_some()
            || self.ahead.find(number).is_some()
            || self.groups.find(number).is_some()
    }

    /// Adds blocks that the followed reader wants next, behind those added before. Returns false while there
    /// is no room for another stretch.
    pub fn follow(&mut self, run: Run) -> bool {
        self.ahead.follow(run)
    }

    /// Stops following, or makes way for another reader.
    pub const fn unfollow(&mut self) {
        self.ahead.forget();
    }

    // --- writing ---

    /// Queues a block to be written. False while there is no room.
    ///
    /// # Errors
    /// Why it cannot be written, or that one before it could not.
    pub fn write(&mut self, number: u32, block: &Block) -> Result<bool, SdError> {
        let card = self.check(number)?;
        if card.is_protected {
            return Err(SdError::Protected);
        }
        if self.write_failure.is_some() {
            return Err(SdError::WriteFailed);
        }
        let Some(slot) = self.queue.push(number) else { return Ok(false) };
        self.host.store(slot, block);
        // Copies at hand must equal the future contents of the card.
        for copy in [self.groups.find(number), self.ahead.slot_of_any(number)].into_iter().flatten() {
            self.host.store(copy, block);
        }
        Ok(true)
    }

    /// Returns the number of blocks that can be queued.
    pub const fn room(&self) -> usize {
        self.queue.room()
    }

    /// Keeps writes back, or lets them go.
    pub const fn hold(&mut self, is_held: bool) {
        self.is_held = is_held;
    }

    /// Whether the card would answer a read at once, and there is room for so many blocks. The card is then
    /// kept free for the caller for two milliseconds.
    pub fn is_ready(&mut self, room: usize) -> bool {
        if !matches!(self.state, State::Ready(_)) || self.is_lent {
            return self.state != State::Identifying;
        }
        if self.queue.room() < room {
            return false;
        }
        let is_writing = self.is_writing();
        // The user's own writes must not wait once the card is ready.
        self.asked_until_us = if is_writing { self.now_us + ASKED_US } else { 0 };
        !is_writing
    }

    fn is_writing(&self) -> bool {
        matches!(&self.active, Active::Move(moving, ..) if moving.what.direction == Direction::ToCard)
    }

    /// Returns whether all writes are on the card.
    ///
    /// # Errors
    /// Why something is not.
    pub const fn is_kept(&self) -> Result<bool, SdError> {
        match self.write_failure {
            Some(error) => Err(error),
            None => Ok(self.queue.is_empty() && self.last_written.is_none()),
        }
    }

    /// Allows writes again, once the writer knows of the failed ones.
    pub const fn forgive(&mut self) {
        self.write_failure = None;
    }

    // --- a user of its own ---

    /// Gives the card to one user alone, until it is [taken back](Self::take_back). Returns false while
    /// blocks wait to be written, or are under way to the memory lent.
    ///
    /// # Errors
    /// Without a card, or when something could not be written.
    pub fn lend(&mut self) -> Result<bool, SdError> {
        if let State::Absent(error) = self.state {
            return Err(error);
        }
        if !self.is_kept()? || self.state == State::Identifying || matches!(self.active, Active::Move(..)) {
            return Ok(false);
        }
        (self.is_lent, self.lent, self.lent_is) = (true, None, Lent::Idle);
        self.forget_all();
        Ok(true)
    }

    /// Takes the card back from its single user. Not while a transfer of that user is under way
    /// ([`is_lent_busy`](Self::is_lent_busy)): its blocks would overwrite those of others.
    pub fn take_back(&mut self) {
        self.is_lent = false;
        self.lent = None;
        self.lent_is = Lent::Idle;
        self.forget_all();
    }

    /// Returns whether the card is lent to one user.
    pub const fn is_lent(&self) -> bool {
        self.is_lent
    }

    /// Begins to move blocks between the card and memory at this address, which the host's DMA must reach and
    /// which belongs to the transfer until it has ended.
    ///
    /// # Errors
    /// When another one is under way, the card is not lent or not there, or has no such blocks.
    pub fn begin(&mut self, direction: Direction, run: Run, address: u32) -> Result<(), SdError> {
        let State::Ready(card) = self.state else { return Err(SdError::NoCard) };
        if !self.is_lent || self.lent_is == Lent::Busy {
            return Err(SdError::Lent);
        }
        if run.count == 0 || run.first.checked_add(run.count).is_none_or(|end| end > card.blocks) {
            return Err(SdError::OutOfRange);
        }
        if direction == Direction::ToCard && card.is_protected {
            return Err(SdError::Protected);
        }
        self.lent = Some(Move { direction, first: run.first, count: run.count, place: Place::Address(address) });
        self.lent_is = Lent::Busy;
        Ok(())
    }

    /// Returns whether a transfer of the single user is under way.
    pub const fn is_lent_busy(&self) -> bool {
        matches!(self.lent_is, Lent::Busy)
    }

    /// Returns whether such a transfer has ended and not been reported.
    pub const fn has_lent_news(&self) -> bool {
        matches!(self.lent_is, Lent::Done | Lent::Failed(_))
    }

    /// Returns the progress of the transfer. The end is told once.
    pub fn lent(&mut self) -> Lent {
        let is = self.lent_is;
        if is != Lent::Busy {
            self.lent_is = Lent::Idle;
        }
        is
    }

    fn check(&self, number: u32) -> Result<CardInfo, SdError> {
        match self.state {
            _ if self.is_lent => Err(SdError::Lent),
            State::Ready(card) if number < card.blocks => Ok(card),
            State::Ready(_) => Err(SdError::OutOfRange),
            State::Absent(error) => Err(error),
            State::Identifying => Err(SdError::NoCard),
        }
    }
}
