//! Answers of a name server (RFC 1035) and of a time server (RFC 4330).

use std::collections::BTreeMap;
use std::net::Ipv4Addr;

/// Seconds from 1900, where NTP begins, to 1970.
const SINCE_1900: u64 = 2_208_988_800;

/// A name server that knows some names.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Whether it answers at all.
    pub is_off: bool,
    /// Addresses by names in small letters.
    pub known: BTreeMap<String, Ipv4Addr>,
    /// Names that were asked for, oldest first.
    pub asked: Vec<String>,
}

impl Names {
    /// Answers a query: with an address, or that the name does not exist.
    pub fn answer(&mut self, query: &[u8]) -> Option<Vec<u8>> {
        // A query, with one question.
        if query.get(2)? & 0x80 != 0 || query.get(4..6)? != [0, 1] {
            return None;
        }
        let mut labels = Vec::new();
        let mut at = 12;
        loop {
            let length = usize::from(*query.get(at)?);
            at += 1;
            if length == 0 {
                break;
            }
            labels.push(String::from_utf8_lossy(query.get(at..at + length)?).to_lowercase());
            at += length;
        }
        let question = query.get(12..at + 4)?;
        let name = labels.join(".");
        self.asked.push(name.clone());
        let is_address = query.get(at..at + 4)? == [0, 1, 0, 1];
        let found = self.known.get(&name);
        if self.is_off {
            return None;
        }
        let address = found.filter(|_| is_address);
        let code = if found.is_some() { 0 } else { 3 };
        let mut answer = [&query[..2], &[0x81, 0x80 | code, 0, 1, 0, u8::from(address.is_some()), 0, 0, 0, 0]].concat();
        answer.extend(question);
        if let Some(address) = address {
            // The name is that of the question; an address for a minute.
            answer.extend([0xC0, 12, 0, 1, 0, 1, 0, 0, 0, 60, 0, 4]);
            answer.extend(address.octets());
        }
        Some(answer)
    }
}

/// A time server.
#[derive(Clone, Copy, Debug)]
pub struct TimeServer {
    /// Whether it answers at all.
    pub is_off: bool,
    /// Seconds since 1970 at the board's power-on.
    pub epoch_s: u64,
    /// Number of answers.
    pub answered: u32,
}

impl Default for TimeServer {
    /// Begins on 2026-11-29, noon.
    fn default() -> Self {
        Self { is_off: false, epoch_s: 1_795_953_600, answered: 0 }
    }
}

impl TimeServer {
    /// Answers a client at this instant.
    pub fn answer(&mut self, request: &[u8], now_ns: u64) -> Option<Vec<u8>> {
        if self.is_off || request.len() < 48 || request[0] & 7 != 3 {
            return None;
        }
        self.answered += 1;
        let seconds = self.epoch_s + SINCE_1900 + now_ns / 1_000_000_000;
        let fraction = ((now_ns % 1_000_000_000) << 32) / 1_000_000_000;
        let stamp = (seconds << 32 | fraction).to_be_bytes();
        // No warning, the request's version, a server; stratum 1.
        let mut answer = vec![request[0] & 0x38 | 4, 1, request[2], 0xEC];
        answer.resize(12, 0);
        answer.extend(b"LOCL");
        answer.extend(stamp);
        answer.extend(&request[40..48]);
        answer.extend(stamp);
        answer.extend(stamp);
        Some(answer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_addresses_or_do_not_exist() {
        let mut names = Names::default();
        names.known.insert("pool.ntp.org".into(), Ipv4Addr::new(10, 0, 2, 2));
        let query =
            |name: &[u8]| [b"\x12\x34\x01\x00\x00\x01\x00\x00\x00\x00\x00\x00", name, b"\x00\x01\x00\x01"].concat();
        let answer = names.answer(&query(b"\x04pool\x03NTP\x03org\x00")).expect("an answer");
        assert_eq!((&answer[..4], &answer[answer.len() - 4..]), (&b"\x12\x34\x81\x80"[..], &[10, 0, 2, 2][..]));
        let answer = names.answer(&query(b"\x05other\x00")).expect("an answer");
        assert_eq!(answer[3] & 0xF, 3);
        assert_eq!(names.asked, ["pool.ntp.org", "other"]);
    }

    #[test]
    fn the_time_goes_on_with_the_board() {
        let mut server = TimeServer::default();
        let mut request = [0; 48];
        request[0] = 0x23;
        request[40..48].copy_from_slice(&[1, 2, 3, 4, 5, 6, 7, 8]);
        let answer = server.answer(&request, 2_500_000_000).expect("an answer");
        assert_eq!((answer.len(), answer[0], &answer[24..32]), (48, 0x24, &[1, 2, 3, 4, 5, 6, 7, 8][..]));
        let seconds = u32::from_be_bytes([answer[40], answer[41], answer[42], answer[43]]);
        assert_eq!(u64::from(seconds), server.epoch_s + SINCE_1900 + 2);
        assert_eq!(answer[44], 0x80, "half a second");
        assert_eq!(server.answer(&request[..47], 0), None);
    }
}
