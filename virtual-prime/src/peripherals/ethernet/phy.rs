//! The board's Ethernet PHY, a LAN8720A (data sheet DS00002165, chapters 3 and 4): its registers, the link
//! and its negotiation.
//!
//! The cable and what hangs at its other end come from [`super::wire`]. A link comes up some time after the
//! cable, the end of a reset or a restart of the negotiation; it goes at once.

use super::link::{Cable, Link, abilities};

/// Basic control: bits.
const SOFT_RESET: u16 = 1 << 15;
const LOOPBACK: u16 = 1 << 14;
const SPEED_100: u16 = 1 << 13;
const NEGOTIATES: u16 = 1 << 12;
const POWER_DOWN: u16 = 1 << 11;
const ISOLATE: u16 = 1 << 10;
const RESTART: u16 = 1 << 9;
const FULL_DUPLEX: u16 = 1 << 8;
/// Basic control: bits 7 to 0 are reserved.
const CONTROL_MASK: u16 = 0x7D00;
/// Basic control out of reset with MODE = 111: 100 Mbit/s, auto-negotiation.
const CONTROL: u16 = 0x3000;
/// Basic status: 100BASE-TX and 10BASE-T in half and full duplex, can negotiate, has extended registers.
const STATUS: u16 = 0x7809;
const STATUS_DONE: u16 = 1 << 5;
const STATUS_LINK: u16 = 1 << 2;
/// Identifier: Microchip's (SMSC's) OUI, model 15, revision 1.
const IDENTIFIER: [u16; 2] = [0x0007, 0xC0F1];
/// Advertisement out of reset: all four abilities, IEEE 802.3.
const ADVERTISEMENT: u16 = 0x01E1;
/// Link partner's ability: the selector field's default.
const PARTNER: u16 = 0x0001;
/// Link partner has acknowledged our page.
const ACKNOWLEDGED: u16 = 1 << 14;
/// Expansion: the partner can negotiate, a page was received, parallel detection found two technologies.
const PARTNER_NEGOTIATES: u16 = 1;
const PAGE_RECEIVED: u16 = 1 << 1;
/// Mode control: energy on the line.
const ENERGYON: u16 = 1 << 1;
/// Special modes: MODE = 111, address 0.
const MODES: u16 = 0x00E0;
/// Interrupt sources.
const INT_ENERGYON: u16 = 1 << 7;
const INT_DONE: u16 = 1 << 6;
const INT_DOWN: u16 = 1 << 4;
const INT_ACKNOWLEDGED: u16 = 1 << 3;
const INT_PAGE: u16 = 1 << 1;
/// Special control and status: base value, negotiation done.
const SPECIAL: u16 = 0x0040;
const AUTODONE: u16 = 1 << 12;
/// Duration of a negotiation: from 1.5 s to 3 s, another one each time.
const NEGOTIATION_NS: u64 = 1_500_000_000;
const NEGOTIATION_SPREAD_NS: u64 = 1_500_000_000;
/// Time to a link whose speed is set by hand: some pulses of the partner.
const FORCED_NS: u64 = 300_000_000;

/// State of the PHY.
#[derive(Debug)]
pub struct Phy {
    control: u16,
    advertisement: u16,
    mode_control: u16,
    indications: u16,
    interrupt_mask: u16,
    sources: u16,
    page_received: bool,
    /// Link has been down since register 1 was last read.
    was_down: bool,
    cable: Cable,
    link: Option<Link>,
    /// Instant at which the link comes up.
    up_ns: Option<u64>,
    /// Negotiations so far, of which each takes another time.
    negotiations: u64,
}

impl Default for Phy {
    fn default() -> Self {
        Self {
            control: CONTROL,
            advertisement: ADVERTISEMENT,
            mode_control: 0,
            indications: 0,
            interrupt_mask: 0,
            sources: 0,
            page_received: false,
            was_down: true,
            cable: Cable::default(),
            link: None,
            up_ns: None,
            negotiations: 0,
        }
    }
}

impl Phy {
    /// Management address of the PHY: PHYAD0 is strapped to ground.
    pub const ADDRESS: u8 = 0;

    /// Returns the link as the PHY has it now.
    pub(super) const fn link(&self) -> Option<Link> {
        self.link
    }

    /// Whether frames pass between the MAC and the line: neither isolated nor powered down.
    pub(super) const fn passes(&self) -> bool {
        self.control & (ISOLATE | POWER_DOWN | LOOPBACK) == 0
    }

    /// Whether the PHY sends the MAC's frames back.
    pub(super) const fn loops_back(&self) -> bool {
        self.control & LOOPBACK != 0
    }

    /// Returns the speed of the MAC's side: the link's, or the one that is set.
    pub(super) fn is_fast(&self) -> bool {
        self.link.map_or(self.control & SPEED_100 != 0, |link| link.is_fast)
    }

    /// Returns the instant at which the link comes up.
    pub(super) const fn due(&self) -> Option<u64> {
        self.up_ns
    }

