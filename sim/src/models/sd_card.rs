//! An SD memory card on its own bus: commands and blocks, as a host controller exchanges them with it.
//!
//! Source: SD Physical Layer Simplified Specification 6.00 (PL 6.00). Cards of standard and high capacity,
//! 3.3 V signalling, with high speed (CMD6) or without; [`Traits`] tells how a card differs from the usual,
//! [`Trouble`] lists its faults. Left out: protection of groups of blocks, locking and unlocking (a card is
//! locked or not) and the SPI mode; a switch to other functions than high speed; erase timing.
//!
//! | behaviour | where it is written |
//! |---|---|
//! | identification with 400 kHz at most, then 25 MHz, then 50 MHz with high speed set | 6.6.6, 6.6.7 |
//! | access times and their limits | 4.6.2, 4.16.2; between them what usual cards take |
//! | a locked card takes commands of classes 0 and 7 alone | 4.3.7 |
//! | a block whose error correction fails is not sent, and the status tells | 4.10.1, CARD_ECC_FAILED |
//! | a protected card takes data and drops them, and the status tells | 4.3.4 |

mod data;
mod registers;
mod traits;

pub use traits::{Fake, Make, Traits, Trouble};

/// Size of a block, bytes.
pub const BLOCK: usize = 512;
/// Address that the card proposes for itself.
const ADDRESS: u16 = 0x5A51;
/// Time after the first ACMD41 for which the card shows itself busy.
const POWER_UP_NS: u64 = 2_000_000;
/// Operating conditions, section 5.1: 2.7 to 3.6 V, high capacity.
const OCR: u32 = 0x00FF_8000;
const OCR_CAPACITY: u32 = 1 << 30;
const OCR_POWER_UP_DONE: u32 = 1 << 31;

/// Answer to a command (section 4.9), as far as the host tells the formats apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply {
    /// No answer to the command.
    None,
    /// R1, R1b, R6, R7: 32 bits with index and checksum.
    Short(u32),
    /// R3: 32 bits, with ones where index and checksum would be.
    Unchecked(u32),
    /// R2: 128 bits, first word first.
    Long([u32; 4]),
    /// Answer that arrives damaged.
    Damaged,
}

/// Transfer on the data lines after a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// No transfer after the command.
    None,
    /// The card sends blocks.
    Read,
    /// The card takes blocks.
    Write,
}

/// CURRENT_STATE of the card status, section 4.10.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Idle = 0,
    Ready = 1,
    Identification = 2,
    Standby = 3,
    Transfer = 4,
    Data = 5,
    Receive = 6,
    Program = 7,
}

/// Contents of the data lines.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Stream {
    Idle,
    /// Blocks from memory, from this number on; a single one or until stopped.
    Memory {
        block: u32,
        endless: bool,
    },
    /// Bytes of a register, sent once.
    Register(Vec<u8>),
}

/// Card status bits, section 4.10.1.
const OUT_OF_RANGE: u32 = 1 << 31;
/// The card is write-protected; cleared by the status that tells it (type E R X, clear condition C).
const WP_VIOLATION: u32 = 1 << 26;
const CARD_IS_LOCKED: u32 = 1 << 25;
const ILLEGAL_COMMAND: u32 = 1 << 22;
/// The card's error correction has failed; cleared by the status that tells it.
const CARD_ECC_FAILED: u32 = 1 << 21;
const READY_FOR_DATA: u32 = 1 << 8;
const APP_CMD: u32 = 1 << 5;

/// A block that the host has written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockWrite {
    /// Time at which the card had the block, nanoseconds since power-on.
    pub at_ns: u64,
    /// Number of the block.
    pub block: u32,
    /// Contents of the block from then on.
    pub bytes: Vec<u8>,
}

