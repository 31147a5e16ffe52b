//! Messages of DNS (RFC 1035 section 4), as DNS and mDNS use them: read without trust, written without
//! compression.

use core::iter;

/// Kinds of records.
pub const A: u16 = 1;
/// Pointer to another name.
pub const PTR: u16 = 12;
/// Texts that belong to a service.
pub const TXT: u16 = 16;
/// Host and port of a service (RFC 2782).
pub const SRV: u16 = 33;
/// Kinds of records that a name has (RFC 4034 section 4).
pub const NSEC: u16 = 47;
/// Question for all kinds.
pub const ANY: u16 = 255;
/// The class of the internet.
pub const IN: u16 = 1;
/// Bit of the class: answer to the asker alone, or forget what else is known.
pub const TOP: u16 = 0x8000;

/// Bytes of the header.
const HEADER: usize = 12;
/// Most labels and pointers of a name.
const MOST_PARTS: usize = 64;
/// Top bits of a length that is a pointer.
const POINTER: u8 = 0xC0;

/// Message that came in.
#[derive(Clone, Copy, Debug)]
pub struct Message<'a>(&'a [u8]);

/// Name within a message.
#[derive(Clone, Copy, Debug)]
pub struct Name<'a> {
    message: &'a [u8],
    at: usize,
}

/// Question of a message.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    pub name: Name<'a>,
    pub kind: u16,
    pub class: u16,
}

/// Section that a record stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    Answer,
    Authority,
    Additional,
}

/// Record of a message.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    pub section: Section,
    pub name: Name<'a>,
    pub kind: u16,
    pub class: u16,
    pub ttl: u32,
    pub data: &'a [u8],
    /// Name that the data begin with, where they do.
    pub target: Name<'a>,
}

/// Writes bytes at a place, whole or not at all.
fn put(into: &mut [u8], at: usize, bytes: &[u8]) -> Option<()> {
    let places = into.get_mut(at..at.checked_add(bytes.len())?)?;
    for (place, byte) in places.iter_mut().zip(bytes) {
        *place = *byte;
    }
    Some(())
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    let pair = bytes.get(at..at.checked_add(2)?)?;
    Some(u16::from_be_bytes(pair.try_into().ok()?))
}

impl<'a> Message<'a> {
    /// Reads the header; `None` if there is none.
    pub const fn new(bytes: &'a [u8]) -> Option<Self> {
        if bytes.len() < HEADER { None } else { Some(Self(bytes)) }
    }

    /// Returns the number of the request.
    pub fn id(&self) -> u16 {
        word(self.0, 0).unwrap_or(0)
    }

    fn flags(&self) -> u16 {
        word(self.0, 2).unwrap_or(0)
    }

    /// Returns whether it answers.
    pub fn is_response(&self) -> bool {
        self.flags() & 0x8000 != 0
    }

    /// Returns whether it is a plain question or answer, without an error.
    pub fn is_plain(&self) -> bool {
        self.flags() & 0x780F == 0
    }

    /// Returns whether another message continues it.
    pub fn is_cut(&self) -> bool {
        self.flags() & 0x0200 != 0
    }

    fn count(&self, field: usize) -> u16 {
        word(self.0, 4 + 2 * field).unwrap_or(0)
    }

