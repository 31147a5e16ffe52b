//! The board's Ethernet PHY, a LAN8720A (data sheet DS00002165, chapter 4): its registers, with no cable
//! plugged in.

/// Basic control: bits that clear themselves.
const SOFT_RESET: u16 = 1 << 15;
const RESTART: u16 = 1 << 9;
/// Basic control out of reset with MODE = 111: 100 Mbit/s, auto-negotiation.
const CONTROL: u16 = 0x3000;
/// Basic status: 100BASE-TX and 10BASE-T in half and full duplex, can negotiate, has extended registers. Link
/// (bit 2) and negotiation complete (bit 5) are missing without a cable.
const STATUS: u16 = 0x7809;
/// Identifier: Microchip's (SMSC's) OUI, model 15, revision 1.
const IDENTIFIER: [u16; 2] = [0x0007, 0xC0F1];
/// Advertisement out of reset: all four abilities, IEEE 802.3.
const ADVERTISEMENT: u16 = 0x01E1;
/// Link partner's ability: the selector field's default.
const PARTNER: u16 = 0x0001;
/// Special modes: MODE = 111, address 0.
const MODES: u16 = 0x00E0;

/// State of the PHY.
#[derive(Debug)]
pub struct Phy {
    control: u16,
    advertisement: u16,
    mode_control: u16,
    indications: u16,
    interrupt_mask: u16,
}

impl Default for Phy {
    fn default() -> Self {
        Self { control: CONTROL, advertisement: ADVERTISEMENT, mode_control: 0, indications: 0, interrupt_mask: 0 }
    }
}

impl Phy {
    /// Management address of the PHY: PHYAD0 is strapped to ground.
    pub const ADDRESS: u8 = 0;

    /// Reads a register by a management frame.
    #[must_use]
    pub const fn read(&self, register: u8) -> u16 {
        match register {
            0 => self.control,
            1 => STATUS,
            2 => IDENTIFIER[0],
            3 => IDENTIFIER[1],
            4 => self.advertisement,
            5 => PARTNER,
            17 => self.mode_control,
            18 => MODES,
            27 => self.indications,
            30 => self.interrupt_mask,
            // Counters and flags stay zero without a link.
            _ => 0,
        }
    }

    /// Writes a register by a management frame.
    pub fn write(&mut self, register: u8, value: u16) {
        match register {
            // A "Software reset" sets all registers to their defaults but those of the straps.
            0 if value & SOFT_RESET != 0 => *self = Self::default(),
            0 => self.control = value & !RESTART,
            4 => self.advertisement = value,
            17 => self.mode_control = value,
            27 => self.indications = value,
            30 => self.interrupt_mask = value,
            _ => {}
        }
    }
}
