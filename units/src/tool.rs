//! Numbers that users give to tools and heaters.

use core::fmt;

/// Number that the user gave to a tool or a temperature control (`tool_id`): T of M104, S of M143 and M301, P
/// of M303 and M207.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct ToolId(pub u8);

impl ToolId {
    /// Least number of a bed or a chamber; tools have lower numbers.
    pub const FIRST_BED: Self = Self(100);

    /// Returns the number that a G-code word names; `None` when no tool can have it.
    #[must_use]
    pub fn from_word(value: f64) -> Option<Self> {
        let id = value as u8;
        // The cast saturates and cuts: only a whole number from 0 to 255 comes back as before.
        (f64::from(id) == value).then_some(Self(id))
    }
}

impl fmt::Display for ToolId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_numbers_in_range_name_a_tool() {
        assert_eq!(ToolId::from_word(254.0), Some(ToolId(254)));
        assert_eq!(ToolId::from_word(0.0), Some(ToolId(0)));
        for word in [-1.0, 0.5, 255.5, 256.0, f64::NAN, f64::INFINITY] {
            assert_eq!(ToolId::from_word(word), None, "{word}");
        }
    }
}
