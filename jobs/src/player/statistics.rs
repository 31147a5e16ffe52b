//! Statistics of the last job and of the machine's life, kept on the card in `statistics.txt`.

use core::fmt;

use units::{Axis, AxisSet, Micros, PerAxis};

use super::heater_hours::HeaterHours;
pub use super::heater_hours::HeaterTime;

/// Path of the file of statistics.
pub const PATH: &str = "/sd/statistics.txt";
/// Least way between two samples that is no motion, mm: the same place has got other coordinates.
const JUMP: f64 = 20.0;

/// Sums over jobs, or of one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Time of jobs from their beginnings to their ends.
    pub job: Micros,
    /// Time of jobs in which nothing moved.
    pub still: Micros,
    /// Way of the tool, mm, as sampled a hundred times a second.
    pub way: f64,
    /// Filament that was used, mm: what was drawn back does not count.
    pub filament: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.job = self.job.plus(other.job);
        self.still = self.still.plus(other.still);
        self.way += other.way;
        self.filament += other.filament;
    }
}

/// Statistics of the machine's life.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Life {
    /// Jobs that were played to their ends.
    pub done: u32,
    /// Jobs that were aborted, or dropped by a halt.
    pub broken_off: u32,
    /// Duration of the longest job.
    pub longest: Micros,
    /// Sums of all jobs.
    pub sums: Sums,
    /// Time in which anything moved, jobs or not.
    pub moving: Micros,
}

impl Life {
    /// Reads a figure of the file; false when the key is none of these.
    fn read(&mut self, key: &str, value: f64) -> bool {
        let time = Micros((value * 1e6) as u64);
        match key {
            "jobs_done" => self.done = value as u32,
            "jobs_broken_off" => self.broken_off = value as u32,
            "longest_s" => self.longest = time,
            "job_s" => self.sums.job = time,
            "still_s" => self.sums.still = time,
            "way_mm" => self.sums.way = value,
            "filament_mm" => self.sums.filament = value,
            "moving_s" => self.moving = time,
            _ => return false,
        }
        true
    }
}

/// Writes the text of the file.
impl fmt::Display for Life {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "# What this machine has done. M78 shows it, M78 S78 begins anew.")?;
        writeln!(f, "jobs_done = {}\njobs_broken_off = {}", self.done, self.broken_off)?;
        let s = |time: Micros| time.0 / 1_000_000;
        writeln!(f, "longest_s = {}\njob_s = {}\nstill_s = {}", s(self.longest), s(self.sums.job), s(self.sums.still))?;
        writeln!(f, "way_mm = {:.0}\nfilament_mm = {:.1}", self.sums.way, self.sums.filament)?;
        writeln!(f, "moving_s = {}", s(self.moving))
    }
}

/// Statistics as they are counted.
#[derive(Clone, Debug, Default)]
pub struct Statistics {
    /// Sums of the machine's life, without the job that is played.
    pub life: Life,
    job: Option<Sums>,
    /// Work of the heaters.
    pub heaters: HeaterHours,
    /// Sums of the last job.
    pub before: Option<Sums>,
    last: Option<(Micros, PerAxis<f64>)>,
    is_unsaved: bool,
}

impl Statistics {
    /// Reads a line of the file; false when it cannot be one.
    pub fn read(&mut self, line: &str) -> bool {
        let Some((key, value)) = line.split_once('=') else { return line.trim().is_empty() || line.starts_with('#') };
        let value = gcode::read_f64(value.trim()).filter(|value| value.is_finite() && *value >= 0.0);
        value.is_some_and(|value| self.life.read(key.trim(), value) || self.heaters.read(key.trim(), value))
    }

    /// Samples the tool's place, a hundred times a second. `plays`: a job is open.
    pub fn sample(&mut self, now: Micros, plays: bool, moves: bool, place: &PerAxis<f64>, extruders: AxisSet) {
        let Some((before, from)) = self.last.replace((now, *place)) else { return };
        let time = now.since(before);
        if moves {
            self.life.moving = self.life.moving.plus(time);
        }
        if !plays {
            return;
        }
        let job = self.job.get_or_insert_default();
        job.job = job.job.plus(time);
        if !moves {
            job.still = job.still.plus(time);
            return;
        }
        let by = |axis: Axis| place[axis] - from[axis];
        let way = libm::sqrt(Axis::PRIMARY.into_iter().map(|axis| by(axis) * by(axis)).sum());
        if way < JUMP {
            job.way += way;
        }
        job.filament += extruders.axes().map(by).filter(|mm| libm::fabs(*mm) < JUMP).sum::<f64>();
    }

    /// Returns the filament that the job has used so far, or the last one has, mm.
    #[must_use]
    pub fn filament(&self) -> f64 {
        self.job.as_ref().or(self.before.as_ref()).map_or(0.0, |job| job.filament.max(0.0))
    }

