//! Timeline of the program: tags of the moves being executed, and marks at places of the path.
//!
//! A tag names what a move is for (a line of a file); `Timeline::pass` says whose move the motors are
//! making. A mark is a place between moves: it is made behind whatever has been submitted, and reached when
//! the motors get there. The part that hangs effects on marks (a fan, a target temperature) learns from
//! [`Passed`] which have been reached; the path is the same with and without them.
//!
//! Blocks are counted as in [`crate::planner::Planner`]. The cursor enters each block here when it begins it,
//! up to a few milliseconds before the motors do; what is entered and then taken back is forgotten again.

use units::{Ring, Ticks};

use crate::{
    move_ends::MoveEnds,
    moves::Tag,
    trajectory::{TickTime, at_tick},
};

/// Boundaries that can wait to be passed: those of the trajectory that runs ahead of the motors, at some
/// thousand moves a second.
const BOUNDARIES: usize = 128;
/// Marks at different places that can wait.
const MARKS: usize = 64;

/// A mark, counted from 1, wrapping. Marks are reached in order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mark(pub u32);

impl Mark {
    /// Whether it is `other` or was made before it.
    #[must_use]
    pub const fn is_reached_with(self, other: Self) -> bool {
        other.0.wrapping_sub(self.0) as i32 >= 0
    }
}

/// Progress of the motors in the program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passed {
    /// Tag of the move under way, or of the last one.
    pub tag: Tag,
    /// The last mark that has been reached.
    pub mark: Mark,
}

/// Beginning of a move on the trajectory.
#[derive(Clone, Copy, Debug)]
struct Boundary {
    at: TickTime,
    /// Count of the block that begins.
    block: u32,
    tag: Tag,
}

/// Marks that lie before the block of this count.
#[derive(Clone, Copy, Debug)]
struct Place {
    block: u32,
    /// The last of them.
    mark: Mark,
}

/// Tags and marks between the planner and the motors.
#[derive(Clone, Debug)]
pub(crate) struct Timeline {
    /// Moves that have begun on the trajectory and not yet on the motors.
    begun: Ring<Boundary, BOUNDARIES>,
    /// Marks that have not been reached.
    marks: Ring<Place, MARKS>,
    /// The last mark made.
    made: Mark,
    passed: Passed,
    /// Count of the block that begins next on the trajectory.
    next: u32,
    /// Count of the block that the motors make, or make next.
    under_way: u32,
    /// Ends of moves, for whoever draws the path.
    pub(crate) ends: MoveEnds,
}

impl Timeline {
    /// Creates a timeline on which nothing has happened.
    pub const fn new() -> Self {
        const BOUNDARY: Boundary = Boundary { at: TickTime::ZERO, block: 0, tag: Tag::NONE };
        const PLACE: Place = Place { block: 0, mark: Mark(0) };
        Self {
            begun: Ring::new(BOUNDARY),
            marks: Ring::new(PLACE),
            made: Mark(0),
            passed: Passed { tag: Tag::NONE, mark: Mark(0) },
            next: 0,
            under_way: 0,
            ends: MoveEnds::new(),
        }
    }

    /// Makes a mark behind the blocks pushed so far. `None` when too many wait: ask again later.
    pub fn mark(&mut self, pushed: u32) -> Option<Mark> {
        let made = Mark(self.made.0.wrapping_add(1));
        match self.marks.last_mut() {
            Some(last) if last.block == pushed => last.mark = made,
            _ => {
                if !self.marks.push(Place { block: pushed, mark: made }) {
                    return None;
                }
            }
        }
        self.made = made;
        Some(made)
    }

    /// The block of this count begins then.
    pub fn begin(&mut self, block: u32, tag: Tag, at: TickTime) {
        self.next = block.wrapping_add(1);
        let boundary = Boundary { at, block, tag };
        if !self.begun.push(boundary)
            && let Some(last) = self.begun.last_mut()
        {
            // Moves this short are told together, at the end of the last one: no mark is reached early.
            *last = boundary;
        }
    }

    /// Whether a block has been entered.
    pub const fn has_begun(&self, block: u32) -> bool {
        self.next.wrapping_sub(block) as i32 > 0
    }

    /// Forgets every beginning at or after `from`: those blocks begin anew.
    pub fn take_back(&mut self, from: TickTime) {
        while let Some(last) = self.begun.last_mut().copied().filter(|last| last.at >= from) {
            self.next = last.block;
            self.begun.drop_last();
        }
    }

    /// Blocks from this count on are others than those that were entered. Marks stay where they are counted:
    /// those of blocks that are gone are reached on the way to what follows them.
    pub fn enter_anew(&mut self, from: u32) {
        if self.has_begun(from) {
            self.next = from;
        }
    }

    /// Delays everything from `from` on by `by`.
    pub fn shift(&mut self, from: TickTime, by: TickTime) {
        for index in 0..self.begun.len() {
            if let Some(boundary) = self.begun.get_mut(index).filter(|boundary| boundary.at >= from) {
                boundary.at += by;
            }
        }
    }

