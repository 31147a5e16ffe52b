//! Progress of a job: `progress`, M27, and the status report.
//!
//! The line whose moves the motors make counts; while they rest, the lines that have been read.

use base::clock_time::Clock;
use base::paths::Path;
use base::ports::{Storage, StorageError};
use base::sessions::Reply;
use config::MachineConfig;
use motion::Tag;
use units::Micros;

use super::objects::Objects;
use super::{Job, Jobs};
use crate::journal::{self, PlayedFile};

/// Times from a look ahead at the file, at the present overrides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeLeft {
    /// Time left and in all, by the planner.
    pub planned: Option<Planned>,
    /// Share of the file that has been looked at, per cent, while that goes on.
    pub looked_at: Option<u8>,
}

/// Times of motion, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planned {
    /// Time left.
    pub left: f32,
    /// Time of the whole job.
    pub total: f32,
}

impl Jobs {
    /// Notes the tag of the moves that the motors make now; `None` while they rest. Moves that are not of the
    /// job, a session's among its own, change nothing.
    pub fn executing(&mut self, tag: Option<Tag>) {
        self.place = tag.and_then(|tag| self.tags.executing(tag).or(self.place));
    }

    /// Returns the number of the line that moves with this tag are made for: the job's, or the one a session
    /// gave it.
    #[must_use]
    pub fn line_of(&self, tag: Tag) -> Option<u32> {
        self.tags.number(tag)
    }

    /// Returns the number, and the offset of the end, of the line that the motors make, or that was read
    /// last.
    pub(super) fn place(&self, job: &Job) -> (u32, u32) {
        self.place.unwrap_or((job.lines.number(), job.lines.read()))
    }

    /// Returns seconds since the job began, and per cent of its file.
    #[must_use]
    pub fn progress(&self, now: Micros) -> Option<(u64, u64)> {
        let job = self.job.as_ref()?;
        let (_, done) = self.place(job);
        let percent = u64::from(done) * 100 / u64::from(job.size.max(1));
        Some((now.since(job.started).millis() / 1_000, percent))
    }

    /// Returns per cent of the file being played, and its name.
    #[must_use]
    pub fn share(&self) -> Option<(u8, &str)> {
        let job = self.job.as_ref()?;
        let (_, done) = self.place(job);
        let percent = u64::from(done) * 100 / u64::from(job.size.max(1));
        let name = job.path.rsplit('/').next().unwrap_or_default();
        Some((percent.min(100) as u8, name))
    }

    /// Returns the time left and in all, seconds, with its source: planner or slicer.
    pub(super) fn time_left(&self, job: &Job, time_left: &TimeLeft) -> Option<(f32, f32, &'static str)> {
        if let Some(Planned { left, total }) = time_left.planned {
            return Some((left, total, "planner"));
        }
        let total = job.slicer.total?;
        let done = self.place(job).1 as f32 / job.size.max(1) as f32;
        Some((job.slicer.left.unwrap_or(total * (1.0 - done)), total, "slicer"))
    }

    /// Answers M27 and `progress -b`.
    pub fn say_bytes(&self, time_left: &TimeLeft, reply: &mut Reply<'_>) {
        match &self.job {
            Some(job) => {
                let (_, done) = self.place(job);
                reply.say(format_args!("SD printing byte {done}/{}\n", job.size));
                if let Some((left, total, who)) = self.time_left(job, time_left) {
                    let (left, total) = (Clock(f64::from(left)), Clock(f64::from(total)));
                    reply.say(format_args!("// time left: {left} of {total}, by the {who}\n"));
                }
            }
            None => reply.say(format_args!("Not currently playing\n")),
        }
    }

    /// Answers M73 without words as Prusa's firmware does: hosts read these words. Unknown values are -1.
    pub fn say_progress(&self, time_left: &TimeLeft, reply: &mut Reply<'_>) {
        let Some(job) = &self.job else { return reply.say(format_args!("Not currently playing\n")) };
        let time = self.time_left(job, time_left);
        let by_size = || 100.0 * self.place(job).1 as f32 / job.size.max(1) as f32;
        let by_time = |(left, total, _): (f32, f32, _)| (total > 0.0).then(|| 100.0 * (1.0 - left / total));
        let percent = libm::floorf(units::within(time.and_then(by_time).unwrap_or_else(by_size), 0.0, 100.0));
        let minutes = time.map_or(-1.0, |(left, ..)| libm::ceilf(left / 60.0));
        reply.say(format_args!(
            "NORMAL MODE: Percent done: {percent:.0}; print time remaining in mins: {minutes:.0}; Change in mins: -1\n"
        ));
    }

