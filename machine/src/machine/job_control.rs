//! Pauses that a job makes by itself, and the queue of jobs.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::needs::needs;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use gcode::Extended;
use jobs::files::Files;
use jobs::player::{Jobs, Starter, Tower, parse_pause};
use program::Part;
use units::Axis;

use crate::machine::source::{Origin, Source};
use crate::machine::suspend;
use crate::machine::work_hands::JobHands;

/// Pauses the job at once, or `at` a layer, a line or a height; `list` and `clear` concern those places
/// (`pause`).
pub(crate) fn pause<'c>(hands: &mut impl JobHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    let (word, rest) = arguments.split_once(' ').unwrap_or((arguments, ""));
    match word {
        "" => return suspend::suspend(hands, true, to),
        "at" => {
            let (place, command) = parse_pause(rest)?;
            let rights = hands.world().sessions.rights_of(to);
            hands.jobs().pauses.add(place, command)?;
            // The command will be one of the job's lines.
            hands.jobs().lower_rights(rights);
        }
        "next" if rest.trim() == "layer" => {
            let layer = hands.jobs().layers().current + 1;
            let (place, command) = (jobs::player::PausePlace::Layer(layer), "");
            hands.jobs().pauses.add(place, command)?;
        }
        "clear" => hands.jobs().pauses.clear(),
        "list" => {}
        _ => {
            return Err(parse_pause("").err().unwrap_or(Failure::HALTED));
        }
    }
    let (jobs, World { sessions, .. }) = hands.jobs_in_world();
    let mut reply = Reply::new(sessions, to);
    for (place, command) in jobs.pauses.iter() {
        reply.say(format_args!("{place}: {command}\n"));
    }
    let layers = jobs.layers();
    if layers.current > 0 {
        reply.say(format_args!("now in layer {}", layers.current));
        if let Some(total) = layers.total {
            reply.say(format_args!(" of {total}"));
        }
        reply.say(format_args!("\n"));
    }
    Ok(Answer::Ok)
}

/// Returns the command due before the line just read, which is read again afterwards: a pause, or the next
/// step of a tower.
pub(crate) fn due_before<'c>(hands: &mut impl JobHands<'c>, line: &[u8]) -> Option<(config::Command, Source)> {
    let (jobs, program) = hands.jobs_and_program();
    if jobs.pauses.is_empty() && jobs.tower.is_none() {
        return None;
    }
    let height = program.modal().work(program.position())[Axis::Z];
    let (jobs, world) = hands.jobs_in_world();
    let command = match jobs.take_pause(line, height, &mut world.ports) {
        Some((place, command)) => {
            world.announce(format_args!("// NOTE the job pauses at {place}: {command}\n"));
            command
        }
        None => {
            let command = jobs.take_tower(line, height, &mut world.ports)?;
            world.announce(format_args!("// NOTE height {height:.2} mm: {command}\n"));
            command
        }
    };
    Some((command, Source::of_machine(world.config, Origin::Switch)))
}

/// Runs `TUNING_TOWER`, for the job that is played or comes next.
pub(crate) fn tower(jobs: &mut Jobs, texts: &Texts, command: &Extended<'_>) -> Outcome {
    jobs.tower = Some(Tower::new(texts, command)?);
    Ok(Answer::Ok)
}

/// Runs the command `queue`; `queue next` plays the next job.
pub(crate) fn queue<P: Ports>(
    jobs: &mut Jobs,
    files: &Files,
    world: &mut World<'_, P>,
    arguments: &str,
    to: Recipient,
) -> Outcome {
    if arguments.trim() == "next" {
        return play_next(jobs, world, to);
    }
    let World { ports, sessions, texts, .. } = world;
    let absolute = |name: &str| files.absolute(name);
    jobs.queue.command(texts, arguments, absolute, ports, &mut Reply::new(sessions, to))?;
    Ok(Answer::Ok)
}

fn play_next<P: Ports>(jobs: &mut Jobs, world: &mut World<'_, P>, to: Recipient) -> Outcome {
    needs(world.texts, world.config, Part::Player, jobs.is_playing())?;
    let next = jobs.queue.next().cloned();
    let path = next.ok_or_else(|| Failure::refused(&"no file waits: queue add file"))?;
    let now = world.ports.now();
    let starter = Starter::of(&world.reply(to));
    let size = jobs.open(world.texts, &path, starter, &mut world.ports, now)?;
    jobs.lower_rights(jobs.queue.rights_of_next());
    jobs.queue.take();
    world.say(to, format_args!("Playing {path}\n  File size {size}\n"));
    Ok(Answer::Ok)
}

/// Begins the next job after the end of one, or tells which is next.
pub(crate) fn after_job<P: Ports>(jobs: &mut Jobs, world: &mut World<'_, P>) {
    let Some(next) = jobs.queue.next().cloned() else { return };
    if !world.config.player.queue_auto {
        return world.announce(format_args!("// NOTE {next} is next: clear the bed, then queue next\n"));
    }
    if let Err(why) = play_next(jobs, world, Recipient::All)
        && why.is_refusal()
    {
        world.announce(format_args!("// WARNING {next} was not begun: {}\n", world.texts.of(why)));
    }
}
