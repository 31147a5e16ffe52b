//! Plays files from the card: `play`, `progress`, `abort`, M23 to M27, M32.
//!
//! One line at a time, between the lines of consoles; the look-ahead queue, when full, is what holds it back.
//!
//! A line that cannot be carried out pauses the file: what comes after it counts on it, and a tool that goes on from the wrong place
//! breaks what it meets. Nothing is lost: `M24` goes on with the next line.

use gcode::{Gathered, LineBuffer};
use heapless::{String, Vec};
use units::Micros;

use crate::console::{LineBytes, Target};
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, about_file, message};
use crate::ports::{FileHandle, OpenMode, PATH_BYTES, Ports};
use crate::suspend::Suspended;

/// Bytes read from the card at a time: one sector.
const CHUNK: usize = 512;

/// A file that is open to be played.
#[derive(Debug)]
struct Job {
    file: FileHandle,
    path: String<PATH_BYTES>,
    size: u32,
    /// Bytes handed to lines so far.
    read: u32,
    /// Lines that have ended so far.
    lines: u32,
    started: Micros,
    chunk: Vec<u8, CHUNK>,
    next: usize,
    gathering: LineBuffer,
    /// Lines and replies go here.
    echo: Target,
    /// Whoever started it hears of its end.
    tells_end: Target,
    paused: bool,
    /// Every line has been handed out.
    at_end: bool,
}

/// The player.
#[derive(Debug, Default)]
pub struct Player {
    job: Option<Job>,
    pub(crate) suspended: Option<Suspended>,
    boot_file_pending: bool,
}

/// What the file gave.
enum Next {
    Line,
    TooLong,
    End,
    Failed(&'static str),
}

impl Player {
    /// Seconds and percent of the file being played.
    #[must_use]
    pub fn progress(&self, now: Micros) -> Option<(u64, u64)> {
        let job = self.job.as_ref()?;
        let percent = u64::from(job.read) * 100 / u64::from(job.size.max(1));
        Some((now.since(job.started).millis() / 1_000, percent))
    }

    /// A file is being played and not paused.
    #[must_use]
    pub fn is_playing(&self) -> bool {
        self.job.as_ref().is_some_and(|job| !job.paused)
    }

    /// Forgets a suspension; true when there was one.
    pub fn cancel_suspend(&mut self) -> bool {
        self.suspended.take().is_some()
    }

    pub(crate) fn set_paused(&mut self, paused: bool) -> bool {
        self.job.as_mut().map(|job| job.paused = paused).is_some()
    }
}

impl<P: Ports> Controller<P> {
    /// The boot file is played once the machine listens.
    pub(crate) fn queue_boot_files(&mut self) {
        let player = &self.config.player;
        self.player.boot_file_pending = player.on_boot_gcode_enable && !player.on_boot_gcode.is_empty();
    }

    /// Runs the next line of the file being played. False when there is none.
    pub(crate) async fn play_next_line(&mut self) -> bool {
        self.open_boot_files();
        if !self.player.is_playing() {
            return false;
        }
        let mut line = LineBytes::new();
        match self.next_file_line(&mut line) {
            Next::Line => {
                let echo = self.player.job.as_ref().map_or(Target::Nobody, |job| job.echo);
                self.target = echo;
                if let Ok(text) = core::str::from_utf8(&line)
                    && echo != Target::Nobody
                {
                    self.say(format_args!("{text}\n"));
                }
                let carried_out = self.run_line(&line).await;
                self.drain().await;
                if !carried_out {
                    self.pause_at_this_line("was not carried out");
                }
            }
            Next::TooLong => self.pause_at_this_line("is too long"),
            Next::End => return self.finish_job(),
            Next::Failed(why) => {
                self.target = Target::Nobody;
                let text = message(format_args!("reading the file being played failed: {why}"));
                self.alarm(&text);
            }
        }
        true
    }

    /// The line just read cannot be carried out; unless that has ended the job already, it waits for a person.
    fn pause_at_this_line(&mut self, why: &str) {
        let Some(job) = &mut self.player.job else { return };
        job.paused = true;
        let number = job.lines + u32::from(job.at_end);
        let path = job.path.clone();
        self.announce(format_args!(
            "error:paused, line {number} of {path} {why}: M24 goes on with the next line, abort ends the job\n"
        ));
    }

    fn open_boot_files(&mut self) {
        // There need not be such a file.
        if self.player.job.is_none() && core::mem::take(&mut self.player.boot_file_pending) {
            let path = self.config.player.on_boot_gcode.clone();
            let _ = self.open_job(&path, Target::Nobody, Target::Nobody);
        }
    }

