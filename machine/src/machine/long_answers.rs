//! Long answers: given piece by piece, as fast as a session takes them, beside everything else.

use base::failure::{Answer, Failure, Outcome};
use base::motors;
use base::own_frame::apart;
use base::sessions::{Listing, Recipient, Reply, SessionId};
use base::{Ports, World};
use jobs::files::{Progress, listings};
use procedures::arms;
use procedures::leveling;
use program::Words;
use units::Actuator;

use crate::machine::Machine;
use crate::machine::card;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::saved_settings;

/// Begins a long answer, given as fast as a session takes it, beside everything else. A file that is played
/// has nobody to read one.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>, listing: Listing, to: Recipient) -> Outcome {
    match to.session().and_then(|id| machine.world.sessions.get_mut(id)) {
        Some(session) => {
            session.listing = Some(listing);
            Ok(Answer::Said)
        }
        None => {
            listings::close(&listing, &mut machine.world.ports);
            Ok(Answer::Ok)
        }
    }
}

/// Describes drivers one after the other (M911).
pub(crate) fn describe_drivers<P: Ports>(machine: &mut Machine<'_, P>, words: &Words<'_>, to: Recipient) -> Outcome {
    let motors = motors::named_drivers(machine.world.texts, words, machine.world.config)?;
    if !machine.world.ports.supervisor(|supervisor| supervisor.motor_supply_on()) {
        machine.say(to, format_args!("VMOT is off\n"));
    }
    begin(machine, Listing::Drivers { motors, all: !words.has('P') && words.axes().is_empty() }, to)
}

/// Gives the next piece of a long answer, when there is one and room for it.
pub(crate) fn go_on<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId) {
    let Some(session) = machine.world.sessions.get_mut(id).filter(|session| session.has_room_for_listing()) else {
        return;
    };
    let comes = match &session.listing {
        Some(Listing::File { file, .. } | Listing::Section { file, .. }) => machine.world.ports.is_at_hand(*file),
        Some(listing) if card::is_used_by_answer(listing) => machine.world.ports.is_ready(),
        _ => true,
    };
    if !comes {
        return;
    }
    let Some(session) = machine.world.sessions.get_mut(id) else { return };
    let Some(mut listing) = session.listing.take() else { return };
    let to = Recipient::Session(id);
    if matches!(listing, Listing::Transfer) {
        return apart(|| continue_transfer(machine, id));
    }
    if machine.world.sessions.take_stop(to) {
        // A stopped listing still owes its ending.
        listings::close(&listing, &mut machine.world.ports);
        machine.say(to, format_args!("{}", listings::ending(&listing)));
        return settle(machine, id);
    }
    let more = apart(|| piece(machine, &mut listing, to));
    match more {
        Ok(true) => {
            if let Some(session) = machine.world.sessions.get_mut(id) {
                session.listing = Some(listing);
            }
        }
        Ok(false) => {
            listings::close(&listing, &mut machine.world.ports);
            machine.say(to, format_args!("{}", listings::ending(&listing)));
        }
        Err(failure) => {
            listings::close(&listing, &mut machine.world.ports);
            if failure.has_text() {
                machine.refuse(to, failure);
            }
        }
    }
    settle(machine, id);
}

/// Refuses when the sender of a file has gone; bytes it has sent behind the file are dropped.
pub(crate) fn sender_is_there<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Result<(), Failure> {
    if !machine.world.sessions.has_left(to) {
        return Ok(());
    }
    let Machine { world: World { sessions, ports, .. }, .. } = machine;
    if let Some((id, session)) = to.session().and_then(|id| Some((id, sessions.get_mut(id)?))) {
        session.forget_visit(ports.inbox(id));
        session.broke_off_file = true;
    }
    Err(Failure::refused(&"whoever was to send the file has gone"))
}

/// Takes a console's bytes for a file from now on.
pub(crate) fn begin_transfer<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    if let Recipient::Session(id) = to {
        machine.world.ports.inbox(id).set_raw(true);
    }
    begin(machine, Listing::Transfer, to)
}

fn continue_transfer<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId) {
    let to = Recipient::Session(id);
    let now = machine.world.ports.now();
    // A session that opens behind this look sends nothing of the file.
    let end = machine.world.ports.inbox(id).received();
    let is_his = !machine.world.sessions.is_visited_anew(&machine.world.ports, id);
    let Machine { files, world: World { ports, sessions, .. }, .. } = machine;
    let directory = files.directory().clone();
    let reply = &mut Reply::new(sessions, to);
    let progress =
        if is_his { files.transfers.go_on(&directory, (id, end), now, ports, reply) } else { Progress::Receiving };
    if progress != Progress::Receiving {
        ports.inbox(id).set_raw(false);
    }
    if progress != Progress::Ended {
        if let Some(session) = sessions.get_mut(id) {
            session.listing = Some(Listing::Transfer);
        }
        return;
    }
    machine.say(to, format_args!("ok\n"));
    settle(machine, id);
}

fn settle<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId) {
    if let Some(session) = machine.world.sessions.get_mut(id) {
        session.settle();
    }
}

/// Says one piece. True while there are more.
fn piece<P: Ports>(machine: &mut Machine<'_, P>, listing: &mut Listing, to: Recipient) -> Result<bool, Failure> {
    if let Some(piece) = Features::<P>::long_answer(machine, listing, to) {
        return piece;
    }
    let now = machine.world.ports.now();
    let Machine { program, tuning, bed, thermal, world: World { ports, sessions, config, .. }, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    match listing {
        Listing::Settings { part } => {
            let text = saved_settings::part(*part, ports, program, config, (tuning, thermal), bed);
            let text = text.map_err(|_| Failure::refused(&"the settings are too many to show"))?;
            reply.say(format_args!("{text}"));
            if *part == 1 {
                arms::say_line_cutting(tuning, reply);
            }
            *part += 1;
            Ok(*part < saved_settings::PARTS)
        }
        Listing::Grid { row } => {
            let more = leveling::grid_line(ports, config.leveling.grid.human_readable, *row, reply)?;
            *row += 1;
            Ok(more)
        }
        Listing::Map { line } => {
            *line += 1;
            leveling::map_line(ports, leveling::means(config), *line - 1, reply)
        }
        Listing::Help { line } => {
            let Some(command) = program::commands::COMMANDS.get(*line) else { return Ok(false) };
            reply.say(format_args!("{} {} - {}\n", command.word, command.takes, command.help));
            *line += 1;
            Ok(*line < program::commands::COMMANDS.len())
        }
        Listing::Drivers { motors, all } => {
            let Some(motor) = Actuator::of_bits(*motors).next() else { return Ok(false) };
            *motors &= !motor.bit();
            motors::describe_driver(ports, motor, *all, reply);
            Ok(*motors != 0)
        }
        listing => listings::piece(machine.world.texts, listing, now, ports, reply),
    }
}
