//! Blocks that were read lately, in groups of consecutive ones.

use super::{GROUP_BLOCKS, GROUP_SLOT, GROUPS};

#[derive(Clone, Copy, Debug)]
struct Group {
    first: u32,
    count: u32,
    /// Count of uses at the last use of the group.
    used: u32,
}

/// All groups of blocks.
#[derive(Clone, Debug)]
pub(super) struct Groups {
    groups: [Group; GROUPS],
    uses: u32,
}

impl Groups {
    /// Creates empty groups.
    pub const fn new() -> Self {
        Self { groups: [Group { first: 0, count: 0, used: 0 }; GROUPS], uses: 0 }
    }

    /// The slot of a block.
    pub fn find(&mut self, number: u32) -> Option<usize> {
        self.uses = self.uses.wrapping_add(1);
        let uses = self.uses;
        self.groups.iter_mut().enumerate().find_map(|(place, group)| {
            let offset = number.checked_sub(group.first).filter(|offset| *offset < group.count)?;
            group.used = uses;
            Some(GROUP_SLOT + place * GROUP_BLOCKS + offset as usize)
        })
    }

    /// Makes room for a group from this block up to the next block whose number is a multiple of a group's,
    /// and returns the group's index, its first slot, and the number of blocks. The previous contents are
    /// forgotten.
    pub fn make_room(&mut self, number: u32, end: u32) -> (usize, usize, u32) {
        let uses = self.uses;
        let oldest = self.groups.iter().enumerate().max_by_key(|(_, group)| match group.count {
            0 => u32::MAX,
            _ => uses.wrapping_sub(group.used),
        });
        let place = oldest.map_or(0, |(place, _)| place);
        if let Some(group) = self.groups.get_mut(place) {
            group.count = 0;
        }
        let boundary = (number | (GROUP_BLOCKS as u32 - 1)).saturating_add(1);
        (place, GROUP_SLOT + place * GROUP_BLOCKS, boundary.min(end).saturating_sub(number).max(1))
    }

    /// Notes the blocks that have come.
    pub fn finish(&mut self, place: usize, first: u32, count: u32) {
        let used = self.uses;
        if let Some(group) = self.groups.get_mut(place) {
            *group = Group { first, count, used };
        }
    }

    /// Forgets all blocks.
    pub fn clear(&mut self) {
        self.groups.iter_mut().for_each(|group| group.count = 0);
    }
}
