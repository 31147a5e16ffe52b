//! Station management: frames on MDC and MDIO to the PHY's registers, RM0399 section 61.5.7 ("Station
//! management agent").

use rigless::device::DeviceContext;
use rigless::soc::stm32h743::generated::ethernet_mac::Register;

use super::phy::Phy;
use super::state::Ethernet;

/// A management frame: 32 bits of preamble and 32 bits of frame (section "MDIO clause 22 frame structure").
const FRAME_BITS: u64 = 64;
const PREAMBLE_BITS: u64 = 32;
/// Bits of MACMDIOAR: MB starts a frame and clears at its end; C45E; GOC, 1 to write and 3 to read; PSE
/// suppresses the preamble.
const MB: u32 = 1;
const C45E: u32 = 1 << 1;
const PSE: u32 = 1 << 27;
/// Fastest MDC of the PHY: a period of 400 ns (LAN8720A data sheet, section 3.5).
const FASTEST_HZ: u64 = 2_500_000;
const TOO_FAST: &str = "LAN8720A section 3.5: MDC is above 2.5 MHz, by MACMDIOAR.CR and HCLK";
/// Reading of an undriven line: the board pulls MDIO up.
const NOBODY: u32 = 0xFFFF;
/// Dividers from HCLK to MDC, by MACMDIOAR.CR.
const DIVIDERS: [u64; 16] = [42, 62, 16, 26, 102, 124, 42, 42, 4, 6, 8, 10, 12, 14, 16, 18];

impl Ethernet {
    /// Follows a write of MACMDIOAR or MACMDIODR.
    pub(super) fn write_management(&mut self, register: Register, value: u32, context: &mut DeviceContext<'_>) {
        if self.frame_over.is_some() {
            context.tell("MACMDIOAR", "RM0399 ETH_MACMDIOAR: not to be written while MB is set");
        } else if matches!(register, Register::Macmdioar) && value & MB != 0 {
            let bits = if value & PSE == 0 { FRAME_BITS } else { FRAME_BITS - PREAMBLE_BITS };
            let divider = DIVIDERS[(value >> 8 & 0xF) as usize];
            if self.around.hclk_hz / divider > FASTEST_HZ {
                self.complain("MACMDIOAR", TOO_FAST, context);
            }
            let time_ns = bits * divider * 1_000_000_000 / self.around.hclk_hz.max(1);
            self.frame_over = Some(context.now().0 + time_ns);
        }
    }

    /// Ends a frame and carries it out. Frames of clause 45 get no answer: the PHY knows clause 22 alone.
    pub(super) fn end_management_frame(&mut self, now_ns: u64) {
        self.frame_over = None;
        let address = self.mac.get(Register::Macmdioar);
        let data = self.mac.get(Register::Macmdiodr);
        let phy = (address >> 21 & 0x1F) as u8;
        let register = (address >> 16 & 0x1F) as u8;
        let heard = self.around.managed && address & C45E == 0 && phy == Phy::ADDRESS && self.wire.has_phy();
        match address >> 2 & 3 {
            1 if heard => self.phy.write(register, data as u16, now_ns),
            3 => {
                let read = if heard { u32::from(self.phy.read(register)) } else { NOBODY };
                self.mac.set(Register::Macmdiodr, data & !0xFFFF | read);
            }
            _ => {}
        }
        self.mac.clear_bits(Register::Macmdioar, MB);
    }
}
