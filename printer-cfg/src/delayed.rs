//! G-code that is carried out later: `[delayed_gcode]`.

use heapless::Vec;

use crate::index::Section;

/// Most of them that wait at once.
const MOST: usize = 16;

/// A section whose G-code waits for its time.
#[derive(Clone, Copy, Debug)]
struct Waits {
    section: Section,
    /// Time at which it is due, microseconds since the start.
    due: u64,
}

/// Delayed G-code that waits.
#[derive(Debug)]
pub(crate) struct Delayed {
    waits: Vec<Waits, MOST>,
}

impl Delayed {
    /// Nothing waits.
    pub const fn new() -> Self {
        Self { waits: Vec::new() }
    }

    /// Forgets all that waits.
    pub fn clear(&mut self) {
        self.waits.clear();
    }

    /// Sets when a section is due; never if there is no time. False: there is no room.
    pub fn set(&mut self, section: Section, due: Option<u64>) -> bool {
        self.waits.retain(|waits| waits.section != section);
        due.is_none_or(|due| self.waits.push(Waits { section, due }).is_ok())
    }

    /// Whether one is due.
    pub fn is_due(&self, now: u64) -> bool {
        self.waits.iter().any(|waits| waits.due <= now)
    }

    /// Takes the one that has been due for longest.
    pub fn take(&mut self, now: u64) -> Option<Section> {
        let first = self.waits.iter().filter(|waits| waits.due <= now).min_by_key(|waits| waits.due)?.section;
        self.waits.retain(|waits| waits.section != first);
        Some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_comes_once_when_it_is_due() {
        let mut delayed = Delayed::new();
        assert!(delayed.set(Section(1), Some(20)) && delayed.set(Section(2), Some(10)));
        assert!(!delayed.is_due(9) && delayed.take(9).is_none());
        assert!(delayed.set(Section(2), Some(30)));
        assert_eq!(delayed.take(40), Some(Section(1)));
        assert_eq!(delayed.take(40), Some(Section(2)));
        assert_eq!(delayed.take(40), None);
        assert!(delayed.set(Section(1), Some(50)) && delayed.set(Section(1), None));
        assert!(!delayed.is_due(60));
    }
}
