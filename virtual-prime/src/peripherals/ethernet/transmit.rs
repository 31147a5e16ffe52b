//! The transmit channel of the DMA and the MAC's transmitter, RM0399 sections 61.9.2 ("DMA operation") and
//! 61.5.2 ("MAC transmission").

use rigless::device::DeviceContext;
use rigless::soc::Width;
use rigless::soc::stm32h743::generated::ethernet_dma::Register;
use rigless::soc::stm32h743::generated::ethernet_mac::Register as MacRegister;

use super::bits::{channel, maccr, status};
use super::channels::{Queued, TransmitState};
use super::checksum::{Inserted, Insertion, frame_check, insert};
use super::descriptor::{self, CONTEXT, Descriptor, FIRST, LAST, OWN, pieces, transmit};
use super::link::Link;
use super::memory::{self, Token};
use super::state::Ethernet;
use super::wire::{CHECK, GAP, PREAMBLE, SHORTEST};

impl Ethernet {
    /// Starts the channel, or stops it after the frame under way: DMACTXCR.ST.
    pub(super) fn set_transmitting(&mut self, runs: bool, context: &mut DeviceContext<'_>) {
        let stopped = matches!(self.transmitter.state, TransmitState::Stopped | TransmitState::Failed);
        if runs && stopped {
            if std::mem::take(&mut self.transmitter.list_is_new) {
                self.transmitter.current = self.dma.get(Register::Dmactxdlar);
            }
            self.transmitter.state = TransmitState::Ready;
            self.run_transmitter(context);
        } else if !runs {
            self.stop_transmitter_if_idle();
        }
    }

    fn stop_transmitter_if_idle(&mut self) {
        let idle = matches!(self.transmitter.state, TransmitState::Ready | TransmitState::Suspended);
        let runs = self.dma.get(Register::Dmactxcr) & channel::START != 0;
        if idle && !runs && self.transmitter.queue.is_empty() && self.transmitter.first.is_none() {
            self.transmitter.state = TransmitState::Stopped;
            self.dma.set_bits(Register::Dmacsr, status::TPS);
        }
    }

    /// Takes a poll demand: a write of the tail pointer.
    pub(super) fn demand_transmit_poll(&mut self, context: &mut DeviceContext<'_>) {
        if matches!(self.transmitter.state, TransmitState::Suspended) {
            self.transmitter.state = TransmitState::Ready;
            self.run_transmitter(context);
        }
    }

    /// Fetches the next descriptor, if the queue takes another frame: a second one with OSF alone.
    pub(super) fn run_transmitter(&mut self, context: &mut DeviceContext<'_>) {
        let control = self.dma.get(Register::Dmactxcr);
        let room = if control & channel::OSF == 0 { 1 } else { 2 };
        let goes_on = control & channel::START != 0 || self.transmitter.first.is_some();
        if !matches!(self.transmitter.state, TransmitState::Ready) || !goes_on || self.transmitter.queue.len() >= room {
            return;
        }
        let address = self.transmitter.current;
        if !memory::reads(address, descriptor::BYTES) {
            self.fail_transmitter(status::AT_DESCRIPTOR | status::IN_READ);
            self.complain("DMACTxDLAR", memory::RING_OUT_OF_REACH, context);
            return;
        }
        self.transmitter.state = TransmitState::Fetching(Descriptor::at(address));
        memory::read_words(address, Token::TransmitDescriptor, context);
    }

    /// Takes words of a descriptor.
    pub(super) fn transmit_descriptor_read(&mut self, value: u64, context: &mut DeviceContext<'_>) {
        let TransmitState::Fetching(fetched) = &mut self.transmitter.state else { return };
        if !fetched.take(value as u32) {
            return;
        }
        let fetched = *fetched;
        let [_, _, _, des3] = fetched.words;
        self.transmitter.state = TransmitState::Ready;
        if !fetched.is_owned() {
            self.transmitter.state = TransmitState::Suspended;
            self.dma.set_bits(Register::Dmacsr, status::TBU);
            self.stop_transmitter_if_idle();
        } else if des3 & CONTEXT != 0 {
            self.close_transmit(fetched, 0, context);
            self.step_transmitter();
            self.run_transmitter(context);
        } else {
            self.load(fetched, context);
        }
    }

    /// Begins to read the buffers of a descriptor.
    fn load(&mut self, fetched: Descriptor, context: &mut DeviceContext<'_>) {
        let [first, second, _, des3] = fetched.words;
        if des3 & FIRST != 0 {
            self.transmitter.frame.clear();
            self.transmitter.first = Some(des3);
        } else if self.transmitter.first.is_none() {
            self.complain("DMACTxDTPR", "RM0399 TDES3: a frame begins with a descriptor without FD", context);
            self.transmitter.frame.clear();
            self.transmitter.first = Some(des3);
        }
        if self.transmitter.first.is_some_and(|des3| des3 & transmit::TSE != 0) {
            self.complain("DMACTxCR", "TCP segmentation (TDES3.TSE) is not modelled", context);
        }
        self.dma.set(Register::Dmaccatxbr, first);
        self.transmitter.state = TransmitState::Loading(fetched);
        for (address, length) in [first, second].into_iter().zip(fetched.lengths()) {
            if length > 0 && !memory::reads(address, length) {
                self.fail_transmitter(status::IN_DATA | status::IN_READ);
                self.complain("DMACTxDTPR", memory::BUFFER_OUT_OF_REACH, context);
                return;
            }
            self.transmitter.reads.extend(pieces(address, length).map(|(_, bytes)| bytes));
            memory::read(address, length, Token::TransmitData, context);
        }
        if self.transmitter.reads.is_empty() {
            self.loaded(fetched, context);
        }
    }

