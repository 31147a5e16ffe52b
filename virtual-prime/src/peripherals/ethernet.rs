//! The Ethernet controller, RM0399 rev 4 chapter 61 ("ETH"), with its PHY and the cable: MAC, the queues
//! (MTL), DMA with rings of descriptors, station management.
//!
//! | behaviour | where it is written |
//! |---|---|
//! | SWR stays set until the PHY's clock runs | ETH_DMAMR |
//! | a channel starts at its list, and after a stop where it was | ETH_DMACTXCR.ST, ETH_DMACRXCR.SR |
//! | OWN = 0: TBU or RBU and suspended, until the tail pointer is written | ETH_DMACSR; (1) |
//! | the value of the tail pointer does not matter: OWN says where the ring ends | (2) |
//! | write-back destroys RDES0 | 61.10.4 |
//! | an interrupt with IOC alone; NIS and AIS are sticky and gate the line | ETH_DMACSR, ETH_DMACIER |
//! | packets wait in 2 KB of queue while the channel is suspended; then they are lost | ETH_MTLRXQMPOCR |
//! | DMACMFCR counts what is dropped for a bus error | ETH_DMACMFCR |
//! | the DMA does not reach the TCMs: FBE, and the channel stops | table 3; ETH_DMACSR.FBE |
//! | nothing passes while MAC and PHY have different speeds | 61.6.3, RMII |
//! | a frame takes 80 ns a byte and 960 ns of gap at 100 Mbit/s | IEEE 802.3 |
//!
//! (1) RM0399 says that the receive channel also goes on with the next packet; others have seen that it stays
//! suspended, and so it does here, with a complaint. (2) Drivers that are in use write the next descriptor,
//! the last one, or the start of the list.
//!
//! Left out: collisions and half duplex but for a complaint, flow control, VLAN, time stamps, segmentation,
//! low power, wake-up, ARP offload, filters of layers 3 and 4, threshold mode of the queues (both store and
//! forward).
//!
//! [`crate::mcu::PrimeMcu`] tells the model the state of other blocks before each access ([`Surroundings`]).
//! All three blocks are one model: [`Place`] says which of them is called.

use rigless::device::{DeviceContext, ErasedDevice, RegisterFile, RequestChange};
use rigless::soc::stm32h743::generated::{
    ethernet_dma as dma_table, ethernet_mac as mac_table, ethernet_mtl as mtl_table,
};
use rigless::soc::{Layout, RegisterSpec};
use rigless::time::{EventId, VirtualNanos};

mod bits;
mod block;
mod channels;
mod checksum;
mod descriptor;
mod dma;
mod filter;
mod link;
mod mac;
mod mdio;
mod memory;
mod mmc;
mod phy;
mod receive;
mod state;
mod transmit;
mod wire;

#[cfg(test)]
mod tests;

pub use link::{Cable, Link, Partner};
pub use state::{Ethernet, Place, Surroundings};
pub use wire::{Counters, Sent, Wire};

use bits::{queue, status};
use channels::{ReceiveState, TransmitState};
use memory::Token;

impl Ethernet {
    /// Sets the place at which the next call comes in.
    pub const fn face(&mut self, place: Place) -> &mut Self {
        self.place = place;
        self
    }

    /// Sets the controller's surroundings.
    pub const fn look_around(&mut self, around: Surroundings) {
        self.around = around;
    }

    /// Returns the cable and its far end.
    #[must_use]
    pub const fn wire(&self) -> &Wire {
        &self.wire
    }

    /// Runs `work` with the cable and its far end at this instant.
    pub fn with_wire<R>(&mut self, context: &mut DeviceContext<'_>, work: impl FnOnce(&mut Wire) -> R) -> R {
        let done = work(&mut self.wire);
        self.follow(context);
        done
    }

    /// Schedules events again after a reset of the part, which has dropped them and reset the PHY.
    pub fn restarted(&mut self, context: &mut DeviceContext<'_>) {
        self.due = None;
        self.phy.reset(context.now().0);
        self.follow(context);
    }

