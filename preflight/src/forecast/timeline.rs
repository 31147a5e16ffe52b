//! Timeline of a job: the time at which each line is made, from the beginning. The time left is told by it.
//!
//! Kept at 256 lines of the job or fewer, evenly apart, and further apart the longer the job is; between them
//! time passes evenly. So the error at a place between two is a part of a two-hundredth of the job.

use heapless::Vec;

/// Greatest number of places of the job that are kept.
const MARKS: usize = 256;

/// Parts that make up time, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Time of working moves at even speed.
    pub feed: f32,
    /// Time of changes of their speed.
    pub ramps: f32,
    /// Time of rapid moves, dwells, homing: no feed override changes it.
    pub rest: f32,
}

impl Sums {
    /// Returns the time if working moves go `factor` times as fast as the forecast had them.
    ///
    /// Time at even speed goes inversely with the speed. Half of the time in which speed changes is spent on
    /// reaching it, which takes longer the greater it is; the other half counts by its way, as the even part:
    /// exact for a move from rest to rest that reaches its speed.
    #[must_use]
    pub fn seconds(&self, factor: f32) -> f32 {
        (self.feed + 0.5 * self.ramps) / factor + 0.5 * self.ramps * factor + self.rest
    }

    fn plus(self, other: Self, share: f32) -> Self {
        Self {
            feed: self.feed + share * other.feed,
            ramps: self.ramps + share * other.ramps,
            rest: self.rest + share * other.rest,
        }
    }

    /// Returns the sums added from `other` on to this.
    #[must_use]
    pub fn since(self, other: Self) -> Self {
        self.plus(other, -1.0)
    }
}

/// A place of the job.
#[derive(Clone, Copy, Debug)]
struct Mark {
    /// Sums of the lines before the place.
    sums: Sums,
    /// Factor of feed rates that the forecast has there.
    factor: f32,
}

/// The course of a job.
#[derive(Clone, Debug)]
pub struct JobTimeline {
    /// Marks before the lines at multiples of `stride`, counted from 0.
    marks: Vec<Mark, MARKS>,
    stride: u32,
    /// Factor of feed rates at the line that is worked on.
    factor: f32,
    feed: f64,
    ramps: f64,
    rest: f64,
}

impl Default for JobTimeline {
    fn default() -> Self {
        Self { marks: Vec::new(), stride: 1, factor: 1.0, feed: 0.0, ramps: 0.0, rest: 0.0 }
    }
}

impl JobTimeline {
    /// Forgets the whole course.
    pub fn clear(&mut self) {
        self.marks.clear();
        (self.stride, self.factor) = (1, 1.0);
        (self.feed, self.ramps, self.rest) = (0.0, 0.0, 0.0);
    }

    /// Begins this line of the job, counted from 1 as often as one is carried out; later time belongs to it.
    pub fn line(&mut self, line: u32) {
        while (self.marks.len() as u32).saturating_mul(self.stride) < line {
            if self.marks.is_full() {
                self.thin_out();
                continue;
            }
            let mark = Mark { sums: self.total(), factor: self.factor };
            // There is room: a full list was thinned out.
            let _ = self.marks.push(mark);
        }
    }

    /// Drops every other mark.
    fn thin_out(&mut self) {
        for place in 1..self.marks.len().div_ceil(2) {
            if let Some(mark) = self.marks.get(2 * place).copied()
                && let Some(slot) = self.marks.get_mut(place)
            {
                *slot = mark;
            }
        }
        self.marks.truncate(self.marks.len().div_ceil(2));
        self.stride = self.stride.saturating_mul(2);
    }

    /// Sets the factor by which feed rates are scaled from here on.
    pub fn set_factor(&mut self, factor: f64) {
        self.factor = factor as f32;
    }

    /// Adds a move, or a part of it: seconds at even speed and at changing speed.
    pub fn moved(&mut self, even: f64, ramps: f64, is_feed: bool) {
        if is_feed {
            self.feed += even;
            self.ramps += ramps;
        } else {
            self.rest += even + ramps;
        }
    }

    /// Adds seconds that are no move's.
    pub fn waited(&mut self, seconds: f64) {
        self.rest += seconds;
    }

