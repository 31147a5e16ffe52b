//! Commands to jobs: `play`, M23, M24, M26, M32.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::paths::Path;
use base::ports::{Calendar, OpenMode, Storage, StorageError};
use base::sessions::{Recipient, Reply};
use program::Dialect;
use units::Micros;

use super::{Job, Jobs, Layers, PRINTING, StalledJob, Starter, Suspended};
use crate::files::Files;

/// Refusal where a job would be lost, or go on from the wrong place.
const SUSPENDED: &str = "the job is suspended: resume or M602 goes on with it, abort ends it";
const DIALECTS: &str = "-f takes smoothie, marlin, reprapfirmware, klipper or grbl";
const OPTIONS: &str = "play takes -v, -p, -t and -f dialect behind the name";
const NOTHING_SELECTED: &str = "no file is selected";

impl Jobs {
    /// Plays a file: `play <file> [-v] [-p] [-t] [-f dialect]`.
    ///
    /// # Errors
    /// When nobody knows an option or the dialect. Other failures are said.
    pub fn play_command(
        &mut self,
        texts: &Texts,
        files: &Files,
        arguments: &str,
        now: Micros,
        ports: &mut (impl Storage + Calendar),
        reply: &mut Reply<'_>,
    ) -> Outcome {
        let (name, options) = split_options(arguments);
        let (path, date) = (files.absolute(name), ports.date());
        let options = Options::read(options)?;
        let wanted = |is_wanted| if is_wanted { reply.to() } else { Recipient::Nobody };
        let (echo, tells_end) = (wanted(options.echo), wanted(options.tells_end));
        let rights = reply.rights();
        let starter = Starter { echo, tells_end, tells_date: options.tells_end, rights };
        if self.job.is_some() {
            reply.say(format_args!("{PRINTING}\n"));
            return Ok(Answer::Ok);
        }
        match self.open(texts, &path, starter, ports, now) {
            Ok(size) => {
                self.set_paused(options.paused);
                if let Some(dialect) = options.dialect {
                    self.read_as(dialect);
                }
                reply.say(format_args!("Playing {name}\n  File size {size}\n"));
                if options.tells_end {
                    reply.say(format_args!("  Print started at: {date}\n"));
                }
            }
            Err(_) => reply.say(format_args!("File not found: {name}\n")),
        }
        Ok(Answer::Ok)
    }

    /// Whether the listener for a job's end hears the time of it.
    #[must_use]
    pub fn tells_date(&self) -> bool {
        self.job.as_ref().is_some_and(|job| job.starter.tells_date)
    }

    /// Selects a file, which M24 plays (M23); M32 `plays` it at once.
    ///
    /// # Errors
    /// Without a name, or while another job goes on or is suspended.
    pub fn select(
        &mut self,
        texts: &Texts,
        name: Option<&str>,
        plays: bool,
        now: Micros,
        storage: &mut impl Storage,
        reply: &mut Reply<'_>,
    ) -> Outcome {
        let name = name.ok_or_else(|| Failure::refused(&"the name of a file is missing"))?;
        if self.is_playing() {
            return Err(Failure::refused(&PRINTING));
        }
        if self.suspended.is_some() && self.job.is_some() {
            return Err(Failure::refused(&SUSPENDED));
        }
        self.close(storage);
        let tells_end = if plays { reply.to() } else { Recipient::Nobody };
        let starter = Starter { tells_end, ..Starter::of(reply) };
        // Hosts send the line of a listing back, with its size.
        let short = name.rsplit_once(' ').filter(|(_, size)| size.bytes().all(|byte| byte.is_ascii_digit()));
        let opened = [Some(name), short.map(|(name, _)| name.trim())].into_iter().flatten().find_map(|name| {
            let path = on_card(name)?;
            Some((name, self.open(texts, &path, starter, storage, now).ok()?))
        });
        if let Some((name, size)) = opened {
            self.set_paused(!plays);
            reply.say(format_args!("File opened:{name} Size:{size}\nFile selected\n"));
        } else {
            reply.say(format_args!("file.open failed: {name}\n"));
        }
        Ok(Answer::Ok)
    }