    /// Follows the cable, and a link that is due.
    pub(super) fn follow(&mut self, cable: Cable, now_ns: u64) {
        if cable != self.cable {
            let had_energy = self.has_energy();
            self.cable = cable;
            if self.has_energy() != had_energy {
                self.sources |= INT_ENERGYON;
            }
            self.restart(now_ns);
        }
        if self.up_ns.is_some_and(|at| at <= now_ns) {
            self.up_ns = None;
            self.come_up();
        }
    }

    /// Resets the PHY, by its pin or by its own bit.
    pub(super) fn reset(&mut self, now_ns: u64) {
        let (cable, negotiations, had_link) = (self.cable, self.negotiations, self.link.is_some());
        *self = Self { cable, negotiations, ..Self::default() };
        if had_link {
            self.sources |= INT_DOWN;
        }
        self.restart(now_ns);
    }

    const fn has_energy(&self) -> bool {
        self.cable.is_plugged && self.control & POWER_DOWN == 0
    }

    /// Takes the link down, and begins to find another one.
    fn restart(&mut self, now_ns: u64) {
        if self.link.take().is_some() {
            self.sources |= INT_DOWN;
        }
        self.was_down = true;
        self.up_ns = None;
        if self.has_energy() && self.agree().is_some() {
            let time_ns = if self.control & NEGOTIATES == 0 {
                FORCED_NS
            } else {
                self.negotiations += 1;
                // Steps of 577 ms, which is no part of the span, spread the times over it.
                NEGOTIATION_NS + self.negotiations * 577_000_000 % NEGOTIATION_SPREAD_NS
            };
            self.up_ns = Some(now_ns + time_ns);
        }
    }

    /// Returns the link that both ends agree on.
    fn agree(&self) -> Option<Link> {
        if self.control & NEGOTIATES == 0 {
            let forced = Link { is_fast: self.control & SPEED_100 != 0, is_full: self.control & FULL_DUPLEX != 0 };
            return self.cable.partner.link_with_forced(forced);
        }
        self.cable.partner.link_with(self.advertisement)
    }

    fn come_up(&mut self) {
        self.link = self.agree();
        if self.control & NEGOTIATES != 0 {
            self.sources |= INT_DONE;
            if self.cable.partner.negotiates {
                self.sources |= INT_ACKNOWLEDGED | INT_PAGE;
                self.page_received = true;
            }
        }
    }

    /// Whether a negotiation has ended, with whatever partner.
    const fn is_done(&self) -> bool {
        self.link.is_some() && self.control & NEGOTIATES != 0
    }

    fn read_status(&mut self) -> u16 {
        let is_up = self.link.is_some() && !self.was_down;
        self.was_down = self.link.is_none();
        STATUS | if is_up { STATUS_LINK } else { 0 } | if self.is_done() { STATUS_DONE } else { 0 }
    }

    /// Returns the partner's ability: as it says, or by parallel detection as it sounds.
    fn partner(&self) -> u16 {
        match self.link {
            Some(_) if self.is_done() && self.cable.partner.negotiates => {
                self.cable.partner.abilities | ACKNOWLEDGED | PARTNER
            }
            Some(link) if self.is_done() => abilities(link),
            _ => PARTNER,
        }
    }

    fn read_expansion(&mut self) -> u16 {
        let page = if std::mem::take(&mut self.page_received) { PAGE_RECEIVED } else { 0 };
        let able = self.is_done() && self.cable.partner.negotiates;
        page | if able { PARTNER_NEGOTIATES } else { 0 }
    }

    fn special(&self) -> u16 {
        let speed = self.link.map_or(0, |link| match (link.is_fast, link.is_full) {
            (false, false) => 0b001,
            (true, false) => 0b010,
            (false, true) => 0b101,
            (true, true) => 0b110,
        });
        SPECIAL | speed << 2 | if self.is_done() { AUTODONE } else { 0 }
    }

    /// Reads a register by a management frame.
    pub(super) fn read(&mut self, register: u8) -> u16 {
        match register {
            0 => self.control,
            1 => self.read_status(),
            2 => IDENTIFIER[0],
            3 => IDENTIFIER[1],
            4 => self.advertisement,
            5 => self.partner(),
            6 => self.read_expansion(),
            17 => self.mode_control | if self.has_energy() { ENERGYON } else { 0 },
            18 => MODES,
            27 => self.indications,
            29 => std::mem::take(&mut self.sources),
            30 => self.interrupt_mask,
            31 => self.special(),
            // Counters stay zero.
            _ => 0,
        }
    }

    /// Writes a register by a management frame.
    pub(super) fn write(&mut self, register: u8, value: u16, now_ns: u64) {
        match register {
            // A "Software reset" sets all registers to their defaults but those of the straps.
            0 if value & SOFT_RESET != 0 => self.reset(now_ns),
            0 => {
                let changed = self.control ^ value;
                self.control = value & CONTROL_MASK;
                let by_hand = value & NEGOTIATES == 0 && changed & (SPEED_100 | FULL_DUPLEX) != 0;
                if value & RESTART != 0 || changed & (NEGOTIATES | POWER_DOWN) != 0 || by_hand {
                    self.restart(now_ns);
                }
            }
            4 => self.advertisement = value,
            17 => self.mode_control = value & !ENERGYON,
            27 => self.indications = value,
            30 => self.interrupt_mask = value,
            _ => {}
        }
    }
}
