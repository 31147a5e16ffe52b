//! Decoding of the card's registers from bits.

use super::error::{SdError, Unsupported};

/// Capacity class of a card: unit of its addresses and greatest size (PL 6.00 section 3.3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Standard capacity, up to 2 GB: addresses are bytes.
    Sdsc,
    /// High capacity, up to 32 GB: addresses are blocks.
    Sdhc,
    /// Extended capacity, up to 2 TB: addresses are blocks.
    Sdxc,
}

impl Kind {
    /// Returns the name of the class.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sdsc => "SDSC",
            Self::Sdhc => "SDHC",
            Self::Sdxc => "SDXC",
        }
    }
}

/// Identification register of the card, which names the maker (PL 6.00 section 5.2) and differs between two
/// cards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cid(pub [u32; 4]);

impl Cid {
    /// Returns the product name: five characters.
    #[must_use]
    pub fn name(&self) -> [u8; 5] {
        let [first, second, ..] = self.0;
        let [_, _, _, a] = first.to_be_bytes();
        let [b, c, d, e] = second.to_be_bytes();
        [a, b, c, d, e].map(|byte| if byte.is_ascii_graphic() { byte } else { b'?' })
    }

    /// Returns the maker's number.
    #[must_use]
    pub const fn maker(&self) -> u8 {
        (self.0[0] >> 24) as u8
    }
}

/// Properties of an identified card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CardInfo {
    /// Capacity class, which gives the unit of addresses.
    pub kind: Kind,
    /// Number of blocks of 512 bytes that the card reports.
    pub blocks: u32,
    /// The card takes no writes, according to its CSD.
    pub is_protected: bool,
    /// The card has been set to high speed: it may be clocked with 50 MHz.
    pub is_fast: bool,
    /// Identification register of the card.
    pub cid: Cid,
    /// Address that the card gave itself on the bus, in the upper half.
    pub(super) relative_address: u32,
}

impl CardInfo {
    /// The argument that names a block in a data command.
    pub(super) const fn address_of(&self, block: u32) -> u32 {
        match self.kind {
            Kind::Sdsc => block.wrapping_mul(512),
            Kind::Sdhc | Kind::Sdxc => block,
        }
    }

    /// The highest clock of its bus, Hz (PL 6.00 sections 6.6.6 and 6.6.7).
    #[must_use]
    pub const fn highest_hz(&self) -> u32 {
        if self.is_fast { 50_000_000 } else { 25_000_000 }
    }
}

/// Largest SDHC card in blocks: 32 GB (PL 6.00 section 3.3.2).
const LARGEST_SDHC_BLOCKS: u32 = 32 << 21;

/// Bits `high` to `low` of a 128-bit register, as the specification numbers them; at most 32.
pub(super) const fn field(words: [u32; 4], high: u32, low: u32) -> u32 {
    let whole = (words[0] as u128) << 96 | (words[1] as u128) << 64 | (words[2] as u128) << 32 | words[3] as u128;
    ((whole >> low) & ((1 << (high - low + 1)) - 1)) as u32
}

/// Fields of the CSD in use (PL 6.00 section 5.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Csd {
    pub blocks: u32,
    pub is_protected: bool,
    /// The card knows command class 10: CMD6.
    pub can_switch: bool,
}

impl Csd {
    /// Reads capacity, protection and command classes.
    ///
    /// # Errors
    /// [`SdError::Unsupported`] for a card of more than 2 TB, whose CSD has another version.
    pub fn of(words: [u32; 4]) -> Result<Self, SdError> {
        let blocks = match field(words, 127, 126) {
            0 => {
                // Version 1: capacity = (C_SIZE + 1) * 2^(C_SIZE_MULT + 2) * 2^READ_BL_LEN bytes.
                let shift = field(words, 49, 47) + 2 + field(words, 83, 80);
                (field(words, 73, 62) + 1) << shift.saturating_sub(9)
            }
            // Version 2: (C_SIZE + 1) * 512 KiB. The last of them cannot be counted in 32 bits.
            1 => (field(words, 69, 48) + 1).saturating_mul(1024),
            _ => return Err(SdError::Unsupported(Unsupported::TooLarge)),
        };
        // Either of the bits PERM_WRITE_PROTECT and TMP_WRITE_PROTECT protects the card.
        let is_protected = field(words, 13, 12) != 0;
        Ok(Self { blocks, is_protected, can_switch: field(words, 95, 84) & 1 << 10 != 0 })
    }

    /// Returns the kind of card, given whether its addresses count blocks.
    pub const fn kind(&self, counts_blocks: bool) -> Kind {
        match (counts_blocks, self.blocks > LARGEST_SDHC_BLOCKS) {
            (false, _) => Kind::Sdsc,
            (true, false) => Kind::Sdhc,
            (true, true) => Kind::Sdxc,
        }
    }
}

/// The first byte of the SCR (PL 6.00 section 5.6): whether the card is of version 1.10 or later, which knows
/// CMD6.
pub(super) const fn scr_knows_switch(scr: &[u8]) -> bool {
    matches!(scr, [first, ..] if *first & 0xF >= 1)
}

/// Returns whether group 1 offers high speed, by the answer of CMD6 (PL 6.00 section 4.3.10.4).
pub(super) fn offers_high_speed(status: &[u8]) -> bool {
    status.get(13).is_some_and(|functions| functions & 1 << 1 != 0)
}

/// Returns whether high speed is set, by the answer of CMD6 after setting it.
pub(super) fn has_high_speed(status: &[u8]) -> bool {
    status.get(16).is_some_and(|set| set & 0xF == 1)
}

/// Card status (PL 6.00 section 4.10.1).
pub(super) mod status {
    pub const WP_VIOLATION: u32 = 1 << 26;
    pub const CARD_IS_LOCKED: u32 = 1 << 25;
    pub const CARD_ECC_FAILED: u32 = 1 << 21;
    pub const OUT_OF_RANGE: u32 = 1 << 31;
    /// Bits that are an error of the command, or of one before it.
    pub const ERRORS: u32 = 0xFDF9_8008;
}

/// Returns the error for the error bits of a status.
pub(super) const fn refusal(command: u8, bits: u32) -> SdError {
    if bits & status::WP_VIOLATION != 0 {
        SdError::Protected
    } else if bits & status::CARD_ECC_FAILED != 0 {
        SdError::Unreadable
    } else if bits & status::OUT_OF_RANGE != 0 {
        SdError::OutOfRange
    } else {
        SdError::Refused(command, bits)
    }
}
