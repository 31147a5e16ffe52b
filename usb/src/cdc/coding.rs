//! What a host sets a serial port to. Nothing here has a rate or a parity; a host reads back what it has set.

/// Stop bits of a word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StopBits {
    /// One.
    #[default]
    One,
    /// One and a half.
    OneAndAHalf,
    /// Two.
    Two,
}

/// Parity of a word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parity {
    /// No parity bit.
    #[default]
    None,
    /// An odd number of ones.
    Odd,
    /// An even number.
    Even,
    /// Always one.
    Mark,
    /// Always zero.
    Space,
}

/// Rate and form of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineCoding {
    /// Bits a second.
    pub rate: u32,
    /// Stop bits.
    pub stop_bits: StopBits,
    /// Parity.
    pub parity: Parity,
    /// Bits of data: 5 to 8, or 16.
    pub data_bits: u8,
}

/// Bytes of a line coding (PSTN 1.2, table 17).
pub const CODING_BYTES: usize = 7;

impl Default for LineCoding {
    /// As the debug UART: 115200 baud, 8 bits, no parity.
    fn default() -> Self {
        Self { rate: 115_200, stop_bits: StopBits::One, parity: Parity::None, data_bits: 8 }
    }
}

impl LineCoding {
    /// Reads what a host sets; `None` for what is no line coding.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let &[a, b, c, d, stop_bits, parity, data_bits] = bytes else { return None };
        let stop_bits = match stop_bits {
            0 => StopBits::One,
            1 => StopBits::OneAndAHalf,
            2 => StopBits::Two,
            _ => return None,
        };
        let parity = match parity {
            0 => Parity::None,
            1 => Parity::Odd,
            2 => Parity::Even,
            3 => Parity::Mark,
            4 => Parity::Space,
            _ => return None,
        };
        let is_known = matches!(data_bits, 5..=8 | 16);
        is_known.then_some(Self { rate: u32::from_le_bytes([a, b, c, d]), stop_bits, parity, data_bits })
    }

    /// What a host reads.
    pub fn bytes(self) -> [u8; CODING_BYTES] {
        let [a, b, c, d] = self.rate.to_le_bytes();
        [a, b, c, d, self.stop_bits as u8, self.parity as u8, self.data_bits]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_understood_reads_back_the_same(bytes in prop::array::uniform7(any::<u8>())) {
            if let Some(coding) = LineCoding::parse(&bytes) {
                prop_assert_eq!(coding.bytes(), bytes);
            }
        }
    }

    #[test]
    fn nonsense_is_no_line_coding() {
        let good = LineCoding::default().bytes();
        assert_eq!(LineCoding::parse(&good), Some(LineCoding::default()));
        for (place, value) in [(4, 3), (5, 5), (6, 4), (6, 9)] {
            let mut bad = good;
            bad[place] = value;
            assert_eq!(LineCoding::parse(&bad), None, "byte {place} = {value}");
        }
        assert_eq!(LineCoding::parse(&good[..6]), None);
    }
}