    /// Plays the selected file, or goes on with it (M24); the caller hears of its end, and its rights are
    /// those of a file's lines that begins.
    ///
    /// # Errors
    /// Without a selected file, and while the job is suspended: the machine is not where the job goes on. A
    /// card that was taken out meanwhile has to be back, and the file as it was.
    pub fn start(&mut self, texts: &Texts, storage: &mut impl Storage, reply: &Reply<'_>) -> Outcome {
        let Some(job) = &mut self.job else { return Err(Failure::refused(&NOTHING_SELECTED)) };
        if self.suspended.is_some() {
            return Err(Failure::refused(&SUSPENDED));
        }
        if job.is_lost {
            find_again(texts, job, storage)?;
        }
        (job.paused, job.waits_for_operator) = (false, false);
        job.starter.tells_end = reply.to();
        // Who starts a file that another one has selected answers for it; who goes on with one does not.
        if job.is_new {
            job.starter.rights = reply.rights();
        }
        Ok(Answer::Ok)
    }

    /// Begins the file anew (M26).
    ///
    /// # Errors
    /// Without a selected file, or when the card does not answer.
    pub fn restart(&mut self, texts: &Texts, storage: &mut impl Storage) -> Outcome {
        self.return_all(storage);
        let job = self.job.as_mut().ok_or_else(|| Failure::refused(&NOTHING_SELECTED))?;
        // Everything known and noted of the job begins anew too.
        (job.has_begun, job.is_new, job.layers) = (false, true, Layers::default());
        let restarted = job.lines.restart(storage);
        self.forget_places();
        restarted.map_err(|error| texts.because(error.text()))?;
        Ok(Answer::Ok)
    }

    /// Has the line just read, whose wait was left, read again when the job goes on.
    ///
    /// # Errors
    /// When the card does not answer.
    pub fn wait_again(&mut self, storage: &mut impl Storage) -> Result<(), StorageError> {
        let Some(job) = &mut self.job else { return Ok(()) };
        job.lines.go_to(job.here, storage)?;
        self.tags.take_back();
        Ok(())
    }

    // --- suspending it ---

    /// Whether a suspension waits for its end.
    #[must_use]
    pub const fn is_suspended(&self) -> bool {
        self.suspended.is_some()
    }

    /// Returns the state that `resume` restores.
    #[must_use]
    pub const fn suspended(&self) -> Option<&Suspended> {
        self.suspended.as_ref()
    }

    /// The suspended job, where a stall has stopped it.
    pub fn stalled_job(&mut self) -> Option<&mut StalledJob> {
        self.suspended.as_mut()?.stall.as_mut()
    }

    /// Keeps the state that `resume` restores.
    pub fn suspend(&mut self, suspended: Suspended) {
        self.suspended = Some(suspended);
    }

    /// Ends a suspension, and returns the state to be restored.
    #[must_use]
    pub const fn take_suspended(&mut self) -> Option<Suspended> {
        self.suspended.take()
    }

    /// Forgets a suspension; true when there was one.
    pub fn cancel_suspend(&mut self) -> bool {
        self.suspended.take().is_some()
    }
}

/// Opens the file of a job again, on a card that was put back.
fn find_again(texts: &Texts, job: &mut Job, storage: &mut impl Storage) -> Result<(), Failure> {
    let failed = |error: StorageError| texts.about_file(&job.path, error.text());
    if !job.callers.is_empty() {
        return Err(Failure::refused(&"the card was taken out in the file of a subroutine: abort, and play it again"));
    }
    storage.mount().map_err(failed)?;
    let file = storage.open(&job.path, OpenMode::Read).map_err(failed)?;
    // A change behind the place being read shows in the file's size or date.
    let is_alike = |storage: &mut _| -> Result<bool, StorageError> {
        Ok(Storage::size(storage, file)? == job.size
            && crate::journal::written(&job.path, storage).unwrap_or(0) == job.written)
    };
    let is_same = is_alike(storage)
        .and_then(|is_alike| if is_alike { job.lines.take_up(file, job.here, storage) } else { Ok(false) });
    if is_same != Ok(true) {
        // The file was only read.
        let _ = storage.close(file);
        is_same.map_err(failed)?;
        return Err(texts.about_file(&job.path, "is not the file that was played: put its card back, or abort"));
    }
    storage.read_ahead(file);
    job.is_lost = false;
    Ok(())
}

