//! Analog inputs: sums of conversions at their times, with the range that they must stay in.

use crate::reason::Reason;

/// Most bytes of sums in a report.
const MOST_REPORT_BYTES: usize = 48;
/// Conversions that may be missing one after another: the converter needs a moment to begin.
const MOST_MISSING: u16 = 200;

/// Conversions that the host asks for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Query {
    /// Distance of the conversions of a sum, ticks.
    pub sample_ticks: u32,
    /// Conversions of a sum. Zero: none.
    pub sample_count: u8,
    /// Distance of the sums, ticks.
    pub rest_ticks: u32,
    /// Bytes of sums, two each, that make a report.
    pub report_bytes: u8,
    /// Range of a sum.
    pub least: u16,
    /// Greatest sum that is in range.
    pub most: u16,
    /// Sums out of range one after another that are one too many. Zero: any number may be.
    pub range_checks: u8,
}

/// An analog input and the sum that is being made.
#[derive(Debug)]
pub struct AnalogIn<A> {
    pub input: A,
    query: Query,
    sum: u16,
    samples: u8,
    /// Beginning of the next sum.
    next_begin: u32,
    out_of_range: u8,
    missing: u16,
    report: heapless::Vec<u8, MOST_REPORT_BYTES>,
}

/// Outcome of a conversion.
pub struct Taken {
    /// Time of the next conversion.
    pub due: u32,
    /// A report is whole: clock of the next sum, and the sums.
    pub report: Option<(u32, heapless::Vec<u8, MOST_REPORT_BYTES>)>,
}

impl<A: Copy> AnalogIn<A> {
    /// An input that the host asks for nothing yet.
    pub const fn new(input: A) -> Self {
        Self {
            input,
            query: Query {
                sample_ticks: 0,
                sample_count: 0,
                rest_ticks: 0,
                report_bytes: 0,
                least: 0,
                most: 0,
                range_checks: 0,
            },
            sum: 0,
            samples: 0,
            next_begin: 0,
            out_of_range: 0,
            missing: 0,
            report: heapless::Vec::new(),
        }
    }

    /// Begins with what the host asks for. Returns the time of the first conversion; `None` for none.
    ///
    /// # Errors
    /// Reports of no bytes, of half a sum, or of too many.
    pub fn ask(&mut self, query: Query, clock: u32) -> Result<Option<u32>, Reason> {
        self.query = query;
        self.samples = 0;
        self.sum = 0;
        self.out_of_range = 0;
        self.missing = 0;
        self.report.clear();
        if query.sample_count == 0 {
            return Ok(None);
        }
        let bytes = usize::from(query.report_bytes);
        if bytes == 0 || bytes % 2 != 0 || bytes > MOST_REPORT_BYTES {
            return Err(Reason::ReportTooLong);
        }
        self.next_begin = clock;
        Ok(Some(clock))
    }

    /// Leaves a sum out. Returns when the next one begins.
    pub fn skip(&mut self, due: u32) -> u32 {
        (self.sum, self.samples) = (0, 0);
        self.next_begin = due.wrapping_add(self.query.rest_ticks);
        self.next_begin
    }

    /// Takes a conversion that was due at `due`.
    ///
    /// # Errors
    /// The sums are out of their range, or conversions do not come.
    pub fn take(&mut self, conversion: Option<u16>, due: u32) -> Result<Taken, Reason> {
        let Some(value) = conversion else {
            self.missing += 1;
            return if self.missing > MOST_MISSING {
                Err(Reason::AdcStopped)
            } else {
                Ok(Taken { due: due.wrapping_add(self.query.sample_ticks.max(1)), report: None })
            };
        };
        self.missing = 0;
        // Of at most sixteen conversions, as the host sees to.
        self.sum = self.sum.saturating_add(value);
        self.samples += 1;
        if self.samples < self.query.sample_count {
            return Ok(Taken { due: due.wrapping_add(self.query.sample_ticks), report: None });
        }
        let sum = core::mem::take(&mut self.sum);
        self.samples = 0;
        self.next_begin = self.next_begin.wrapping_add(self.query.rest_ticks);
        if (self.query.least..=self.query.most).contains(&sum) {
            self.out_of_range = 0;
        } else {
            self.out_of_range = self.out_of_range.saturating_add(1);
            if self.out_of_range >= self.query.range_checks && self.query.range_checks != 0 {
                self.out_of_range = 0;
                return Err(Reason::AdcOutOfRange);
            }
        }
        // There is room: a report is sent when it has its bytes.
        let _fits = self.report.extend_from_slice(&sum.to_le_bytes());
        let is_whole = self.report.len() >= usize::from(self.query.report_bytes);
        let report = is_whole.then(|| (self.next_begin, core::mem::take(&mut self.report)));
        Ok(Taken { due: self.next_begin, report })
    }
}
