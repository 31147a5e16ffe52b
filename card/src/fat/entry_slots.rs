//! Allocation and release of a directory entry's slots.

use super::cursor::Cursor;
use super::disk::Disk;
use super::entry::Entry;
use super::geometry::Directory;
use super::name::{MAX_SLOTS, Name, checksum};
use super::short_name::{Basis, TAILS, plain};
use super::slot::{FREE, Place, SLOT_BYTES, Slot, SlotKind, kind_of, short_name};
use super::{Blocks, Error};

/// Most rounds of short names for a name: each of 65,536 gives nine. A directory that has them all was made
/// for that.
const MAX_ROUNDS: u16 = 100;

/// Form in which a name will be written.
pub(super) struct NewName<'a> {
    pub name: &'a Name,
    pub short_name: [u8; 11],
    pub case_bits: u8,
    /// Slots of the long form; none when the short name says it all.
    pub long_slots: usize,
}

impl NewName<'_> {
    /// Returns the number of slots with the entry's own.
    pub const fn slots(&self) -> usize {
        self.long_slots + 1
    }
}

impl<B: Blocks> Disk<'_, B> {
    /// Returns the form of this name in a directory that lacks it, apart from `except`.
    pub fn new_name<'a>(
        &mut self,
        directory: Directory,
        name: &'a Name,
        except: Option<Place>,
    ) -> Result<NewName<'a>, Error<B::Error>> {
        if !name.is_legal() {
            return Err(Error::BadName);
        }
        let (own, mut basis) = (plain(name), Basis::of(name));
        for round in 0..MAX_ROUNDS {
            let mut taken = 0_u16;
            let found = self.search(directory, name, except, |entry, name| {
                // The long form of a name that looks like a short name takes that short name too: otherwise
                // it would be ambiguous.
                for short in [Some(entry.short_name()), plain(name).map(|(short, _)| short)].into_iter().flatten() {
                    taken |= u16::from(own.is_some_and(|(own, _)| own == short));
                    taken |= basis.tail_of(&short).map_or(0, |tail| 1 << tail);
                }
            })?;
            if found.is_some() {
                return Err(Error::Exists);
            }
            match own {
                Some((short_name, Some(case_bits))) if taken & 1 == 0 => {
                    return Ok(NewName { name, short_name, case_bits, long_slots: 0 });
                }
                Some((short_name, None)) if taken & 1 == 0 => {
                    return Ok(NewName { name, short_name, case_bits: 0, long_slots: name.slots() });
                }
                _ => {}
            }
            if let Some(tail) = (1..=TAILS).find(|tail| taken & 1 << tail == 0) {
                let short_name = basis.with_tail(tail);
                return Ok(NewName { name, short_name, case_bits: 0, long_slots: name.slots() });
            }
            basis = Basis::of(name).hashed(name, round);
        }
        Err(Error::DirectoryFull)
    }

    /// Finds so many free slots in a row, growing the directory if needed; returns the first.
    pub fn make_room(&mut self, directory: Directory, slots: usize) -> Result<Cursor, Error<B::Error>> {
        loop {
            match self.find_room(directory, slots)? {
                Ok(first) => return Ok(first),
                Err(last) if last.is_at_limit() => return Err(Error::DirectoryFull),
                Err(last) => {
                    let cluster = last.cluster().ok_or(Error::DirectoryFull)?;
                    self.allocate(Some(cluster), |_, _| {})?;
                }
            }
        }
    }

    /// Finds so many free slots in a row, or the directory's last slot. Pieces of a long name without an
    /// entry behind them count as free: a power cut, or a system without long names, has left them.
    fn find_room(&mut self, directory: Directory, slots: usize) -> Result<Result<Cursor, Cursor>, Error<B::Error>> {
        let mut at = Cursor::start(self, directory)?;
        let (mut first, mut count, mut behind_end) = (at, 0, false);
        loop {
            let kind = if behind_end { SlotKind::Free } else { kind_of(&at.read(self)?) };
            behind_end |= kind == SlotKind::End;
            if count == 0 {
                first = at;
            }
            count = if kind == SlotKind::Entry { 0 } else { count + 1 };
            let next = at.next(self)?;
            // Pieces of a long name are free only if what follows them is no entry.
            if count >= slots && (kind != SlotKind::LongName || next.is_none()) {
                return Ok(Ok(first));
            }
            match next {
                Some(next) => at = next,
                None => return Ok(Err(at)),
            }
        }
    }

    /// Returns the last of so many slots, for the entry itself behind its long name.
    pub fn last_of(&mut self, first: Cursor, slots: usize) -> Result<Cursor, Error<B::Error>> {
        let mut at = first;
        for _ in 1..slots {
            at = at.next(self)?.ok_or(Error::Damaged)?;
        }
        Ok(at)
    }

    /// Writes an entry with its long name, from the slot `first` on. `gone` is removed by the write that
    /// makes the entry visible, if it is in the same block as that.
    pub fn write_entry(
        &mut self,
        first: Cursor,
        name: &NewName<'_>,
        slot: Slot,
        gone: Option<Place>,
    ) -> Result<Entry, Error<B::Error>> {
        self.move_end_behind(first, name.slots())?;
        let (mut at, sum) = (first, checksum(&short_name(&slot)));
        for piece in 0..name.long_slots {
            self.change(at.place(), |place| *place = name.name.slot(piece, sum))?;
            if at.is_last_of_block() {
                self.store()?;
            }
            at = at.next(self)?.ok_or(Error::Damaged)?;
        }
        self.change(at.place(), |place| *place = slot)?;
        if let Some(gone) = gone.filter(|gone| gone.block == at.place().block) {
            self.change(gone, |slot| slot[0] = FREE)?;
        }
        self.store()?;
        Ok(Entry::new(self.volume, slot, at.place(), first))
    }

    /// Moves the directory's end mark behind these slots, which are about to be written, if it is in them.
    fn move_end_behind(&mut self, first: Cursor, slots: usize) -> Result<(), Error<B::Error>> {
        let (mut at, mut has_end) = (first, false);
        for _ in 0..slots {
            has_end |= kind_of(&at.read(self)?) == SlotKind::End;
            match at.next(self)? {
                Some(next) => at = next,
                None => return Ok(()),
            }
        }
        if has_end && kind_of(&at.read(self)?) != SlotKind::End {
            self.change(at.place(), |slot| *slot = [0; SLOT_BYTES])?;
            self.store()?;
        }
        Ok(())
    }

    /// Frees the slots of an entry: the entry itself first, with all that lies in its block; the rest of its
    /// long name after.
    pub fn remove_slots(&mut self, entry: &Entry) -> Result<(), Error<B::Error>> {
        let places = self.places_of(entry)?;
        self.free_slots(places.iter().filter(|place| place.block == entry.place().block))?;
        self.free_slots(places.iter().filter(|place| place.block != entry.place().block))
    }

    /// Frees the slots of an entry's long name; the entry is gone already.
    pub fn remove_long_name(&mut self, entry: &Entry) -> Result<(), Error<B::Error>> {
        let places = self.places_of(entry)?;
        self.free_slots(places.iter().filter(|place| **place != entry.place()))
    }

    /// Returns the slots of an entry, in their order; unused places repeat the entry's own.
    fn places_of(&mut self, entry: &Entry) -> Result<[Place; MAX_SLOTS + 1], Error<B::Error>> {
        let mut places = [entry.place(); MAX_SLOTS + 1];
        let mut at = entry.first;
        for place in &mut places {
            *place = at.place();
            if at.place() == entry.place() {
                break;
            }
            at = at.next(self)?.ok_or(Error::Damaged)?;
        }
        Ok(places)
    }

    /// Frees slots, with one write for those that follow one another in a block.
    fn free_slots<'p>(&mut self, places: impl Iterator<Item = &'p Place>) -> Result<(), Error<B::Error>> {
        let mut block = None;
        for place in places {
            if block.is_some_and(|block| block != place.block) {
                self.store()?;
            }
            self.change(*place, |slot| slot[0] = FREE)?;
            block = Some(place.block);
        }
        if block.is_some() { self.store() } else { Ok(()) }
    }
}
