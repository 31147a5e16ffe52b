//! The link: what two ends of a cable can do, and what they agree on (IEEE 802.3 clause 28).

/// Speed and duplex of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// 100 Mbit/s, and not 10.
    pub is_fast: bool,
    /// Full duplex, and not half.
    pub is_full: bool,
}

impl Link {
    /// Returns the duration of so many bits, nanoseconds.
    pub(super) const fn bits_ns(is_fast: bool, bits: u64) -> u64 {
        bits * if is_fast { 10 } else { 100 }
    }
}

/// Links by priority, the best first, each with its bit in an advertisement.
const PRIORITY: [(u16, Link); 4] = [
    (1 << 8, Link { is_fast: true, is_full: true }),
    (1 << 7, Link { is_fast: true, is_full: false }),
    (1 << 6, Link { is_fast: false, is_full: true }),
    (1 << 5, Link { is_fast: false, is_full: false }),
];

/// Returns the bit of an advertisement that stands for this link.
pub(super) fn abilities(link: Link) -> u16 {
    PRIORITY.iter().find(|&&(_, each)| each == link).map_or(0, |&(bit, _)| bit)
}

/// The other end of the cable: a switch, a hub or a computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Partner {
    /// Its abilities, as in register 4: bits 8 to 5 are 100 full, 100 half, 10 full, 10 half.
    pub abilities: u16,
    /// Whether it negotiates. Otherwise it has one ability, which is found by listening.
    pub negotiates: bool,
}

impl Default for Partner {
    /// A common switch.
    fn default() -> Self {
        Self { abilities: 0x05E1, negotiates: true }
    }
}

impl Partner {
    /// Creates a partner that is set to this link and does not negotiate.
    #[must_use]
    pub fn forced(link: Link) -> Self {
        Self { abilities: abilities(link), negotiates: false }
    }

    /// Creates a partner that negotiates and can do this alone.
    #[must_use]
    pub fn only(link: Link) -> Self {
        Self { abilities: abilities(link), negotiates: true }
    }

    /// Returns the link with an end that negotiates. Of a partner that does not, only its speed is heard, so
    /// the link is in half duplex at this end (clause 28.2.3.1).
    pub(super) fn link_with(self, advertisement: u16) -> Option<Link> {
        if self.negotiates {
            let both = self.abilities & advertisement;
            return PRIORITY.iter().find(|&&(bit, _)| both & bit != 0).map(|&(_, link)| link);
        }
        let heard = PRIORITY.iter().find(|&&(bit, _)| self.abilities & bit != 0)?.1;
        let half = Link { is_full: false, ..heard };
        (advertisement & abilities(half) != 0).then_some(half)
    }

    /// Returns the link with an end that is set by hand: the speeds have to fit, the duplex is not looked at.
    pub(super) fn link_with_forced(self, own: Link) -> Option<Link> {
        let fits = PRIORITY.iter().any(|&(bit, link)| link.is_fast == own.is_fast && self.abilities & bit != 0);
        fits.then_some(own)
    }
}

/// The cable as the PHY sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cable {
    /// Whether it is in the socket, with a partner that is switched on.
    pub is_plugged: bool,
    /// What hangs at the other end.
    pub partner: Partner,
}