    /// Ends the samples: nothing moves, and no job is open.
    pub const fn rest(&mut self) {
        self.last = None;
    }

    /// Ends the job, and returns its sums. `None` when there was none.
    pub fn end_job(&mut self, is_done: bool) -> Option<Sums> {
        let mut sums = self.job.take()?;
        sums.filament = sums.filament.max(0.0);
        self.life.done += u32::from(is_done);
        self.life.broken_off += u32::from(!is_done);
        self.life.longest = self.life.longest.max(sums.job);
        self.life.sums.add(&sums);
        (self.before, self.is_unsaved) = (Some(sums), true);
        Some(sums)
    }

    /// Resets all statistics to nothing.
    pub fn reset(&mut self) {
        (self.life, self.heaters, self.is_unsaved) = (Life::default(), HeaterHours::default(), true);
    }

    /// Whether the statistics are to be saved; asked once.
    pub fn take_unsaved(&mut self) -> bool {
        self.heaters.take_unsaved() | core::mem::take(&mut self.is_unsaved)
    }
}

/// A length of time, in hours, minutes and seconds.
pub struct Duration(pub Micros);

impl fmt::Display for Duration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0.0 / 1_000_000;
        let (hours, minutes, seconds) = (seconds / 3_600, seconds / 60 % 60, seconds % 60);
        write!(f, "{hours}:{minutes:02}:{seconds:02}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(x: f64, e: f64) -> PerAxis<f64> {
        let mut place = PerAxis([0.0; units::MAX_AXES]);
        (place[Axis::X], place[Axis::A]) = (x, e);
        place
    }

    #[test]
    fn a_job_is_added_up() {
        let mut statistics = Statistics::default();
        let extruders = AxisSet::NONE.with(Axis::A);
        for step in 0..=1_000_u64 {
            let x = (step as f64 * 0.1).min(50.0);
            // The extruder has pushed 5, drawn back 2 and pushed again.
            let e = match step {
                0..=500 => step as f64 * 0.01,
                501..=600 => 5.0 - (step - 500) as f64 * 0.02,
                _ => (3.0 + (step - 600) as f64 * 0.02).min(5.0),
            };
            statistics.sample(Micros(step * 10_000), true, step <= 800, &at(x, e), extruders);
        }
        let job = statistics.end_job(true).unwrap();
        assert_eq!((job.job, job.still), (Micros(10_000_000), Micros(2_000_000)));
        assert!((job.way - 50.0).abs() < 1e-6 && (job.filament - 5.0).abs() < 1e-6, "{job:?}");
        assert_eq!((statistics.life.done, statistics.life.moving), (1, Micros(8_000_000)));
        assert!(statistics.take_unsaved() && !statistics.take_unsaved());
        assert_eq!(statistics.end_job(false), None, "it has been counted");
    }

    #[test]
    fn a_place_that_is_only_called_otherwise_is_no_way() {
        let mut statistics = Statistics::default();
        for (step, x) in [0.0, 0.1, 100.0, 100.1].into_iter().enumerate() {
            statistics.sample(Micros(step as u64), true, true, &at(x, 0.0), AxisSet::NONE);
        }
        assert!((statistics.end_job(false).unwrap().way - 0.2).abs() < 1e-9);
        assert_eq!(statistics.life.broken_off, 1);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(
            (done, broken_off) in (0..9_999_u32, 0..9_999_u32),
            seconds in proptest::array::uniform4(0..9_999_999_u64),
            (way, filament) in (0..999_999_999_u32, 0..999_999_u32),
        ) {
            let [job, still, longest, moving] = seconds.map(|s| Micros(s * 1_000_000));
            let sums = Sums { job, still, way: f64::from(way), filament: f64::from(filament) / 10.0 };
            let life = Life { done, broken_off, longest, sums, moving };
            let (text, mut read) = (std::format!("{life}"), Statistics::default());
            prop_assert!(text.lines().all(|line| read.read(line)));
            prop_assert_eq!(read.life, life);
        }

        #[test]
        fn any_line_is_taken_or_refused(line in "[ -~]{0,80}") {
            let _ = Statistics::default().read(&line);
        }
    }

    #[test]
    fn a_length_of_time_is_read_as_on_a_clock() {
        for (seconds, text) in
            [(0, "0:00:00"), (59, "0:00:59"), (60, "0:01:00"), (3_599, "0:59:59"), (360_061, "100:01:01")]
        {
            assert_eq!(Duration(Micros::from_seconds(seconds)).to_string(), text);
        }
    }

    #[test]
    fn a_line_that_is_no_figure_is_none_of_the_file() {
        let mut statistics = Statistics::default();
        for line in ["", "  ", "# what follows"] {
            assert!(statistics.read(line), "{line}");
        }
        for line in ["x", "moving", "moving = -1", "moving = nan", "moving = inf", "moving = x", "nothing_known = 1"] {
            assert!(!statistics.read(line), "{line}");
        }
    }
}
