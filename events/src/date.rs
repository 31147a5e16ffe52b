//! Date and time of day.

use core::fmt;

/// Date and time of day, from 2000 to 2099.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DateTime {
    /// Year, 2000 to 2099.
    pub year: u16,
    /// Month, 1 to 12.
    pub month: u8,
    /// Day, 1 to 31.
    pub day: u8,
    /// Hour, 0 to 23.
    pub hour: u8,
    /// Minute, 0 to 59.
    pub minute: u8,
    /// Second, 0 to 59.
    pub second: u8,
}

impl DateTime {
    /// Date with which an unset clock begins.
    pub const UNSET: Self = Self { year: 2000, month: 1, day: 1, hour: 0, minute: 0, second: 0 };

    /// Returns whether somebody has set the clock that gave the date.
    #[must_use]
    pub const fn is_set(&self) -> bool {
        self.year != Self::UNSET.year
    }

    /// Parses `YYMMDDhhmmss`; `None` when it is no date of the calendar.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        if text.len() != 12 || !text.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        let part = |place: usize| text.get(2 * place..2 * place + 2)?.parse::<u8>().ok();
        let date = Self {
            year: 2000 + u16::from(part(0)?),
            month: part(1)?,
            day: part(2)?,
            hour: part(3)?,
            minute: part(4)?,
            second: part(5)?,
        };
        date.is_sound().then_some(date)
    }

    fn is_sound(self) -> bool {
        let days = match self.month {
            4 | 6 | 9 | 11 => 30,
            2 if self.year.is_multiple_of(4) => 29,
            2 => 28,
            _ => 31,
        };
        (1..=12).contains(&self.month)
            && (1..=days).contains(&self.day)
            && self.hour < 24
            && self.minute < 60
            && self.second < 60
    }
}

/// Prints date and time as `2026-01-02 03:04:05`.
impl fmt::Display for DateTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { year, month, day, hour, minute, second } = self;
        write!(f, "{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_read_and_said() {
        let date = DateTime::parse("260102030405").unwrap();
        assert_eq!(std::format!("{date}"), "2026-01-02 03:04:05");
        assert!(DateTime::parse("240229000000").is_some(), "a leap year");
    }

    #[test]
    fn what_is_in_no_calendar_is_no_date() {
        for text in
            ["", "26", "26010203040", "2601020304055", "261302030405", "230229000000", "260102240000", "26010203x405"]
        {
            assert_eq!(DateTime::parse(text), None, "{text}");
        }
    }

    #[test]
    fn the_last_of_each_part_is_a_date_and_the_next_is_none() {
        for (last, next) in [
            ("261231235959", "261331235959"),
            ("260430235959", "260431235959"),
            ("260228000000", "260229000000"),
            ("260102235900", "260102236000"),
            ("260102235959", "260102235960"),
        ] {
            assert!(DateTime::parse(last).is_some() && DateTime::parse(next).is_none(), "{last} {next}");
        }
    }
}
