//! The card as a computer's disk (`msc`).
//!
//! The card has one user at a time: two file systems on it, each with its own memory of what is where, would
//! destroy it. So the computer's disk is empty until somebody says `msc`, and while the computer has the card
//! the machine has none.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::ports::{Disk, NotLent, StorageError, Usb as _, Wake};
use base::{Ports, World};
use units::Micros;

use crate::machine::moments::Moments;
use crate::machine::work_hands::WorldHands;

const NO_COMPUTER: &str = "no computer is at the USB socket, or it sleeps";
const HAS_IT: &str = "a computer has the SD card already: eject it there, or msc off";

/// The card as a computer's disk, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: WorldHands<'c>> Moments<M> for Feature {
    fn each_10_ms(hands: &mut M, _now: Micros) {
        watch(hands.world());
    }
}

/// Lends the card to the computer, or takes it back: `msc [off]`.
pub(crate) fn msc<'c>(hands: &mut impl Hands<'c>, arguments: &str) -> Outcome {
    let disk = hands.storage().disk();
    match arguments {
        _ if !hands.config().system.msc_enable => Err(Failure::refused(&"MSC is disabled: [system] msc_enable")),
        "" if hands.has_job() => Err(Failure::refused(&"a file is played: wait for its end, or abort it")),
        "" if disk != Disk::Kept => Err(Failure::refused(&HAS_IT)),
        "" => lend(hands),
        "off" if disk == Disk::Kept => Err(Failure::refused(&"no computer has the SD card")),
        "off" => {
            hands.storage().revoke_card();
            Ok(Answer::Ok)
        }
        _ => Err(Failure::refused(&"write msc, or msc off")),
    }
}

fn lend<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    loop {
        match hands.storage().lend_card() {
            Ok(true) => break,
            Ok(false) => {
                hands.wait(Wake::Any).whatever_happens();
            }
            Err(NotLent::NoComputer) => return Err(Failure::refused(&NO_COMPUTER)),
            Err(NotLent::Storage(StorageError::Busy)) => {
                return Err(Failure::refused(&"files are open: end what writes or reads them"));
            }
            Err(NotLent::Storage(error)) => return Err(hands.texts().because(error.text())),
        }
    }
    hands.say(format_args!("The computer has the SD card: eject it there to give it back\n"));
    Ok(Answer::Ok)
}

/// Takes the card back when the computer has ejected it, or has gone. The card may be another one by now, and
/// its contents have changed.
fn watch<P: Ports>(world: &mut World<'_, P>) {
    let why = match world.ports.disk() {
        Disk::Kept | Disk::Lent => return,
        Disk::GivenBack => "given the SD card back",
        Disk::Gone => "gone: the machine has the SD card again",
    };
    world.ports.take_card_back();
    world.announce(format_args!("// NOTICE the computer has {why}\n"));
    match world.ports.mount() {
        // A missing card has been reported already.
        Ok(()) | Err(StorageError::NoCard | StorageError::NotResponding) => {}
        Err(error) => world.announce(format_args!("WARNING: {}\n", error.text())),
    }
}
