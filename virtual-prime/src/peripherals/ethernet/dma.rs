//! The DMA's registers: channels, status and interrupt, RM0399 sections 61.9.2 ("DMA operation"), 61.9.6
//! ("DMA interrupts") and 61.11.2 ("Ethernet DMA registers"); and its way to memory.

use rigless::device::{DeviceContext, Level};
use rigless::soc::Width;
use rigless::soc::stm32h743::generated::ethernet_dma::Register;

use super::bits::{channel, dmamr, status};
use super::channels::{ReceiveState, TransmitState};
use super::memory::Token;
use super::state::{Ethernet, Place};

/// Duration of the reset, which ends once it is over in the slowest clock domain ("DMA mode register"): some
/// periods of the 2.5 MHz to which 50 MHz are divided out of reset, when MACCR.FES selects 10 Mbit/s.
const RESET_NS: u64 = 2_000;
/// Address of ETH_MACISR, whose model has the interrupt.
const MACISR: u64 = 0x4002_80B0;
/// Debug states of ETH_DMADSR: waiting for a packet, suspended, reading the queue or a buffer.
const WAITS_FOR_PACKET: u32 = 3;
const RECEIVE_SUSPENDED: u32 = 4;
const TRANSMIT_SUSPENDED: u32 = 6;
const WAITS_FOR_STATUS: u32 = 2;

impl Ethernet {
    /// Whether the block is held in its software reset.
    pub(super) fn is_resetting(&self) -> bool {
        self.dma.get(Register::Dmamr) & dmamr::SWR != 0
    }

    /// Continues the reset, which ends only while the PHY's clock is there; the clock may come later than the
    /// request.
    pub(super) fn continue_reset(&mut self, now_ns: u64) {
        if self.is_resetting() && self.is_clocked() && self.reset_over.is_none() {
            self.reset_over = Some(now_ns + RESET_NS);
        }
    }

    pub(super) fn end_reset(&mut self) {
        self.reset_over = None;
        self.dma.clear_bits(Register::Dmamr, dmamr::SWR);
    }

    fn begin_reset(&mut self, context: &mut DeviceContext<'_>) {
        self.reset_blocks();
        self.dma.set(Register::Dmamr, dmamr::SWR);
        if !self.is_clocked() {
            context.tell("DMAMR", "RM0399 ETH_DMAMR: SWR stays set until the PHY's clock is there");
        }
        self.continue_reset(context.now().0);
    }

    /// Returns what a read of a register answers.
    pub(super) fn read_dma(&mut self, register: Register) -> u32 {
        match register {
            Register::Dmacmfcr => self.dma.take(register),
            _ => self.peek_dma(register),
        }
    }

    /// Returns the present value of a register, and changes nothing.
    pub(super) fn peek_dma(&self, register: Register) -> u32 {
        match register {
            Register::Dmaisr => {
                let mac = if self.mac_interrupts() != 0 { 1 << 17 } else { 0 };
                u32::from(self.is_summed_up()) | mac
            }
            Register::Dmadsr => self.receive_state() << 8 | self.transmit_state() << 12,
            Register::Dmaccatxdr => self.transmitter.current,
            Register::Dmaccarxdr => self.receiver.current,
            other => self.dma.get(other),
        }
    }

    fn receive_state(&self) -> u32 {
        match self.receiver.state {
            ReceiveState::Stopped | ReceiveState::Failed => 0,
            ReceiveState::Fetching(_) => 1,
            ReceiveState::Ready(_) => WAITS_FOR_PACKET,
            ReceiveState::Suspended => RECEIVE_SUSPENDED,
        }
    }

    fn transmit_state(&self) -> u32 {
        match self.transmitter.state {
            TransmitState::Stopped | TransmitState::Failed => 0,
            TransmitState::Fetching(_) | TransmitState::Loading(_) => 1,
            TransmitState::Ready => WAITS_FOR_STATUS,
            TransmitState::Suspended => TRANSMIT_SUSPENDED,
        }
    }