    /// Answers `progress [-b]` with the progress of the job.
    pub fn progress_command(&self, arguments: &str, now: Micros, time_left: &TimeLeft, reply: &mut Reply<'_>) {
        if arguments.contains("-b") {
            return self.say_bytes(time_left, reply);
        }
        if self.suspended.is_some() {
            return reply.say(format_args!("Suspended\n"));
        }
        let Some(job) = &self.job else { return reply.say(format_args!("Not currently playing\n")) };
        let ((_, done), size) = (self.place(job), job.size);
        if job.paused {
            return reply.say(format_args!("SD print is paused at {done}/{size}\n"));
        }
        if size == 0 {
            return reply.say(format_args!("File size is unknown\n"));
        }
        let share = f64::from(done) / f64::from(size);
        let elapsed = now.since(job.started).millis() / 1_000;
        let (percent, time) = (share * 100.0, Clock(elapsed as f64));
        reply.say(format_args!("file: {}, {percent:.1} % complete, elapsed time: {time}", job.path));
        if let Some((left, total, who)) = self.time_left(job, time_left) {
            let (left, total) = (Clock(f64::from(left)), Clock(f64::from(total)));
            reply.say(format_args!(", est time: {left} of {total} by the {who}"));
        } else if done > 0 {
            let left = elapsed as f64 / share - elapsed as f64;
            reply.say(format_args!(", est time: {}", Clock(libm::floor(left))));
        }
        if let Some(percent) = time_left.looked_at {
            reply.say(format_args!(", the planner has looked at {percent} %"));
        }
        reply.say(format_args!("{}\n", if self.is_heating { ", heating" } else { "" }));
    }
}

/// State of a job that a look ahead at its file needs.
impl Jobs {
    /// Marks the job as new, so that the question is asked again.
    pub const fn is_new_again(&mut self) {
        if let Some(job) = &mut self.job {
            job.is_new = true;
        }
    }

    /// Returns the number of the job since boot.
    #[must_use]
    pub const fn count(&self) -> u32 {
        self.opened
    }

    /// Has the job begin whatever a look at its file says.
    pub const fn force(&mut self) {
        if let Some(job) = &mut self.job {
            job.is_forced = true;
        }
    }

    /// Whether the job begins whatever a look at its file says.
    #[must_use]
    pub fn is_forced(&self) -> bool {
        self.job.as_ref().is_some_and(|job| job.is_forced)
    }

    /// Whether all lines of the job have been read; its last moves may still be made.
    #[must_use]
    pub fn is_read(&self) -> bool {
        self.job.as_ref().is_some_and(|job| job.lines.is_at_end() && job.callers.is_empty())
    }

    /// Returns the path of the file that is played.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.job.as_ref().map(|job| &job.path)
    }
}

/// Data of a job for its journal, and their reading.
impl Jobs {
    /// Returns the file that is played, before any of it is read; `machine` is the check value over the
    /// settings.
    ///
    /// # Errors
    /// Errors of the card.
    pub fn played_file(&self, machine: u32, storage: &mut impl Storage) -> Result<PlayedFile, StorageError> {
        let Some(job) = &self.job else { return Err(StorageError::NotFound) };
        let check = journal::check_value(job.lines.file(), job.size, storage)?;
        storage.seek(job.lines.file(), 0)?;
        Ok(PlayedFile {
            path: job.path.clone(),
            size: job.size,
            written: journal::written(&job.path, storage)?,
            check,
            machine,
            dialect: self.dialect.map_or(0, |dialect| dialect as u8 + 1),
        })
    }

    /// Begins at the file's beginning again, to be read without its moves.
    ///
    /// # Errors
    /// When the card does not answer.
    pub fn read_again(&mut self, storage: &mut impl Storage) -> Result<(), StorageError> {
        self.return_all(storage);
        self.objects = Objects::default();
        self.forget_places();
        let Some(job) = &mut self.job else { return Ok(()) };
        job.has_begun = false;
        // Marks without a number count on from here.
        job.layers.current = 0;
        job.lines.restart(storage)
    }

    /// Whether the file is the boot file.
    #[must_use]
    pub fn is_boot_file(&self, config: &MachineConfig) -> bool {
        self.job.as_ref().is_some_and(|job| job.path.eq_ignore_ascii_case(&config.player.on_boot_gcode))
    }

    /// Returns the line that the motors make, or that was read last.
    #[must_use]
    pub fn line_now(&self) -> u32 {
        self.place.map_or_else(|| self.line(), |(line, _)| line)
    }

    /// Returns the number of lines made when the motors make the moves with this tag.
    #[must_use]
    pub fn made(&self, tag: Tag) -> Option<u32> {
        self.tags.ordinal(tag).map(|ordinal| ordinal.saturating_sub(1))
    }

