//! Data from the card, RM0399 section 58.5.5: states Wait_R and Receive.

use rigless::device::{DeviceContext, RegisterFile};
use rigless::soc::Width;
use rigless::time::{EventId, VirtualNanos};
use sim::models::sd_card::{SdCard, Transfer};

use super::idma;
use super::state::{Data, FIFO_WORDS, Incoming, Sdmmc};
use crate::peripherals::sdmmc_flags as flag;

/// Clocks of a block beside its data: a start bit before them, the checksum and an end bit after them.
const START_CLOCKS: u64 = 1;
const END_CLOCKS: u64 = 17;

impl Sdmmc {
    /// Enters Wait_R; with an access time when the card has another block to send.
    pub(super) fn wait_receive(
        &mut self,
        access_ns: Option<u64>,
        file: &RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let timeout = self.schedule_timeout(file, context);
        let start = access_ns.map(|access| context.schedule(VirtualNanos(context.now().0 + access)));
        self.data = Data::WaitReceive { timeout, start };
    }

    /// Follows a command that has told the card to send.
    pub(super) fn follow_receive(&mut self, _file: &RegisterFile, context: &mut DeviceContext<'_>) {
        if self.transfer == Transfer::Read
            && let Data::WaitReceive { start, .. } = &mut self.data
            && let Some(card) = &mut self.card
        {
            *start = Some(context.schedule(VirtualNanos(context.now().0 + card.access_ns())));
        }
    }

    pub(super) fn wait_is_over(
        &mut self,
        event: EventId,
        timeout: EventId,
        start: Option<EventId>,
        file: &RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.data = Data::WaitReceive { timeout, start };
        if start == Some(event) {
            self.begin_block(file, context);
        }
        if timeout == event && matches!(self.data, Data::WaitReceive { .. }) {
            self.fail(flag::DTIMEOUT);
        }
    }

    /// Receives the card's start bit, if the card still has something to send.
    fn begin_block(&mut self, file: &RegisterFile, context: &mut DeviceContext<'_>) {
        let bytes = Self::block_bytes(file);
        let intact = self.arrives_intact(file) && !self.card.as_mut().is_some_and(SdCard::damages_block);
        let Some(block) = self.card.as_mut().and_then(|card| card.read(bytes as usize)) else { return };
        let words = block.chunks(4).map(|chunk| {
            let mut word = [0; 4];
            word[..chunk.len()].copy_from_slice(chunk);
            u32::from_le_bytes(word)
        });
        let began_ns = context.now().0 + self.clocks(START_CLOCKS, file);
        let mut incoming = Incoming { words: words.collect(), bytes, began_ns, came: 0, event: None, intact };
        if Self::dma(file) {
            incoming.event = Some(self.schedule_end(&incoming, file, context));
        } else {
            incoming.event = Some(self.schedule_word(&incoming, file, context));
        }
        self.data = Data::Receive(incoming);
    }

    /// Schedules the end of the next word.
    fn schedule_word(&self, incoming: &Incoming, file: &RegisterFile, context: &mut DeviceContext<'_>) -> EventId {
        let bits = ((incoming.came + 1) * 32).min(incoming.bytes * 8);
        context.schedule(VirtualNanos(incoming.began_ns + self.clocks(bits / Self::lines(file), file)))
    }

    /// Schedules the block's end bit.
    fn schedule_end(&self, incoming: &Incoming, file: &RegisterFile, context: &mut DeviceContext<'_>) -> EventId {
        let clocks = incoming.bytes * 8 / Self::lines(file) + END_CLOCKS;
        context.schedule(VirtualNanos(incoming.began_ns + self.clocks(clocks, file)))
    }

    /// Receives a word, or with DMA the block.
    pub(super) fn receive(
        &mut self,
        event: EventId,
        mut incoming: Incoming,
        file: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if incoming.event != Some(event) {
            self.data = Data::Receive(incoming);
        } else if Self::dma(file) {
            self.store_block(incoming, file, context);
        } else if incoming.words.is_empty() {
            self.end_of_block(incoming.intact, file, context);
        } else if self.fifo.len() == FIFO_WORDS {
            if Self::flow_control(file) {
                // The clock stands still until there is room.
                incoming.event = None;
                self.data = Data::Receive(incoming);
            } else {
                self.fail(flag::RXOVERR);
            }
        } else {
            self.take_word(&mut incoming, file, context);
            self.data = Data::Receive(incoming);
        }
    }

    fn take_word(&mut self, incoming: &mut Incoming, file: &RegisterFile, context: &mut DeviceContext<'_>) {
        let word = incoming.words.pop_front();
        if self.overdrawn > 0 {
            self.overdrawn -= 1;
        } else {
            self.fifo.extend(word);
        }
        self.remaining = self.remaining.saturating_sub(4);
        incoming.came += 1;
        incoming.event = Some(if incoming.words.is_empty() {
            self.schedule_end(incoming, file, context)
        } else {
            self.schedule_word(incoming, file, context)
        });
    }

    /// Lets firmware take a word. The manual does not define a read of the empty FIFO. On silicon DATAEND
    /// waits until the FIFO is empty, and a driver that reads both words of the SCR as soon as the first is
    /// there still sees it: so the next word to come counts as read.
    pub(super) fn read_fifo(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> u64 {
        let word = self.fifo.pop_front();
        if word.is_none() && self.remaining > 0 {
            context.tell("FIFOR", "RM0399 SDMMC: read while the receive FIFO is empty");
            self.overdrawn += 1;
        }
        self.room_in_fifo(file, context);
        u64::from(word.unwrap_or(0))
    }

    /// Follows a word taken by firmware: a clock that stood still goes on, or the transfer is complete.
    fn room_in_fifo(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        match std::mem::replace(&mut self.data, Data::Failed) {
            Data::Receive(mut incoming) if incoming.event.is_none() => {
                let bits = (incoming.came + 1) * 32;
                let due_ns = incoming.began_ns + self.clocks(bits / Self::lines(file), file);
                incoming.began_ns += context.now().0.saturating_sub(due_ns);
                self.take_word(&mut incoming, file, context);
                self.data = Data::Receive(incoming);
            }
            Data::Emptying if self.fifo.is_empty() => self.complete(file),
            other => self.data = other,
        }
    }

    fn store_block(&mut self, incoming: Incoming, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        for word in incoming.words {
            let Some(address) = self.next_dma_address(file) else {
                self.fail(flag::IDMATE);
                return;
            };
            context.write_to(address, Width::W32, u64::from(word), idma::STORE);
            self.remaining = self.remaining.saturating_sub(4);
        }
        self.end_of_block(incoming.intact, file, context);
    }

    fn end_of_block(&mut self, intact: bool, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if let Some(card) = &mut self.card {
            card.block_sent();
        }
        if !intact {
            self.fail(flag::DCRCFAIL);
        } else if self.remaining > 0 {
            let next_ns = self.card.as_ref().map(SdCard::next_ns);
            self.wait_receive(next_ns, file, context);
        } else if self.fifo.is_empty() {
            self.complete(file);
        } else {
            self.data = Data::Emptying;
        }
    }
}
