//! Work on buses, which is done without the controller's lock: bytes take their time there, and timers go on
//! meanwhile.

use crate::board::{Board, Spi as _};
use crate::objects::accelerometer::{self, Answer, Request};
use crate::objects::i2c::{I2c, Status};
use crate::objects::spi::{Bytes, Chip};

/// Bytes for a chip.
pub struct Job<B: Board> {
    pub(super) oid: u8,
    pub(super) work: Work<B>,
}

/// Bus of a job, with the chip, which is out meanwhile.
pub(super) enum Work<B: Board> {
    /// Bytes that are exchanged in place, and whether the host wants them.
    Spi { chip: Chip<B>, bytes: Bytes, answers: bool },
    /// A question to an accelerometer, and its answer.
    Accelerometer { chip: Chip<B>, request: Request, answer: Option<Answer> },
    /// Bytes to write, how many to read, and what came of it.
    I2c { chip: I2c<B>, write: Bytes, read_length: usize, outcome: Result<Bytes, Status> },
}

impl<B: Board> Job<B> {
    /// Exchanges the bytes with the chip. `clock` is the step clock.
    pub fn run(&mut self, clock: impl Fn() -> u32) {
        match &mut self.work {
            Work::Spi { chip, bytes, .. } => chip.exchange(bytes),
            Work::Accelerometer { chip, request, answer } => *answer = Some(accelerometer::ask(chip, *request, clock)),
            Work::I2c { chip, write, read_length, outcome } => *outcome = chip.transfer(write, *read_length),
        }
    }
}
