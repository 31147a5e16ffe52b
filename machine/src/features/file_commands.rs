//! Console commands about files: `ls`, `cat`, `cp`, `upload` and the like.

use base::failure::{Answer, Failure, Outcome};
use base::own_frame::apart;
use base::sessions::{ConsoleKind, Recipient, Reply};
use base::{Ports, World};
use jobs::files::{self, Files, listings};
use program::commands::FileCommand;

use crate::features::editing;
use crate::machine::long_answers::{self, AnswerHands};
use crate::machine::work_hands::MoveHands;

/// The machine for commands about files.
pub(crate) trait FileCommandHands<'c>: AnswerHands<'c> + MoveHands<'c> {}

impl<'c, H: AnswerHands<'c> + MoveHands<'c>> FileCommandHands<'c> for H {}

/// Runs a command about files. Each has a stack frame of its own.
///
/// # Errors
/// Those of the command.
pub(crate) fn run<'c>(
    hands: &mut impl FileCommandHands<'c>,
    command: FileCommand,
    arguments: &str,
    to: Recipient,
) -> Outcome {
    use FileCommand as C;
    let (files, world) = hands.files_in_world();
    match command {
        C::List | C::Show | C::ShowSection => apart(|| list(world, files, command, arguments, to)),
        C::Delete | C::Move | C::MakeFolder | C::ChangeFolder => {
            apart(|| change_files(world, files, command, arguments, to))
        }
        C::ReceiveByYmodem | C::Receive => apart(|| receive(world, files, command, arguments, to)),
        C::ReceiveCounted => apart(|| receive_counted(world, files, arguments, to)),
        C::Copy | C::Truncate | C::Md5Sum => apart(|| copy(hands, command, arguments, to)),
        C::Card => apart(|| files::card_facts::card(&mut hands.sequence(to))),
        C::Edit => apart(|| editing::begin(files, world, arguments, to)),
        C::SetSetting => {
            apart(|| files::config_edit::config_set(&mut hands.sequence(to), arguments)).map(|()| Answer::Said)
        }
    }
}

fn list<P: Ports>(
    world: &mut World<'_, P>,
    files: &mut Files,
    command: FileCommand,
    arguments: &str,
    to: Recipient,
) -> Outcome {
    let World { ports, sessions, texts, .. } = world;
    let now = ports.now();
    let reply = &mut Reply::new(sessions, to);
    let listing = match command {
        FileCommand::List => listings::directory(files, arguments),
        FileCommand::Show => listings::file(files, arguments, now, ports, reply),
        _ => listings::section(texts, arguments, ports, reply),
    }?;
    match listing {
        Some(listing) => long_answers::begin(world, listing, to),
        None => Ok(Answer::Said),
    }
}

fn change_files<P: Ports>(
    World { ports, sessions, .. }: &mut World<'_, P>,
    files: &mut Files,
    command: FileCommand,
    arguments: &str,
    to: Recipient,
) -> Outcome {
    let reply = &mut Reply::new(sessions, to);
    match command {
        FileCommand::Delete => files.remove_command(arguments, ports, reply),
        FileCommand::Move => files.directory_command("mv", arguments, ports, reply),
        FileCommand::MakeFolder => files.directory_command("mkdir", arguments, ports, reply),
        _ => files.directory_command("cd", arguments, ports, reply),
    }
}

fn copy<'c>(hands: &mut impl FileCommandHands<'c>, command: FileCommand, arguments: &str, to: Recipient) -> Outcome {
    let (files, _) = hands.files_in_world();
    let directory = files.directory().clone();
    let hands = &mut hands.sequence(to);
    match command {
        FileCommand::Copy => files::copying::copy(hands, &directory, arguments),
        FileCommand::Truncate => files::copying::truncate(hands, &directory, arguments),
        _ => files::copying::md5sum(hands, &directory, arguments),
    }
}

/// Takes the console's next bytes for a file (`ry` and `upload`).
fn receive<P: Ports>(
    world: &mut World<'_, P>,
    files: &mut Files,
    command: FileCommand,
    arguments: &str,
    to: Recipient,
) -> Outcome {
    if to.session().is_none() {
        return Err(Failure::refused(&"only a console can send a file"));
    }
    world.sends_alone(to)?;
    long_answers::sender_is_there(world, to)?;
    let World { ports, sessions, texts, .. } = world;
    let now = ports.now();
    let reply = &mut Reply::new(sessions, to);
    match command {
        FileCommand::ReceiveByYmodem => files.transfers.receive(!arguments.is_empty(), now, reply),
        _ => {
            let path = files.absolute(arguments);
            files.transfers.receive_plain(texts, arguments.trim_matches('"'), path, ports, reply)
        }
    }?;
    long_answers::begin_transfer(world, to)
}

/// Receives a file for programs, which look at how the answer begins: `dl file bytes`. Only on a transport
/// that holds its sender back.
fn receive_counted<P: Ports>(world: &mut World<'_, P>, files: &mut Files, arguments: &str, to: Recipient) -> Outcome {
    long_answers::sender_is_there(world, to)?;
    let World { ports, sessions, .. } = world;
    let now = ports.now();
    let kind = to.session().map(|id| ports.profile(id).kind);
    let reply = &mut Reply::new(sessions, to);
    let (name, size) = arguments.rsplit_once([' ', '\t']).unwrap_or((arguments, ""));
    let begun = match size.parse() {
        _ if name.trim().is_empty() || size.is_empty() => Err("Usage dl filename size"),
        _ if !matches!(kind, Some(ConsoleKind::Usb | ConsoleKind::Network)) => Err("download only allowed over USB"),
        Err(_) | Ok(0) => Err("file size is bad"),
        Ok(size) => {
            let path = files.absolute(name.trim());
            files.transfers.receive_counted(path, size, now, ports, reply)
        }
    };
    match begun {
        Ok(()) => long_answers::begin_transfer(world, to),
        Err(why) => {
            reply.say(format_args!("FAIL - {why}\n"));
            Ok(Answer::Said)
        }
    }
}
