//! The Ethernet controller as far as a driver's start-up needs it, RM0399 rev 4 chapter 61 ("ETH"): the
//! software reset of DMA, MTL and MAC, and the station management (MDIO) that reads and writes the PHY's
//! registers.
//!
//! No frame moves: nothing is plugged in, so the PHY finds no link. An image that starts a DMA channel gets a
//! complaint.
//!
//! [`crate::mcu::PrimeMcu`] tells the model the state of other blocks before each access ([`Surroundings`]):
//! whether the PHY's 50 MHz arrive and its management lines are connected, and the rate of HCLK.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32h743::generated::{ethernet_dma as dma, ethernet_mac as mac};
use rigless::time::{EventId, VirtualNanos};

use crate::peripherals::phy::Phy;

/// Software reset, DMAMR.SWR.
const SWR: u64 = 1;
/// Bits DMACTXCR.ST and DMACRXCR.SR: a channel runs.
const START: u64 = 1;
/// Duration of the reset, which ends once it is over in the slowest clock domain ("DMA mode register"): some
/// periods of the 2.5 MHz to which 50 MHz are divided out of reset, when MACCR.FES selects 10 Mbit/s.
const RESET_NS: u64 = 2_000;
/// A management frame: 32 bits of preamble and 32 bits of frame (section "MDIO clause 22 frame structure").
const FRAME_BITS: u64 = 64;
const PREAMBLE_BITS: u64 = 32;
/// Bits of MACMDIOAR: MB starts a frame and clears at its end; C45E; GOC, 1 to write and 3 to read; PSE
/// suppresses the preamble.
const MB: u64 = 1;
const C45E: u64 = 1 << 1;
const PSE: u64 = 1 << 27;
/// Reading of an undriven line: the board pulls MDIO up.
const NOBODY: u64 = 0xFFFF;

/// Conditions outside of the controller's own registers that it depends on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Surroundings {
    /// Whether the PHY's clock reaches the MAC: RMII is selected, PA1 is connected to it and RCC lets all
    /// three clocks through.
    pub clocked: bool,
    /// Whether MDC (PC1) and MDIO (PA2) are connected to the MAC.
    pub managed: bool,
    /// Rate of HCLK, from which MDC is made.
    pub hclk_hz: u64,
}

/// The DMA's registers, with the software reset.
#[derive(Debug, Default)]
pub struct EthernetDma {
    /// Surroundings as of the access under way.
    pub around: Surroundings,
    over: Option<EventId>,
    /// Whether a software reset began, and the MAC's registers still have to be reset.
    pub mac_is_stale: bool,
    /// Whether a software reset began, and the MTL's registers still have to be reset.
    pub mtl_is_stale: bool,
}

impl EthernetDma {
    /// Whether the block is held in its software reset.
    #[must_use]
    pub fn resetting(file: &RegisterFile) -> bool {
        file.get(dma::Register::Dmamr) & SWR != 0
    }

    /// Continues the reset, which ends only while the PHY's clock is there; the clock may come later than the
    /// request.
    fn go_on(&mut self, file: &RegisterFile, context: &mut DeviceContext<'_>) {
        if Self::resetting(file) && self.around.clocked && self.over.is_none() {
            self.over = Some(context.schedule(VirtualNanos(context.now().0 + RESET_NS)));
        }
    }
}

impl Device for EthernetDma {
    type Register = dma::Register;

    fn read(&mut self, _: dma::Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        self.go_on(file, context);
        None
    }

    fn write(&mut self, register: dma::Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        match register {
            dma::Register::Dmamr if value & SWR != 0 => {
                file.reset();
                file.set(dma::Register::Dmamr, SWR);
                (self.mac_is_stale, self.mtl_is_stale) = (true, true);
                if !self.around.clocked {
                    context.tell("DMAMR", "RM0399 ETH_DMAMR: SWR stays set until the PHY's clock is there");
                }
                self.go_on(file, context);
            }
            dma::Register::Dmactxcr | dma::Register::Dmacrxcr if value & START != 0 => {
                context.tell("DMACxCR", "no frame moves: the virtual board has no network");
            }
            _ => {}
        }
    }

    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        if self.over == Some(event) {
            self.over = None;
            file.set(dma::Register::Dmamr, file.get(dma::Register::Dmamr) & !SWR);
        }
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}

/// The MAC's registers, with the station management and the PHY behind it.
#[derive(Debug, Default)]
pub struct EthernetMac {
    /// Surroundings as of the access under way.
    pub around: Surroundings,
    phy: Phy,
    /// Event of the end of the frame on the wire.
    frame: Option<EventId>,
}

/// Dividers from HCLK to MDC, by MACMDIOAR.CR.
const DIVIDERS: [u64; 16] = [42, 62, 16, 26, 102, 124, 42, 42, 4, 6, 8, 10, 12, 14, 16, 18];

impl EthernetMac {
    /// Aborts the frame on the wire, as the software reset does.
    pub const fn abort(&mut self) {
        self.frame = None;
    }

    fn begin(&mut self, address: u64, context: &mut DeviceContext<'_>) {
        let bits = if address & PSE == 0 { FRAME_BITS } else { FRAME_BITS - PREAMBLE_BITS };
        let divider = DIVIDERS[(address >> 8 & 0xF) as usize];
        let time_ns = bits * divider * 1_000_000_000 / self.around.hclk_hz.max(1);
        self.frame = Some(context.schedule(VirtualNanos(context.now().0 + time_ns)));
    }

    /// Ends a frame and carries it out. Frames of clause 45 get no answer: the PHY knows clause 22 alone.
    fn end(&mut self, file: &mut RegisterFile) {
        let address = file.get(mac::Register::Macmdioar);
        let data = file.get(mac::Register::Macmdiodr);
        let phy = (address >> 21 & 0x1F) as u8;
        let register = (address >> 16 & 0x1F) as u8;
        let heard = self.around.managed && address & C45E == 0 && phy == Phy::ADDRESS;
        match address >> 2 & 3 {
            1 if heard => self.phy.write(register, data as u16),
            3 => {
                let read = if heard { u64::from(self.phy.read(register)) } else { NOBODY };
                file.set(mac::Register::Macmdiodr, data & !0xFFFF | read);
            }
            _ => {}
        }
        file.set(mac::Register::Macmdioar, address & !MB);
    }
}

impl Device for EthernetMac {
    type Register = mac::Register;

    fn write(&mut self, register: mac::Register, value: u64, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        match register {
            mac::Register::Macmdioar | mac::Register::Macmdiodr if self.frame.is_some() => {
                context.tell("MACMDIOAR", "RM0399 ETH_MACMDIOAR: not to be written while MB is set");
            }
            mac::Register::Macmdioar if value & MB != 0 => self.begin(value, context),
            _ => {}
        }
    }

    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        if self.frame == Some(event) {
            self.frame = None;
            self.end(file);
        }
    }

    /// Resets the PHY as well, as the part's reset pulls NRST low.
    fn reset(&mut self) {
        *self = Self::default();
    }
}