    /// Returns the number of this job's lines that have begun and are no comments, each as often as it did.
    #[must_use]
    pub const fn begun(&self) -> u32 {
        self.tags.count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::player::{Next, Starter};
    use base::bench::{Card, Desk};
    use base::sessions::LineBytes;

    const NOW: Micros = Micros::from_seconds(35);

    /// A job of ten lines of ten bytes each that began 30 s ago, and of which so many have been read.
    fn reading(lines: usize) -> (Jobs, Card, Vec<Tag>) {
        let mut card = Card::with(&[("/sd/a.g", &"G1 X1 Y12\n".repeat(10))]);
        let mut jobs = Jobs::default();
        assert_eq!(
            jobs.open(&base::failure::Texts::new(), "/sd/a.g", Starter::default(), &mut card, Micros::from_seconds(5)),
            Ok(100)
        );
        jobs.read_as(program::Dialect::Smoothie);
        let mut line = LineBytes::new();
        let mut tags = Vec::new();
        for _ in 0..lines {
            assert_eq!(jobs.next_line(&mut card, &mut line), Next::Line);
            tags.push(jobs.begin_line());
        }
        (jobs, card, tags)
    }

    fn said(jobs: &Jobs, arguments: &str) -> String {
        Desk::new().hears(|reply| jobs.progress_command(arguments, NOW, &TimeLeft::default(), reply))
    }

    #[test]
    fn what_executes_counts_not_what_was_read() {
        let (mut jobs, _, tags) = reading(5);
        for (index, tag) in tags.into_iter().enumerate() {
            jobs.executing(Some(tag));
            let done = 10 * (index as u64 + 1);
            assert_eq!(jobs.progress(NOW), Some((30, done)));
            assert_eq!(said(&jobs, "-b"), format!("SD printing byte {done}/100\n"));
        }
    }

    #[test]
    fn while_nothing_moves_what_was_read_counts() {
        let (mut jobs, _, tags) = reading(5);
        assert_eq!(jobs.progress(NOW), Some((30, 50)));
        jobs.executing(Some(tags[1]));
        assert_eq!(jobs.progress(NOW), Some((30, 20)));
        jobs.executing(None);
        assert_eq!(jobs.progress(NOW), Some((30, 50)));
    }

    #[test]
    fn moves_of_somebody_else_are_no_progress() {
        let (mut jobs, _, tags) = reading(5);
        jobs.executing(Some(tags[1]));
        for other in [Tag::NONE, Tag(999)] {
            jobs.executing(Some(other));
            assert_eq!(jobs.progress(NOW), Some((30, 20)));
        }
    }

    #[test]
    fn the_answer_says_how_long_it_took_takes_and_that_it_heats() {
        let (mut jobs, mut card, tags) = reading(5);
        jobs.executing(Some(tags[1]));
        let expected = "file: /sd/a.g, 20.0 % complete, elapsed time: 00:00:30, est time: 00:02:00";
        assert_eq!(said(&jobs, ""), format!("{expected}\n"));
        jobs.set_heating(true);
        assert_eq!(said(&jobs, ""), format!("{expected}, heating\n"));
        jobs.set_heating(false);
        assert_eq!(said(&jobs, ""), format!("{expected}\n"));
        jobs.set_paused(true);
        assert_eq!(said(&jobs, ""), "SD print is paused at 20/100\n");
        jobs.close(&mut card);
        assert_eq!(said(&jobs, ""), "Not currently playing\n");
        assert_eq!(said(&jobs, "-b"), "Not currently playing\n");
        assert_eq!(jobs.progress(NOW), None);
    }

    #[test]
    fn nothing_of_a_job_is_taken_for_the_next_one() {
        let (mut jobs, mut card, tags) = reading(9);
        jobs.executing(Some(tags[7]));
        jobs.set_heating(true);
        jobs.close(&mut card);
        assert_eq!(jobs.open(&base::failure::Texts::new(), "/sd/a.g", Starter::default(), &mut card, NOW), Ok(100));
        jobs.executing(Some(tags[7]));
        assert_eq!(said(&jobs, ""), "file: /sd/a.g, 0.0 % complete, elapsed time: 00:00:00\n");
    }

    #[test]
    fn nothing_of_it_is_done_when_it_begins_again() {
        let (mut jobs, mut card, tags) = reading(9);
        jobs.executing(Some(tags[7]));
        assert!(jobs.restart(&base::failure::Texts::new(), &mut card).is_ok());
        jobs.executing(Some(tags[8]));
        assert_eq!(jobs.progress(NOW), Some((30, 0)));
    }

    #[test]
    fn times_read_as_a_clock() {
        assert_eq!(std::format!("{}", Clock(3_725.4)), "01:02:05");
        assert_eq!(std::format!("{}", Clock(59.5)), "00:01:00");
    }
}
