//! Lists, tuples, views, dicts and namespaces in memory: a head that stays, and elements that move when
//! they grow.

use super::{Memory, NOWHERE};
use crate::value::{self, Value};

/// A list, tuple, view, dict or namespace in memory: where its elements are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    pub data: usize,
    pub len: usize,
    pub room: usize,
}

/// Length of a block's head, bytes.
const HEAD: usize = 6;

impl Memory<'_> {
    /// Makes an empty block with room for elements of a size.
    #[inline(never)]
    pub fn new_block(&mut self, room: usize, size: usize) -> u16 {
        let head = self.reserve(HEAD) as u16;
        let data = self.reserve(room.saturating_mul(size));
        self.set_block(head, Block { data, len: 0, room });
        head
    }

    /// Makes an empty list, tuple or view.
    #[inline(never)]
    pub fn new_list(&mut self) -> u16 {
        self.new_block(0, value::SIZE)
    }

    /// The block with its head at a place.
    #[inline(never)]
    pub fn block(&self, head: u16) -> Block {
        let head = usize::from(head);
        let [data, len, room] = [0, 2, 4].map(|offset| usize::from(self.word(head + offset)));
        Block { data, len, room }
    }

    /// Number of elements of a block.
    #[inline(never)]
    pub fn count(&self, head: u16) -> usize {
        usize::from(self.word(usize::from(head) + 2))
    }

    /// Cuts a block to so many elements.
    #[inline(never)]
    pub fn set_count(&mut self, head: u16, count: usize) {
        self.set_word(usize::from(head) + 2, count as u16);
    }

    /// Place of an element of a block whose elements have a size.
    #[inline(never)]
    pub fn place(&self, head: u16, index: usize, size: usize) -> usize {
        usize::from(self.word(usize::from(head))) + index * size
    }

    /// Element of a block of values.
    #[inline(never)]
    pub fn element(&self, head: u16, index: usize) -> Value {
        self.value(self.place(head, index, value::SIZE))
    }

    /// Writes the head of a block.
    #[inline(never)]
    pub fn set_block(&mut self, head: u16, block: Block) {
        for (index, word) in [block.data, block.len, block.room].into_iter().enumerate() {
            self.set_word(usize::from(head) + 2 * index, word as u16);
        }
    }

    /// Makes room for one more element of a size; returns its place.
    #[inline(never)]
    pub fn grow(&mut self, head: u16, size: usize) -> usize {
        let mut block = self.block(head);
        if block.len == block.room {
            let more = block.room.max(2);
            if block.data + block.room * size == self.top {
                self.reserve(more * size);
            } else {
                let data = self.reserve((block.room + more) * size);
                self.copy(block.data, data, block.len * size);
                block.data = data;
            }
            block.room += more;
        }
        if self.is_full {
            return NOWHERE;
        }
        let at = block.data + block.len * size;
        block.len += 1;
        self.set_block(head, block);
        at
    }
}