    /// Takes bytes of a buffer.
    pub(super) fn transmit_data_read(&mut self, value: u64, context: &mut DeviceContext<'_>) {
        let TransmitState::Loading(fetched) = self.transmitter.state else { return };
        let Some(bytes) = self.transmitter.reads.pop_front() else { return };
        self.transmitter.frame.extend(&value.to_le_bytes()[..bytes as usize]);
        if self.transmitter.reads.is_empty() {
            self.loaded(fetched, context);
        }
    }

    /// Follows a descriptor whose buffers are read.
    fn loaded(&mut self, fetched: Descriptor, context: &mut DeviceContext<'_>) {
        self.transmitter.state = TransmitState::Ready;
        if fetched.words[3] & LAST == 0 {
            self.close_transmit(fetched, 0, context);
        } else {
            let queued = self.finish(fetched);
            self.transmitter.queue.push_back(queued);
            self.dma.set_bits(Register::Dmacsr, status::ETI);
            self.send(context);
        }
        self.step_transmitter();
        self.run_transmitter(context);
    }

    /// Makes a whole frame out of what was read: checksums, filling, check sequence, by CIC and CPC.
    fn finish(&mut self, last: Descriptor) -> Queued {
        let mut bytes = std::mem::take(&mut self.transmitter.frame);
        let first = self.transmitter.first.take().unwrap_or(0);
        let inserted = insert(&mut bytes, Insertion::of(first));
        let mut is_sound = true;
        match first >> 26 & 3 {
            0 => bytes.resize(bytes.len().max(SHORTEST), 0),
            1 => {}
            control => {
                let check: Vec<u8> = bytes.split_off(bytes.len().saturating_sub(CHECK as usize));
                is_sound = control == 3 || check == frame_check(&bytes).to_le_bytes();
            }
        }
        let mut state = self.status_of(inserted);
        let configuration = self.mac.get(MacRegister::Maccr);
        let longest = if configuration & maccr::JE == 0 { 2_048 } else { 10_240 };
        if configuration & maccr::JD == 0 && bytes.len() + CHECK as usize > longest {
            bytes.truncate(longest);
            is_sound = false;
            state |= transmit::JT | transmit::ES;
        }
        Queued { bytes, is_sound, last, status: state }
    }

    const fn status_of(&self, inserted: Inserted) -> u32 {
        let header = if inserted.header_error { transmit::IHE | transmit::ES } else { 0 };
        let payload = if inserted.payload_error { transmit::PCE | transmit::ES } else { 0 };
        header | payload
    }

    fn step_transmitter(&mut self) {
        let [base, length] = [Register::Dmactxdlar, Register::Dmactxrlr].map(|register| self.dma.get(register));
        self.transmitter.current = memory::after(self.transmitter.current, base, length, self.skip_bytes());
    }

    /// Puts the first frame of the queue on the line, when transmitter and clock are on.
    pub(super) fn send(&mut self, context: &mut DeviceContext<'_>) {
        let configuration = self.mac.get(MacRegister::Maccr);
        let Some(frame) = self.transmitter.queue.front() else { return };
        if self.transmitter.ends_ns.is_some() || configuration & maccr::TE == 0 || !self.is_clocked() {
            return;
        }
        let bits = |octets: u64| Link::bits_ns(configuration & maccr::FES != 0, octets * 8);
        let begins_ns = context.now().0.max(self.transmitter.free_ns);
        let ends_ns = begins_ns + bits(PREAMBLE + frame.bytes.len() as u64 + CHECK);
        self.transmitter.ends_ns = Some(ends_ns);
        self.transmitter.free_ns = ends_ns + bits(GAP);
    }

    /// Follows the last bit of a frame: the line has it, and the descriptor its status.
    pub(super) fn sent(&mut self, context: &mut DeviceContext<'_>) {
        self.transmitter.ends_ns = None;
        if let Some(frame) = self.transmitter.queue.pop_front() {
            self.close_transmit(frame.last, frame.status, context);
            if frame.last.words[2] & transmit::IOC != 0 {
                self.dma.set_bits(Register::Dmacsr, status::TI);
            }
            self.leave(frame.bytes, frame.is_sound, context);
        }
        self.send(context);
        self.run_transmitter(context);
        self.stop_transmitter_if_idle();
    }

    /// Gives a descriptor back.
    fn close_transmit(&mut self, closed: Descriptor, state: u32, context: &mut DeviceContext<'_>) {
        let kept = closed.words[3] & !OWN & (CONTEXT | FIRST | LAST);
        let [_, _, _, des3] = memory::words_of(closed.address);
        context.write_to(u64::from(des3), Width::W32, u64::from(kept | state), Token::Close as u64);
    }

    /// Stops the channel on a bus error.
    pub(super) fn fail_transmitter(&mut self, error: u32) {
        self.transmitter.state = TransmitState::Failed;
        self.transmitter.reads.clear();
        self.transmitter.first = None;
        self.dma.clear_bits(Register::Dmacsr, 7 << status::TEB);
        self.dma.set_bits(Register::Dmacsr, status::FBE | error << status::TEB);
    }
}
