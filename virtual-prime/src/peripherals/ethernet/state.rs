//! State of the Ethernet controller.

use rigless::device::DeviceContext;
use rigless::soc::stm32h743::generated::{ethernet_dma as dma, ethernet_mac as mac, ethernet_mtl as mtl};

use super::block::Block;
use super::channels::{Receiver, Transmitter};
use super::phy::Phy;
use super::wire::Wire;

/// Conditions outside of the controller's own registers that it depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Surroundings {
    /// Whether the PHY's clock reaches the MAC: RMII is selected, PA1 is connected to it and RCC lets all
    /// three clocks through.
    pub clocked: bool,
    /// Whether MDC (PC1) and MDIO (PA2) are connected to the MAC.
    pub managed: bool,
    /// Whether the lines of received data (PA7, PC4, PC5) are connected to the MAC.
    pub hears: bool,
    /// Whether the lines of data to be sent (PG11 to PG13) are connected to the MAC.
    pub speaks: bool,
    /// Whether the same lines are driven faster than at low speed (OSPEEDR).
    pub speaks_fast: bool,
    /// Rate of HCLK, from which MDC is made.
    pub hclk_hz: u64,
}

/// Block of registers that is being called, of the controller's three.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// The MAC, which has the interrupt.
    #[default]
    Mac,
    /// The queues between MAC and DMA.
    Mtl,
    /// The DMA.
    Dma,
}

/// The controller with the PHY and the cable.
#[derive(Debug, Default)]
pub struct Ethernet {
    pub(super) place: Place,
    pub(super) around: Surroundings,
    pub(super) mac: Block<mac::Register>,
    pub(super) mtl: Block<mtl::Register>,
    pub(super) dma: Block<dma::Register>,
    /// Instant at which the software reset ends, once the PHY's clock is there.
    pub(super) reset_over: Option<u64>,
    /// Instant at which the management frame ends.
    pub(super) frame_over: Option<u64>,
    /// Station address that the filter has, which takes over the registers at a write of the low one.
    pub(super) station: [u8; 6],
    pub(super) transmitter: Transmitter,
    pub(super) receiver: Receiver,
    pub(super) phy: Phy,
    pub(super) wire: Wire,
    /// Level of the interrupt.
    pub(super) raised: bool,
    /// Whether the DMA has asked for the read that drives the interrupt.
    pub(super) is_handing_over: bool,
    /// Instant of the next event that was scheduled.
    pub(super) due: Option<u64>,
    /// Complaints that were made: each is made once.
    told: Vec<&'static str>,
}

impl Ethernet {
    /// Creates the controller out of reset, without a cable.
    #[must_use]
    pub fn new() -> Self {
        let mut ethernet = Self::default();
        ethernet.reset_blocks();
        ethernet
    }

    /// Tells a reason for complaint, once.
    pub(super) fn complain(&mut self, register: &'static str, reason: &'static str, context: &mut DeviceContext<'_>) {
        if !self.told.contains(&reason) {
            self.told.push(reason);
            context.tell(register, reason);
        }
    }

    /// Whether the PHY's clock runs the MAC.
    pub(super) const fn is_clocked(&self) -> bool {
        self.around.clocked && self.wire.has_clock()
    }

    /// Resets the registers of all three blocks and what goes on behind them. PHY and cable notice nothing.
    pub(super) fn reset_blocks(&mut self) {
        self.mac.reset();
        self.mtl.reset();
        self.dma.reset();
        self.reset_over = None;
        self.frame_over = None;
        self.station = [0xFF; 6];
        self.transmitter = Transmitter::default();
        self.receiver = Receiver::default();
    }

    /// Returns the bytes between two descriptors: DMACCR.DSL, in words.
    pub(super) fn skip_bytes(&self) -> u32 {
        (self.dma.get(dma::Register::Dmaccr) >> 18 & 7) * 4
    }
}