    /// Carries out what is due, drives the interrupt, and schedules the next event.
    fn follow(&mut self, context: &mut DeviceContext<'_>) {
        let now_ns = context.now().0;
        let is_due = |at: Option<u64>| at.is_some_and(|at| at <= now_ns);
        self.continue_reset(now_ns);
        if is_due(self.reset_over) {
            self.end_reset();
        }
        if is_due(self.frame_over) {
            self.end_management_frame(now_ns);
        }
        self.phy.follow(self.wire.cable(), now_ns);
        if is_due(self.transmitter.ends_ns) {
            self.sent(context);
        }
        if is_due(self.receiver.watchdog_ns) {
            self.set_received();
        }
        if let Some(frame) = self.wire.arrive(now_ns) {
            self.take_from_line(&frame, context);
        }
        self.wire.begin(now_ns, self.phy.link());
        if !self.is_resetting() {
            self.send(context);
        }
        self.drive_interrupt(context);
        let next = self.next_event();
        if let Some(at) = next.filter(|_| next != self.due) {
            context.schedule(VirtualNanos(at.max(now_ns)));
        }
        self.due = next;
    }

    /// Whether a channel is in the middle of a descriptor or a buffer: more answers come at this instant.
    const fn is_reading(&self) -> bool {
        matches!(self.transmitter.state, TransmitState::Fetching(_) | TransmitState::Loading(_))
            || matches!(self.receiver.state, ReceiveState::Fetching(_))
    }

    fn next_event(&self) -> Option<u64> {
        let list = [
            self.reset_over,
            self.frame_over,
            self.phy.due(),
            self.transmitter.ends_ns,
            self.receiver.watchdog_ns,
            self.wire.due(),
        ];
        list.into_iter().flatten().min()
    }

    fn read_register(&mut self, row: usize) -> u32 {
        match self.place {
            Place::Mac => mac_table::Register::from_index(row).map_or(0, |register| self.read_mac(register)),
            Place::Mtl => mtl_table::Register::from_index(row).map_or(0, |register| match register {
                register if Self::is_cleared(register) => self.mtl.take(register),
                other => self.peek_mtl(other),
            }),
            Place::Dma => dma_table::Register::from_index(row).map_or(0, |register| self.read_dma(register)),
        }
    }

    /// Whether a register of the queues is cleared by a read.
    const fn is_cleared(register: mtl_table::Register) -> bool {
        matches!(register, mtl_table::Register::Mtlrxqmpocr | mtl_table::Register::Mtltxqur)
    }

    /// Returns a register of the queues: of the debug registers, whether they are empty.
    fn peek_mtl(&self, register: mtl_table::Register) -> u32 {
        match register {
            mtl_table::Register::Mtltxqdr => u32::from(self.transmitter.queued() > 0) << 4,
            mtl_table::Register::Mtlrxqdr => u32::from(self.receiver.holds_packets()) << 4,
            other => self.mtl.get(other),
        }
    }

    fn write_mtl(&mut self, register: mtl_table::Register, value: u32) {
        /// Flags of MTLQICSR, which are cleared by writing ones.
        const FLAGS: u32 = 1 | 1 << 16;
        let flags = self.mtl.get(mtl_table::Register::Mtlqicsr) & FLAGS;
        self.mtl.write(register, value);
        match register {
            mtl_table::Register::Mtltxqomr if value & queue::FTQ != 0 => {
                self.transmitter.flush();
                self.mtl.clear_bits(register, queue::FTQ);
            }
            mtl_table::Register::Mtlqicsr => {
                self.mtl.clear_bits(register, FLAGS);
                self.mtl.set_bits(register, flags & !value);
            }
            _ => {}
        }
    }
}

