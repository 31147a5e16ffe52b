//! SDMMC1, RM0399 rev 4 chapter 58 ("SDMMC"): the host controller of the SD card, with its FIFO and internal
//! DMA.
//!
//! The card is `sim`'s. Everything takes its time on the bus: the kernel clock over CLKDIV, 48 or 136 bits on
//! CMD, one or four data lines. Through the FIFO a word comes or goes every 32 / lines clocks; with the
//! internal DMA a block moves at its end, since nobody sees its words on the way.
//!
//! | behaviour | where it is written |
//! |---|---|
//! | PWRCTRL = 11 stays until the block is reset by RCC | 58.10.1: "any further write is ignored" |
//! | no command in the first 74 clocks after power-on | 58.10.1 |
//! | flags of the FIFO only while the data path is active | 58.5.5, FIFO; 58.10.14 resets to zero |
//! | DATAEND once the receive FIFO is empty | 58.5.5, Wait_R with DATACOUNT = 0 |
//! | an error leaves the data path active until CMD12 with CMDSTOP, or reset | 58.5.5; others' drivers |
//! | a command goes out while DTEN is set, and is a complaint | others' drivers, against 58.10.4 |
//! | BUSYD0 is sampled at the end of a response and follows the line from then on | 58.10.14 |
//! | a bus faster than the card may have it damages all data: a complaint | SD PL 6.00, 6.6.6 and 6.6.7 |
//! | registers of the data path keep their values while it is active | 58.10.2 to 58.10.20, each field |
//!
//! Left out: boot mode, SDIO (interrupts, read wait, suspend), voltage switching, and the data transfer modes
//! other than the block mode. FIFOR answers at its first address alone.

use std::collections::VecDeque;

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::soc::stm32h743::generated::sdmmc1::Register;
use rigless::time::{EventId, VirtualNanos};
use sim::models::sd_card::{SdCard, Transfer};

use super::sdmmc_flags as flag;

mod command;
mod idma;
mod receive;
mod send;

use command::Command;
use receive::Incoming;
use send::Outgoing;

#[cfg(test)]
mod tests;

/// Depth of the FIFO, words.
const FIFO_WORDS: usize = 16;
const HALF_FIFO: usize = FIFO_WORDS / 2;
/// Value of PWRCTRL in POWER for power on.
const POWER_ON: u64 = 0b11;
/// Clocks from power-on until commands go out.
const POWER_UP_CLOCKS: u64 = 74;
/// CMDR fields, section 58.10.4.
const CMDTRANS: u64 = 1 << 6;
const CMDSTOP: u64 = 1 << 7;
const CPSMEN: u64 = 1 << 12;
/// DCTRL fields, section 58.10.12.
const DTEN: u64 = 1;
const DTDIR: u64 = 1 << 1;
const DTMODE: u64 = 3 << 2;
const FIFORST: u64 = 1 << 13;
/// CLKCR fields, section 58.10.2.
const HWFC_EN: u64 = 1 << 17;
/// Registers that firmware can write only while the data path is idle.
const LOCKED: [Register; 5] =
    [Register::Clkcr, Register::Dtimer, Register::Dlenr, Register::Dctrl, Register::Idmactrlr];

/// The data path state machine (DPSM), section 58.5.5.
#[derive(Clone, Debug)]
enum Data {
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
    card: Option<SdCard>,
    kernel_hz: u64,
    /// End of the 74 clocks after power-on.
    powered_ns: u64,
    command: Option<Command>,
    /// End of the busy signal after a response, for BUSYD0END; and the time-out by DTIMER meanwhile.
    busy: Option<EventId>,
    busy_timeout: Option<EventId>,
    data: Data,
    transfer: Transfer,
    fifo: VecDeque<u32>,
    /// Words read from the receive FIFO before they were received.
    overdrawn: u32,
    status: u64,
    remaining: u64,
    dma_address: u64,
    dma_room: u64,
    raised: bool,
    /// Values of POWER and the locked registers, which a write in the wrong state does not change.
    power: u64,
    kept: [u64; LOCKED.len()],
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
    fn hz(&self, file: &RegisterFile) -> u64 {
        let divider = (file.get(Register::Clkcr) & 0x3FF) * 2;
        (self.kernel_hz.max(1) / divider.max(1)).max(1)
    }

