//! Functions of files, jobs and saved settings.

use base::bed::Bed;
use base::failure::{Answer, Failure, Outcome};
use base::sessions::{Periodic, Recipient, Reply};
use base::{CodeContext, Ports, World};
use events::{Event, Text};
use jobs::files::{self, Files, listings};
use jobs::journal::Journal;
use jobs::player::Jobs;
use parts::filament::Filament;
use procedures::leveling;
use program::{FileFunction, Interpreter, Words};

use crate::features::forecast::ForecastHands;
use crate::features::objects::ObjectHands;
use crate::features::state::States;
use crate::features::{forecast, objects, periodic_reports};
use crate::machine::work_hands::JobHands;
use crate::machine::{Machine, long_answers, settings_file};

/// Files and jobs, and what depends on them.
pub(crate) struct Stored<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    files: &'m mut Files,
    jobs: &'m mut Jobs,
    program: &'m mut Interpreter,
    bed: &'m mut Bed,
    journal: &'m mut Journal,
    filament: &'m Filament,
}

/// The machine for functions of files and jobs.
pub(crate) trait StoredHands<'c>: ForecastHands<'c> + ObjectHands<'c> {
    /// Returns files and jobs.
    fn stored(&mut self) -> Stored<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> StoredHands<'c> for Machine<'c, P> {
    fn stored(&mut self) -> Stored<'_, 'c, P> {
        let Self { world, files, jobs, program, bed, features: States { journal, filament, .. }, .. } = self;
        Stored { world, files, jobs, program, bed, journal, filament }
    }
}

/// Carries out a function of files, jobs or saved settings.
pub(crate) fn file_or_job<'c>(
    hands: &mut impl StoredHands<'c>,
    asked: FileFunction,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    match asked {
        FileFunction::ListFiles => {
            hands.say(to, format_args!("Begin file list\n"));
            long_answers::begin(hands.world(), listings::card(), to)
        }
        FileFunction::AutoReport => periodic_reports::command(hands.world(), Periodic::Temperatures, words, to),
        FileFunction::Keepalive => periodic_reports::command(hands.world(), Periodic::Busy, words, to),
        FileFunction::ReportJob if words.has('S') => periodic_reports::command(hands.world(), Periodic::Job, words, to),
        FileFunction::ReportJob => {
            forecast::say_bytes(&mut hands.forecast(), to);
            Ok(Answer::Ok)
        }
        FileFunction::ReportProgress => {
            forecast::say_progress(&mut hands.forecast(), to);
            Ok(Answer::Ok)
        }
        FileFunction::LoadSettings => settings_file::load(hands, words.text(), to),
        FileFunction::LabelObject => objects::label(hands, words.text().unwrap_or(""), to),
        FileFunction::Mount => mount(hands.world(), to),
        FileFunction::SelectFile => select(hands.stored(), words.text(), false, to),
        FileFunction::StartFile => select(hands.stored(), words.text(), true, to),
        FileFunction::StartJob => start(hands.stored(), to),
        FileFunction::PauseJob => Ok(pause(hands.stored(), to)),
        FileFunction::RestartJob => restart(hands, words),
        FileFunction::PowerLoss => Ok(power_loss(hands.stored(), words, to)),
        FileFunction::Upload => upload(hands.stored(), words.text().unwrap_or(""), to),
        FileFunction::EndUpload => Ok(Answer::Ok),
        FileFunction::RemoveFile => {
            let Stored { files, world: World { ports, sessions, .. }, .. } = hands.stored();
            files.remove(words.text().unwrap_or(""), ports, &mut Reply::new(sessions, to))
        }
        FileFunction::DeleteGrid => {
            let Stored { bed, world: World { ports, sessions, config, texts }, .. } = hands.stored();
            let reply = &mut Reply::new(sessions, to);
            leveling::delete(CodeContext { texts, ports, config, words, reply }, bed)
        }
        FileFunction::ForgetSettings => {
            let World { ports, sessions, texts, .. } = hands.world();
            let dialect = sessions.dialect_of(to);
            settings_file::forget(texts, ports, &mut Reply::new(sessions, to), dialect)
        }
    }
}

