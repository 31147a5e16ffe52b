//! Renaming and moving of files and directories.
//!
//! Two writes move an entry between blocks: the first takes it away, the second puts it there. A power cut
//! between them would lose it, or leave two names for the same clusters. So they stand between two others: an
//! entry in the root directory that notes both places comes first and goes last. At mounting,
//! [`Volume::settle`] finds that note and sees how far the move came:
//!
//! | after | what a reader without this sees | settled |
//! |---|---|---|
//! | the note | the old name | the old name |
//! | taking the old entry away | neither; its clusters have no name | the old name, put back |
//! | writing the new entry | the new name | the new name |
//!
//! The `..` of a directory is written last. After a cut it may still lead to where the directory was; nothing
//! here follows it.

use super::disk::Disk;
use super::entry::Entry;
use super::entry_slots::NewName;
use super::geometry::Directory;
use super::lookup::split;
use super::name::Name;
use super::slot::{Attributes, FREE, Place, SLOT_BYTES, Slot, SlotKind, kind_of, set_cluster};
use super::table::Link;
use super::{Blocks, Error, Listing, Volume, put, word};

/// Short name of the note.
const NOTE: [u8; 11] = *b"~MOVING TMP";
/// Attributes of the note, which make it unique: hidden, of the system, and without clusters.
const NOTE_ATTRIBUTES: u8 = Attributes::HIDDEN.0 | Attributes::SYSTEM.0;

/// Contents of the note, kept where an entry has its times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Note {
    from: Place,
    /// First byte of the short name in the old slot, which freeing the slot overwrites.
    first_byte: u8,
    to: Place,
    /// Sum of the new slot's earlier contents.
    sum: u8,
}

impl Note {
    fn slot(self) -> Slot {
        let mut slot = [0; SLOT_BYTES];
        put(&mut slot, 0, &NOTE);
        slot[11] = NOTE_ATTRIBUTES;
        // Slots of a block are numbered to 15.
        slot[13] = self.from.slot | self.to.slot << 4;
        put(&mut slot, 14, &self.from.block.to_le_bytes());
        slot[18] = self.first_byte;
        slot[19] = self.sum;
        put(&mut slot, 22, &self.to.block.to_le_bytes());
        slot
    }

    fn of(slot: &Slot) -> Option<Self> {
        let is_note = slot.starts_with(&NOTE) && slot[11] == NOTE_ATTRIBUTES && word(slot, 28) == 0;
        let from = Place { block: word(slot, 14), slot: slot[13] & 15 };
        let to = Place { block: word(slot, 22), slot: slot[13] >> 4 };
        is_note.then_some(Self { from, first_byte: slot[18], to, sum: slot[19] })
    }
}

fn sum(slot: &Slot) -> u8 {
    slot.iter().fold(0, |sum: u8, byte| sum.rotate_left(1).wrapping_add(*byte))
}

impl Volume {
    /// Gives an entry another name, in the same directory or another one. A change of case alone counts. No
    /// other user may have the entry open.
    ///
    /// # Errors
    /// [`Error::Exists`], [`Error::IntoItself`], [`Error::BadName`], [`Error::Full`],
    /// [`Error::DirectoryFull`], as [`find`](Self::find) for the new directory, or the device's.
    pub fn rename<B: Blocks>(&mut self, device: &mut B, entry: &Entry, to: &str) -> Result<(), Error<B::Error>> {
        let disk = &mut Disk::new(self, device);
        let (path, name) = split(to)?;
        if entry.is_directory() {
            disk.directory_of(entry)?;
        }
        let directory = disk.directory(path, entry.is_directory().then(|| entry.cluster()))?;
        let name = Name::parse(name).ok_or(Error::BadName)?;
        let name = disk.new_name(directory, &name, Some(entry.place()))?;
        let mut slot = entry.slot;
        put(&mut slot, 0, &name.short_name);
        slot[12] = name.case_bits;
        let room = disk.make_room(directory, name.slots())?;
        if disk.last_of(room, name.slots())?.place().block == entry.place().block {
            disk.write_entry(room, &name, slot, Some(entry.place()))?;
        } else {
            disk.move_with_note(entry, directory, &name, slot)?;
        }
        disk.remove_long_name(entry)
    }

