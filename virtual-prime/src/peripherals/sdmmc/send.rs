//! Data to the card, RM0399 section 58.5.5: states Wait_S, Send and Busy.

use rigless::device::{DeviceContext, RegisterFile};
use rigless::soc::Width;
use rigless::time::{EventId, VirtualNanos};
use sim::models::sd_card::{SdCard, Transfer};

use super::idma;
use super::state::{Data, Outgoing, Sdmmc};
use crate::peripherals::sdmmc_flags as flag;

/// Clocks before a block: N_WR of the SD specification, at least two, and the start bit.
const START_CLOCKS: u64 = 3;
/// Clocks after a block's data: checksum, end bit, two clocks of turn-round and the card's five bits of CRC
/// status.
const END_CLOCKS: u64 = 16 + 1 + 2 + 5;

impl Sdmmc {
    /// Begins a block in Wait_S, once the card has been told to take one and the first word is there.
    pub(super) fn follow_send(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if !matches!(self.data, Data::WaitSend) || self.transfer != Transfer::Write {
            return;
        }
        let length = Self::block_bytes(file);
        let began_ns = context.now().0 + self.clocks(START_CLOCKS, file);
        let mut outgoing =
            Outgoing { bytes: Vec::with_capacity(length as usize), length, began_ns, went: 0, event: None };
        if Self::dma(file) {
            for _ in 0..outgoing.words() {
                let Some(address) = self.next_dma_address(file) else {
                    self.fail(flag::IDMATE);
                    return;
                };
                // The fetched words come back in order and fill the block.
                context.read_from(address, Width::W32, idma::FETCH);
            }
            outgoing.went = outgoing.words();
        } else if self.fifo.is_empty() {
            return;
        }
        outgoing.event = Some(self.schedule_next(&outgoing, file, context));
        self.data = Data::Send(outgoing);
    }

    /// Schedules the next word in the shift register; after the last word, the end of the card's status.
    fn schedule_next(&self, outgoing: &Outgoing, file: &RegisterFile, context: &mut DeviceContext<'_>) -> EventId {
        let lines = Self::lines(file);
        let clocks = if outgoing.went < outgoing.words() {
            outgoing.went * 32 / lines
        } else {
            outgoing.length * 8 / lines + END_CLOCKS
        };
        context.schedule(VirtualNanos(outgoing.began_ns + self.clocks(clocks, file)))
    }

    pub(super) fn send(
        &mut self,
        event: EventId,
        mut outgoing: Outgoing,
        file: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if outgoing.event != Some(event) {
            self.data = Data::Send(outgoing);
        } else if outgoing.went == outgoing.words() {
            self.end_of_sending(outgoing, file, context);
        } else if let Some(word) = self.fifo.pop_front() {
            outgoing.fetched(word);
            outgoing.went += 1;
            outgoing.event = Some(self.schedule_next(&outgoing, file, context));
            self.data = Data::Send(outgoing);
        } else if Self::flow_control(file) {
            // The clock stands still until there is a word.
            outgoing.event = None;
            self.data = Data::Send(outgoing);
        } else {
            self.fail(flag::TXUNDERR);
        }
    }

    /// Follows a word written by firmware.
    pub(super) fn word_in_fifo(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.follow_send(file, context);
        let due_clocks = match &self.data {
            Data::Send(Outgoing { event: None, went, .. }) => went * 32 / Self::lines(file),
            _ => return,
        };
        let due_ns = self.clocks(due_clocks, file);
        if let Data::Send(outgoing) = &mut self.data {
            outgoing.began_ns = context.now().0.saturating_sub(due_ns);
            outgoing.event = Some(context.schedule(context.now()));
        }
    }

    fn end_of_sending(&mut self, mut outgoing: Outgoing, file: &RegisterFile, context: &mut DeviceContext<'_>) {
        outgoing.bytes.truncate(outgoing.length as usize);
        let whole = outgoing.bytes.len() as u64 == outgoing.length && self.arrives_intact(file);
        let now_ns = context.now().0;
        let taken = whole && self.card.as_mut().is_some_and(|card| card.write(now_ns, &outgoing.bytes));
        if !taken {
            self.fail(flag::DCRCFAIL);
            return;
        }
        self.remaining = self.remaining.saturating_sub(outgoing.length);
        let ready_ns = self.card.as_ref().map_or(now_ns, SdCard::busy_until_ns);
        let ready = context.schedule(VirtualNanos(ready_ns));
        self.data = Data::Busy { ready, timeout: self.schedule_timeout(file, context) };
    }

    pub(super) fn busy_is_over(
        &mut self,
        event: EventId,
        ready: EventId,
        timeout: EventId,
        file: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if event == ready {
            if self.remaining == 0 {
                self.complete(file);
            } else {
                self.data = Data::WaitSend;
                self.follow_send(file, context);
            }
        } else if event == timeout {
            self.fail(flag::DTIMEOUT);
        } else {
            self.data = Data::Busy { ready, timeout };
        }
    }
}
