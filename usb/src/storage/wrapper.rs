//! What a command comes in and its status goes in (BOT section 5).

/// Bytes of a command block wrapper.
pub const COMMAND_BYTES: usize = 31;
/// Bytes of a command status wrapper.
pub const STATUS_BYTES: usize = 13;
const COMMAND_SIGNATURE: [u8; 4] = *b"USBC";
const STATUS_SIGNATURE: [u8; 4] = *b"USBS";

/// A command block wrapper (BOT table 5.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wrapper {
    /// Comes back with the status.
    pub tag: u32,
    /// Bytes of data that the host is ready for.
    pub bytes: u32,
    /// They are to go to the host.
    pub is_to_host: bool,
    /// Which unit; there is only 0.
    pub unit: u8,
    /// The command, zeros behind it.
    pub command: [u8; 16],
}

impl Wrapper {
    /// Reads a packet; `None` for what is not valid (BOT section 6.2.1), nor meaningful by its reserved bits
    /// and its length (section 6.2.2).
    pub fn parse(packet: &[u8]) -> Option<Self> {
        let packet: &[u8; COMMAND_BYTES] = packet.try_into().ok()?;
        let (head, command) = packet.split_first_chunk::<15>()?;
        let &[a, b, c, d, t0, t1, t2, t3, l0, l1, l2, l3, flags, unit, length] = head;
        let is_valid =
            [a, b, c, d] == COMMAND_SIGNATURE && flags & 0x7F == 0 && unit & 0xF0 == 0 && (1..=16).contains(&length);
        is_valid.then_some(Self {
            tag: u32::from_le_bytes([t0, t1, t2, t3]),
            bytes: u32::from_le_bytes([l0, l1, l2, l3]),
            is_to_host: flags & 0x80 != 0,
            unit,
            command: command.try_into().ok()?,
        })
    }
}

/// How a command ended (BOT table 5.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As asked.
    Passed = 0,
    /// Not; the sense data say why.
    Failed = 1,
    /// Host and device do not agree about the data: the host resets the transport.
    PhaseError = 2,
}

/// A command status wrapper (BOT table 5.2). `residue`: bytes that the host was ready for and that were not
/// moved.
pub fn status(tag: u32, residue: u32, outcome: Outcome) -> [u8; STATUS_BYTES] {
    let mut bytes = [0; STATUS_BYTES];
    let parts = STATUS_SIGNATURE.into_iter().chain(tag.to_le_bytes()).chain(residue.to_le_bytes());
    bytes.iter_mut().zip(parts.chain([outcome as u8])).for_each(|(place, byte)| *place = byte);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packet() -> [u8; COMMAND_BYTES] {
        let mut packet = [0; COMMAND_BYTES];
        packet[..15].copy_from_slice(&[0x55, 0x53, 0x42, 0x43, 1, 2, 3, 4, 36, 0, 0, 0, 0x80, 0, 6]);
        packet[15] = 0x12;
        packet
    }

    #[test]
    fn a_wrapper_is_read() {
        let wrapper = Wrapper::parse(&packet()).unwrap();
        assert_eq!((wrapper.tag, wrapper.bytes, wrapper.is_to_host, wrapper.unit), (0x0403_0201, 36, true, 0));
        assert_eq!(wrapper.command[0], 0x12);
    }

    #[test]
    fn what_is_no_wrapper_is_refused() {
        assert_eq!(Wrapper::parse(&packet()[..30]), None, "too short");
        let mut long = packet().to_vec();
        long.push(0);
        assert_eq!(Wrapper::parse(&long), None, "too long");
        for (place, value) in [(0, 0), (12, 0x81), (13, 0x10), (14, 0), (14, 17)] {
            let mut bad = packet();
            bad[place] = value;
            assert_eq!(Wrapper::parse(&bad), None, "byte {place} = {value}");
        }
    }

    #[test]
    fn a_status_has_tag_and_residue() {
        assert_eq!(status(0x0403_0201, 7, Outcome::Failed), *b"USBS\x01\x02\x03\x04\x07\0\0\0\x01");
    }
}