    /// Returns the questions, up to the first that is malformed.
    pub fn questions(self) -> impl Iterator<Item = Question<'a>> {
        let (mut left, mut at) = (self.count(0), HEADER);
        iter::from_fn(move || {
            left = left.checked_sub(1)?;
            let (question, end) = self.question(at)?;
            at = end;
            Some(question)
        })
    }

    /// Returns the records of all sections, up to the first that is malformed.
    pub fn records(self) -> impl Iterator<Item = Record<'a>> {
        let mut at = Some(HEADER);
        for _ in 0..self.count(0) {
            at = at.and_then(|at| self.question(at)).map(|(_, end)| end);
            if at.is_none() {
                break;
            }
        }
        let sections = [Section::Answer, Section::Authority, Section::Additional];
        let mut counts = [self.count(1), self.count(2), self.count(3)];
        iter::from_fn(move || {
            let (count, section) = counts.iter_mut().zip(sections).find(|(count, _)| **count > 0)?;
            *count -= 1;
            let (record, end) = self.record(at?, section)?;
            at = Some(end);
            Some(record)
        })
    }

    fn question(self, at: usize) -> Option<(Question<'a>, usize)> {
        let name = Name { message: self.0, at };
        let end = name.end()?;
        let question = Question { name, kind: word(self.0, end)?, class: word(self.0, end.checked_add(2)?)? };
        Some((question, end.checked_add(4)?))
    }

    fn record(self, at: usize, section: Section) -> Option<(Record<'a>, usize)> {
        let name = Name { message: self.0, at };
        let end = name.end()?;
        let field = |offset: usize| word(self.0, end.checked_add(offset)?);
        let ttl = u32::from(field(4)?) << 16 | u32::from(field(6)?);
        let from = end.checked_add(10)?;
        let to = from.checked_add(usize::from(field(8)?))?;
        let (kind, class) = (field(0)?, field(2)?);
        let skipped = if kind == SRV { 6 } else { 0 };
        let target = Name { message: self.0, at: from.checked_add(skipped)? };
        let record = Record { section, name, kind, class, ttl, data: self.0.get(from..to)?, target };
        Some((record, to))
    }
}

impl<'a> Name<'a> {
    /// Returns where the name ends in the message.
    fn end(&self) -> Option<usize> {
        let mut at = self.at;
        for _ in 0..MOST_PARTS {
            let length = *self.message.get(at)?;
            match length {
                0 => return at.checked_add(1),
                POINTER.. => return at.checked_add(2),
                1..64 => at = at.checked_add(1 + usize::from(length))?,
                64..POINTER => return None,
            }
        }
        None
    }

    /// Returns the labels, up to the first that is malformed; that is an empty one.
    pub fn labels(self) -> impl Iterator<Item = &'a [u8]> {
        let (mut at, mut left) = (self.at, MOST_PARTS);
        iter::from_fn(move || {
            loop {
                left = left.checked_sub(1)?;
                let Some(length) = self.message.get(at).copied() else { return Some(&[][..]) };
                if length == 0 {
                    return None;
                }
                if length < POINTER {
                    let label = self.message.get(at + 1..at + 1 + usize::from(length)).unwrap_or_default();
                    at += 1 + usize::from(length);
                    return Some(label);
                }
                let Some(pointer) = word(self.message, at) else { return Some(&[][..]) };
                at = usize::from(pointer & 0x3FFF);
            }
        })
    }

    /// Returns whether it is this name, whose labels have points between them; the case of letters does not
    /// matter.
    pub fn is(self, name: &str) -> bool {
        let mut own = self.labels();
        let same = labels_of(name).all(|label| own.next().is_some_and(|own| own.eq_ignore_ascii_case(label)));
        same && own.next().is_none()
    }
}

fn labels_of(name: &str) -> impl Iterator<Item = &[u8]> {
    name.as_bytes().split(|byte| *byte == b'.')
}

/// Message that goes out. Records that do not fit are left out.
#[derive(Debug)]
pub struct Writer<'a> {
    into: &'a mut [u8],
    at: usize,
}

/// Place of the number of records of a section in the header, and of the questions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Questions = 4,
    Answers = 6,
    Authorities = 8,
    Additionals = 10,
}

impl<'a> Writer<'a> {
    /// Begins a message; `None` if not even the header fits.
    pub fn new(into: &'a mut [u8], id: u16, flags: u16) -> Option<Self> {
        let header = into.get_mut(..HEADER)?;
        header.fill(0);
        put(header, 0, &id.to_be_bytes())?;
        put(header, 2, &flags.to_be_bytes())?;
        Some(Self { into, at: HEADER })
    }

    /// Returns the length of the message.
    pub const fn len(&self) -> usize {
        self.at
    }

    /// Writes something whole or not at all, and counts it.
    pub fn add(&mut self, part: Part, write: impl FnOnce(&mut Self) -> Option<()>) {
        let before = self.at;
        if write(self).is_none() {
            self.at = before;
            return;
        }
        if let Some(count) = self.into.get_mut(part as usize + 1) {
            *count = count.saturating_add(1);
        }
    }