/// A card in its slot.
#[derive(Clone, Debug)]
pub struct SdCard {
    content: Vec<u8>,
    traits: Traits,
    trouble: Trouble,
    /// Blocks written since the log was asked for, if it was.
    log: Option<Vec<BlockWrite>>,
    /// A write was refused, and the host has not been told yet.
    has_refused: bool,
    /// A block could not be read, and the host has not been told yet.
    has_failed: bool,
    state: State,
    application: bool,
    illegal: bool,
    powering_up_until_ns: Option<u64>,
    busy_until_ns: u64,
    stream: Stream,
    block_length: usize,
    wide: bool,
    high_speed: bool,
    erase: [u32; 2],
}

impl SdCard {
    /// Makes a card with this content, rounded up to the 512 KiB that a card's size is stated in.
    #[must_use]
    pub fn new(mut content: Vec<u8>) -> Self {
        const UNIT: usize = 512 * 1024;
        content.resize(content.len().max(1).next_multiple_of(UNIT), 0);
        Self {
            content,
            traits: Traits::default(),
            trouble: Trouble::default(),
            log: None,
            has_refused: false,
            has_failed: false,
            state: State::Idle,
            application: false,
            illegal: false,
            powering_up_until_ns: None,
            busy_until_ns: 0,
            stream: Stream::Idle,
            block_length: BLOCK,
            wide: false,
            high_speed: false,
            erase: [0; 2],
        }
    }

    /// Returns the same card with other traits.
    #[must_use]
    pub const fn with(mut self, traits: Traits) -> Self {
        self.traits = traits;
        self
    }

    /// Returns the troubles to come, to be set.
    pub const fn trouble(&mut self) -> &mut Trouble {
        &mut self.trouble
    }

    /// Keeps a log of the blocks written from now on.
    pub fn keep_writes(&mut self) {
        self.log = Some(Vec::new());
    }

    /// Returns the blocks written since the log was asked for, in order.
    #[must_use]
    pub fn writes(&self) -> &[BlockWrite] {
        self.log.as_deref().unwrap_or(&[])
    }

    /// Returns everything on the card.
    #[must_use]
    pub fn content(&self) -> &[u8] {
        &self.content
    }

    /// Returns whether the host has set four data lines.
    #[must_use]
    pub const fn is_wide(&self) -> bool {
        self.wide
    }

    /// Returns the time until which the card programs and holds D0 low.
    #[must_use]
    pub const fn busy_until_ns(&self) -> u64 {
        self.busy_until_ns
    }

    fn status(&mut self, now_ns: u64) -> u32 {
        self.settle(now_ns);
        let ready = if self.state == State::Program { 0 } else { READY_FOR_DATA };
        let illegal = if std::mem::take(&mut self.illegal) { ILLEGAL_COMMAND } else { 0 };
        let refused = if std::mem::take(&mut self.has_refused) { WP_VIOLATION } else { 0 };
        let failed = if std::mem::take(&mut self.has_failed) { CARD_ECC_FAILED } else { 0 };
        let locked = if self.traits.is_locked { CARD_IS_LOCKED } else { 0 };
        let application = if self.application { APP_CMD } else { 0 };
        (self.state as u32) << 9 | ready | illegal | refused | failed | locked | application
    }

    /// Takes a command; returns the reply, and the transfer on the data lines that follows.
    pub fn command(&mut self, now_ns: u64, index: u8, argument: u32) -> (Reply, Transfer) {
        let (reply, transfer) = self.carry_out(now_ns, index, argument);
        if reply != Reply::None && Trouble::take(&mut self.trouble.damaged_answers) {
            return (Reply::Damaged, transfer);
        }
        (reply, transfer)
    }

    /// Returns whether a card of this kind, and in this condition, knows a command.
    const fn knows(&self, index: u8) -> bool {
        match self.traits.make {
            Make::Mmc => matches!(index, 0 | 1),
            _ if self.traits.is_locked && matches!(self.state, State::Transfer) => {
                matches!(index, 0 | 7 | 13 | 16 | 42 | 55)
            }
            _ => index != 6 || self.traits.is_fast,
        }
    }

