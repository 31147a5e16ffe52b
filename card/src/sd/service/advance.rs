//! Choice of the next transfer, and the handling of finished ones.

use super::{Active, Counters, Lent, Purpose, Service, State};
use crate::sd::block_transfer::{Move, Moved, Moving};
use crate::sd::error::SdError;
use crate::sd::host::{Command, Direction, Host, Place, Progress};
use crate::sd::identify::Identify;
use crate::sd::read_ahead::Run;
use crate::sd::registers::CardInfo;
use crate::sd::{BLOCK_BYTES, SCRATCH_SLOT};

/// Fastest bus clock that is tried, and slowest one after errors, Hz.
const FASTEST_HZ: u32 = 50_000_000;
const SLOWEST_HZ: u32 = 12_500_000;
/// Damaged transfers since the bus was set after which it is made slower; the second one in a row does so
/// too.
const MOST_DAMAGED: u32 = 16;
/// Most blocks per command of reading ahead, and of writing while no reader is followed.
const CHUNK: usize = 16;
/// Commands of reading ahead before a waiting write gets one.
const TURNS: u8 = 8;
/// Period of the check whether an unused card is still there, or an empty slot has one.
const LOOK_PERIOD_US: u64 = 1_000_000;
const SLOT_PERIOD_US: u64 = 2_000_000;
/// Number of unanswered checks in a row after which the card counts as gone.
const LOOKS: u8 = 3;

impl<H: Host> Service<H> {
    /// Advances as far as possible without waiting. Called by the controller's interrupt, and as time passes.
    pub fn advance(&mut self, now_us: u64) {
        self.now_us = now_us;
        loop {
            match &mut self.active {
                Active::Nothing => {
                    if !self.start() {
                        return;
                    }
                }
                Active::Identify(identify) => match identify.advance(&mut self.host, now_us) {
                    None => return,
                    Some(found) => self.identified(found),
                },
                Active::Look(looks) => match self.host.progress() {
                    Progress::Busy => return,
                    Progress::Done => self.rest(),
                    Progress::Failed(_) if *looks < LOOKS => {
                        *looks += 1;
                        self.look();
                    }
                    Progress::Failed(_) => self.gone(SdError::NotResponding(13)),
                },
                Active::Move(moving, purpose, since_us) => {
                    let State::Ready(card) = self.state else {
                        // A card that has gone never delivers the blocks to read ahead.
                        self.ahead.finish(false);
                        self.ahead.forget();
                        return self.rest();
                    };
                    let (moved, purpose, since_us) =
                        (moving.advance(&card, &mut self.host, now_us), *purpose, *since_us);
                    let (what, attempt, is_damaged) = (moving.what, moving.attempt, moving.is_damaged);
                    match moved {
                        Moved::Not => return,
                        Moved::Yes => self.moved(what, purpose, since_us),
                        Moved::Again => self.again(attempt, is_damaged),
                        Moved::Failed(error) => self.failed(what, purpose, error),
                        Moved::Gone(error) => self.gone(error),
                    }
                }
            }
        }
    }

    fn rest(&mut self) {
        self.active = Active::Nothing;
        self.looked_us = self.now_us;
    }

    /// Begins the next work; returns false when there is none.
    fn start(&mut self) -> bool {
        if core::mem::take(&mut self.begins_anew) {
            self.active = Active::Identify(Identify::new(FASTEST_HZ));
            return true;
        }
        let since_us = self.now_us.saturating_sub(self.looked_us);
        let State::Ready(card) = self.state else {
            let looks = self.looks_by_itself && since_us >= SLOT_PERIOD_US && self.state != State::Identifying;
            (self.begins_anew, self.is_found_by_itself) = (looks, looks);
            return looks;
        };
        let (what, purpose) = match self.next(&card) {
            Some(next) => next,
            None if self.looks_by_itself && since_us >= LOOK_PERIOD_US => {
                self.active = Active::Look(1);
                self.look();
                return true;
            }
            None => return false,
        };
        self.active = Active::Move(Moving::new(what), purpose, self.now_us);
        true
    }

    fn look(&mut self) {
        if let State::Ready(card) = self.state {
            self.host.begin(Command::new(13, card.relative_address), None);
        }
    }

    fn next(&mut self, card: &CardInfo) -> Option<(Move, Purpose)> {
        if let Some(what) = self.lent.take() {
            return Some((what, Purpose::Lent));
        }
        let from = |first, count, slot| Move { direction: Direction::FromCard, first, count, place: Place::Slot(slot) };
        if let Some(number) = self.wanted.take() {
            let is_alone = self.alone.is_some_and(|run| number.wrapping_sub(run.first) < run.count);
            let end = if is_alone { number + 1 } else { card.blocks };
            let (group, slot, count) = self.groups.make_room(number, end);
            return Some((from(number, count, slot), Purpose::Group(group)));
        }
        let is_free = !self.is_held && self.now_us >= self.asked_until_us;
        let has_write = is_free && !self.queue.is_empty();
        if let Some((run, slot)) = self.ahead.next(CHUNK)
            && !(has_write && self.turns >= TURNS)
            // Blocks are gathered, not read one by one behind a slow reader.
            && (self.ahead.room() >= CHUNK / 2 || !self.ahead.has_longer(run))
        {
            self.turns = self.turns.saturating_add(1);
            self.ahead.begin(run);
            return Some((from(run.first, run.count, slot), Purpose::Ahead));
        }
        if has_write {
            self.turns = 0;
            let most = if self.ahead.is_used() { 1 } else { CHUNK };
            let (first, slot, count) = self.queue.begin(most)?;
            let place = Place::Slot(slot);
            return Some((Move { direction: Direction::ToCard, first, count: count as u32, place }, Purpose::Write));
        }
        if self.queue.is_empty()
            && is_free
            && let Some((number, slot)) = self.last_written
        {
            return Some((from(number, 1, SCRATCH_SLOT), Purpose::ReadBack(slot)));
        }
        None
    }

