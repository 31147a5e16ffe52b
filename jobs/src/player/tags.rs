//! Tags of moves: the line of the file that a move is made for, and how far into the file it is.
//!
//! Lines are read well before the motors make their moves. Each move carries the tag of its line, motion
//! hands back the tag of the move that executes, and [`Tags`] finds the line of the tag.

use motion::Tag;

/// Number of lines that are remembered; more than moves are queued in a usual look-ahead queue.
const REMEMBERED: usize = 256;

/// Bit of tags that are line numbers given by sessions (`N`).
const NUMBERED: u32 = 1 << 31;

/// Returns the tag of moves that a session's line of this number makes.
#[must_use]
pub const fn of_number(number: u32) -> Tag {
    Tag(NUMBERED | number)
}

/// Place of a line that moves are made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    /// Number of the line, from 1.
    line: u32,
    /// Offset of the line's end in the file, bytes.
    offset: u32,
}

/// The last lines of a job, by the tags of their moves.
#[derive(Debug)]
pub struct Tags {
    places: [Place; REMEMBERED],
    /// The tag given last.
    newest: Tag,
    /// Number of tags given in this job.
    count: u32,
}

impl Default for Tags {
    fn default() -> Self {
        Self { places: [Place { line: 0, offset: 0 }; REMEMBERED], newest: Tag::NONE, count: 0 }
    }
}

impl Tags {
    /// Begins a line that ends at this offset of the file, and returns the tag of its moves.
    pub fn begin_line(&mut self, line: u32, offset: u32) -> Tag {
        let mut next = self.newest.0.wrapping_add(1) & !NUMBERED;
        if next == Tag::NONE.0 {
            next = 1;
        }
        if let Some(place) = self.places.get_mut(index(next)) {
            *place = Place { line, offset };
        }
        self.newest = Tag(next);
        self.count = self.count.saturating_add(1);
        self.newest
    }

    /// Takes back the line that was begun last: it has made no move, and is begun again.
    pub const fn take_back(&mut self) {
        self.newest = Tag(self.newest.0.wrapping_sub(1) & !NUMBERED);
        self.count = self.count.saturating_sub(1);
    }

    /// Returns the line, and the offset of its end, that moves with this tag are made for; `None` when they
    /// are not of this job. For a line too long ago, returns the oldest line that is remembered.
    #[must_use]
    pub fn executing(&self, tag: Tag) -> Option<(u32, u32)> {
        let age = self.newest.0.wrapping_sub(tag.0) & !NUMBERED;
        if tag == Tag::NONE || tag.0 & NUMBERED != 0 || age >= self.count {
            return None;
        }
        let oldest = REMEMBERED as u32 - 1;
        let place = self.places.get(index(self.newest.0.wrapping_sub(age.min(oldest))))?;
        Some((place.line, place.offset))
    }

    /// Returns the number of lines of this job that have begun.
    #[must_use]
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// Returns the number, from 1 in the order of beginnings, of the line that moves with this tag are made
    /// for.
    #[must_use]
    pub fn ordinal(&self, tag: Tag) -> Option<u32> {
        let age = self.newest.0.wrapping_sub(tag.0) & !NUMBERED;
        if tag == Tag::NONE || tag.0 & NUMBERED != 0 { None } else { self.count.checked_sub(age).filter(|n| *n > 0) }
    }

    /// Returns the number of the line that moves with this tag are made for.
    #[must_use]
    pub fn number(&self, tag: Tag) -> Option<u32> {
        if tag.0 & NUMBERED != 0 { Some(tag.0 & !NUMBERED) } else { self.executing(tag).map(|(line, _)| line) }
    }

    /// Forgets all tags, at another job or at this one from its beginning.
    pub const fn forget(&mut self) {
        self.count = 0;
    }
}

const fn index(tag: u32) -> usize {
    tag as usize % REMEMBERED
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_tag_leads_to_its_line() {
        let mut tags = Tags::default();
        let given: Vec<Tag> = (0..REMEMBERED as u32).map(|line| tags.begin_line(line + 1, 10 * line)).collect();
        for (line, tag) in given.iter().enumerate() {
            assert_eq!(tags.executing(*tag), Some((line as u32 + 1, 10 * line as u32)));
        }
        assert_eq!(tags.executing(Tag::NONE), None);
        assert_eq!(tags.executing(Tag(given.len() as u32 + 1)), None, "it has not been given");
    }

    #[test]
    fn a_sessions_number_is_no_line_of_the_job() {
        let mut tags = Tags::default();
        let first = tags.begin_line(3, 10);
        assert_eq!((tags.number(first), tags.number(of_number(12))), (Some(3), Some(12)));
        assert_eq!((tags.executing(of_number(1)), tags.number(Tag::NONE)), (None, None));
    }

    #[test]
    fn of_a_line_long_ago_the_oldest_one_is_told() {
        let mut tags = Tags::default();
        let first = tags.begin_line(1, 10);
        for line in 2..=1_000 {
            tags.begin_line(line, 10 * line);
        }
        assert_eq!(tags.executing(first), Some((1_001 - REMEMBERED as u32, 10 * (1_001 - REMEMBERED as u32))));
    }

    #[test]
    fn tags_of_another_job_are_not_of_this_one() {
        let mut tags = Tags::default();
        let before = tags.begin_line(7, 70);
        tags.forget();
        assert_eq!(tags.executing(before), None);
        let now = tags.begin_line(1, 5);
        assert_eq!((tags.executing(before), tags.executing(now)), (None, Some((1, 5))));
    }

    proptest! {
        #[test]
        fn tags_are_never_none_and_progress_never_goes_back(start in 0..NUMBERED, steps in prop::collection::vec(1_u32..40, 1..600)) {
            let mut tags = Tags { newest: Tag(start), ..Tags::default() };
            let mut given = Vec::new();
            let mut offset = 0;
            for (line, step) in steps.iter().enumerate() {
                offset += step;
                let tag = tags.begin_line(line as u32 + 1, offset);
                prop_assert_ne!(tag, Tag::NONE);
                given.push(tag);
            }
            // A count that begins anew uses one place twice.
            let begins_anew = start + steps.len() as u32 >= NUMBERED;
            let reported: Vec<u32> = given.iter().filter_map(|tag| tags.executing(*tag)).map(|(line, _)| line).collect();
            prop_assert!(reported.len() + usize::from(begins_anew) >= given.len());
            prop_assert!(begins_anew || reported.is_sorted());
            prop_assert_eq!(reported.last().copied(), Some(steps.len() as u32));
        }
    }

    #[test]
    fn lines_are_counted_in_the_order_of_their_beginnings() {
        let mut tags = Tags::default();
        let given: Vec<Tag> = [7, 3, 9].into_iter().map(|line| tags.begin_line(line, 0)).collect();
        assert_eq!(given.iter().map(|tag| tags.ordinal(*tag)).collect::<Vec<_>>(), [Some(1), Some(2), Some(3)]);
        assert_eq!((tags.ordinal(Tag::NONE), tags.ordinal(of_number(3))), (None, None));
        assert_eq!(tags.count(), 3);
    }
}
