//! Question for the address of a name, and its answer (RFC 1035).

use core::net::Ipv4Addr;

use crate::names::message::{A, IN, Message, Part, Section, TOP, Writer};
use crate::settings::is_host;

/// Wish that the server asks others.
const RECURSION: u16 = 0x0100;

/// What a message means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    Address(Ipv4Addr),
    /// The server does not know.
    Unknown,
    /// The message answers something else.
    Foreign,
}

/// Writes the question. Returns its length.
pub fn write(id: u16, name: &str, into: &mut [u8]) -> Option<usize> {
    let mut writer = Writer::new(into, id, RECURSION)?;
    let before = writer.len();
    writer.add(Part::Questions, |writer| {
        writer.name(name)?;
        writer.word(A)?;
        writer.word(IN)
    });
    Some(writer.len()).filter(|length| *length > before)
}

/// Reads an answer.
pub fn read(id: u16, name: &str, bytes: &[u8]) -> Answer {
    let Some(message) = Message::new(bytes).filter(|message| message.is_response() && message.id() == id) else {
        return Answer::Foreign;
    };
    if message.questions().next().is_none_or(|question| question.kind != A || !question.name.is(name)) {
        return Answer::Foreign;
    }
    // Where the name is another's alias, the address stands at the other's name.
    let is_address = |kind: u16, class: u16| kind == A && class & !TOP == IN;
    let mut answers = message.records().filter(|record| record.section == Section::Answer);
    let address = answers.find_map(|record| {
        let octets: [u8; 4] = record.data.try_into().ok()?;
        let address = Ipv4Addr::from(octets);
        (is_address(record.kind, record.class) && is_host(address)).then_some(address)
    });
    address.map_or(Answer::Unknown, Answer::Address)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the answer to a question: flags, and records as they stand behind it.
    fn answer(flags: u16, count: u8, records: &[u8]) -> Vec<u8> {
        let mut into = [0; 100];
        let length = write(7, "pool.ntp.org", &mut into).unwrap();
        let mut bytes = [&into[..length], records].concat();
        bytes[2..4].copy_from_slice(&flags.to_be_bytes());
        bytes[7] = count;
        bytes
    }

    const ALIAS: [u8; 14] = [0xC0, 12, 0, 5, 0, 1, 0, 0, 0, 9, 0, 2, 0xC0, 17];
    const ADDRESS: [u8; 16] = [0xC0, 17, 0, 1, 0, 1, 0, 0, 0, 9, 0, 4, 10, 0, 0, 7];

    #[test]
    fn an_address_is_found_behind_an_alias() {
        let bytes = answer(0x8180, 2, &[&ALIAS[..], &ADDRESS].concat());
        let found = Answer::Address(Ipv4Addr::new(10, 0, 0, 7));
        assert_eq!(read(7, "Pool.NTP.org", &bytes), found);
        assert_eq!(read(8, "pool.ntp.org", &bytes), Answer::Foreign);
        assert_eq!(read(7, "other.ntp.org", &bytes), Answer::Foreign);
        assert_eq!(read(7, "pool.ntp.org", &answer(0x0100, 2, &[])), Answer::Foreign, "no answer");
    }

    #[test]
    fn no_address_is_an_answer_too() {
        assert_eq!(read(7, "pool.ntp.org", &answer(0x8183, 0, &[])), Answer::Unknown);
        assert_eq!(read(7, "pool.ntp.org", &answer(0x8180, 1, &ALIAS)), Answer::Unknown);
        let mut nowhere = ADDRESS;
        nowhere[12..].fill(0);
        assert_eq!(read(7, "pool.ntp.org", &answer(0x8180, 1, &nowhere)), Answer::Unknown);
    }

    #[test]
    fn a_name_that_is_none_makes_no_question() {
        assert_eq!(write(7, "a..b", &mut [0; 100]), None);
        assert_eq!(write(7, &"x".repeat(64), &mut [0; 100]), None);
    }
}
