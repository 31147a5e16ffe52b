//! Long answers: given piece by piece, as fast as a session takes them, beside everything else.

use base::bed::Bed;
use base::failure::{Answer, Failure, Outcome};
use base::motors;
use base::own_frame::apart;
use base::sessions::{Listing, Recipient, Reply, SessionId};
use base::tuning::Tuning;
use base::{Ports, World};
use jobs::files::{Files, Progress, listings};
use parts::z_thermal::Thermal;
use procedures::arms;
use procedures::leveling;
use program::{Interpreter, Words};
use units::Actuator;

use crate::machine::moments::{Features, Moments as _};
use crate::machine::work_hands::WorldHands;
use crate::machine::{Machine, card, saved_settings};

/// Begins a long answer, given as fast as a session takes it, beside everything else. A file that is played
/// has nobody to read one.
pub(crate) fn begin<P: Ports>(world: &mut World<'_, P>, listing: Listing, to: Recipient) -> Outcome {
    match to.session().and_then(|id| world.sessions.get_mut(id)) {
        Some(session) => {
            session.listing = Some(listing);
            Ok(Answer::Said)
        }
        None => {
            listings::close(&listing, &mut world.ports);
            Ok(Answer::Ok)
        }
    }
}

/// Describes drivers one after the other (M911).
pub(crate) fn describe_drivers<P: Ports>(world: &mut World<'_, P>, words: &Words<'_>, to: Recipient) -> Outcome {
    let motors = motors::named_drivers(world.texts, words, world.config)?;
    if !world.ports.supervisor(|supervisor| supervisor.motor_supply_on()) {
        world.say(to, format_args!("VMOT is off\n"));
    }
    begin(world, Listing::Drivers { motors, all: !words.has('P') && words.axes().is_empty() }, to)
}

/// The machine for long answers.
pub(crate) trait AnswerHands<'c>: WorldHands<'c> {
    /// Returns the files that are sent and received, and the world.
    fn files_in_world(&mut self) -> (&mut Files, &mut World<'c, Self::Ports>);

    /// Says one piece. True while there are more.
    ///
    /// # Errors
    /// When there is nothing to say, with the reason.
    fn say_piece(&mut self, listing: &mut Listing, to: Recipient) -> Result<bool, Failure>;
}

impl<'c, P: Ports> AnswerHands<'c> for Machine<'c, P> {
    fn files_in_world(&mut self) -> (&mut Files, &mut World<'c, P>) {
        (&mut self.files, &mut self.world)
    }

    fn say_piece(&mut self, listing: &mut Listing, to: Recipient) -> Result<bool, Failure> {
        match Features::<P>::long_answer(self, listing, to) {
            Some(piece) => piece,
            None => {
                let Self { program, tuning, bed, thermal, world, .. } = self;
                piece(world, program, (tuning, thermal), bed, listing, to)
            }
        }
    }
}

/// Gives the next piece of a long answer, when there is one and room for it.
pub(crate) fn go_on<'c>(hands: &mut impl AnswerHands<'c>, id: SessionId) {
    let Some(mut listing) = take_next(hands.world(), id) else { return };
    let to = Recipient::Session(id);
    if matches!(listing, Listing::Transfer) {
        let (files, world) = hands.files_in_world();
        return apart(|| continue_transfer(world, files, id));
    }
    // A stopped listing still owes its ending.
    let more = match hands.world().sessions.take_stop(to) {
        true => Ok(false),
        false => apart(|| hands.say_piece(&mut listing, to)),
    };
    let World { ports, sessions, texts, .. } = hands.world();
    let Some(session) = sessions.get_mut(id) else { return listings::close(&listing, ports) };
    match more {
        Ok(true) => session.listing = Some(listing),
        Ok(false) => {
            listings::close(&listing, ports);
            session.say(format_args!("{}", listings::ending(&listing)));
        }
        Err(failure) => {
            listings::close(&listing, ports);
            if failure.has_text() {
                session.refuse(failure.reason, format_args!("{}", texts.of(failure)));
            }
        }
    }
    session.settle();
}

/// Takes the long answer whose next piece is to be given, when there is room for it and the card has read it.
fn take_next<P: Ports>(World { ports, sessions, .. }: &mut World<'_, P>, id: SessionId) -> Option<Listing> {
    let session = sessions.get_mut(id).filter(|session| session.has_room_for_listing())?;
    let comes = match &session.listing {
        Some(Listing::File { file, .. } | Listing::Section { file, .. }) => ports.is_at_hand(*file),
        Some(listing) if card::is_used_by_answer(listing) => ports.is_ready(),
        _ => true,
    };
    if comes { session.listing.take() } else { None }
}

/// Refuses when the sender of a file has gone; bytes it has sent behind the file are dropped.
pub(crate) fn sender_is_there<P: Ports>(
    World { sessions, ports, .. }: &mut World<'_, P>,
    to: Recipient,
) -> Result<(), Failure> {
    if !sessions.has_left(to) {
        return Ok(());
    }
    if let Some((id, session)) = to.session().and_then(|id| Some((id, sessions.get_mut(id)?))) {
        session.forget_visit(ports.inbox(id));
        session.broke_off_file = true;
    }
    Err(Failure::refused(&"whoever was to send the file has gone"))
}

/// Takes a console's bytes for a file from now on.
pub(crate) fn begin_transfer<P: Ports>(world: &mut World<'_, P>, to: Recipient) -> Outcome {
    if let Recipient::Session(id) = to {
        world.ports.inbox(id).set_raw(true);
    }
    begin(world, Listing::Transfer, to)
}

fn continue_transfer<P: Ports>(World { ports, sessions, .. }: &mut World<'_, P>, files: &mut Files, id: SessionId) {
    let now = ports.now();
    // A session that opens behind this look sends nothing of the file.
    let end = ports.inbox(id).received();
    let is_his = !sessions.is_visited_anew(ports, id);
    let directory = files.directory().clone();
    let reply = &mut Reply::new(sessions, Recipient::Session(id));
    let progress =
        if is_his { files.transfers.go_on(&directory, (id, end), now, ports, reply) } else { Progress::Receiving };
    if progress != Progress::Receiving {
        ports.inbox(id).set_raw(false);
    }
    let Some(session) = sessions.get_mut(id) else { return };
    if progress != Progress::Ended {
        session.listing = Some(Listing::Transfer);
        return;
    }
    session.say(format_args!("ok\n"));
    session.settle();
}

/// Says one piece. True while there are more.
fn piece<P: Ports>(
    World { ports, sessions, config, texts }: &mut World<'_, P>,
    program: &Interpreter,
    (tuning, thermal): (&Tuning, &Thermal),
    bed: &Bed,
    listing: &mut Listing,
    to: Recipient,
) -> Result<bool, Failure> {
    let now = ports.now();
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
        listing => listings::piece(texts, listing, now, ports, reply),
    }
}
