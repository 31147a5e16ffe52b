//! Descriptors of the DMA's rings, RM0399 section 61.10 ("Descriptors"): four words each.

/// Bits of DES3 that both directions share.
pub(super) const OWN: u32 = 1 << 31;
pub(super) const CONTEXT: u32 = 1 << 30;
pub(super) const FIRST: u32 = 1 << 29;
pub(super) const LAST: u32 = 1 << 28;
/// Bytes of a descriptor.
pub(super) const BYTES: u32 = 16;

/// Bits of transmit descriptors.
pub(super) mod transmit {
    /// DES2: interrupt on completion.
    pub(in super::super) const IOC: u32 = 1 << 31;
    /// DES3: TCP segmentation.
    pub(in super::super) const TSE: u32 = 1 << 18;
    /// DES3 on write-back: error summary, jabber.
    pub(in super::super) const ES: u32 = 1 << 15;
    pub(in super::super) const JT: u32 = 1 << 14;
    /// DES3 on write-back: payload checksum error, IP header error.
    pub(in super::super) const PCE: u32 = 1 << 12;
    pub(in super::super) const IHE: u32 = 1;
}

/// Bits of receive descriptors.
pub(super) mod receive {
    /// DES3 as read: interrupt on completion, buffers valid.
    pub(in super::super) const IOC: u32 = 1 << 30;
    pub(in super::super) const BUF2V: u32 = 1 << 25;
    pub(in super::super) const BUF1V: u32 = 1 << 24;
    /// DES3 on write-back: RDES1 valid, RDES0 valid, CRC error, watchdog, receive error, dribble, summary.
    pub(in super::super) const RS1V: u32 = 1 << 26;
    pub(in super::super) const CE: u32 = 1 << 24;
    pub(in super::super) const GP: u32 = 1 << 23;
    pub(in super::super) const RWT: u32 = 1 << 22;
    pub(in super::super) const ES: u32 = 1 << 15;
    /// DES3 on write-back: position of the length and type field, and its values.
    pub(in super::super) const LT: u32 = 16;
    pub(in super::super) const LT_LENGTH: u32 = 0;
    pub(in super::super) const LT_TYPE: u32 = 1;
    pub(in super::super) const LT_ARP: u32 = 3;
    pub(in super::super) const LT_VLAN: u32 = 4;
    pub(in super::super) const LT_CONTROL: u32 = 6;
    /// DES1 on write-back: payload and header errors, kinds of the packet.
    pub(in super::super) const IPCE: u32 = 1 << 7;
    pub(in super::super) const IPCB: u32 = 1 << 6;
    pub(in super::super) const IPV6: u32 = 1 << 5;
    pub(in super::super) const IPV4: u32 = 1 << 4;
    pub(in super::super) const IPHE: u32 = 1 << 3;
    /// DES2 on write-back: destination filter failed, source filter failed, hash matched.
    pub(in super::super) const DAF: u32 = 1 << 17;
    pub(in super::super) const SAF: u32 = 1 << 16;
    pub(in super::super) const HF: u32 = 1 << 18;
}

/// A descriptor while the DMA has it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Descriptor {
    /// Address that it was read from.
    pub(super) address: u32,
    pub(super) words: [u32; 4],
    /// Words that have arrived.
    pub(super) read: usize,
}

impl Descriptor {
    pub(super) fn at(address: u32) -> Self {
        Self { address, ..Self::default() }
    }

    /// Takes the next word. Returns whether it was the last one.
    pub(super) fn take(&mut self, word: u32) -> bool {
        if let Some(place) = self.words.get_mut(self.read) {
            *place = word;
        }
        self.read += 1;
        self.read >= self.words.len()
    }

    pub(super) const fn is_owned(&self) -> bool {
        self.words[3] & OWN != 0
    }

    /// Length of the first buffer of a transmit descriptor, and of the second.
    pub(super) const fn lengths(&self) -> [u32; 2] {
        [self.words[2] & 0x3FFF, self.words[2] >> 16 & 0x3FFF]
    }
}

/// Accesses that move these bytes: address and bytes of each, which is as wide as alignment allows.
pub(super) fn pieces(address: u32, length: u32) -> impl Iterator<Item = (u32, u32)> {
    let (mut at, mut left) = (address, length);
    std::iter::from_fn(move || {
        let width = [8, 4, 2, 1].into_iter().find(|&width| at.is_multiple_of(width) && left >= width)?;
        let piece = (at, width);
        at = at.wrapping_add(width);
        left -= width;
        Some(piece)
    })
}
