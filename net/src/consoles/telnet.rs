//! Telnet (RFC 854, RFC 855, RFC 1143), as little of it as is correct: every option is refused but that this
//! end echoes, which is offered while a password is typed.
//!
//! A connection is telnet if the first that comes is a command: 0xFF and a byte of 0xF0 to 0xFE. Telnet
//! clients negotiate before anybody types, and senders of programs never begin so. Any other connection is
//! raw for good: every byte is data both ways, 0xFF too, so that files and the realtime bytes of GRBL's
//! dialect arrive as they are.
//!
//! Suppressing go-aheads (RFC 858) is refused as well: a client that is granted it sends each key by itself,
//! without any means to correct a line, which no console here offers.

use heapless::Deque;

const SE: u8 = 0xF0;
const DATA_MARK: u8 = 0xF2;
const ABORT_OUTPUT: u8 = 0xF5;
const ARE_YOU_THERE: u8 = 0xF6;
const SB: u8 = 0xFA;
const WILL: u8 = 0xFB;
const WONT: u8 = 0xFC;
const DO: u8 = 0xFD;
const DONT: u8 = 0xFE;
const IAC: u8 = 0xFF;
/// Option of echoing what was typed (RFC 857).
const ECHO: u8 = 1;

/// Most bytes of a subnegotiation. Nobody has a reason for one here.
const MOST_SKIPPED: u16 = 1_024;
/// Answers that wait for room.
const ANSWER_BYTES: usize = 64;
/// Longest answer.
const LONGEST: usize = 16;

/// Kind of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Nothing has come yet.
    Unknown,
    Raw,
    Telnet,
}

/// Place in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Data,
    /// Behind a carriage return, which a line feed or NUL belongs to.
    Return,
    Command,
    /// Behind WILL, WONT, DO or DONT.
    Option(u8),
    /// In a subnegotiation, so many bytes of it.
    Skipping(u16),
    /// Behind 0xFF in a subnegotiation.
    SkippingCommand(u16),
}

/// What a byte of the stream means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    Nothing,
    Byte(u8),
    /// A connection that begins with 0xFF and is not telnet.
    Two(u8, u8),
    /// WILL, WONT, DO or DONT, and the option.
    Option(u8, u8),
    AreYouThere,
    AbortOutput,
    /// No telnet that makes sense.
    Broken,
}

/// Reader of what a peer sends.
#[derive(Clone, Copy, Debug)]
pub struct Decoder {
    kind: Kind,
    place: Place,
}

impl Decoder {
    /// Begins at the beginning of a connection.
    pub const fn new() -> Self {
        Self { kind: Kind::Unknown, place: Place::Data }
    }

    /// Returns whether the peer speaks telnet.
    pub fn is_telnet(&self) -> bool {
        self.kind == Kind::Telnet
    }

    /// Reads a byte.
    pub fn hear(&mut self, byte: u8) -> Heard {
        if self.kind == Kind::Telnet { self.hear_telnet(byte) } else { self.begin(byte) }
    }

    /// Reads a byte of a connection that speaks telnet.
    fn hear_telnet(&mut self, byte: u8) -> Heard {
        let (place, heard) = match (self.place, byte) {
            (Place::Data | Place::Return, IAC) => (Place::Command, Heard::Nothing),
            (Place::Return, 0) => (Place::Data, Heard::Nothing),
            (Place::Data | Place::Return, b'\r') => (Place::Return, Heard::Byte(byte)),
            (Place::Data | Place::Return, _) => (Place::Data, Heard::Byte(byte)),
            (Place::Command, IAC) => (Place::Data, Heard::Byte(byte)),
            (Place::Command, SB) => (Place::Skipping(0), Heard::Nothing),
            (Place::Command, WILL..=DONT) => (Place::Option(byte), Heard::Nothing),
            (Place::Command, ARE_YOU_THERE) => (Place::Data, Heard::AreYouThere),
            (Place::Command, ABORT_OUTPUT) => (Place::Data, Heard::AbortOutput),
            // Interrupt and break are keys that are hit to leave a terminal: the machine goes on.
            (Place::Command, _) => (Place::Data, Heard::Nothing),
            (Place::Option(verb), option) => (Place::Data, Heard::Option(verb, option)),
            (Place::Skipping(MOST_SKIPPED..), _) => (Place::Data, Heard::Broken),
            (Place::Skipping(count), IAC) => (Place::SkippingCommand(count + 1), Heard::Nothing),
            (Place::Skipping(count), _) => (Place::Skipping(count + 1), Heard::Nothing),
            (Place::SkippingCommand(_), SE) => (Place::Data, Heard::Nothing),
            (Place::SkippingCommand(count), _) => (Place::Skipping(count), Heard::Nothing),
        };
        self.place = place;
        heard
    }

