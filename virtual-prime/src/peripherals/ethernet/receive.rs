//! The receive channel of the DMA and the receive queue, RM0399 sections 61.9.2 ("DMA operation"), 61.9.5
//! ("Rx DMA") and 61.5.4 ("MTL reception").

use rigless::device::DeviceContext;
use rigless::soc::Width;
use rigless::soc::stm32h743::generated::ethernet_dma::Register;
use rigless::soc::stm32h743::generated::ethernet_mtl::Register as MtlRegister;

use super::bits::{channel, status};
use super::channels::{Packet, ReceiveState};
use super::descriptor::{self, CONTEXT, Descriptor, FIRST, LAST, OWN, receive};
use super::memory::{self, Token};
use super::state::Ethernet;

/// Bytes of the receive queue: MACHWF1R.RXFIFOSIZE.
const QUEUE: usize = 2_048;
/// Bits of the counters of lost packets, with their overflow bits.
const COUNT: u32 = 0x7FF;
const MFCO: u32 = 1 << 15;
const OVFCNTOVF: u32 = 1 << 11;
/// Time in which a driver that gives descriptors back writes the tail pointer.
const PATIENCE_NS: u64 = 1_000_000;
/// Bit RXOVFIS of MTLQICSR.
const RXOVFIS: u32 = 1 << 16;

impl Ethernet {
    /// Starts the channel, or stops it after the packet under way: DMACRXCR.SR.
    pub(super) fn set_receiving(&mut self, runs: bool, context: &mut DeviceContext<'_>) {
        let stopped = matches!(self.receiver.state, ReceiveState::Stopped | ReceiveState::Failed);
        if runs && stopped {
            if std::mem::take(&mut self.receiver.list_is_new) {
                self.receiver.current = self.dma.get(Register::Dmacrxdlar);
            }
            if self.dma.get(Register::Dmacrxcr) & channel::RPF != 0 {
                self.flush_received();
            }
            self.fetch_receive(context);
        } else if !runs && matches!(self.receiver.state, ReceiveState::Ready(_) | ReceiveState::Suspended) {
            self.receiver.state = ReceiveState::Stopped;
            self.dma.set_bits(Register::Dmacsr, status::RPS);
        }
    }

    /// Drops the packets of the queue: those of a channel that a bus error has stopped, with DMACRXCR.RPF.
    fn flush_received(&mut self) {
        for _ in std::mem::take(&mut self.receiver.queue) {
            self.count_dropped();
        }
        self.receiver.stored = 0;
    }

    fn count_dropped(&mut self) {
        let count = self.dma.get(Register::Dmacmfcr);
        let more = if count & COUNT == COUNT { MFCO } else { 1 };
        self.dma.set(Register::Dmacmfcr, if more == MFCO { count | MFCO } else { count + 1 });
    }

    /// Takes a poll demand: a write of the tail pointer.
    pub(super) fn demand_receive_poll(&mut self, context: &mut DeviceContext<'_>) {
        self.receiver.forgotten_ns = None;
        if matches!(self.receiver.state, ReceiveState::Suspended) {
            self.fetch_receive(context);
        }
    }

    fn fetch_receive(&mut self, context: &mut DeviceContext<'_>) {
        let address = self.receiver.current;
        if !memory::writes(address, descriptor::BYTES) {
            self.fail_receiver(status::AT_DESCRIPTOR | status::IN_READ);
            self.complain("DMACRxDLAR", memory::RING_OUT_OF_REACH, context);
            return;
        }
        self.receiver.state = ReceiveState::Fetching(Descriptor::at(address));
        memory::read_words(address, Token::ReceiveDescriptor, context);
    }

