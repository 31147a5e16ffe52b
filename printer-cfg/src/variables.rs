//! Variables of macros that were changed since the configuration was read: as texts of Python literals.

use heapless::Vec;

use crate::index::Section;

/// Room for all changed variables with their names, bytes.
pub const ROOM: usize = 2048;
/// Bytes before the name: section, length of the name, length of the value.
const HEAD: usize = 5;

/// Variables that were changed. All zero at first.
#[derive(Debug)]
pub struct Variables {
    bytes: Vec<u8, ROOM>,
}

/// Place of a variable's value.
struct Found {
    at: usize,
    value: usize,
    end: usize,
}

impl Default for Variables {
    fn default() -> Self {
        Self::new()
    }
}

impl Variables {
    /// Every variable is as configured.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: Vec::new() }
    }

    /// Forgets all changes.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }

    fn find(&self, section: Section, name: &str) -> Option<Found> {
        let mut at = 0;
        while let Some(&[low, high, name_len, value_low, value_high]) = self.bytes.get(at..at + HEAD) {
            let value = at + HEAD + usize::from(name_len);
            let end = value + usize::from(u16::from_le_bytes([value_low, value_high]));
            let is_it = u16::from_le_bytes([low, high]) == section.0
                && self.bytes.get(at + HEAD..value) == Some(name.as_bytes());
            if is_it {
                return Some(Found { at, value, end });
            }
            at = end;
        }
        None
    }

    /// Returns the changed value of a variable; none if it has that of the configuration.
    #[must_use]
    pub fn get(&self, section: Section, name: &str) -> Option<&str> {
        let Found { value, end, .. } = self.find(section, name)?;
        core::str::from_utf8(self.bytes.get(value..end)?).ok()
    }

    /// Changes a variable. False, and it is as it was: there is no room.
    pub fn set(&mut self, section: Section, name: &str, value: &str) -> bool {
        let found = self.find(section, name);
        let freed = found.as_ref().map_or(0, |found| found.end - found.at);
        let (Ok(name_len), Ok(value_len)) = (u8::try_from(name.len()), u16::try_from(value.len())) else {
            return false;
        };
        if self.bytes.len() - freed + HEAD + name.len() + value.len() > ROOM {
            return false;
        }
        if let Some(Found { at, end, .. }) = found {
            let length = self.bytes.len();
            self.bytes.copy_within(end.., at);
            self.bytes.truncate(length - (end - at));
        }
        let parts = [&section.0.to_le_bytes()[..], &[name_len], &value_len.to_le_bytes(), name.as_bytes()];
        for part in parts.into_iter().chain([value.as_bytes()]) {
            // There is room, as was looked.
            let _ = self.bytes.extend_from_slice(part);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_set_last_is_what_is() {
        let mut variables = Variables::new();
        assert!(variables.set(Section(1), "a", "1"));
        assert!(variables.set(Section(2), "a", "'two'"));
        assert!(variables.set(Section(1), "b", "[1, 2]"));
        assert!(variables.set(Section(1), "a", "None"));
        assert_eq!(variables.get(Section(1), "a"), Some("None"));
        assert_eq!(variables.get(Section(2), "a"), Some("'two'"));
        assert_eq!(variables.get(Section(1), "b"), Some("[1, 2]"));
        assert_eq!(variables.get(Section(2), "b"), None);
    }

    #[test]
    fn without_room_a_variable_stays_as_it_was() {
        let mut variables = Variables::new();
        let long = "x".repeat(1200);
        assert!(variables.set(Section(1), "a", &long));
        assert!(!variables.set(Section(1), "b", &long));
        assert!(variables.set(Section(1), "a", "1") && variables.set(Section(1), "b", &long));
        assert_eq!(variables.get(Section(1), "a"), Some("1"));
        assert_eq!(variables.get(Section(1), "b"), Some(long.as_str()));
    }
}