    /// Duration of so many clocks of the bus, nanoseconds.
    fn clocks(&self, count: u64, file: &RegisterFile) -> u64 {
        u64::try_from(u128::from(count) * 1_000_000_000 / u128::from(self.hz(file))).unwrap_or(u64::MAX)
    }

    fn schedule_clocks(&self, count: u64, file: &RegisterFile, context: &mut DeviceContext<'_>) -> EventId {
        context.schedule(VirtualNanos(context.now().0.saturating_add(self.clocks(count, file))))
    }

    /// Schedules the time-out of a DTIMER that starts now: on entering Wait_R or Busy, and after a response
    /// with a busy card.
    fn schedule_timeout(&self, file: &RegisterFile, context: &mut DeviceContext<'_>) -> EventId {
        self.schedule_clocks(file.get(Register::Dtimer).max(1), file, context)
    }

    /// Number of data lines in use.
    fn lines(file: &RegisterFile) -> u64 {
        match file.get(Register::Clkcr) >> 14 & 3 {
            0 => 1,
            1 => 4,
            _ => 8,
        }
    }

    /// Whether card and controller use the same data lines: otherwise no checksum is ever right.
    fn lines_agree(&self, file: &RegisterFile) -> bool {
        self.card.as_ref().is_some_and(|card| Self::lines(file) == if card.is_wide() { 4 } else { 1 })
    }

    /// Whether data arrive as they were sent.
    fn arrives_intact(&self, file: &RegisterFile) -> bool {
        self.lines_agree(file) && self.card.as_ref().is_some_and(|card| card.is_clean_at(self.hz(file)))
    }

    fn block_bytes(file: &RegisterFile) -> u64 {
        1 << (file.get(Register::Dctrl) >> 4 & 0xF)
    }

    fn from_card(file: &RegisterFile) -> bool {
        file.get(Register::Dctrl) & DTDIR != 0
    }

    fn flow_control(file: &RegisterFile) -> bool {
        file.get(Register::Clkcr) & HWFC_EN != 0
    }

    /// Enables the data path, which leaves Idle: by a command with CMDTRANS, or by DTEN.
    fn enable_data(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if file.get(Register::Dctrl) & DTMODE != 0 {
            context.tell("DCTRL", "a data transfer mode other than the block mode has no model");
        }
        let block = Self::block_bytes(file);
        self.remaining = (file.get(Register::Dlenr) & 0x1FF_FFFF) / block * block;
        self.fifo.clear();
        self.overdrawn = 0;
        self.dma_address = file.get(Register::Idmabase0r);
        self.dma_room = idma::buffer_bytes(file);
        if self.remaining == 0 {
            self.complete(file);
        } else if Self::from_card(file) {
            self.wait_receive(None, file, context);
        } else {
            self.data = Data::WaitSend;
            self.follow_send(file, context);
        }
    }

    /// Completes a transfer whose data have all moved without an error.
    fn complete(&mut self, file: &mut RegisterFile) {
        self.status |= flag::DATAEND;
        self.idle(file);
    }

    fn fail(&mut self, why: u64) {
        self.status |= why;
        self.data = Data::Failed;
        self.transfer = Transfer::None;
    }

    /// Returns the data path to Idle, which empties the FIFO.
    fn idle(&mut self, file: &mut RegisterFile) {
        self.data = Data::Idle;
        self.transfer = Transfer::None;
        self.fifo.clear();
        file.set(Register::Dctrl, file.get(Register::Dctrl) & !(DTEN | FIFORST));
        self.keep(file);
    }

    /// Remembers the locked registers as they are now.
    fn keep(&mut self, file: &RegisterFile) {
        self.kept = LOCKED.map(|register| file.get(register));
    }

    fn active(&self) -> bool {
        !matches!(self.data, Data::Idle)
    }

