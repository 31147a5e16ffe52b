//! A card as a trait, and as [`card::fat`] sees it: with waiting and without.

use base::ports::{CardEvent, CardFacts, StorageError};
use card::fat::{Block, Blocks};
use card::sd::Run;

/// A card, or what stands in for one: blocks that can be waited for, and questions that need no waiting. A
/// card without a queue that reads nothing ahead keeps the default answers to the questions.
pub trait Card {
    /// Error of a block that could not be moved.
    type Error: core::error::Error + 'static;

    /// Finds the card; again after a change of cards.
    ///
    /// # Errors
    /// The card's own.
    fn identify(&mut self) -> Result<(), Self::Error>;

    /// Reads a block, and waits for it.
    ///
    /// # Errors
    /// The card's own.
    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), Self::Error>;

    /// Reads a block if that takes no waiting. False: it was asked for.
    ///
    /// # Errors
    /// The card's own.
    fn read_at_hand(&mut self, number: u32, block: &mut Block) -> Result<bool, Self::Error> {
        self.read(number, block).map(|()| true)
    }

    /// Writes a block, behind all that were written before; waits only for room among them.
    ///
    /// # Errors
    /// The card's own: of this block, or of one before it.
    fn write(&mut self, number: u32, block: &Block) -> Result<(), Self::Error>;

    /// Returns the number of blocks of the card.
    ///
    /// # Errors
    /// The card's own.
    fn blocks(&mut self) -> Result<u32, Self::Error>;

    /// Keeps writes back, so that reads between them find the card at rest. The owner of the card lets the
    /// writes go when the turn of the task that works on files is over: a change is often several calls.
    fn hold(&mut self) {}

    /// Whether it is at rest, with room for so many writes. The card is kept at rest for a caller that asks
    /// again soon.
    fn is_ready(&mut self, _room: usize) -> bool {
        true
    }

    /// Whether everything that was written is on the card.
    ///
    /// # Errors
    /// The reason for which something is not on the card.
    fn is_kept(&mut self) -> Result<bool, Self::Error> {
        Ok(true)
    }

    /// Reports life between the steps of a long change.
    fn between_steps(&mut self) {}

    /// Forgets a write that has failed, once that is known: writes are taken again.
    fn forgive(&mut self) {}

    /// Returns the card's identification and its counts since power-on, if known.
    fn facts(&mut self) -> Option<CardFacts> {
        None
    }

    /// Takes an event of the card that nobody has heard of.
    fn take_event(&mut self) -> Option<CardEvent> {
        None
    }

    /// Reads these blocks ahead, behind those it was told before. False while there is no room for more.
    fn follow(&mut self, _run: Run) -> bool {
        false
    }

    /// Whether there is room for so many writes, though the card may be at work.
    fn has_room(&mut self, _blocks: usize) -> bool {
        true
    }

    /// Lets held writes go, and begins with them.
    fn let_go(&mut self) {}

    /// Stops all reading ahead.
    fn unfollow(&mut self) {}

    /// Returns the machine's error for an error of the card.
    fn reason(error: &Self::Error) -> StorageError;
}

/// The card as [`card::fat`] sees it.
pub(crate) struct Device<'a, C>(pub &'a mut C);

impl<C: Card> Blocks for Device<'_, C> {
    type Error = C::Error;

    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), C::Error> {
        self.0.read(number, block)
    }

    fn write(&mut self, number: u32, block: &Block) -> Result<(), C::Error> {
        self.0.write(number, block)
    }
}

/// The card for a caller that does not wait: a block that is not at hand is asked for.
pub(crate) struct AtHand<'a, C>(pub &'a mut C);

/// Reason for which a block was not read.
pub(crate) enum NotRead<E> {
    /// The block has been asked for, and will come.
    Yet,
    /// The card's own error.
    AtAll(E),
}

impl<C: Card> Blocks for AtHand<'_, C> {
    type Error = NotRead<C::Error>;

    fn read(&mut self, number: u32, block: &mut Block) -> Result<(), Self::Error> {
        match self.0.read_at_hand(number, block) {
            Ok(true) => Ok(()),
            Ok(false) => Err(NotRead::Yet),
            Err(error) => Err(NotRead::AtAll(error)),
        }
    }

    fn write(&mut self, number: u32, block: &Block) -> Result<(), Self::Error> {
        self.0.write(number, block).map_err(NotRead::AtAll)
    }
}
