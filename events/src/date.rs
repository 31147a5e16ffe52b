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

    /// Returns the date of a time in seconds since 1970; `None` outside 2000 to 2099.
    #[must_use]
    pub fn from_unix(seconds: u64) -> Option<Self> {
        /// Days from 1970 to 2000.
        const TO_2000: u64 = 10_957;
        let part = |unit: u64, of: u64| (seconds / unit % of) as u8;
        let mut date = Self { hour: part(3_600, 24), minute: part(60, 60), second: part(1, 60), ..Self::UNSET };
        let mut days = (seconds / 86_400).checked_sub(TO_2000)?;
        loop {
            let year = if date.year.is_multiple_of(4) { 366 } else { 365 };
            if days < year {
                break;
            }
            days -= year;
            date.year += 1;
            if date.year > 2099 {
                return None;
            }
        }
        while days >= u64::from(date.days_of_month()) {
            days -= u64::from(date.days_of_month());
            date.month += 1;
        }
        date.day = days as u8 + 1;
        Some(date)
    }

    const fn days_of_month(self) -> u8 {
        match self.month {
            4 | 6 | 9 | 11 => 30,
            2 if self.year.is_multiple_of(4) => 29,
            2 => 28,
            _ => 31,
        }
    }

    fn is_sound(self) -> bool {
        (1..=12).contains(&self.month)
            && (1..=self.days_of_month()).contains(&self.day)
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
    fn seconds_since_1970_are_dates() {
        let date = |seconds| DateTime::from_unix(seconds).map(|date| std::format!("{date}"));
        assert_eq!(date(946_684_800).as_deref(), Some("2000-01-01 00:00:00"));
        assert_eq!(date(1_709_164_799).as_deref(), Some("2024-02-28 23:59:59"));
        assert_eq!(date(1_709_164_800).as_deref(), Some("2024-02-29 00:00:00"));
        assert_eq!(date(1_795_910_400).as_deref(), Some("2026-11-29 00:00:00"));
        assert_eq!(date(4_102_444_799).as_deref(), Some("2099-12-31 23:59:59"));
        assert_eq!((date(4_102_444_800), date(946_684_799)), (None, None));
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