    /// Drops everything that has not been reached, with the moves it waited for; marks count as reached, so
    /// that nobody waits for them.
    pub fn clear(&mut self, pushed: u32) {
        self.begun.clear();
        self.marks.clear();
        self.ends.drop_from(self.under_way);
        self.passed.mark = self.made;
        self.next = pushed;
    }

    /// Whether the motors make the block of this count.
    pub const fn is_under_way(&self, block: u32) -> bool {
        self.under_way == block
    }

    /// Takes the oldest end of a move that the motors have made since moves are watched.
    pub fn take_end(&mut self) -> Option<crate::MoveEnd> {
        self.ends.take_before(self.under_way)
    }

    /// Returns the progress of the motors at this tick. `rests` when they have played all that was submitted
    /// so far, `pushed` blocks.
    pub fn pass(&mut self, now: Ticks, rests: bool, pushed: u32) -> Passed {
        let mut reached = None;
        while let Some(boundary) = self.begun.get(0).filter(|boundary| boundary.at <= at_tick(now)) {
            self.passed.tag = boundary.tag;
            reached = Some(boundary.block);
            self.begun.drop_first();
        }
        if rests && self.begun.is_empty() {
            reached = Some(pushed);
        }
        if let Some(block) = reached {
            self.under_way = block;
            while let Some(place) = self.marks.get(0).filter(|place| block.wrapping_sub(place.block) as i32 >= 0) {
                self.passed.mark = place.mark;
                self.marks.drop_first();
            }
        }
        self.passed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(ticks: u64) -> TickTime {
        at_tick(Ticks(ticks))
    }

    #[test]
    fn a_mark_is_reached_when_the_block_behind_it_begins() {
        let mut timeline = Timeline::new();
        let before = timeline.mark(0).unwrap();
        let [between, twin] = [timeline.mark(1).unwrap(), timeline.mark(1).unwrap()];
        let after = timeline.mark(2).unwrap();
        timeline.begin(0, Tag(7), tick(100));
        timeline.begin(1, Tag(8), tick(200));
        let passed = |tag, mark| Passed { tag: Tag(tag), mark };
        assert_eq!(timeline.pass(Ticks(99), false, 2), passed(0, Mark(0)));
        assert_eq!(timeline.pass(Ticks(150), false, 2), passed(7, before));
        assert_eq!(timeline.pass(Ticks(200), false, 2), passed(8, twin));
        assert!(between.is_reached_with(twin) && !after.is_reached_with(twin));
        assert_eq!(timeline.pass(Ticks(300), true, 2), passed(8, after), "the motors rest behind the last block");
    }

    #[test]
    fn without_motion_a_mark_is_reached_at_once() {
        let mut timeline = Timeline::new();
        let mark = timeline.mark(5).unwrap();
        assert_eq!(timeline.pass(Ticks(1), true, 5).mark, mark);
    }

    #[test]
    fn what_is_taken_back_begins_anew() {
        let mut timeline = Timeline::new();
        let mark = timeline.mark(1).unwrap();
        timeline.begin(0, Tag(1), tick(100));
        timeline.begin(1, Tag(2), tick(200));
        timeline.take_back(tick(150));
        assert!(timeline.has_begun(0) && !timeline.has_begun(1));
        assert_eq!(timeline.pass(Ticks(250), false, 2).tag, Tag(1));
        timeline.begin(1, Tag(2), tick(300));
        assert_eq!(timeline.pass(Ticks(299), false, 2).mark, Mark(0));
        assert_eq!(timeline.pass(Ticks(300), false, 2), Passed { tag: Tag(2), mark });
    }

    #[test]
    fn a_shift_moves_what_is_to_come() {
        let mut timeline = Timeline::new();
        timeline.begin(0, Tag(1), tick(100));
        timeline.begin(1, Tag(2), tick(200));
        timeline.shift(tick(150), tick(1_000));
        assert_eq!(timeline.pass(Ticks(1_199), false, 2).tag, Tag(1));
        assert_eq!(timeline.pass(Ticks(1_200), false, 2).tag, Tag(2));
    }

    #[test]
    fn full_rings_refuse_marks_and_tell_short_moves_together() {
        let mut timeline = Timeline::new();
        for block in 0..MARKS as u32 {
            assert!(timeline.mark(block).is_some());
        }
        assert_eq!(timeline.mark(MARKS as u32), None);
        for block in 0..2 * BOUNDARIES as u32 {
            timeline.begin(block, Tag(block), tick(u64::from(block)));
        }
        let passed = timeline.pass(Ticks(BOUNDARIES as u64), false, 1_000);
        assert_eq!(passed.tag, Tag(BOUNDARIES as u32 - 2));
        assert_eq!(timeline.pass(Ticks(1_000), false, 1_000).tag, Tag(2 * BOUNDARIES as u32 - 1));
        assert!(timeline.mark(1_000).is_some());
    }

    #[test]
    fn clearing_leaves_nobody_waiting() {
        let mut timeline = Timeline::new();
        let mark = timeline.mark(3).unwrap();
        timeline.begin(0, Tag(1), tick(100));
        timeline.clear(3);
        assert!(mark.is_reached_with(timeline.pass(Ticks(0), false, 3).mark));
        assert!(timeline.has_begun(2) && !timeline.has_begun(3));
    }
}