    /// Takes words of a descriptor.
    pub(super) fn receive_descriptor_read(&mut self, value: u64, context: &mut DeviceContext<'_>) {
        let ReceiveState::Fetching(fetched) = &mut self.receiver.state else { return };
        if !fetched.take(value as u32) {
            return;
        }
        let fetched = *fetched;
        if self.dma.get(Register::Dmacrxcr) & channel::START == 0 {
            self.receiver.state = ReceiveState::Stopped;
            self.dma.set_bits(Register::Dmacsr, status::RPS);
        } else if fetched.is_owned() {
            self.receiver.state = ReceiveState::Ready(fetched);
            self.check_receive_descriptor(fetched, context);
            self.run_receiver(context);
        } else {
            self.receiver.state = ReceiveState::Suspended;
            self.dma.set_bits(Register::Dmacsr, status::RBU);
        }
    }

    fn check_receive_descriptor(&mut self, fetched: Descriptor, context: &mut DeviceContext<'_>) {
        let [first, _, _, des3] = fetched.words;
        if des3 & (receive::BUF1V | receive::BUF2V) == 0 {
            self.complain("DMACRxDTPR", "RM0399 RDES3: a descriptor without a valid buffer (BUF1V, BUF2V)", context);
        }
        if des3 & receive::BUF1V != 0 && first == 0 {
            self.complain(
                "DMACRxDTPR",
                "RM0399 RDES0: a descriptor was given back without its buffer's address, which the write-back destroys",
                context,
            );
        }
        if des3 & CONTEXT != 0 && des3 & receive::IOC == 0 {
            self.complain("DMACRxDTPR", "RM0399 RDES3: bit 30 of a descriptor as read is IOC", context);
        }
    }

    /// Takes a packet into the queue, if there is room.
    pub(super) fn queue_packet(&mut self, packet: Packet, context: &mut DeviceContext<'_>) {
        if matches!(self.receiver.state, ReceiveState::Failed) && self.dma.get(Register::Dmacrxcr) & channel::RPF != 0 {
            self.count_dropped();
            return;
        }
        if self.receiver.used() + packet.room() > QUEUE.max(packet.room()) {
            self.wire.counters.overflowed += 1;
            let count = self.mtl.get(MtlRegister::Mtlrxqmpocr);
            let more = if count & COUNT == COUNT { count | OVFCNTOVF } else { count + 1 };
            self.mtl.set(MtlRegister::Mtlrxqmpocr, more);
            self.mtl.set_bits(MtlRegister::Mtlqicsr, RXOVFIS);
        } else {
            self.wire.counters.received += 1;
            self.receiver.queue.push_back(packet);
        }
        if matches!(self.receiver.state, ReceiveState::Suspended) {
            let [.., des3] = memory::words_of(self.receiver.current);
            context.read_from(u64::from(des3), Width::W32, Token::Look as u64);
        }
        self.run_receiver(context);
    }

    /// Follows the look at the descriptor of a suspended channel, as a packet arrives. The channel goes on
    /// with a write of the tail pointer: others have found that it does not without, whatever RM0399 says of
    /// ETH_DMACSR.RBU.
    pub(super) fn receive_descriptor_seen(&mut self, value: u64, context: &mut DeviceContext<'_>) {
        let now_ns = context.now().0;
        if value as u32 & OWN == 0 || !matches!(self.receiver.state, ReceiveState::Suspended) {
            return;
        }
        if now_ns - *self.receiver.forgotten_ns.get_or_insert(now_ns) >= PATIENCE_NS {
            self.complain(
                "DMACRxDTPR",
                "RM0399 ETH_DMACSR.RBU: descriptors were given back, but the tail pointer was not written; the channel stays \
                 suspended",
                context,
            );
        }
    }

    /// Stores the packets of the queue, as far as there are descriptors.
    fn run_receiver(&mut self, context: &mut DeviceContext<'_>) {
        if let ReceiveState::Ready(held) = self.receiver.state
            && let Some(packet) = self.receiver.queue.pop_front()
        {
            self.store(held, packet, context);
        }
    }