    fn carry_out(&mut self, now_ns: u64, index: u8, argument: u32) -> (Reply, Transfer) {
        self.settle(now_ns);
        if !self.knows(index) && !self.application {
            self.illegal = true;
            return (Reply::None, Transfer::None);
        }
        if self.traits.make == Make::Mmc && index == 1 {
            return (Reply::Unchecked(OCR | OCR_POWER_UP_DONE), Transfer::None);
        }
        if std::mem::take(&mut self.application)
            && let Some(answer) = self.application_command(now_ns, index, argument)
        {
            return answer;
        }
        if let Some(answer) = self.identification_command(now_ns, index, argument) {
            return answer;
        }
        let addressed = (argument >> 16) as u16 == ADDRESS;
        match (index, self.state) {
            (12, State::Data | State::Receive) => self.stop(now_ns),
            // A card has no address, and no status to give, before it is identified (table 4-35).
            (13, State::Standby | State::Transfer | State::Data | State::Receive | State::Program) if addressed => {
                (Reply::Short(self.status(now_ns)), Transfer::None)
            }
            (16, State::Transfer) => {
                // The length is fixed at 512 for memory of a high-capacity card; registers follow it.
                self.block_length = (argument as usize).clamp(1, BLOCK);
                (Reply::Short(self.status(now_ns)), Transfer::None)
            }
            (6, State::Transfer) => self.switch(now_ns, argument),
            (17 | 18, State::Transfer) => self.begin(now_ns, argument, index == 18, State::Data, Transfer::Read),
            (24 | 25, State::Transfer) => self.begin(now_ns, argument, index == 25, State::Receive, Transfer::Write),
            (23, State::Transfer) => (Reply::Short(self.status(now_ns)), Transfer::None),
            (32 | 33, State::Transfer) => {
                self.erase[usize::from(index - 32)] = argument;
                (Reply::Short(self.status(now_ns)), Transfer::None)
            }
            (38, State::Transfer) => self.erase_blocks(now_ns),
            (55, _) => {
                // Before it has an address, a card is spoken to with address zero.
                self.application = true;
                (Reply::Short(self.status(now_ns)), Transfer::None)
            }
            _ => {
                // An illegal command gets no reply; the next status says so.
                self.illegal = true;
                (Reply::None, Transfer::None)
            }
        }
    }

    /// Carries out a command that finds and selects cards. `None` for any other.
    fn identification_command(&mut self, now_ns: u64, index: u8, argument: u32) -> Option<(Reply, Transfer)> {
        let addressed = (argument >> 16) as u16 == ADDRESS;
        let nothing = (Reply::None, Transfer::None);
        Some(match (index, self.state) {
            (0, _) => {
                let log = self.log.take();
                let trouble = std::mem::take(&mut self.trouble);
                *self = Self { log, trouble, ..Self::new(std::mem::take(&mut self.content)).with(self.traits) };
                nothing
            }
            (2, State::Ready) => {
                self.state = State::Identification;
                (Reply::Long(registers::CID), Transfer::None)
            }
            (3, State::Identification | State::Standby) => {
                self.state = State::Standby;
                let status = self.status(now_ns);
                // R6: address, then status bits 23, 22, 19 and 12..0.
                let bits = (status >> 8 & 0xC000) | (status >> 6 & 0x2000) | (status & 0x1FFF);
                (Reply::Short(u32::from(ADDRESS) << 16 | bits), Transfer::None)
            }
            (7, State::Standby) if addressed => self.r1_into(now_ns, State::Transfer),
            (7, State::Transfer | State::Data) if !addressed => {
                self.state = State::Standby;
                self.stream = Stream::Idle;
                nothing
            }
            // R7: voltage accepted and check pattern echoed.
            (8, State::Idle) => (Reply::Short(argument & 0xFFF), Transfer::None),
            (9, State::Standby) if addressed => (Reply::Long(self.csd()), Transfer::None),
            (10, State::Standby) if addressed => (Reply::Long(registers::CID), Transfer::None),
            _ => return None,
        })
    }

    /// Ends programming, which takes nothing but time.
    fn settle(&mut self, now_ns: u64) {
        if self.state == State::Program && now_ns >= self.busy_until_ns {
            self.state = State::Transfer;
        }
    }

