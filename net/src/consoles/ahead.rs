//! Bytes that act at once while the line's queue is full: found among those that wait in the TCP buffer, and
//! left out when their turn comes.

use core::ops::Range;

use heapless::Vec;

/// Places that have acted and still wait in the stream.
const PLACES: usize = 8;

/// Places of a stream that are not to be received any more. Bytes of data are counted from the beginning,
/// wrapping.
#[derive(Clone, Debug)]
pub struct Ahead {
    /// Count of bytes of data that have been taken out of the TCP buffer.
    taken: u32,
    /// Bytes that have acted, as offsets from `taken`, in order.
    acted: Vec<Range<u32>, PLACES>,
    /// Bytes of the TCP buffer that have been looked through, commands of telnet among them.
    looked: usize,
}

impl Ahead {
    /// Begins at the beginning of a connection.
    pub const fn new() -> Self {
        Self { taken: 0, acted: Vec::new(), looked: 0 }
    }

    /// Takes the next byte of data. False if it has acted.
    pub fn take(&mut self) -> bool {
        let at = self.taken;
        self.taken = at.wrapping_add(1);
        let has_acted = self.has_acted(at);
        if let Some(first) = self.acted.first()
            && first.end == self.taken
        {
            self.acted.remove(0);
        }
        !has_acted
    }

    /// Notes that so many bytes of the TCP buffer have been taken.
    pub const fn consumed(&mut self, count: usize) {
        self.looked = self.looked.saturating_sub(count);
    }

    /// Returns how many bytes of the TCP buffer have been looked through.
    pub const fn looked(&self) -> usize {
        self.looked
    }

    /// Notes that so many bytes of the TCP buffer have been looked through.
    pub const fn look(&mut self, count: usize) {
        self.looked = count;
    }

    /// Returns whether a byte of data that waits has acted, by its number among those that wait.
    pub fn acted(&self, index: u32) -> bool {
        self.has_acted(self.taken.wrapping_add(index))
    }

    /// Returns whether one more place can be remembered.
    pub fn has_room(&self) -> bool {
        !self.acted.is_full()
    }

    /// Notes that bytes have acted, by their places among those that wait and have not acted.
    pub fn act(&mut self, place: Range<usize>) {
        let (mut first, mut end) = (None, 0);
        let (mut index, mut kept) = (0, 0);
        while kept < place.end {
            if !self.acted(index) {
                if kept == place.start {
                    first = Some(index);
                }
                kept += 1;
                end = index + 1;
            }
            index += 1;
        }
        let Some(first) = first else { return };
        self.remember(self.taken.wrapping_add(first)..self.taken.wrapping_add(end));
    }

    /// Adds a place, and has it swallow those within it and meet those beside it.
    fn remember(&mut self, place: Range<u32>) {
        let mut all = place;
        let from = |of: u32| of.wrapping_sub(self.taken);
        let mut others: Vec<Range<u32>, PLACES> = Vec::new();
        for other in &self.acted {
            if from(other.end) < from(all.start) || from(other.start) > from(all.end) {
                let _has_room = others.push(other.clone());
            } else {
                let start = if from(other.start) < from(all.start) { other.start } else { all.start };
                let end = if from(other.end) > from(all.end) { other.end } else { all.end };
                all = start..end;
            }
        }
        let at = others.iter().position(|other| from(other.start) > from(all.start)).unwrap_or(others.len());
        let _has_room = others.insert(at, all);
        self.acted = others;
    }

    fn has_acted(&self, at: u32) -> bool {
        self.acted.iter().any(|place| at.wrapping_sub(place.start) < place.end.wrapping_sub(place.start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes so many bytes, and returns which are left.
    fn left(ahead: &mut Ahead, count: usize) -> Vec<usize, 64> {
        (0..count).filter(|_| ahead.take()).collect()
    }

    #[test]
    fn bytes_that_have_acted_are_left_out_once() {
        for start in [0, u32::MAX - 3] {
            let mut ahead = Ahead { taken: start, ..Ahead::new() };
            ahead.act(2..3);
            // The third byte is gone, so the third that is left is the fourth.
            ahead.act(2..3);
            ahead.act(5..7);
            let mut index = 0;
            let mut kept = std::vec::Vec::new();
            while index < 12 {
                if ahead.take() {
                    kept.push(index);
                }
                index += 1;
            }
            assert_eq!(kept, [0, 1, 4, 5, 6, 9, 10, 11]);
            assert!(ahead.acted.is_empty());
        }
    }

    #[test]
    fn a_reset_takes_all_before_it_along() {
        let mut ahead = Ahead::new();
        ahead.act(3..4);
        ahead.act(6..7);
        ahead.act(0..8);
        assert_eq!(ahead.acted.len(), 1);
        assert_eq!(left(&mut ahead, 10).len(), 0);
        assert_eq!(left(&mut ahead, 2).len(), 2);
    }

    #[test]
    fn many_in_a_row_are_one_place() {
        let mut ahead = Ahead::new();
        for _ in 0..100 {
            assert!(ahead.has_room());
            ahead.act(4..5);
        }
        assert_eq!(left(&mut ahead, 110).len(), 10);
    }
}
