//! State of the controller: of the command path, the data path and the FIFO.

use std::collections::VecDeque;

use rigless::device::{DeviceContext, RegisterFile};
use rigless::soc::stm32h743::generated::sdmmc1::Register;
use rigless::time::{EventId, VirtualNanos};
use sim::models::sd_card::{Reply, SdCard, Transfer};

use crate::peripherals::sdmmc_flags as flag;

/// Depth of the FIFO, words.
pub(super) const FIFO_WORDS: usize = 16;
pub(super) const HALF_FIFO: usize = FIFO_WORDS / 2;
/// Value of PWRCTRL in POWER for power on.
pub(super) const POWER_ON: u64 = 0b11;
/// Clocks from power-on until commands go out.
pub(super) const POWER_UP_CLOCKS: u64 = 74;
/// CMDR fields, section 58.10.4.
pub(super) const CMDTRANS: u64 = 1 << 6;
pub(super) const CMDSTOP: u64 = 1 << 7;
pub(super) const CPSMEN: u64 = 1 << 12;
/// DCTRL fields, section 58.10.12.
pub(super) const DTEN: u64 = 1;
pub(super) const DTDIR: u64 = 1 << 1;
pub(super) const DTMODE: u64 = 3 << 2;
pub(super) const FIFORST: u64 = 1 << 13;
/// CLKCR fields, section 58.10.2.
pub(super) const HWFC_EN: u64 = 1 << 17;
/// Registers that firmware can write only while the data path is idle.
pub(super) const LOCKED: [Register; 5] =
    [Register::Clkcr, Register::Dtimer, Register::Dlenr, Register::Dctrl, Register::Idmactrlr];
/// Field CMDINDEX of register CMDR.
pub(super) const INDEX: u64 = 0x3F;

/// A command on the command line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Command {
    /// Event of the next step: end of the command, or of its response.
    pub(super) event: EventId,
    pub(super) register: u64,
    pub(super) argument: u32,
    /// Answer of the card, once it has heard the command.
    pub(super) heard: Option<(Reply, Transfer)>,
}

impl Command {
    pub(super) const fn index(&self) -> u8 {
        (self.register & INDEX) as u8
    }

    pub(super) const fn awaits(&self) -> u64 {
        self.register >> 8 & 3
    }
}

/// A block that is being received.
#[derive(Clone, Debug)]
pub(super) struct Incoming {
    pub(super) words: VecDeque<u32>,
    pub(super) bytes: u64,
    /// Instant of the first data bit; later by the time that the clock has stood still since.
    pub(super) began_ns: u64,
    /// Words received, of which the last may wait for room.
    pub(super) came: u64,
    /// Event of the next word or the end of the block; `None` while flow control holds the clock.
    pub(super) event: Option<EventId>,
    /// Whether the checksum will be right.
    pub(super) intact: bool,
}

impl Incoming {
    pub(super) fn spoil(&mut self) {
        self.intact = false;
    }
}

/// A block that is being sent.
#[derive(Clone, Debug)]
pub(super) struct Outgoing {
    pub(super) bytes: Vec<u8>,
    /// Bytes of the whole block.
    pub(super) length: u64,
    /// Instant of the first data bit; later by the time that the clock has stood still since.
    pub(super) began_ns: u64,
    /// Words taken from the FIFO.
    pub(super) went: u64,
    /// Event of the next word or of the card's status; `None` while flow control holds the clock.
    pub(super) event: Option<EventId>,
}

impl Outgoing {
    /// Takes a word that the DMA has fetched.
    pub(super) fn fetched(&mut self, word: u32) {
        self.bytes.extend(word.to_le_bytes());
    }

    pub(super) const fn words(&self) -> u64 {
        self.length.div_ceil(4)
    }
}

/// The data path state machine (DPSM), section 58.5.5.
#[derive(Clone, Debug)]
pub(super) enum Data {
    Idle,
    /// Wait_R: waits for the start bit, until DTIMER runs out.
    WaitReceive {
        timeout: EventId,
        start: Option<EventId>,
    },
    Receive(Incoming),
    /// Wait_R with no more data to come: waits for the receive FIFO to be emptied.
    Emptying,
    /// Wait_S: waits for the response to the command, and for data.
    WaitSend,
    Send(Outgoing),
    /// The card programs the last block, for DTIMER at most.
    Busy {
        ready: EventId,
        timeout: EventId,
    },
    /// State after an error, until the transfer is aborted.
    Failed,
}

/// The controller with its card slot.
#[derive(Debug)]
pub struct Sdmmc {
    pub(super) card: Option<SdCard>,
    pub(super) kernel_hz: u64,
    /// End of the 74 clocks after power-on.
    pub(super) powered_ns: u64,
    pub(super) command: Option<Command>,
    /// End of the busy signal after a response, for BUSYD0END; and the time-out by DTIMER meanwhile.
    pub(super) busy: Option<EventId>,
    pub(super) busy_timeout: Option<EventId>,
    pub(super) data: Data,
    pub(super) transfer: Transfer,
    pub(super) fifo: VecDeque<u32>,
    /// Words read from the receive FIFO before they were received.
    pub(super) overdrawn: u32,
    pub(super) status: u64,
    pub(super) remaining: u64,
    pub(super) dma_address: u64,
    pub(super) dma_room: u64,
    pub(super) raised: bool,
    /// Values of POWER and the locked registers, which a write in the wrong state does not change.
    pub(super) power: u64,
    pub(super) kept: [u64; LOCKED.len()],
}