    /// Completes or takes back a move that a power cut has interrupted. Called when the volume is mounted,
    /// before anything else; it reads the root directory.
    ///
    /// # Errors
    /// [`Error::Damaged`], or the device's.
    pub fn settle<B: Blocks>(&mut self, device: &mut B) -> Result<(), Error<B::Error>> {
        Disk::new(self, device).settle()
    }
}

impl<B: Blocks> Disk<'_, B> {
    fn move_with_note(
        &mut self,
        entry: &Entry,
        directory: Directory,
        name: &NewName<'_>,
        slot: Slot,
    ) -> Result<(), Error<B::Error>> {
        // A second note would hide the first one, if a device error has left one.
        self.settle()?;
        // In the root, the note takes the first slot of the room.
        let in_root = directory == self.volume.root;
        let mut room = self.make_room(directory, name.slots() + usize::from(in_root))?;
        let note_room = if in_root { room } else { self.make_room(self.volume.root, 1)? };
        if in_root {
            room = room.next(self)?.ok_or(Error::Damaged)?;
        }
        let to = self.last_of(room, name.slots())?.place();
        let sum = sum(&self.slot(to)?);
        let note = Note { from: entry.place(), first_byte: entry.slot[0], to, sum };
        let note_name = NewName { name: name.name, short_name: NOTE, case_bits: 0, long_slots: 0 };
        let note = self.write_entry(note_room, &note_name, note.slot(), None)?;
        self.change(entry.place(), |slot| slot[0] = FREE)?;
        self.store()?;
        self.write_entry(room, name, slot, None)?;
        if entry.is_directory() {
            self.set_parent(entry.cluster(), self.parent_cluster(directory))?;
        }
        self.remove_slots(&note)
    }

    /// Writes a directory's `..`, its second slot.
    fn set_parent(&mut self, directory: u32, parent: u32) -> Result<(), Error<B::Error>> {
        let place = Place { block: self.volume.block_of(directory), slot: 1 };
        if self.slot(place)?.starts_with(b"..         ") {
            self.change(place, |slot| set_cluster(slot, parent))?;
            self.store()?;
        }
        Ok(())
    }

    fn settle(&mut self) -> Result<(), Error<B::Error>> {
        let (mut listing, mut name) = (Listing::start(self, self.volume.root)?, Name::new());
        while let Some(entry) = listing.next_entry(self, &mut name)? {
            if let Some(note) = Note::of(&entry.slot) {
                self.complete(note)?;
                self.remove_slots(&entry)?;
            }
        }
        Ok(())
    }

    fn complete(&mut self, note: Note) -> Result<(), Error<B::Error>> {
        if !(self.volume.may_hold_entries(note.from.block) && self.volume.may_hold_entries(note.to.block)) {
            return Ok(());
        }
        let (taken_away, to) = (self.slot(note.from)?, self.slot(note.to)?);
        let mut before = taken_away;
        before[0] = note.first_byte;
        let cluster = super::slot::cluster(&before, self.volume.kind);
        // An entry moved differs only in its name. A target that was written and is gone was moved on or
        // removed by others.
        let is_there = kind_of(&to) == SlotKind::Entry && to[11] == before[11] && to[13..] == before[13..];
        let never_was_there = !is_there && sum(&to) == note.sum;
        // A file system check may have freed the entry's clusters meanwhile.
        let has_clusters = cluster == 0 || (self.volume.has_cluster(cluster) && self.link(cluster)? != Link::Free);
        if taken_away[0] == FREE && never_was_there && has_clusters && kind_of(&before) == SlotKind::Entry {
            self.change(note.from, |slot| slot[0] = note.first_byte)?;
            self.store()?;
        }
        Ok(())
    }
}
