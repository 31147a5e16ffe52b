//! Telnet as a client speaks it (RFC 854): every option that the other end offers or wants is refused.
//! Nothing is negotiated from here, so that a peer that does not either is talked to byte for byte.

const SE: u8 = 0xF0;
const SB: u8 = 0xFA;
const WILL: u8 = 0xFB;
const WONT: u8 = 0xFC;
const DO: u8 = 0xFD;
const DONT: u8 = 0xFE;
const IAC: u8 = 0xFF;

/// Place in what the peer sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    #[default]
    Data,
    /// Behind a carriage return, which a NUL may belong to.
    Return,
    Command,
    /// Behind WILL, WONT, DO or DONT.
    Option(u8),
    /// Within a subnegotiation, whose bytes are no text.
    Skipping,
    /// Behind 0xFF in a subnegotiation.
    SkippingCommand,
}

/// Reader of what the peer sends.
#[derive(Debug, Default)]
pub struct Decoder {
    place: Place,
    is_telnet: bool,
}

impl Decoder {
    /// Returns whether the peer has shown that it speaks telnet.
    pub const fn is_telnet(&self) -> bool {
        self.is_telnet
    }

    /// Reads what has come. Returns the text in it, and what is to be answered.
    pub fn hear(&mut self, bytes: &[u8]) -> (Vec<u8>, Vec<u8>) {
        let (mut text, mut answers) = (Vec::new(), Vec::new());
        for &byte in bytes {
            self.place = match (self.place, byte) {
                (Place::Data | Place::Return, IAC) => Place::Command,
                // The NUL makes a carriage return of telnet one alone.
                (Place::Return, 0) if self.is_telnet => Place::Data,
                (Place::Data | Place::Return, _) => {
                    text.push(byte);
                    if byte == b'\r' { Place::Return } else { Place::Data }
                }
                (Place::Command, IAC) => {
                    text.push(byte);
                    Place::Data
                }
                (Place::Command, SB) => Place::Skipping,
                (Place::Command, WILL..=DONT) => Place::Option(byte),
                (Place::Command, _) => Place::Data,
                (Place::Option(verb), option) => {
                    self.is_telnet = true;
                    match verb {
                        WILL => answers.extend([IAC, DONT, option]),
                        DO => answers.extend([IAC, WONT, option]),
                        // Nothing is on that could be switched off.
                        _ => {}
                    }
                    Place::Data
                }
                (Place::Skipping, IAC) => Place::SkippingCommand,
                (Place::SkippingCommand, SE) => Place::Data,
                (Place::Skipping | Place::SkippingCommand, _) => Place::Skipping,
            };
        }
        (text, answers)
    }
}

/// Returns text in the form that the peer understands.
pub fn encode(text: &[u8], is_telnet: bool) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(text.len());
    for &byte in text {
        match byte {
            IAC if is_telnet => bytes.extend([IAC, IAC]),
            b'\n' if is_telnet => bytes.extend(*b"\r\n"),
            _ => bytes.push(byte),
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn heard(pieces: &[&[u8]]) -> (Vec<u8>, Vec<u8>) {
        let (mut decoder, mut text, mut answers) = (Decoder::default(), Vec::new(), Vec::new());
        for piece in pieces {
            let (more, answer) = decoder.hear(piece);
            text.extend(more);
            answers.extend(answer);
        }
        answers.extend(encode(b"G28\n\xFF", decoder.is_telnet()));
        (text, answers)
    }

    #[test]
    fn what_is_offered_and_wanted_is_refused_once() {
        let (text, answers) = heard(&[&[IAC, WILL, 1, IAC], &[DO, 31, b'h', IAC, WONT, 1], &[IAC, DONT, 3, b'i']]);
        assert_eq!(text, b"hi");
        assert_eq!(answers, [&[IAC, DONT, 1, IAC, WONT, 31][..], b"G28\r\n\xFF\xFF"].concat());
    }

    #[test]
    fn subnegotiations_and_other_commands_are_no_text() {
        let (text, answers) = heard(&[&[b'a', IAC, SB, 24, 1, IAC, IAC, IAC, SE, b'b', IAC, 0xF1, b'c']]);
        assert_eq!((text.as_slice(), answers.as_slice()), (&b"abc"[..], &b"G28\n\xFF"[..]));
    }

    #[test]
    fn a_carriage_return_of_telnet_loses_its_nul() {
        assert_eq!(heard(&[&[IAC, WILL, 3], b"50%\r\0", b"ok\r\n"]).0, b"50%\rok\r\n");
        assert_eq!(heard(&[b"raw\r\0"]).0, b"raw\r\0");
    }

    proptest! {
        #[test]
        fn pieces_of_any_size_are_heard_alike(bytes in prop::collection::vec(any::<u8>(), 0..200), at in 0_usize..200) {
            let (first, second) = bytes.split_at(at.min(bytes.len()));
            prop_assert_eq!(heard(&[&bytes]), heard(&[first, second]));
        }

        #[test]
        fn text_without_commands_arrives_as_it_is(text in "[ -~\r\n]{0,80}") {
            prop_assert_eq!(heard(&[text.as_bytes()]).0, text.as_bytes());
        }
    }
}
