//! Waiting for the card without keeping anybody waiting: everybody is served meanwhile.
//!
//! A card that writes may take a quarter of a second for a block. Every change of files comes here first;
//! once the card is at rest the change's own reads are short, and its writes go into a queue.

use base::ports::{CardEvent, Storage as _, StorageError, Wake};
use base::safe_file::Draft;
use base::sessions::Listing;
use base::{Ports, World};

use crate::machine::work_hands::WaitHands;

/// Waits until the card is at rest, and takes what most changes write. A card that has failed does not keep
/// anybody: the change itself is told why. Everybody is served once in any case, so that changes one after
/// the other never hold the machine for longer than one of them.
pub(crate) fn at_rest<'c>(hands: &mut impl WaitHands<'c>) {
    loop {
        hands.wait(Wake::Any).whatever_happens();
        if hands.world().ports.is_ready() {
            return;
        }
    }
}

/// Waits until all that was written is on the card.
///
/// # Errors
/// When something was not written, with the reason.
pub(crate) fn kept<'c>(hands: &mut impl WaitHands<'c>) -> Result<(), StorageError> {
    while !hands.world().ports.is_kept()? {
        hands.wait(Wake::Any).whatever_happens();
    }
    Ok(())
}

/// Puts a newly written file in the place of the old one, and waits until it is on the card.
///
/// # Errors
/// Those of the card; the file is the old one then.
pub(crate) fn finish<'c, H: WaitHands<'c>>(hands: &mut H, draft: Draft<H::Ports>) -> Result<(), StorageError> {
    at_rest(hands);
    let mut replacing = draft.close(&mut hands.world().ports)?;
    loop {
        hands.wait(Wake::Any).whatever_happens();
        at_rest(hands);
        if replacing.step(&mut hands.world().ports)? {
            return kept(hands);
        }
    }
}

/// Says what has happened to the card by itself, and finds the volume of one that was put in.
pub(crate) fn watch<P: Ports>(world: &mut World<'_, P>) {
    let Some(event) = world.ports.take_event() else { return };
    if matches!(event, CardEvent::Removed { .. }) {
        // A computer that had the card has it no longer.
        world.ports.revoke_card();
        world.ports.forget_card();
    }
    match event {
        CardEvent::Inserted => match world.ports.mount() {
            Ok(()) => world.announce(format_args!("// NOTICE an SD card was put in\n")),
            // A card lent to a computer is none of the machine's.
            Err(StorageError::Lent) => {}
            Err(error) => world.announce(format_args!("WARNING: {}\n", error.text())),
        },
        CardEvent::Removed { loses: false } => world.announce(format_args!("// NOTICE the SD card was taken out\n")),
        CardEvent::Removed { loses: true } => world.announce(format_args!(
            "WARNING: the SD card was taken out, or has failed, before all was written: the last changes are lost\n"
        )),
        CardEvent::WriteFailed(error) => world.announce(format_args!(
            "WARNING: the SD card could not be written, the last changes are lost: {}\n",
            error.text()
        )),
        CardEvent::Slower(khz) => world.announce(format_args!(
            "// NOTICE much from the SD card arrives damaged, its bus is set to {}.{} MHz: clean its contacts\n",
            khz / 1_000,
            khz % 1_000 / 100
        )),
    }
}

/// Whether a long answer needs the card at rest: a directory is read, or a file that somebody sends is
/// written.
pub(crate) const fn is_used_by_answer(listing: &Listing) -> bool {
    matches!(listing, Listing::Directory { .. } | Listing::Transfer)
}