    /// Returns the sums of all lines so far.
    #[must_use]
    pub fn total(&self) -> Sums {
        Sums { feed: self.feed as f32, ramps: self.ramps as f32, rest: self.rest as f32 }
    }

    /// Returns the sums when so many lines have been made.
    #[must_use]
    pub fn at(&self, lines: u32) -> Sums {
        let place = (lines / self.stride) as usize;
        let Some(before) = self.marks.get(place).map(|mark| mark.sums) else { return self.total() };
        let after = self.marks.get(place + 1).map_or_else(|| self.total(), |mark| mark.sums);
        let share = (lines % self.stride) as f32 / self.stride as f32;
        before.plus(after.since(before), share)
    }

    /// Returns the factor of feed rates that the forecast has there.
    #[must_use]
    pub fn factor_at(&self, lines: u32) -> f32 {
        self.marks.get((lines / self.stride) as usize).map_or(self.factor, |mark| mark.factor)
    }

    /// Returns the sums left when so many lines have been made.
    #[must_use]
    pub fn left(&self, lines: u32) -> Sums {
        self.total().since(self.at(lines))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_left_is_what_comes(times in prop::collection::vec(0.0..3.0_f64, 1..3_000), place in 0.0..1.0_f64) {
            let mut course = JobTimeline::default();
            for (index, seconds) in times.iter().enumerate() {
                course.line(index as u32 + 1);
                course.moved(0.5 * seconds, 0.25 * seconds, true);
                course.waited(0.25 * seconds);
            }
            let made = (place * times.len() as f64) as usize;
            let (left, total): (f64, f64) = (times[made..].iter().sum(), times.iter().sum());
            let told = f64::from(course.left(made as u32).seconds(1.0));
            // Between two places of the 128 to 256 that are kept.
            let most = 3.0 * (times.len() as f64 / 128.0).max(0.0) + 1e-4 * total;
            prop_assert!((told - left).abs() <= most, "{told} {left}");
            prop_assert!((f64::from(course.total().seconds(1.0)) - total).abs() < 1e-4 * (total + 1.0));
            if times.len() <= MARKS {
                prop_assert!((told - left).abs() <= 1e-4 * (total + 1.0));
            }
        }
    }

    #[test]
    fn lines_that_take_no_time_have_their_place_too() {
        let mut course = JobTimeline::default();
        course.line(5);
        course.waited(2.0);
        course.line(9);
        course.waited(3.0);
        let left: std::vec::Vec<_> = [0, 4, 5, 8, 9].iter().map(|line| course.left(*line).seconds(1.0)).collect();
        assert_eq!(left, [5.0, 5.0, 3.0, 3.0, 0.0]);
        course.clear();
        assert_eq!(course.left(0), Sums::default());
    }

    #[test]
    fn rapids_and_waits_take_their_time_whatever_the_override() {
        let mut course = JobTimeline::default();
        course.line(1);
        course.moved(2.0, 0.5, false);
        course.waited(1.5);
        for factor in [0.25, 1.0, 2.0] {
            assert_eq!(course.left(0).seconds(factor), 4.0, "{factor}");
        }
    }

    #[test]
    fn a_factor_of_feed_rates_counts_from_its_line_on() {
        let mut course = JobTimeline::default();
        for line in 1..=1_000 {
            course.line(line);
            course.set_factor(if line >= 400 { 0.5 } else { 1.0 });
        }
        assert_eq!([10, 300, 500, 999, 5_000].map(|line| course.factor_at(line)), [1.0, 1.0, 0.5, 0.5, 0.5]);
    }

    #[test]
    fn a_move_from_rest_to_rest_takes_what_an_override_makes_of_it() {
        // 10 mm at 20 mm/s and 400 mm/s2.
        let time = |speed: f32| (10.0 / speed - speed / 400.0, 2.0 * speed / 400.0);
        let (feed, ramps) = time(20.0);
        for factor in [0.5, 1.0, 2.0] {
            let (even, changing) = time(20.0 * factor);
            let told = Sums { feed, ramps, rest: 0.0 }.seconds(factor);
            assert!((told - even - changing).abs() < 1e-5, "{factor}: {told}");
        }
    }
}