/// Begins to write the lines of a session into a file (M28).
fn upload<P: Ports>(stored: Stored<'_, '_, P>, name: &str, to: Recipient) -> Outcome {
    stored.world.sends_alone(to)?;
    let Stored { files, world: World { ports, sessions, .. }, .. } = stored;
    match to {
        Recipient::Session(session) => files.begin_upload(session, name, ports, &mut Reply::new(sessions, to)),
        _ => Err(Failure::refused(&"only a session can upload a file")),
    }
}

/// Finds the volume of a card (M21).
fn mount<P: Ports>(World { ports, sessions, texts, .. }: &mut World<'_, P>, to: Recipient) -> Outcome {
    let mounted = files::commands::mount(texts, ports, &mut Reply::new(sessions, to));
    let news = match &mounted {
        Err(why) if why.is_refusal() => Event::CardFailed(Text::new(format_args!("{}", texts.of(*why)))),
        _ => Event::CardMounted,
    };
    ports.events().record(ports.now(), &news);
    mounted
}

/// Selects a file as the job, and starts it if it is to begin at once (M23, M32).
fn select<P: Ports>(stored: Stored<'_, '_, P>, name: Option<&str>, starts: bool, to: Recipient) -> Outcome {
    let Stored { jobs, program, journal, world: World { ports, sessions, texts, .. }, .. } = stored;
    let (was_open, now) = (jobs.is_open(), ports.now());
    let selected = jobs.select(texts, name, starts, now, ports, &mut Reply::new(sessions, to));
    if was_open && selected.is_ok() {
        // Loops and subroutines of a paused job are none of the next job's.
        program.end_program();
        journal.end(ports);
    }
    selected
}

/// Starts the job, or goes on with it (M24).
fn start<P: Ports>(stored: Stored<'_, '_, P>, to: Recipient) -> Outcome {
    let Stored { jobs, journal, filament, world: World { ports, sessions, config, texts }, .. } = stored;
    // A job that has not begun is suspended before its first move instead.
    if jobs.begun() > 0 && filament.is_missing(config).is_some() {
        return filament.must_be_there(texts, config).map(|()| Answer::Ok);
    }
    let reply = &mut Reply::new(sessions, to);
    let is_back = jobs.begun() > 0 && !jobs.is_playing();
    let started = jobs.start(texts, ports, reply);
    if is_back && started.is_ok() {
        reply.tell_hosts("resumed");
    }
    journal.reopen(ports);
    started
}

/// Pauses the job (M25).
fn pause<P: Ports>(Stored { jobs, world, .. }: Stored<'_, '_, P>, to: Recipient) -> Answer {
    if jobs.is_playing() {
        jobs.set_paused(true);
        world.reply(to).tell_hosts("paused");
    }
    Answer::Ok
}

/// Switches the journal of jobs on or off, and tells which it is (M413).
fn power_loss<P: Ports>(Stored { journal, world, .. }: Stored<'_, '_, P>, words: &Words<'_>, to: Recipient) -> Answer {
    if let Some(on) = words.get('S') {
        journal.is_on = on != 0.0;
    }
    world.say(to, format_args!("power-loss recovery is {}\n", if journal.is_on { "on" } else { "off" }));
    Answer::Ok
}

/// Begins the job anew (M26).
fn restart<'c>(hands: &mut impl JobHands<'c>, words: &Words<'_>) -> Outcome {
    if words.get('S').is_some_and(|offset| offset > 0.0) {
        return Err(Failure::refused(
            &"M26 S: play file --from byte N begins there, with modes and E as the file has them by then",
        ));
    }
    let (jobs, World { ports, texts, .. }) = hands.jobs_in_world();
    let restarted = jobs.restart(texts, ports);
    if restarted.is_ok() {
        hands.program().end_program();
    }
    restarted
}