    /// Reads a byte of a connection that is not known to be telnet.
    fn begin(&mut self, byte: u8) -> Heard {
        match (self.kind, self.place, byte) {
            (Kind::Unknown, Place::Data, IAC) => {
                self.place = Place::Command;
                Heard::Nothing
            }
            (Kind::Unknown, Place::Command, SE..=DONT) => {
                self.kind = Kind::Telnet;
                self.hear_telnet(byte)
            }
            (Kind::Unknown, Place::Command, _) => {
                *self = Self { kind: Kind::Raw, place: Place::Data };
                Heard::Two(IAC, byte)
            }
            _ => {
                self.kind = Kind::Raw;
                Heard::Byte(byte)
            }
        }
    }
}

/// State of the option that this end echoes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Echo {
    Off,
    /// Offered; whether it is no longer wanted.
    Offered {
        over: bool,
    },
    On,
    /// Taken back, which the peer has not acknowledged.
    Ending,
}

/// Writer of what goes to a peer: answers of telnet, and data in its form.
#[derive(Clone, Debug)]
pub struct Encoder {
    echo: Echo,
    /// Whether the peer was asked to show nothing.
    hides: bool,
    answers: Deque<u8, ANSWER_BYTES>,
    /// Second byte of a pair whose first is written.
    second: Option<u8>,
    /// Whether the byte before was a carriage return.
    returned: bool,
}

impl Encoder {
    /// Begins at the beginning of a connection.
    pub const fn new() -> Self {
        Self { echo: Echo::Off, hides: false, answers: Deque::new(), second: None, returned: false }
    }

    /// Returns whether any answer has room.
    pub fn has_room(&self) -> bool {
        self.answers.len() + LONGEST <= ANSWER_BYTES
    }

    /// Answers what a peer said.
    pub fn answer(&mut self, heard: Heard) {
        match heard {
            Heard::Option(WILL, option) => self.push(&[IAC, DONT, option]),
            Heard::Option(DO, ECHO) => self.granted(),
            Heard::Option(DONT, ECHO) => self.denied(),
            Heard::Option(DO, option) => self.push(&[IAC, WONT, option]),
            Heard::AreYouThere => self.push(b"\r\n[yes]\r\n"),
            Heard::AbortOutput => self.push(&[IAC, DATA_MARK]),
            Heard::Option(..) | Heard::Nothing | Heard::Byte(_) | Heard::Two(..) | Heard::Broken => {}
        }
    }

    fn granted(&mut self) {
        match self.echo {
            Echo::Off => self.push(&[IAC, WONT, ECHO]),
            Echo::Offered { over: false } => self.echo = Echo::On,
            Echo::Offered { over: true } => {
                self.push(&[IAC, WONT, ECHO]);
                self.echo = Echo::Ending;
            }
            Echo::On | Echo::Ending => {}
        }
    }

    fn denied(&mut self) {
        if self.echo == Echo::On {
            self.push(&[IAC, WONT, ECHO]);
        }
        self.echo = Echo::Off;
    }