    fn identified(&mut self, found: Result<CardInfo, SdError>) {
        self.rest();
        self.state = match found {
            Ok(card) => {
                self.bus_hz = card.highest_hz();
                self.untold.is_inserted = self.is_found_by_itself;
                State::Ready(card)
            }
            Err(error) => State::Absent(error),
        };
    }

    fn moved(&mut self, what: Move, purpose: Purpose, since_us: u64) {
        let took_us = u32::try_from(self.now_us.saturating_sub(since_us)).unwrap_or(u32::MAX);
        let Counters { reads, writes, slowest_read_us, slowest_write_us, .. } = &mut self.counters;
        match what.direction {
            Direction::FromCard => {
                (*reads, *slowest_read_us) = (reads.wrapping_add(what.count), took_us.max(*slowest_read_us));
            }
            Direction::ToCard => {
                (*writes, *slowest_write_us) = (writes.wrapping_add(what.count), took_us.max(*slowest_write_us));
            }
        }
        match purpose {
            Purpose::Group(group) => {
                self.groups.finish(group, what.first, what.count);
                self.overlay(what);
            }
            Purpose::Ahead => {
                self.ahead.finish(true);
                self.overlay(what);
            }
            Purpose::Write => self.last_written = Some(self.queue.finish()),
            Purpose::ReadBack(slot) => self.compare(slot),
            Purpose::Lent => self.lent_is = Lent::Done,
        }
        self.rest();
    }

    /// Blocks that have come are as they were on the card: what waits to be written over them counts.
    // Kept out of its caller, so that its block is on the stack only while it runs. The same below.
    #[inline(never)]
    fn overlay(&mut self, what: Move) {
        let Place::Slot(slot) = what.place else { return };
        let (host, mut block) = (&mut self.host, [0; BLOCK_BYTES]);
        self.queue.each_within(what.first, what.count, |offset, from| {
            host.load(from, &mut block);
            host.store(slot + offset as usize, &block);
        });
    }

    /// Compares the last block written with its contents read back.
    #[inline(never)]
    fn compare(&mut self, slot: usize) {
        self.last_written = None;
        // A queue that has filled up meanwhile has another block in that slot.
        if self.queue.room() == 0 {
            return;
        }
        let (mut written, mut read) = ([0; BLOCK_BYTES], [0; BLOCK_BYTES]);
        self.host.load(slot, &mut written);
        self.host.load(SCRATCH_SLOT, &mut read);
        if written != read {
            self.fail_writes(SdError::NotKept);
        }
    }

    fn again(&mut self, attempt: u8, is_damaged: bool) {
        self.counters.repeated = self.counters.repeated.wrapping_add(1);
        if !is_damaged {
            return;
        }
        self.counters.damaged = self.counters.damaged.wrapping_add(1);
        self.damaged += 1;
        if (attempt > 2 || self.damaged >= MOST_DAMAGED) && self.bus_hz > SLOWEST_HZ {
            (self.bus_hz, self.damaged) = (self.bus_hz / 2, 0);
            self.host.set_bus(self.bus_hz, true);
            self.untold.slower = Some(self.bus_hz);
        }
    }

    fn failed(&mut self, what: Move, purpose: Purpose, error: SdError) {
        match purpose {
            // The bad block among them is found by reading each alone.
            Purpose::Group(_) if what.count > 1 => {
                self.alone = Some(Run { first: what.first, count: what.count });
                self.wanted = Some(what.first);
            }
            Purpose::Group(_) => self.unread = Some((what.first, error)),
            Purpose::Ahead => self.ahead.finish(false),
            Purpose::Write | Purpose::ReadBack(_) => self.fail_writes(error),
            Purpose::Lent => self.lent_is = Lent::Failed(error),
        }
        self.rest();
    }

    /// Fails all waiting writes, as after a power cut: nothing behind the failed one is written.
    fn fail_writes(&mut self, error: SdError) {
        self.queue.clear();
        self.last_written = None;
        self.write_failure = Some(error);
        self.untold.write_failed = Some(error);
        // Groups and blocks read ahead hold the data that the card lacks.
        self.groups.clear();
        self.ahead.forget();
    }

    fn gone(&mut self, error: SdError) {
        if self.lent_is == Lent::Busy {
            self.lent_is = Lent::Failed(error);
        }
        let loses = !self.queue.is_empty();
        self.rest();
        self.forget_all();
        self.state = State::Absent(error);
        self.untold.removed = Some((error, loses));
        if loses {
            self.write_failure = Some(error);
        }
    }

    pub(super) fn forget_all(&mut self) {
        self.queue.clear();
        self.last_written = None;
        self.groups.clear();
        self.ahead.forget();
        if !matches!(self.active, Active::Move(_, Purpose::Ahead, _)) {
            self.ahead.finish(false);
            self.ahead.forget();
        }
        (self.wanted, self.unread, self.alone) = (None, None, None);
    }
}