impl Sdmmc {
    /// Creates the controller with this card in its slot, or an empty slot.
    #[must_use]
    pub fn new(card: Option<SdCard>) -> Self {
        Self {
            card,
            // Reset state of the kernel multiplexer: PLL1_Q, which does not run yet.
            kernel_hz: 0,
            powered_ns: 0,
            command: None,
            busy: None,
            busy_timeout: None,
            data: Data::Idle,
            transfer: Transfer::None,
            fifo: VecDeque::new(),
            overdrawn: 0,
            status: 0,
            remaining: 0,
            dma_address: 0,
            dma_room: 0,
            raised: false,
            power: 0,
            kept: [0; LOCKED.len()],
        }
    }

    /// Returns the card in the slot.
    #[must_use]
    pub const fn card(&self) -> Option<&SdCard> {
        self.card.as_ref()
    }

    /// Returns the card in the slot, for faults to be set.
    pub const fn card_mut(&mut self) -> Option<&mut SdCard> {
        self.card.as_mut()
    }

    /// Puts a card into the slot, or takes it out, at any time: a block under way arrives damaged.
    pub fn insert(&mut self, card: Option<SdCard>) {
        self.card = card;
        if let Data::Receive(incoming) = &mut self.data {
            incoming.spoil();
        }
    }

    /// Frequency of the bus clock: the kernel's over twice CLKDIV, or the kernel's (58.10.2).
    pub(super) fn hz(&self, file: &RegisterFile) -> u64 {
        let divider = (file.get(Register::Clkcr) & 0x3FF) * 2;
        (self.kernel_hz.max(1) / divider.max(1)).max(1)
    }

    /// Duration of so many clocks of the bus, nanoseconds.
    pub(super) fn clocks(&self, count: u64, file: &RegisterFile) -> u64 {
        u64::try_from(u128::from(count) * 1_000_000_000 / u128::from(self.hz(file))).unwrap_or(u64::MAX)
    }

    pub(super) fn schedule_clocks(&self, count: u64, file: &RegisterFile, context: &mut DeviceContext<'_>) -> EventId {
        context.schedule(VirtualNanos(context.now().0.saturating_add(self.clocks(count, file))))
    }

    /// Schedules the time-out of a DTIMER that starts now: on entering Wait_R or Busy, and after a response
    /// with a busy card.
    pub(super) fn schedule_timeout(&self, file: &RegisterFile, context: &mut DeviceContext<'_>) -> EventId {
        self.schedule_clocks(file.get(Register::Dtimer).max(1), file, context)
    }

    /// Number of data lines in use.
    pub(super) fn lines(file: &RegisterFile) -> u64 {
        match file.get(Register::Clkcr) >> 14 & 3 {
            0 => 1,
            1 => 4,
            _ => 8,
        }
    }

    /// Whether card and controller use the same data lines: otherwise no checksum is ever right.
    pub(super) fn lines_agree(&self, file: &RegisterFile) -> bool {
        self.card.as_ref().is_some_and(|card| Self::lines(file) == if card.is_wide() { 4 } else { 1 })
    }

    /// Whether data arrive as they were sent.
    pub(super) fn arrives_intact(&self, file: &RegisterFile) -> bool {
        self.lines_agree(file) && self.card.as_ref().is_some_and(|card| card.is_clean_at(self.hz(file)))
    }

    pub(super) fn block_bytes(file: &RegisterFile) -> u64 {
        1 << (file.get(Register::Dctrl) >> 4 & 0xF)
    }

    pub(super) fn from_card(file: &RegisterFile) -> bool {
        file.get(Register::Dctrl) & DTDIR != 0
    }

    pub(super) fn flow_control(file: &RegisterFile) -> bool {
        file.get(Register::Clkcr) & HWFC_EN != 0
    }

    /// Completes a transfer whose data have all moved without an error.
    pub(super) fn complete(&mut self, file: &mut RegisterFile) {
        self.status |= flag::DATAEND;
        self.idle(file);
    }

    pub(super) fn fail(&mut self, why: u64) {
        self.status |= why;
        self.data = Data::Failed;
        self.transfer = Transfer::None;
    }

    /// Returns the data path to Idle, which empties the FIFO.
    pub(super) fn idle(&mut self, file: &mut RegisterFile) {
        self.data = Data::Idle;
        self.transfer = Transfer::None;
        self.fifo.clear();
        file.set(Register::Dctrl, file.get(Register::Dctrl) & !(DTEN | FIFORST));
        self.keep(file);
    }

    /// Remembers the locked registers as they are now.
    pub(super) fn keep(&mut self, file: &RegisterFile) {
        self.kept = LOCKED.map(|register| file.get(register));
    }

    pub(super) fn active(&self) -> bool {
        !matches!(self.data, Data::Idle)
    }

    /// Returns the state flags of STAR, which follow the FIFO and the two state machines.
    pub(super) fn live_flags(&self, file: &RegisterFile) -> u64 {
        let receiving = self.active() && Self::from_card(file);
        let sending = self.active() && !Self::from_card(file);
        let count = self.fifo.len();
        let list = [
            (flag::CPSMACT, self.command.is_some()),
            (flag::DPSMACT, self.active()),
            (flag::BUSYD0, self.busy.is_some()),
            (flag::RXFIFOHF, receiving && count >= HALF_FIFO),
            (flag::RXFIFOF, receiving && count == FIFO_WORDS),
            (flag::RXFIFOE, receiving && count == 0),
            (flag::TXFIFOHE, sending && count <= HALF_FIFO),
            (flag::TXFIFOF, sending && count == FIFO_WORDS),
            (flag::TXFIFOE, sending && count == 0),
        ];
        list.into_iter().filter(|&(_, set)| set).fold(0, |word, (bit, _)| word | bit)
    }
}