/// Returns the path of a name as M23 takes it: from the card's root, whatever the current directory. `None`
/// when it is too long.
fn on_card(name: &str) -> Option<Path> {
    let mut path = Path::new();
    let fits = path.push_str("/sd/").is_ok() && path.push_str(name.trim_start_matches('/')).is_ok();
    fits.then_some(path)
}

/// The options of `play`.
#[derive(Default)]
struct Options {
    /// -v: the lines of the job are shown.
    echo: bool,
    /// -p: the job begins paused.
    paused: bool,
    /// -t: the job's end is told, with the time.
    tells_end: bool,
    /// -f: the dialect in which the file is read.
    dialect: Option<Dialect>,
}

impl Options {
    fn read(text: &str) -> Result<Self, Failure> {
        let (mut options, mut words) = (Self::default(), text.split_whitespace());
        while let Some(word) = words.next() {
            match word {
                "-v" => options.echo = true,
                "-p" => options.paused = true,
                "-t" => options.tells_end = true,
                "-f" => {
                    let name = words.next().unwrap_or("");
                    options.dialect = Some(Dialect::named(name).ok_or_else(|| Failure::refused(&DIALECTS))?);
                }
                _ => return Err(Failure::refused(&OPTIONS)),
            }
        }
        Ok(options)
    }
}