    /// Returns the state flags of STAR, which follow the FIFO and the two state machines.
    fn live_flags(&self, file: &RegisterFile) -> u64 {
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

    fn refresh(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let shown = self.status | self.live_flags(file);
        file.set(Register::Star, shown);
        file.set(Register::Dcntr, self.remaining);
        let raised = shown & file.get(Register::Maskr) != 0;
        if raised != self.raised {
            self.raised = raised;
            context.interrupt(0, Level::from(raised));
        }
    }

    fn write_power(&mut self, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        // Value 01 is reserved and changes nothing; 11 stays until a reset.
        if self.power & POWER_ON == POWER_ON || value & POWER_ON == 0b01 {
            file.set(Register::Power, value & !POWER_ON | self.power & POWER_ON);
        } else if value & POWER_ON == POWER_ON {
            self.powered_ns = context.now().0.saturating_add(self.clocks(POWER_UP_CLOCKS, file));
        }
        self.power = file.get(Register::Power);
    }

    fn write_data_control(&mut self, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.active() {
            if value & FIFORST != 0 && matches!(self.data, Data::Failed) && !Self::dma(file) {
                self.fifo.clear();
            }
        } else {
            file.set(Register::Dctrl, value & !FIFORST);
            self.keep(file);
            if value & DTEN != 0 {
                self.enable_data(file, context);
            }
        }
    }

    /// Whether words can move between firmware and the FIFO: only while the data path is active and the DMA
    /// is off.
    fn fifo_open(&self, file: &RegisterFile, from_card: bool) -> bool {
        self.active() && !Self::dma(file) && Self::from_card(file) == from_card
    }
}

impl Device for Sdmmc {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        if register != Register::Fifor {
            return None;
        }
        if !self.fifo_open(file, true) {
            return Some(0);
        }
        let word = self.read_fifo(file, context);
        self.refresh(file, context);
        Some(word)
    }

    fn steady(&self, register: Register, _: &RegisterFile) -> bool {
        register != Register::Fifor
    }

    fn write(&mut self, register: Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if let Some(place) = LOCKED.iter().position(|&locked| locked == register) {
            if self.active() {
                file.set(register, self.kept[place]);
            } else {
                self.kept[place] = file.get(register);
            }
        }
        match register {
            Register::Power => self.write_power(value, file, context),
            Register::Cmdr => self.write_command(value, file, context),
            Register::Dctrl => self.write_data_control(value, file, context),
            Register::Icr => {
                self.status &= !(value & flag::CLEARABLE);
                file.set(Register::Icr, 0);
            }
            Register::Fifor if self.fifo_open(file, false) && self.fifo.len() < FIFO_WORDS => {
                self.fifo.push_back(value as u32);
                self.word_in_fifo(file, context);
            }
            _ => {}
        }
        self.refresh(file, context);
    }

    /// Handles an event. Two ends at the same instant share an event, so each part checks for its own.
    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.command.as_ref().is_some_and(|command| command.event == event) {
            self.advance_command(file, context);
        }
        if self.busy_timeout == Some(event) {
            self.busy_timeout = None;
            if self.busy != Some(event) {
                self.status |= flag::DTIMEOUT;
            }
        }
        if self.busy == Some(event) {
            self.busy = None;
            self.busy_timeout = None;
            self.status |= flag::BUSYD0END;
        }
        match std::mem::replace(&mut self.data, Data::Failed) {
            Data::WaitReceive { timeout, start } => self.wait_is_over(event, timeout, start, file, context),
            Data::Receive(incoming) => self.receive(event, incoming, file, context),
            Data::Send(outgoing) => self.send(event, outgoing, file, context),
            Data::Busy { ready, timeout } => self.busy_is_over(event, ready, timeout, file, context),
            other => self.data = other,
        }
        self.refresh(file, context);
    }

    fn on_access(&mut self, token: u64, value: u64, file: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        if let Data::Send(outgoing) = &mut self.data
            && Self::dma(file)
            && token == idma::FETCH
        {
            outgoing.fetched(value as u32);
        }
    }

    /// Handles a DMA access to an address that does not answer.
    fn on_refused(&mut self, _token: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.fail(flag::IDMATE);
        self.refresh(file, context);
    }

    fn on_clock(&mut self, hz: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        self.kernel_hz = hz;
    }

    /// Resets the block, with the part or by RCC. The card has its own supply and notices nothing.
    fn reset(&mut self) {
        let kernel_hz = self.kernel_hz;
        *self = Self { kernel_hz, ..Self::new(self.card.take()) };
    }
}