impl ErasedDevice for Ethernet {
    fn layout(&self) -> &'static [RegisterSpec] {
        match self.place {
            Place::Mac => mac_table::Register::REGISTERS,
            Place::Mtl => mtl_table::Register::REGISTERS,
            Place::Dma => dma_table::Register::REGISTERS,
        }
    }

    fn read(&mut self, row: usize, _: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        self.follow(context);
        let value = self.read_register(row);
        self.follow(context);
        Some(u64::from(value))
    }

    fn peek(&self, row: usize, _: &RegisterFile, _: VirtualNanos) -> Option<u64> {
        let value = match self.place {
            Place::Mac => mac_table::Register::from_index(row).map(|register| self.peek_mac(register)),
            Place::Mtl => mtl_table::Register::from_index(row).map(|register| self.peek_mtl(register)),
            Place::Dma => dma_table::Register::from_index(row).map(|register| self.peek_dma(register)),
        };
        value.map(u64::from)
    }

    /// Whether a read changes nothing: true but for the registers that a read clears, and the reset that
    /// waits for a clock.
    fn steady(&self, row: usize, _: &RegisterFile) -> bool {
        match self.place {
            Place::Mac => mac_table::Register::from_index(row).is_some_and(|register| !Self::is_counter(register)),
            Place::Mtl => mtl_table::Register::from_index(row).is_some_and(|register| !Self::is_cleared(register)),
            Place::Dma => row != dma_table::Register::Dmacmfcr.index() && (!self.is_resetting() || self.is_clocked()),
        }
    }

    /// Takes a write. While SWR is set all registers are held in reset.
    fn write(&mut self, row: usize, value: u64, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let value = value as u32;
        self.follow(context);
        match self.place {
            _ if self.is_resetting() => {}
            Place::Mac => {
                if let Some(register) = mac_table::Register::from_index(row) {
                    self.write_mac(register, value, context);
                }
            }
            Place::Mtl => {
                if let Some(register) = mtl_table::Register::from_index(row) {
                    self.write_mtl(register, value);
                }
            }
            Place::Dma => {
                if let Some(register) = dma_table::Register::from_index(row) {
                    self.write_dma(register, value, context);
                }
            }
        }
        self.follow(context);
    }

    fn on_event(&mut self, _: EventId, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.due = None;
        self.follow(context);
    }

    fn on_request(&mut self, _: RequestChange, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn hears(&self, _: &'static str, _: usize) -> bool {
        false
    }

    fn on_clock(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn poll(&mut self, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    /// Resets the controller with the part, whose reset pulls the PHY's NRST low as well.
    fn reset(&mut self) {
        self.reset_blocks();
        self.raised = false;
        self.is_handing_over = false;
        self.due = None;
    }

    /// Resets the controller by RCC. The PHY notices nothing.
    fn reset_line(&mut self, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.reset();
        self.follow(context);
    }

    fn on_access(&mut self, token: u64, value: u64, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        match Token::of(token) {
            Some(Token::TransmitDescriptor) => self.transmit_descriptor_read(value, context),
            Some(Token::TransmitData) => self.transmit_data_read(value, context),
            Some(Token::ReceiveDescriptor) => self.receive_descriptor_read(value, context),
            Some(Token::Look) => self.receive_descriptor_seen(value, context),
            Some(Token::Interrupt) => self.is_handing_over = false,
            Some(Token::Close | Token::ReceiveData | Token::ReceiveClose) | None => return,
        }
        if !self.is_reading() {
            self.follow(context);
        }
    }

    /// Handles an access of the DMA to an address that does not answer: a fatal bus error.
    fn on_refused(&mut self, token: u64, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        match Token::of(token) {
            Some(Token::TransmitDescriptor) => self.fail_transmitter(status::AT_DESCRIPTOR | status::IN_READ),
            Some(Token::TransmitData) => self.fail_transmitter(status::IN_DATA | status::IN_READ),
            Some(Token::Close) => self.fail_transmitter(status::AT_DESCRIPTOR),
            Some(Token::ReceiveDescriptor | Token::Look) => {
                self.fail_receiver(status::AT_DESCRIPTOR | status::IN_READ);
            }
            Some(Token::ReceiveData) => self.fail_receiver(status::IN_DATA),
            Some(Token::ReceiveClose) => self.fail_receiver(status::AT_DESCRIPTOR),
            Some(Token::Interrupt) => {
                self.is_handing_over = false;
                return;
            }
            None => return,
        }
        self.follow(context);
    }
}