    /// Has the peer show nothing of what is typed. A peer that refuses is not asked again.
    pub fn hide(&mut self) {
        if !core::mem::replace(&mut self.hides, true) {
            self.push(&[IAC, WILL, ECHO]);
            self.echo = Echo::Offered { over: false };
        }
    }

    /// Has the peer show again what is typed.
    pub fn show(&mut self) {
        self.hides = false;
        match self.echo {
            Echo::On => {
                self.push(&[IAC, WONT, ECHO]);
                self.echo = Echo::Ending;
            }
            Echo::Offered { .. } => self.echo = Echo::Offered { over: true },
            Echo::Off | Echo::Ending => {}
        }
    }

    fn push(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let _has_room = self.answers.push_back(*byte);
        }
    }

    /// Writes as many answers as fit, behind the rest of a pair. Returns the number of bytes.
    pub fn write_answers(&mut self, into: &mut [u8]) -> usize {
        let mut count = 0;
        for place in into {
            let Some(byte) = self.second.take().or_else(|| self.answers.pop_front()) else { break };
            *place = byte;
            count += 1;
        }
        count
    }

    /// Writes as much data as fits, in telnet's form if the peer speaks it: 0xFF is doubled, and a line ends
    /// with CR LF. Returns the numbers of bytes that were taken and written.
    pub fn write(&mut self, is_telnet: bool, bytes: &[u8], into: &mut [u8]) -> (usize, usize) {
        if !is_telnet && self.second.is_none() {
            let count = bytes.len().min(into.len());
            for (place, byte) in into.iter_mut().zip(bytes) {
                *place = *byte;
            }
            return (count, count);
        }
        let (mut taken, mut written) = (0, 0);
        for place in into {
            *place = match self.second.take() {
                Some(second) => second,
                None => {
                    let Some(byte) = bytes.get(taken) else { break };
                    taken += self.begin(*byte, place);
                    written += 1;
                    continue;
                }
            };
            written += 1;
        }
        (taken, written)
    }

    /// Writes the first byte of what stands for a byte. Returns how many of the bytes are taken by that.
    fn begin(&mut self, byte: u8, place: &mut u8) -> usize {
        let returned = core::mem::take(&mut self.returned);
        match byte {
            b'\n' if !returned => {
                *place = b'\r';
                self.second = Some(byte);
            }
            // A carriage return alone is followed by NUL; the byte itself comes next.
            _ if returned && byte != b'\n' => {
                *place = 0;
                return 0;
            }
            IAC => {
                *place = byte;
                self.second = Some(byte);
            }
            _ => {
                *place = byte;
                self.returned = byte == b'\r';
            }
        }
        1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the data of a stream, and the answers to it.
    fn heard(bytes: &[u8]) -> (Vec<u8>, Vec<u8>) {
        let (mut decoder, mut encoder, mut data) = (Decoder::new(), Encoder::new(), Vec::new());
        for byte in bytes {
            let heard = decoder.hear(*byte);
            match heard {
                Heard::Byte(byte) => data.push(byte),
                Heard::Two(first, second) => data.extend([first, second]),
                _ => encoder.answer(heard),
            }
        }
        (data, answers(&mut encoder))
    }

    fn answers(encoder: &mut Encoder) -> Vec<u8> {
        let mut into = [0; ANSWER_BYTES];
        let count = encoder.write_answers(&mut into);
        into[..count].to_vec()
    }

    fn written(is_telnet: bool, bytes: &[u8], space: usize) -> Vec<u8> {
        let (mut encoder, mut all, mut left) = (Encoder::new(), Vec::new(), bytes);
        loop {
            let mut into = vec![0; space];
            let (taken, count) = encoder.write(is_telnet, left, &mut into);
            if taken == 0 && count == 0 {
                return all;
            }
            all.extend(&into[..count]);
            left = &left[taken..];
        }
    }

    #[test]
    fn a_raw_connection_keeps_every_byte() {
        let all: Vec<u8> = (0..=255).chain([IAC, DO, ECHO, b'\r', 0, IAC, IAC]).collect();
        assert_eq!(heard(&all), (all, vec![]));
        assert_eq!(heard(&[IAC, IAC, 7]), (vec![IAC, IAC, 7], vec![]));
        assert_eq!(heard(&[IAC, b'?']), (vec![IAC, b'?'], vec![]));
        assert_eq!(written(false, &[IAC, b'\n', b'\r', 1], 3), [IAC, b'\n', b'\r', 1]);
    }

    #[test]
    fn options_are_refused_once_and_refusals_are_not_answered() {
        let asked = [IAC, WILL, 31, IAC, DO, 3, IAC, WONT, 24, IAC, DONT, 5, b'?'];
        assert_eq!(heard(&asked), (vec![b'?'], vec![IAC, DONT, 31, IAC, WONT, 3]));
    }

    #[test]
    fn data_in_telnet_is_unwrapped() {
        let sent = [IAC, DO, 3, b'a', b'\r', 0, b'\r', b'\n', IAC, IAC, b'b', IAC, 0xF1, 0, 0x85];
        assert_eq!(heard(&sent).0, [b'a', b'\r', b'\r', b'\n', IAC, b'b', 0, 0x85]);
    }

    #[test]
    fn a_subnegotiation_is_skipped_and_an_endless_one_breaks_the_connection() {
        let sent = [IAC, SB, 24, 0, IAC, IAC, b'x', IAC, SE, b'y'];
        assert_eq!(heard(&sent).0, [b'y']);
        let mut decoder = Decoder::new();
        let broken = [IAC, SB].into_iter().chain([7; 2_000]).any(|byte| decoder.hear(byte) == Heard::Broken);
        assert!(broken);
    }

    #[test]
    fn questions_are_answered_and_an_interrupt_does_nothing() {
        assert_eq!(heard(&[IAC, ARE_YOU_THERE]), (vec![], b"\r\n[yes]\r\n".to_vec()));
        assert_eq!(heard(&[IAC, 0xF4, IAC, ABORT_OUTPUT]), (vec![], vec![IAC, DATA_MARK]));
    }

    #[test]
    fn lines_and_0xff_have_telnets_form() {
        for space in 1..5 {
            assert_eq!(written(true, b"a\nb\r\nc\xFFd\re", space), b"a\r\nb\r\nc\xFF\xFFd\r\0e", "{space}");
        }
    }

    #[test]
    fn echo_is_offered_and_taken_back() {
        let mut encoder = Encoder::new();
        encoder.hide();
        encoder.hide();
        encoder.answer(Heard::Option(DO, ECHO));
        assert_eq!(answers(&mut encoder), [IAC, WILL, ECHO]);
        encoder.show();
        encoder.answer(Heard::Option(DONT, ECHO));
        assert_eq!(answers(&mut encoder), [IAC, WONT, ECHO]);
        encoder.answer(Heard::Option(DO, ECHO));
        assert_eq!(answers(&mut encoder), [IAC, WONT, ECHO], "nobody echoes now");
    }

    #[test]
    fn an_offer_that_is_refused_is_not_made_again() {
        let mut encoder = Encoder::new();
        encoder.hide();
        encoder.answer(Heard::Option(DONT, ECHO));
        encoder.hide();
        assert_eq!(answers(&mut encoder), [IAC, WILL, ECHO]);
        encoder.show();
        assert_eq!(answers(&mut encoder), []);
    }

    #[test]
    fn an_offer_that_is_over_before_its_answer_is_taken_back_then() {
        let mut encoder = Encoder::new();
        encoder.hide();
        encoder.show();
        assert_eq!(answers(&mut encoder), [IAC, WILL, ECHO]);
        encoder.answer(Heard::Option(DO, ECHO));
        assert_eq!(answers(&mut encoder), [IAC, WONT, ECHO]);
    }
}