    /// Follows a write of a register.
    pub(super) fn write_dma(&mut self, register: Register, value: u32, context: &mut DeviceContext<'_>) {
        let old = self.dma.get(register);
        match register {
            Register::Dmamr if value & dmamr::SWR != 0 => return self.begin_reset(context),
            Register::Dmacsr => return self.clear_status(value),
            _ => {}
        }
        self.watch(register, value, context);
        self.dma.write(register, value);
        let started = (old ^ value) & channel::START != 0;
        let runs = value & channel::START != 0;
        match register {
            Register::Dmactxcr if started => self.set_transmitting(runs, context),
            Register::Dmacrxcr if started => self.set_receiving(runs, context),
            Register::Dmactxdlar => self.transmitter.list_is_new = true,
            Register::Dmacrxdlar => self.receiver.list_is_new = true,
            Register::Dmactxdtpr => self.demand_transmit_poll(context),
            Register::Dmacrxdtpr => self.demand_receive_poll(context),
            _ => {}
        }
    }

    /// Complains of writes to registers of a channel that runs.
    fn watch(&mut self, register: Register, value: u32, context: &mut DeviceContext<'_>) {
        let old = self.dma.get(register);
        let sends = !matches!(self.transmitter.state, TransmitState::Stopped | TransmitState::Failed);
        let receives = !matches!(self.receiver.state, ReceiveState::Stopped | ReceiveState::Failed);
        let written = match register {
            Register::Dmactxdlar if sends => Some("RM0399 ETH_DMACTXDLAR: written while the channel runs"),
            Register::Dmactxrlr if sends => Some("RM0399 ETH_DMACTXRLR: written while the channel runs"),
            Register::Dmacrxdlar if receives => Some("RM0399 ETH_DMACRXDLAR: written while the channel runs"),
            Register::Dmacrxrlr if receives => Some("RM0399 ETH_DMACRXRLR: written while the channel runs"),
            Register::Dmacrxcr if receives && (old ^ value) & channel::RBSZ != 0 => {
                Some("RM0399 ETH_DMACRXCR: RBSZ written while the channel runs")
            }
            Register::Dmaccr if (sends || receives) && old != value => {
                Some("RM0399 ETH_DMACCR: written while a channel runs")
            }
            _ => None,
        };
        if let Some(reason) = written {
            self.complain("DMACxDLAR", reason, context);
        }
        let starts = value & channel::START != 0 && old & channel::START == 0;
        let without_list = match register {
            Register::Dmactxcr => starts && !self.transmitter.list_is_new && self.transmitter.current == 0,
            Register::Dmacrxcr => starts && !self.receiver.list_is_new && self.receiver.current == 0,
            _ => false,
        };
        if without_list {
            self.complain("DMACxDLAR", "RM0399 ETH_DMACxCR: a channel is started before its list is set", context);
        }
    }

    /// Clears flags that are written as ones.
    fn clear_status(&mut self, value: u32) {
        const FLAGS: u32 = status::NORMAL | status::ABNORMAL | status::AIS | status::NIS;
        self.dma.clear_bits(Register::Dmacsr, value & FLAGS);
    }

    /// Sums up the status: NIS and AIS stay once a cause that is enabled has set them.
    pub(super) fn sum_up(&mut self) {
        let causes = self.dma.get(Register::Dmacsr) & self.dma.get(Register::Dmacier);
        if causes & status::NORMAL != 0 {
            self.dma.set_bits(Register::Dmacsr, status::NIS);
        }
        if causes & status::ABNORMAL != 0 {
            self.dma.set_bits(Register::Dmacsr, status::AIS);
        }
    }

    /// Whether a summary is set that DMACIER lets through.
    fn is_summed_up(&self) -> bool {
        self.dma.get(Register::Dmacsr) & self.dma.get(Register::Dmacier) & (status::AIS | status::NIS) != 0
    }

    /// Drives the interrupt. The part's table gives it to the MAC: elsewhere the DMA asks for a read of the
    /// MAC, whose model drives it then, at the same instant.
    pub(super) fn drive_interrupt(&mut self, context: &mut DeviceContext<'_>) {
        self.sum_up();
        let level = self.is_summed_up() || self.mac_interrupts() != 0;
        if level == self.raised {
            return;
        }
        if self.place == Place::Mac {
            self.raised = level;
            context.interrupt(0, Level::from(level));
        } else if !std::mem::replace(&mut self.is_handing_over, true) {
            context.read_from(MACISR, Width::W32, Token::Interrupt as u64);
        }
    }
}