    fn next_file_line(&mut self, line: &mut LineBytes) -> Next {
        let Self { ports, player, .. } = self;
        let Some(job) = player.job.as_mut().filter(|job| !job.at_end) else { return Next::End };
        loop {
            while let Some(byte) = job.chunk.get(job.next).copied() {
                job.next += 1;
                job.read = job.read.saturating_add(1);
                job.lines += u32::from(byte == b'\n');
                match job.gathering.push(byte) {
                    Some(Gathered::Line(bytes)) => return whole(bytes, line),
                    Some(Gathered::TooLong) => return Next::TooLong,
                    None => {}
                }
            }
            let mut chunk = [0; CHUNK];
            match ports.read(job.file, &mut chunk) {
                Ok(0) => break,
                Ok(count) => {
                    job.next = 0;
                    job.chunk.clear();
                    // A chunk fits a chunk.
                    let _ = job.chunk.extend_from_slice(chunk.get(..count).unwrap_or(&[]));
                }
                Err(error) => return Next::Failed(error.text()),
            }
        }
        job.next = 0;
        job.chunk.clear();
        job.at_end = true;
        match job.gathering.finish() {
            Some(Gathered::Line(bytes)) => whole(bytes, line),
            Some(Gathered::TooLong) => Next::TooLong,
            None => Next::End,
        }
    }

    /// The file has been read; it is done when its last moves are. False while they go on, so that consoles are heard.
    fn finish_job(&mut self) -> bool {
        self.ports.motion(motion::Motion::flush);
        if !self.ports.motion(|motion| motion.is_idle()) {
            return false;
        }
        let told = self.player.job.as_ref().map_or(Target::Nobody, |job| job.tells_end);
        self.stop_player();
        self.consoles.write(told, format_args!("Done printing file\n"));
        true
    }

    /// Closes the file being played, if there is one.
    pub(crate) fn stop_player(&mut self) -> bool {
        let Some(job) = self.player.job.take() else { return false };
        // It was only read: a failing close loses nothing.
        let _ = self.ports.close(job.file);
        true
    }

    pub(crate) fn open_job(&mut self, path: &str, echo: Target, tells_end: Target) -> Result<u32, Failure> {
        if self.player.job.is_some() {
            return Err(Failure::refused("Currently printing, abort print first"));
        }
        let failed = |error: crate::ports::StorageError| Failure::Refused(about_file(path, error.text()));
        let file = self.ports.open(path, OpenMode::Read).map_err(failed)?;
        let size = self.ports.size(file).map_err(failed)?;
        let path = String::try_from(path).unwrap_or_default();
        let started = self.ports.now();
        let (chunk, gathering) = (Vec::new(), LineBuffer::new());
        let job = Job {
            file,
            path,
            size,
            read: 0,
            lines: 0,
            started,
            chunk,
            next: 0,
            gathering,
            echo,
            tells_end,
            paused: false,
            at_end: false,
        };
        self.player.job = Some(job);
        Ok(size)
    }

    /// `play <file> [-v] [-p] [-t]`
    pub(crate) fn play_command(&mut self, arguments: &str) {
        let (name, options) = split_options(arguments);
        let path = self.absolute(name);
        let echo = if options.contains("-v") { self.target } else { Target::Nobody };
        let tells_end = if options.contains("-t") { self.target } else { Target::Nobody };
        match self.open_job(&path, echo, tells_end) {
            Ok(size) => {
                self.player.set_paused(options.contains("-p"));
                self.say(format_args!("Playing {path}\n  File size {size}\n"));
            }
            Err(Failure::Refused(_)) if self.player.job.is_some() => {
                self.say(format_args!("Currently printing, abort print first\n"));
            }
            Err(_) => self.say(format_args!("File not found: {path}\n")),
        }
    }

    /// M23 to M27 and M32.
    pub(crate) fn play_code(&mut self, number: u16, name: Option<&str>) -> Outcome {
        match (number, name) {
            (23 | 32, Some(name)) => self.select_file(number, name),
            (23 | 32, None) => Err(Failure::refused("the name of a file is missing")),
            (24, _) => {
                let tells = self.target;
                let Some(job) = &mut self.player.job else { return Err(Failure::refused("no file is selected")) };
                job.paused = false;
                job.tells_end = tells;
                Ok(Answer::Ok)
            }
            (25, _) => {
                self.player.set_paused(true);
                Ok(Answer::Ok)
            }
            (26, _) => self.restart_file(),
            _ => {
                self.say_bytes();
                Ok(Answer::Ok)
            }
        }
    }