    /// Stores a packet, or as much of it as the buffers of a descriptor take.
    fn store(&mut self, held: Descriptor, packet: Packet, context: &mut DeviceContext<'_>) {
        let is_first = self.receiver.stored == 0;
        let Some(ends) = self.store_in_buffers(held, &packet, context) else {
            self.count_dropped();
            return;
        };
        self.receiver.stored = ends;
        let is_last = ends == packet.bytes.len();
        let marks = if is_first { FIRST } else { 0 } | if is_last { LAST | packet.des3 } else { 0 };
        let words =
            [0, if is_last { packet.des1 } else { 0 }, if is_last { packet.des2 } else { 0 }, marks | ends as u32];
        for (address, word) in memory::words_of(held.address).into_iter().zip(words) {
            context.write_to(u64::from(address), Width::W32, u64::from(word), Token::ReceiveClose as u64);
        }
        if is_last {
            self.receiver.stored = 0;
            self.announce(held, context);
        } else {
            if is_first {
                self.dma.set_bits(Register::Dmacsr, status::ERI);
            }
            self.receiver.queue.push_front(packet);
        }
        let [base, length] = [Register::Dmacrxdlar, Register::Dmacrxrlr].map(|register| self.dma.get(register));
        self.receiver.current = memory::after(self.receiver.current, base, length, self.skip_bytes());
        self.fetch_receive(context);
    }

    /// Writes the next bytes of a packet to a descriptor's buffers. Returns the bytes that are stored then;
    /// `None` on a bus error.
    fn store_in_buffers(
        &mut self,
        held: Descriptor,
        packet: &Packet,
        context: &mut DeviceContext<'_>,
    ) -> Option<usize> {
        // The two lowest bits of the size in bytes read as zero.
        let size = (self.dma.get(Register::Dmacrxcr) & channel::RBSZ) >> 1;
        let [first, _, second, des3] = held.words;
        let mut stored = self.receiver.stored;
        for (address, valid) in [(first, receive::BUF1V), (second, receive::BUF2V)] {
            let count = (packet.bytes.len() - stored).min(size as usize);
            if des3 & valid == 0 || count == 0 {
                continue;
            }
            if !memory::writes(address, count as u32) {
                self.fail_receiver(status::IN_DATA);
                self.complain("DMACRxDTPR", memory::BUFFER_OUT_OF_REACH, context);
                return None;
            }
            self.dma.set(Register::Dmaccarxbr, address);
            memory::write(address, &packet.bytes[stored..stored + count], context);
            stored += count;
        }
        if size == 0 {
            self.complain("DMACRxCR", "RM0399 ETH_DMACRXCR: a packet arrived while RBSZ is 0", context);
        }
        Some(stored)
    }

    /// Sets RI for a packet that is stored, at once or by the watchdog (ETH_DMACRXIWTR).
    fn announce(&mut self, held: Descriptor, context: &mut DeviceContext<'_>) {
        let watchdog = u64::from(self.dma.get(Register::Dmacrxiwtr) & 0xFF);
        if held.words[3] & receive::IOC != 0 {
            self.set_received();
        } else if watchdog > 0 && self.receiver.watchdog_ns.is_none() {
            let time_ns = watchdog * 256 * 1_000_000_000 / self.around.hclk_hz.max(1);
            self.receiver.watchdog_ns = Some(context.now().0 + time_ns);
        }
    }

    /// Sets RI, which clears ERI and ends the watchdog.
    pub(super) fn set_received(&mut self) {
        self.receiver.watchdog_ns = None;
        self.dma.clear_bits(Register::Dmacsr, status::ERI);
        self.dma.set_bits(Register::Dmacsr, status::RI);
    }

    /// Stops the channel on a bus error.
    pub(super) fn fail_receiver(&mut self, error: u32) {
        self.receiver.state = ReceiveState::Failed;
        self.receiver.stored = 0;
        self.dma.clear_bits(Register::Dmacsr, 7 << status::REB);
        self.dma.set_bits(Register::Dmacsr, status::FBE | error << status::REB);
    }
}
