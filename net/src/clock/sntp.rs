//! Simple Network Time Protocol (RFC 4330): one request, one reply, and what to believe of it.

/// Bytes of a message without options.
pub const BYTES: usize = 48;
/// Version 4, client.
const CLIENT: u8 = 0x23;
const SERVER: u8 = 4;
/// Seconds from 1900, where the protocol's time begins, to 1970.
const TO_1970: u64 = 2_208_988_800;
/// Seconds of an era: the protocol's seconds begin anew in 2036.
const ERA: u64 = 1 << 32;
/// Earliest time that is believed, in 2025: no board with this firmware is older.
const EARLIEST: u64 = 1_735_689_600;

/// What a reply says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply {
    /// Milliseconds since 1970, when it was sent.
    Time(u64),
    /// The server does not want to be asked, or does not know the time.
    Refused,
    /// Nothing, or nothing that was asked for.
    Foreign,
}

/// Returns a request. Its number stands where the own time would, which is nobody's business.
pub fn request(nonce: u64) -> [u8; BYTES] {
    let mut bytes = [0; BYTES];
    bytes[0] = CLIENT;
    bytes[40..].copy_from_slice(&nonce.to_be_bytes());
    bytes
}

/// Reads a reply to the request of this number.
pub fn read(nonce: u64, bytes: &[u8]) -> Reply {
    let field = |at: usize| {
        let field = bytes.get(at..at + 8).and_then(|field| field.try_into().ok());
        field.map(u64::from_be_bytes)
    };
    let (Some(originate), Some(transmit)) = (field(24), field(40)) else { return Reply::Foreign };
    let (Some(head), Some(stratum)) = (bytes.first(), bytes.get(1)) else { return Reply::Foreign };
    let (leap, version, mode) = (head >> 6, head >> 3 & 7, head & 7);
    if originate != nonce || mode != SERVER || version == 0 {
        return Reply::Foreign;
    }
    // Stratum 0 asks to go away, 16 and a leap of 3 know no time.
    if leap == 3 || !(1..16).contains(stratum) || transmit == 0 {
        return Reply::Refused;
    }
    let (seconds, fraction) = (transmit >> 32, transmit & 0xFFFF_FFFF);
    let since_1900 = if seconds < 1 << 31 { seconds + ERA } else { seconds };
    match since_1900.checked_sub(TO_1970) {
        Some(seconds) if seconds >= EARLIEST => Reply::Time(seconds * 1_000 + ((fraction * 1_000) >> 32)),
        _ => Reply::Refused,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reply(head: u8, stratum: u8, nonce: u64, transmit: u64) -> [u8; BYTES] {
        let mut bytes = [0; BYTES];
        (bytes[0], bytes[1]) = (head, stratum);
        bytes[24..32].copy_from_slice(&nonce.to_be_bytes());
        bytes[40..].copy_from_slice(&transmit.to_be_bytes());
        bytes
    }

    /// 2026-11-29 02:00:00.5 UTC.
    const UNIX: u64 = 1_795_917_600;
    const THEN: u64 = ((UNIX + TO_1970) << 32) + (1 << 31);

    #[test]
    fn a_request_bears_its_number_and_nothing_else() {
        let bytes = request(0x0102_0304_0506_0708);
        assert_eq!((bytes[0], &bytes[40..]), (0x23, &[1, 2, 3, 4, 5, 6, 7, 8][..]));
        assert!(bytes[1..40].iter().all(|byte| *byte == 0));
    }

    #[test]
    fn a_time_is_read() {
        assert_eq!(read(9, &reply(0x24, 2, 9, THEN)), Reply::Time(UNIX * 1_000 + 500));
        let in_2040 = 2_208_988_800_u64;
        let transmit = (in_2040 + TO_1970 - ERA) << 32;
        assert_eq!(read(9, &reply(0x1C, 15, 9, transmit)), Reply::Time(in_2040 * 1_000), "the next era");
    }

    #[test]
    fn what_was_not_asked_for_is_nothing() {
        assert_eq!(read(8, &reply(0x24, 2, 9, THEN)), Reply::Foreign);
        assert_eq!(read(9, &reply(0x23, 2, 9, THEN)), Reply::Foreign, "another client");
        assert_eq!(read(9, &reply(0x24, 2, 9, THEN)[..47]), Reply::Foreign);
        assert_eq!(read(0, &[]), Reply::Foreign);
    }

    #[test]
    fn servers_without_a_time_are_not_believed() {
        assert_eq!(read(9, &reply(0x24, 0, 9, THEN)), Reply::Refused, "go away");
        assert_eq!(read(9, &reply(0x24, 16, 9, THEN)), Reply::Refused);
        assert_eq!(read(9, &reply(0xE4, 2, 9, THEN)), Reply::Refused);
        assert_eq!(read(9, &reply(0x24, 2, 9, 0)), Reply::Refused);
        assert_eq!(read(9, &reply(0x24, 2, 9, (TO_1970 + 9) << 32)), Reply::Refused, "the year 1970");
    }
}