    fn select_file(&mut self, number: u16, name: &str) -> Outcome {
        let mut path: String<PATH_BYTES> = String::new();
        let fits = path.push_str("/sd/").is_ok() && path.push_str(name.trim_start_matches('/')).is_ok();
        if self.player.is_playing() {
            return Err(Failure::refused("Currently printing, abort print first"));
        }
        self.stop_player();
        let tells = if number == 32 { self.target } else { Target::Nobody };
        match self.open_job(&path, Target::Nobody, tells) {
            Ok(size) if fits => {
                self.player.set_paused(number == 23);
                self.say(format_args!("File opened:{name} Size:{size}\nFile selected\n"));
                Ok(Answer::Ok)
            }
            _ => {
                self.say(format_args!("file.open failed: {name}\n"));
                Ok(Answer::Ok)
            }
        }
    }

    fn restart_file(&mut self) -> Outcome {
        let Self { ports, player, .. } = self;
        let Some(job) = &mut player.job else { return Err(Failure::refused("no file is selected")) };
        let sought = ports.seek(job.file, 0);
        job.read = 0;
        job.lines = 0;
        job.at_end = false;
        job.chunk.clear();
        job.next = 0;
        job.gathering.clear();
        sought.map_err(|error| Failure::refused(error.text()))?;
        Ok(Answer::Ok)
    }

    fn say_bytes(&mut self) {
        match self.player.job.as_ref().map(|job| (job.read, job.size)) {
            Some((read, size)) => self.say(format_args!("SD printing byte {read}/{size}\n")),
            None => self.say(format_args!("Not currently playing\n")),
        }
    }

    /// `progress [-b]`
    pub(crate) fn progress_command(&mut self, arguments: &str) {
        if arguments.contains("-b") {
            return self.say_bytes();
        }
        if self.player.suspended.is_some() {
            return self.say(format_args!("Suspended\n"));
        }
        let now = self.ports.now();
        let Some(job) = &self.player.job else { return self.say(format_args!("Not currently playing\n")) };
        let (path, read, size) = (job.path.clone(), job.read, job.size);
        if job.paused {
            return self.say(format_args!("SD print is paused at {read}/{size}\n"));
        }
        if size == 0 {
            return self.say(format_args!("File size is unknown\n"));
        }
        let share = f64::from(read) / f64::from(size);
        let elapsed = now.since(job.started).millis() / 1_000;
        self.say(format_args!("file: {path}, {:.1} % complete, elapsed time: {}", share * 100.0, Clock(elapsed)));
        if read > 0 {
            let left = elapsed as f64 / share - elapsed as f64;
            self.say(format_args!(", est time: {}", Clock(left as u64)));
        }
        self.say(format_args!("\n"));
    }

    /// `abort`: brakes, drops what is queued, closes the file. Heaters are left alone.
    pub(crate) async fn abort_command(&mut self) {
        let suspended = self.player.cancel_suspend();
        if suspended {
            self.say(format_args!("Suspend cleared\n"));
        }
        if !self.stop_player() {
            if !suspended {
                self.say(format_args!("Not currently playing\n"));
            }
            return;
        }
        self.say(format_args!("Please wait for abort to complete. Turn any heaters off manually\n"));
        self.ports.motion(motion::Motion::stop);
        // A halt meanwhile has dropped everything too.
        let _ = self.wait_idle().await;
        self.resync();
    }
}

fn whole(bytes: &[u8], line: &mut LineBytes) -> Next {
    line.clear();
    if line.extend_from_slice(bytes).is_ok() { Next::Line } else { Next::TooLong }
}

/// A name that may have blanks, and options that begin at the first ` -` whose letter is one of ours.
fn split_options(arguments: &str) -> (&str, &str) {
    let place = [" -v", " -p", " -t"].into_iter().filter_map(|option| arguments.find(option)).min();
    let (name, options) = arguments.split_at(place.unwrap_or(arguments.len()));
    (name.trim(), options)
}

/// Seconds as `hh:mm:ss`.
struct Clock(u64);

impl core::fmt::Display for Clock {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:02}:{:02}:{:02}", self.0 / 3_600, self.0 / 60 % 60, self.0 % 60)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_may_hold_blanks_and_dashes() {
        assert_eq!(split_options("/sd/my - part.gcode -v -p"), ("/sd/my - part.gcode", " -v -p"));
        assert_eq!(split_options("a-b.g"), ("a-b.g", ""));
    }

    #[test]
    fn times_read_as_a_clock() {
        assert_eq!(std::format!("{}", Clock(3_725)), "01:02:05");
    }
}