    /// Returns R1 with the state the command found, and puts the card in the new state.
    fn r1_into(&mut self, now_ns: u64, state: State) -> (Reply, Transfer) {
        let status = self.status(now_ns);
        self.state = state;
        (Reply::Short(status), Transfer::None)
    }

    fn begin(
        &mut self,
        now_ns: u64,
        argument: u32,
        endless: bool,
        state: State,
        transfer: Transfer,
    ) -> (Reply, Transfer) {
        let status = self.status(now_ns);
        let block = if self.traits.make == Make::Standard { argument / BLOCK as u32 } else { argument };
        if block as usize >= self.claimed() / BLOCK {
            return (Reply::Short(status | OUT_OF_RANGE), Transfer::None);
        }
        self.state = state;
        self.stream = Stream::Memory { block, endless };
        (Reply::Short(status), transfer)
    }

    fn register(&mut self, now_ns: u64, bytes: Vec<u8>) -> (Reply, Transfer) {
        let status = self.status(now_ns);
        self.state = State::Data;
        self.stream = Stream::Register(bytes);
        (Reply::Short(status), Transfer::Read)
    }

    fn stop(&mut self, now_ns: u64) -> (Reply, Transfer) {
        let status = self.status(now_ns);
        self.state =
            if self.state == State::Receive && now_ns < self.busy_until_ns { State::Program } else { State::Transfer };
        self.stream = Stream::Idle;
        (Reply::Short(status), Transfer::None)
    }

    fn erase_blocks(&mut self, now_ns: u64) -> (Reply, Transfer) {
        let status = self.status(now_ns);
        let [first, last] = self.erase.map(|block| block as usize * BLOCK);
        let range = first..(last + BLOCK).min(self.content.len());
        self.content.get_mut(range).into_iter().for_each(|blocks| blocks.fill(0));
        self.busy_until_ns = now_ns + self.traits.programming_ns;
        self.state = State::Program;
        (Reply::Short(status), Transfer::None)
    }

    /// Carries out CMD6 (section 4.3.10): function group 1 offers default (0) and high speed (1).
    fn switch(&mut self, now_ns: u64, argument: u32) -> (Reply, Transfer) {
        let wanted = argument & 0xF;
        let selected = match wanted {
            0xF => u8::from(self.high_speed),
            0 | 1 => wanted as u8,
            _ => 0xF,
        };
        if argument >> 31 == 1 && selected != 0xF {
            self.high_speed = selected == 1;
        }
        self.register(now_ns, registers::switch_status(selected))
    }

    fn application_command(&mut self, now_ns: u64, index: u8, argument: u32) -> Option<(Reply, Transfer)> {
        Some(match (index, self.state) {
            (41, State::Idle) => {
                let capacity = if self.traits.make == Make::High { OCR_CAPACITY } else { 0 };
                if argument & 0x00FF_8000 == 0 {
                    return Some((Reply::Unchecked(OCR | capacity), Transfer::None));
                }
                let until = *self.powering_up_until_ns.get_or_insert(now_ns + POWER_UP_NS);
                if now_ns < until {
                    return Some((Reply::Unchecked(OCR), Transfer::None));
                }
                self.state = State::Ready;
                (Reply::Unchecked(OCR | capacity | OCR_POWER_UP_DONE), Transfer::None)
            }
            (6, State::Transfer) => {
                self.wide = argument & 3 == 2;
                (Reply::Short(self.status(now_ns) | APP_CMD), Transfer::None)
            }
            (13, State::Transfer) => {
                let mut bytes = vec![0; 64];
                bytes[0] = if self.wide { 0x80 } else { 0 };
                bytes[8] = 0x04; // class 10
                self.register(now_ns, bytes)
            }
            (51, State::Transfer) => self.register(now_ns, registers::scr(&self.traits)),
            (23 | 42, State::Transfer) => (Reply::Short(self.status(now_ns) | APP_CMD), Transfer::None),
            _ => return None,
        })
    }

    fn csd(&self) -> [u32; 4] {
        registers::csd(&self.traits, self.claimed(), self.high_speed)
    }
}

#[cfg(test)]
mod tests;
