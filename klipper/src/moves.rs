//! Memory of queued moves: one pool for the steps of all motors and the changes of all outputs, as the host
//! expects it.

/// Moves that there is room for. A host keeps half a second of them in advance, some hundred; Klipper's own
/// firmware has 1024.
pub const MOVES: usize = 4096;

/// Place of no move: the end of a list.
const NONE: u16 = u16::MAX;

/// A queued move: its three numbers mean what their queue's owner makes of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Move {
    /// Interval of steps, or clock of an output's change.
    pub time: u32,
    /// Count and addend of steps, or the new state of an output.
    pub value: u32,
    /// Direction of steps; not used by outputs.
    pub flag: u16,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    content: Move,
    next: u16,
}

/// The memory itself. All zero at first.
#[derive(Debug)]
pub struct Moves {
    slots: [Slot; MOVES],
}

impl Default for Moves {
    fn default() -> Self {
        Self::new()
    }
}

impl Moves {
    /// Creates memory of zeros.
    #[must_use]
    pub const fn new() -> Self {
        Self { slots: [Slot { content: Move { time: 0, value: 0, flag: 0 }, next: 0 }; MOVES] }
    }
}

/// First and last of a queue's moves.
#[derive(Clone, Copy, Debug)]
pub struct Queue {
    first: u16,
    last: u16,
}

impl Queue {
    /// A queue without moves.
    pub const EMPTY: Self = Self { first: NONE, last: NONE };

    /// Returns whether nothing is queued.
    pub const fn is_empty(&self) -> bool {
        self.first == NONE
    }
}

/// The pool: what is free, and the links of what is not.
#[derive(Debug)]
pub struct Pool {
    moves: &'static mut Moves,
    free: u16,
}

impl Pool {
    /// Makes a pool of which all is free.
    pub fn new(moves: &'static mut Moves) -> Self {
        for (index, slot) in moves.slots.iter_mut().enumerate() {
            slot.next = if index + 1 < MOVES { index as u16 + 1 } else { NONE };
        }
        Self { moves, free: 0 }
    }

    /// Gives the memory back.
    pub fn into_moves(self) -> &'static mut Moves {
        self.moves
    }

    fn slot(&mut self, place: u16) -> Option<&mut Slot> {
        self.moves.slots.get_mut(usize::from(place))
    }

    /// Appends a move to a queue. `None` when there is no room.
    pub fn push(&mut self, queue: &mut Queue, content: Move) -> Option<()> {
        let place = self.free;
        let slot = self.slot(place)?;
        let free = slot.next;
        *slot = Slot { content, next: NONE };
        self.free = free;
        match self.slot(queue.last) {
            Some(last) => last.next = place,
            None => queue.first = place,
        }
        queue.last = place;
        Some(())
    }

    /// Returns the first move of a queue.
    pub fn first(&self, queue: &Queue) -> Option<Move> {
        self.moves.slots.get(usize::from(queue.first)).map(|slot| slot.content)
    }

    /// Takes the first move of a queue.
    pub fn pop(&mut self, queue: &mut Queue) -> Option<Move> {
        let (place, free) = (queue.first, self.free);
        let slot = self.slot(place)?;
        let (content, next) = (slot.content, slot.next);
        slot.next = free;
        self.free = place;
        queue.first = next;
        if next == NONE {
            queue.last = NONE;
        }
        Some(content)
    }

    /// Gives back all moves of a queue.
    pub fn clear(&mut self, queue: &mut Queue) {
        if let Some(last) = self.moves.slots.get_mut(usize::from(queue.last)) {
            last.next = self.free;
            self.free = queue.first;
        }
        *queue = Queue::EMPTY;
    }
}
