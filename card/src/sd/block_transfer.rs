//! Transfer of blocks with the commands around it, repeated after errors.

use super::error::SdError;
use super::host::{Command, Direction, Fault, Host, Place, Progress, Transfer};
use super::registers::{CardInfo, refusal, status};

/// Most attempts of a transfer.
pub(super) const ATTEMPTS: u8 = 4;
/// Limit of a wait for the card, which may take 250 ms or 500 ms (PL 6.00 section 4.6.2), and gets a second
/// more.
const LIMIT_US: u64 = 1_200_000;
/// Tries to reach the card; an answer to any of them shows that it is there.
const ALIVE_TRIES: u8 = 3;

/// Blocks and memory of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Move {
    pub direction: Direction,
    pub first: u32,
    pub count: u32,
    pub place: Place,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Read or write command, and the data.
    Data,
    /// CMD12 behind several blocks.
    Stop,
    /// The card programs its memory.
    Busy,
    /// CMD13: result of the transfer.
    Status,
    /// After an error: CMD12, whose answer does not matter.
    Cut,
    /// After an error: the wait for the end of the card's work.
    Settle,
    /// After an error: CMD13, whether the card is there, and waits for commands.
    Alive,
}

/// Transfer in progress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    pub what: Move,
    stage: Stage,
    since_us: u64,
    pub attempt: u8,
    tries: u8,
    /// Error bits of the answers since the first error.
    told: u32,
    error: SdError,
    has_begun: bool,
    /// Data or answers arrived damaged: the bus may be too fast.
    pub is_damaged: bool,
}

/// State of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moved {
    /// The transfer goes on.
    Not,
    /// All blocks have been moved.
    Yes,
    /// The transfer begins anew.
    Again,
    /// The last attempt has failed; the card is there.
    Failed(SdError),
    /// The card is gone.
    Gone(SdError),
}

impl Moving {
    /// Creates a transfer that has not begun.
    pub const fn new(what: Move) -> Self {
        Self {
            what,
            stage: Stage::Data,
            since_us: 0,
            attempt: 1,
            tries: 0,
            told: 0,
            error: SdError::Host,
            has_begun: false,
            is_damaged: false,
        }
    }

    const fn index(&self) -> u8 {
        match (self.what.direction, self.what.count) {
            (Direction::FromCard, 1) => 17,
            (Direction::FromCard, _) => 18,
            (Direction::ToCard, 1) => 24,
            (Direction::ToCard, _) => 25,
        }
    }

    fn enter(&mut self, stage: Stage, card: &CardInfo, host: &mut impl Host, now_us: u64) {
        (self.stage, self.since_us) = (stage, now_us);
        match stage {
            Stage::Data => {
                let Move { direction, first, count, place } = self.what;
                let data = Transfer { direction, blocks: count, block_bytes: super::BLOCK_BYTES as u16, place };
                host.begin(Command::new(self.index(), card.address_of(first)), Some(data));
            }
            Stage::Stop | Stage::Cut => host.begin(Command::new(12, 0), None),
            Stage::Status | Stage::Alive => host.begin(Command::new(13, card.relative_address), None),
            Stage::Busy | Stage::Settle => {}
        }
    }

    /// Advances as far as possible without waiting.
    pub fn advance(&mut self, card: &CardInfo, host: &mut impl Host, now_us: u64) -> Moved {
        if !core::mem::replace(&mut self.has_begun, true) {
            self.enter(Stage::Data, card, host, now_us);
        }
        loop {
            let is_late = now_us.saturating_sub(self.since_us) > LIMIT_US;
            let next = match self.stage {
                Stage::Busy if host.is_held_busy() && !is_late => return Moved::Not,
                Stage::Busy if is_late => self.fail(SdError::StaysBusy(self.index())),
                Stage::Busy if self.what.direction == Direction::FromCard => return Moved::Yes,
                Stage::Busy => Stage::Status,
                Stage::Settle if host.is_held_busy() => {
                    if is_late {
                        return Moved::Gone(self.error);
                    }
                    return Moved::Not;
                }
                Stage::Settle => Stage::Alive,
                _ => match host.progress() {
                    Progress::Busy if !is_late => return Moved::Not,
                    Progress::Busy => match self.after(Err(Fault::TooLate), host) {
                        Ok(next) => next,
                        Err(ended) => return ended,
                    },
                    Progress::Done => match self.after(Ok(()), host) {
                        Ok(next) => next,
                        Err(ended) => return ended,
                    },
                    Progress::Failed(fault) => match self.after(Err(fault), host) {
                        Ok(next) => next,
                        Err(ended) => return ended,
                    },
                },
            };
            self.enter(next, card, host, now_us);
        }
    }

    const fn fail(&mut self, error: SdError) -> Stage {
        self.error = error;
        (self.tries, self.told) = (0, 0);
        Stage::Cut
    }

    /// Returns the stage after a command that has ended, or the end.
    fn after(&mut self, done: Result<(), Fault>, host: &mut impl Host) -> Result<Stage, Moved> {
        self.is_damaged |= matches!(done, Err(Fault::AnswerDamaged | Fault::DataDamaged));
        let [answer, ..] = host.answer();
        let bits = answer & status::ERRORS;
        match (self.stage, done) {
            (Stage::Cut, done) => {
                self.told = if done.is_ok() { bits } else { 0 };
                Ok(Stage::Settle)
            }
            (Stage::Alive, Ok(())) => Err(self.again(self.told | bits)),
            (Stage::Alive, Err(Fault::NoAnswer)) => {
                self.tries += 1;
                if self.tries < ALIVE_TRIES { Ok(Stage::Alive) } else { Err(Moved::Gone(self.error)) }
            }
            // The card answers, but the bus may be too fast for it.
            (Stage::Alive, Err(_)) => Err(self.again(self.told)),
            (Stage::Stop, Err(fault)) => Ok(self.fail(SdError::of(fault, 12))),
            (_, Err(fault)) => Ok(self.fail(SdError::of(fault, self.index()))),
            // CMD12 also reports that a read ran on to the card's last block, which is no error here.
            (Stage::Stop, Ok(())) if bits & !status::OUT_OF_RANGE != 0 => {
                Ok(self.fail(refusal(self.index(), bits & !status::OUT_OF_RANGE)))
            }
            (Stage::Data | Stage::Status, Ok(())) if bits != 0 => Ok(self.fail(refusal(self.index(), bits))),
            (Stage::Data, Ok(())) if self.what.count > 1 => Ok(Stage::Stop),
            (Stage::Data | Stage::Stop, Ok(())) => Ok(Stage::Busy),
            _ => Err(Moved::Yes),
        }
    }

    /// Repeats the transfer, as the card is there. A transfer refused for good is not repeated.
    fn again(&mut self, told: u32) -> Moved {
        let error = match self.error {
            // The status names the reason.
            SdError::Damaged(_) | SdError::StaysBusy(_) if told != 0 => refusal(self.index(), told),
            error => error,
        };
        // A transfer that takes as long as that is not repeated as often.
        let most = match error {
            SdError::Protected | SdError::OutOfRange | SdError::Unreadable => 1,
            SdError::StaysBusy(_) => ATTEMPTS / 2,
            _ => ATTEMPTS,
        };
        if self.attempt >= most {
            return Moved::Failed(error);
        }
        self.attempt += 1;
        self.has_begun = false;
        Moved::Again
    }
}
