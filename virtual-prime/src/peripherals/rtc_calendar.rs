//! Dates as the RTC's registers hold them: binary-coded decimal, two-digit years of 2000.

/// A date and a time of day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DateTime {
    year: u64,
    month: u64,
    day: u64,
    weekday: u64,
    seconds: u64,
}

/// The calendar at the instant it was set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calendar(DateTime);

impl Default for Calendar {
    /// Reset values of RTC_TR and RTC_DR: Monday, 1 January of year 0.
    fn default() -> Self {
        Self(DateTime { year: 0, month: 1, day: 1, weekday: 1, seconds: 0 })
    }
}

impl From<DateTime> for Calendar {
    fn from(now: DateTime) -> Self {
        Self(now)
    }
}

const fn from_bcd(value: u64) -> u64 {
    (value >> 4) * 10 + (value & 0xF)
}

const fn to_bcd(value: u64) -> u64 {
    ((value / 10) << 4) | (value % 10)
}

const fn days_of(month: u64, year: u64) -> u64 {
    match month {
        4 | 6 | 9 | 11 => 30,
        2 if year.is_multiple_of(4) => 29,
        2 => 28,
        _ => 31,
    }
}

impl Calendar {
    /// Decodes RTC_TR (hours in bits 21..16, minutes 14..8, seconds 6..0) and RTC_DR (year 23..16, weekday
    /// 15..13, month 12..8, day 5..0).
    pub fn from_registers(time: u64, date: u64) -> Self {
        let seconds = from_bcd(time >> 16 & 0x3F) * 3_600 + from_bcd(time >> 8 & 0x7F) * 60 + from_bcd(time & 0x7F);
        Self(DateTime {
            year: from_bcd(date >> 16 & 0xFF),
            month: from_bcd(date >> 8 & 0x1F),
            day: from_bcd(date & 0x3F),
            weekday: date >> 13 & 7,
            seconds,
        })
    }

    /// Whether INITS is set: "the calendar year field is different from 0".
    pub const fn is_set(&self) -> bool {
        self.0.year != 0
    }

    /// Returns the date and time so many seconds later.
    pub fn after(&self, seconds: u64) -> DateTime {
        let mut at = self.0;
        let total = at.seconds + seconds;
        at.seconds = total % 86_400;
        for _ in 0..total / 86_400 {
            at.weekday = at.weekday % 7 + 1;
            at.day += 1;
            if at.day > days_of(at.month, at.year) {
                at.day = 1;
                at.month += 1;
            }
            if at.month > 12 {
                at.month = 1;
                at.year = (at.year + 1) % 100;
            }
        }
        at
    }
}

impl DateTime {
    /// Encodes the time for RTC_TR.
    pub const fn time_register(&self) -> u64 {
        to_bcd(self.seconds / 3_600) << 16 | to_bcd(self.seconds / 60 % 60) << 8 | to_bcd(self.seconds % 60)
    }

    /// Encodes the date for RTC_DR.
    pub const fn date_register(&self) -> u64 {
        to_bcd(self.year) << 16 | self.weekday << 13 | to_bcd(self.month) << 8 | to_bcd(self.day)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leap_day_and_a_new_year_come_at_midnight() {
        // The date is Wednesday, 28 February 2024, 23:59:59.
        let before = Calendar::from_registers(0x23_5959, 0x24_6228);
        assert_eq!((before.after(1).time_register(), before.after(1).date_register()), (0, 0x24_8229));
        assert_eq!(before.after(86_401).date_register(), 0x24_A301);
        let eve = Calendar::from_registers(0x23_5959, 0x99_9231);
        assert_eq!(eve.after(1).date_register() & 0xFF_1F3F, 0x00_0101);
    }
}