/// Splits off the options, which begin at the first ` -` with a letter of ours: a name may have blanks.
fn split_options(arguments: &str) -> (&str, &str) {
    let place = [" -v", " -p", " -t", " -f"].into_iter().filter_map(|option| arguments.find(option)).min();
    let (name, options) = arguments.split_at(place.unwrap_or(arguments.len()));
    (name.trim(), options)
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::{Card, Desk};
    use base::ports::PATH_BYTES;
    use base::sessions::SessionId;

    const ME: Recipient = Recipient::Session(SessionId(0));

    const OK: Outcome = Ok(Answer::Ok);

    struct Table {
        jobs: Jobs,
        card: Card,
        desk: Desk,
    }

    impl Table {
        fn new() -> Self {
            let card = Card::with(&[("/sd/a.g", "G28\n"), ("/sd/my - part.g", "G28\nG1 X1\n")]);
            Self { jobs: Jobs::default(), card, desk: Desk::new() }
        }

        fn play(&mut self, arguments: &str) -> String {
            let Self { jobs, card, desk } = self;
            desk.hears(|reply| {
                assert_eq!(jobs.play_command(&Texts::new(), &Files::default(), arguments, Micros(0), card, reply), OK);
            })
        }

        fn select(&mut self, name: Option<&str>, plays: bool) -> (Outcome, String) {
            let (Self { jobs, card, desk }, mut done) = (self, Ok(Answer::Unknown));
            let said = desk.hears(|reply| done = jobs.select(&Texts::new(), name, plays, Micros(0), card, reply));
            (done, said)
        }

        fn start(&mut self) -> Outcome {
            let (Self { jobs, desk, card }, mut done) = (self, Ok(Answer::Unknown));
            desk.hears(|reply| done = jobs.start(&Texts::new(), card, reply));
            done
        }

        fn suspend(&mut self) {
            let kept = program::Interpreter::new(program::Setup::default()).keep();
            let position = units::PerAxis([0.0; units::MAX_AXES]);
            self.jobs.set_paused(true);
            self.jobs.suspend(Suspended {
                position,
                kept,
                targets: [units::Celsius(0.0); units::MAX_HEATERS],
                change: None,
                stall: None,
            });
        }
    }

    #[test]
    fn names_may_hold_blanks_and_dashes() {
        assert_eq!(split_options("/sd/my - part.gcode -v -p"), ("/sd/my - part.gcode", " -v -p"));
        assert_eq!(split_options("a-b.g"), ("a-b.g", ""));
    }

    #[test]
    fn play_takes_its_options() {
        let mut table = Table::new();
        assert_eq!(table.play("my - part.g -v -p"), "Playing my - part.g\n  File size 10\n");
        assert_eq!(
            (table.jobs.echo(), table.jobs.tells_end(), table.jobs.is_playing()),
            (ME, Recipient::Nobody, false)
        );
        assert_eq!(table.play("a.g"), "Currently printing, abort print first\n");
        table.jobs.close(&mut table.card);
        assert_eq!(table.play("no.g"), "File not found: no.g\n");
        assert_eq!(table.play("a.g -t"), "Playing a.g\n  File size 4\n  Print started at: 2000-01-01 00:00:00\n");
        assert_eq!((table.jobs.echo(), table.jobs.tells_end(), table.jobs.is_playing()), (Recipient::Nobody, ME, true));
        table.jobs.close(&mut table.card);
        assert!(table.play("a.g -f marlin -t").contains("Print started at"), "options in any order");
        assert_eq!((table.jobs.dialect(), table.jobs.tells_end()), (Some(Dialect::Marlin), ME));
        assert!(Options::read("-v -x").is_err() && Options::read("-f x").is_err() && Options::read("-f").is_err());
    }

    #[test]
    fn a_file_is_selected_then_played() {
        let mut table = Table::new();
        assert_eq!(table.start(), Err(Failure::refused(&"no file is selected")));
        assert_eq!(table.select(None, false).0, Err(Failure::refused(&"the name of a file is missing")));
        assert_eq!(table.select(Some("no.g"), true), (OK, "file.open failed: no.g\n".into()));
        assert_eq!(table.select(Some(&"x".repeat(PATH_BYTES)), true).0, OK);
        assert!(!table.jobs.set_paused(false), "there is no job");
        assert_eq!(table.select(Some("/a.g"), false), (OK, "File opened:/a.g Size:4\nFile selected\n".into()));
        assert!(!table.jobs.is_playing());
        assert_eq!((table.start(), table.jobs.tells_end()), (OK, ME));
        assert!(table.jobs.is_playing());
        assert_eq!(table.select(Some("a.g"), true).0, Err(Failure::refused(&"Currently printing, abort print first")));
        table.jobs.set_paused(true);
        assert_eq!(table.select(Some("my - part.g"), true).0, OK);
        assert!(table.jobs.is_playing());
        assert_eq!(table.card.open_files(), 1, "the one before is closed");
    }

    #[test]
    fn nothing_but_a_resume_goes_on_with_a_suspended_job() {
        let mut table = Table::new();
        assert_eq!(table.select(Some("a.g"), true).0, OK);
        table.suspend();
        let refused = Err(Failure::refused(&SUSPENDED));
        assert_eq!(table.start(), refused);
        assert_eq!(table.select(Some("my - part.g"), false), (refused, String::new()));
        assert_eq!(table.select(Some("my - part.g"), true).0, refused);
        assert!(!table.jobs.is_playing() && table.jobs.is_suspended() && table.card.open_files() == 1);
        assert!(SUSPENDED.contains("resume") && SUSPENDED.contains("M602"));
        assert!(table.jobs.take_suspended().is_some());
        assert_eq!(table.start(), OK);
    }

    #[test]
    fn a_suspension_can_be_forgotten() {
        let mut table = Table::new();
        assert!(!table.jobs.cancel_suspend());
        table.suspend();
        assert!(table.jobs.suspended().is_some() && table.jobs.cancel_suspend());
        assert!(!table.jobs.is_suspended());
    }
}
