//! Line coding of a serial port. These ports have no real rate or parity; a host only reads back its own
//! setting.

/// Line coding as sent over the bus (PSTN 1.2, table 17): bits a second in four bytes, stop bits, parity,
/// bits of data.
pub type LineCoding = [u8; 7];

/// Default, as the debug UART: 115200 baud, one stop bit, no parity, 8 bits.
pub const DEFAULT: LineCoding = [0x00, 0xC2, 0x01, 0x00, 0, 0, 8];

/// Parses a host's setting; `None` for an invalid line coding.
pub fn parse(bytes: &[u8]) -> Option<LineCoding> {
    let coding: LineCoding = *bytes.first_chunk()?;
    matches!(coding, [.., 0..=2, 0..=4, 5..=8 | 16]).then_some(coding)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_no_line_coding() {
        assert_eq!(parse(&DEFAULT), Some(DEFAULT));
        for (place, value) in [(4, 3), (5, 5), (6, 4), (6, 9)] {
            let mut bad = DEFAULT;
            bad[place] = value;
            assert_eq!(parse(&bad), None, "byte {place} = {value}");
        }
        assert_eq!(parse(&DEFAULT[..6]), None);
    }
}
