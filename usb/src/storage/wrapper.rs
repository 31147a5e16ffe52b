//! Command and status wrappers (BOT section 5).

/// Size of a command block wrapper, bytes.
pub const COMMAND_BYTES: usize = 31;
/// Size of a command status wrapper, bytes.
pub const STATUS_BYTES: usize = 13;
const COMMAND_SIGNATURE: [u8; 4] = *b"USBC";
const STATUS_SIGNATURE: [u8; 4] = *b"USBS";

/// Command block wrapper (BOT table 5.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wrapper {
    /// Tag that the status returns to the host.
    pub tag: u32,
    /// Bytes of data that the host expects to move.
    pub bytes: u32,
    /// Whether data goes to the host.
    pub is_to_host: bool,
    /// Number of the logical unit; only 0 exists.
    pub unit: u8,
    /// SCSI command, padded with zeros.
    pub command: [u8; 16],
}

impl Wrapper {
    /// Parses a packet; `None` for a packet that is not valid (BOT section 6.2.1), or not meaningful by its
    /// reserved bits and its length (section 6.2.2).
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

/// Status of a finished command (BOT table 5.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Command was carried out as requested.
    Passed = 0,
    /// Command failed; the sense data give the reason.
    Failed = 1,
    /// Host and device disagree about the data, so the host must reset the transport.
    PhaseError = 2,
}

/// Returns a command status wrapper (BOT table 5.2). `residue`: bytes that the host expected and that were
/// not moved.
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