    /// Writes bytes as they are.
    pub fn bytes(&mut self, bytes: &[u8]) -> Option<()> {
        put(self.into, self.at, bytes)?;
        self.at += bytes.len();
        Some(())
    }

    /// Writes a number.
    pub fn word(&mut self, word: u16) -> Option<()> {
        self.bytes(&word.to_be_bytes())
    }

    /// Writes a name, whose labels have points between them.
    pub fn name(&mut self, name: &str) -> Option<()> {
        labels_of(name).try_for_each(|label| self.label(label))?;
        self.bytes(&[0])
    }

    /// Writes a name of another message.
    pub fn copy(&mut self, name: Name<'_>) -> Option<()> {
        name.labels().try_for_each(|label| self.label(label))?;
        self.bytes(&[0])
    }

    fn label(&mut self, label: &[u8]) -> Option<()> {
        let length = u8::try_from(label.len()).ok().filter(|length| (1..64).contains(length))?;
        self.bytes(&[length])?;
        self.bytes(label)
    }

    /// Writes the data of a record with its length, behind what precedes them.
    pub fn data(&mut self, write: impl FnOnce(&mut Self) -> Option<()>) -> Option<()> {
        let at = self.at;
        self.word(0)?;
        write(self)?;
        let length = u16::try_from(self.at.checked_sub(at + 2)?).ok()?;
        put(self.into, at, &length.to_be_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn message() -> Vec<u8> {
        let mut into = [0; 200];
        let mut writer = Writer::new(&mut into, 7, 0x8400).unwrap();
        writer.add(Part::Questions, |writer| {
            writer.name("velvet.local")?;
            writer.word(ANY)?;
            writer.word(IN)
        });
        writer.add(Part::Authorities, |writer| {
            writer.bytes(&[0xC0, 12])?;
            writer.word(A)?;
            writer.word(IN | TOP)?;
            writer.bytes(&120_u32.to_be_bytes())?;
            writer.data(|writer| writer.bytes(&[10, 0, 0, 9]))
        });
        let length = writer.len();
        into[..length].to_vec()
    }

    #[test]
    fn a_message_is_read_as_it_is_written() {
        let bytes = message();
        let message = Message::new(&bytes).unwrap();
        assert!(message.id() == 7 && message.is_response() && message.is_plain() && !message.is_cut());
        let question = message.questions().next().unwrap();
        assert!(question.kind == ANY && question.name.is("VELVET.local"));
        assert!(!question.name.is("velvet") && !question.name.is("velvet.local.x"));
        let record = message.records().next().unwrap();
        assert!(record.section == Section::Authority && record.name.is("velvet.local"));
        assert_eq!((record.kind, record.class, record.ttl, record.data), (A, IN | TOP, 120, &[10, 0, 0, 9][..]));
        assert_eq!((message.questions().count(), message.records().count()), (1, 1));
    }

    #[test]
    fn what_does_not_fit_is_left_out_whole() {
        let mut into = [0; 20];
        let mut writer = Writer::new(&mut into, 0, 0).unwrap();
        writer.add(Part::Answers, |writer| writer.name("a-name-that-is-too-long.local"));
        assert_eq!(writer.len(), 12);
        assert_eq!(into[7], 0);
        assert!(Writer::new(&mut [0; 11], 0, 0).is_none());
    }

    #[test]
    fn a_name_that_points_at_itself_ends() {
        let mut bytes = message();
        bytes[12..14].copy_from_slice(&[0xC0, 12]);
        let message = Message::new(&bytes).unwrap();
        assert!(message.questions().all(|question| !question.name.is("velvet.local")));
        assert!(message.records().count() <= 3);
    }

    #[test]
    fn no_bytes_make_the_reader_fail() {
        let (mut random, whole) = (Random::new(3), message());
        for _ in 0..20_000 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random.below(6) {
                let at = random.below(bytes.len() as u32) as usize;
                bytes[at] = random.next() as u8;
            }
            bytes.truncate(random.below(bytes.len() as u32 + 1) as usize);
            let Some(message) = Message::new(&bytes) else { continue };
            let names = message.questions().filter(|question| question.name.is("velvet.local")).count();
            let data: usize = message.records().map(|record| record.data.len()).sum();
            assert!(names <= 65_536 && data <= 65_536 * 200);
        }
    }
}
