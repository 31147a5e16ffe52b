//! Bytes that act at once, wherever they stand in a line, and are never part of it; and the lines that act
//! as soon as they are whole, ahead of the line in work: M112, and M108 and M410 as Marlin has them.
//!
//! Only consoles look for such bytes. None leaves the payload of an upload (M28 to M29), a line with a
//! number, which has a checksum over all its bytes, the text of a code that takes one (M117), nor the text
//! behind the word of a console's command (`config-set "switch" fan.output_pin PE1!`): there `!` is a letter.
//! Ctrl-X and Ctrl-Y are no letters, and act everywhere but in an upload. A byte of 0x80 or more is part of
//! some letter in UTF-8, in a comment or a text. A byte of 0x80 to 0xBF that stands alone is no letter, but a
//! command of GRBL 1.1: the command acts where GRBL's dialect is spoken, and breaks no line elsewhere.
//! Senders that write their bytes as text (bCNC, CNCjs) put 0xC2 before each: in GRBL's dialect, such a
//! letter is the command too, outside comments and texts.

mod request;

pub use request::Realtime;
use request::{ABORT, STOP, classify, classify_extended, classify_line};

use crate::scanner::TEXT_M_CODES;

/// First byte in UTF-8 of the letters U+0080 to U+00BF, whose second byte is the number of the letter itself.
const LATIN_MARK: u8 = 0xC2;

/// A byte that goes on with a letter of UTF-8 and begins none.
const fn continues_letter(byte: u8) -> bool {
    matches!(byte, 0x80..=0xBF)
}

/// Part of a line wherever it stands behind the line's first word, and nothing begins or ends with it, no
/// comment either.
const fn is_plain(byte: u8) -> bool {
    matches!(byte, b' '..=b'}') && !matches!(byte, b'?' | b'!' | b'*' | b'(' | b')' | b';')
}

/// Position of the receiver in a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    /// Before the first word.
    #[default]
    Start,
    /// In the digits of N.
    LineNumber,
    /// In the digits of the first code, an M.
    Code,
    /// Behind the first letter, a small one.
    SmallLetter,
    /// In the word of a command: small letters, and more than one.
    Command,
    /// Behind the checksum's star.
    Checksum,
    /// Anywhere else in the line.
    Rest,
}

/// Meaning of a byte for the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// Part of the line.
    Byte,
    /// Part of the line, which it ends, and which acts now.
    Line(Realtime),
    /// A request, and no part of any line.
    Request(Realtime),
    /// Second byte of a letter of the line. The byte before it, 0xC2, was answered with [`Heard::Nothing`].
    Letter,
    /// A command of GRBL's that is not spoken here, or that has none: no part of any line. Or 0xC2, which is
    /// none either, unless [`Heard::Letter`] follows.
    Nothing,
}

/// Listens to the bytes of one console. Small and without loops: it runs in the interrupt that receives them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Receiver {
    place: Place,
    /// The line has a number.
    numbered: bool,
    /// The line is text, or its rest is.
    text: bool,
    /// In a comment: up to this byte, or to the end of the line.
    comment: Option<u8>,
    /// An upload: the lines are stored in a file.
    uploading: bool,
    /// Digits read so far; of the first code when it is an M.
    number: u16,
    /// The number of the line's first code, an M without subcode.
    code: Option<u16>,
    /// XOR of the bytes before the star.
    xor: u8,
    /// The number behind the star.
    checksum: Option<u16>,
    /// Bytes that a letter of UTF-8 still has.
    letter: u8,
    /// The byte before was [`LATIN_MARK`], and is not known to be part of the line yet.
    marked: bool,
}

impl Receiver {
    /// Creates a receiver at the beginning of a line.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            place: Place::Start,
            numbered: false,
            text: false,
            comment: None,
            uploading: false,
            number: 0,
            code: None,
            xor: 0,
            checksum: None,
            letter: 0,
            marked: false,
        }
    }

    /// Takes the next byte. `extended`: this console speaks GRBL's dialect.
    pub fn hear(&mut self, byte: u8, extended: bool) -> Heard {
        if matches!(byte, b'\n' | b'\r') {
            return self.end_line(extended);
        }
        let marked = core::mem::take(&mut self.marked);
        match self.heard(byte, extended) {
            Heard::Byte if marked && continues_letter(byte) => self.latin(byte),
            Heard::Byte if byte == LATIN_MARK && extended && self.is_in_words() => {
                self.marked = true;
                Heard::Nothing
            }
            Heard::Byte => {
                self.read(byte);
                Heard::Byte
            }
            heard => heard,
        }
    }

    /// Takes as many bytes as can be told to be part of the line by themselves, as [`Self::hear`] would one
    /// by one: most of a line, or none. Returns the number of bytes taken.
    pub fn hear_plain(&mut self, bytes: &[u8]) -> usize {
        let is_in_rest = match self.place {
            Place::Rest => true,
            Place::Checksum => false,
            _ => self.comment.is_some(),
        };
        if !is_in_rest {
            return 0;
        }
        let plain = bytes.iter().take_while(|byte| is_plain(**byte));
        let (count, xor) = plain.fold((0, self.xor), |(count, xor), byte| (count + 1, xor ^ byte));
        if count > 0 {
            *self = Self { xor, letter: 0, marked: false, ..*self };
        }
        count
    }

    /// The second byte of a letter that is a command, or one of the line.
    fn latin(&mut self, byte: u8) -> Heard {
        if let Some(request) = classify_extended(byte) {
            return Heard::Request(request);
        }
        self.read(LATIN_MARK);
        self.read(byte);
        Heard::Letter
    }

    /// Whether the line has words and numbers alone here: no text, comment or upload.
    const fn is_in_words(&self) -> bool {
        !self.uploading && !self.numbered && !self.text && self.comment.is_none()
    }

    fn heard(&mut self, byte: u8, extended: bool) -> Heard {
        let is_letter = self.is_in_letter(byte);
        let request = match byte {
            _ if self.uploading => None,
            ABORT | STOP => classify(byte),
            _ if self.numbered || self.text => None,
            byte if continues_letter(byte) && self.comment.is_none() && !is_letter => {
                return classify_extended(byte).filter(|_| extended).map_or(Heard::Nothing, Heard::Request);
            }
            byte => classify(byte),
        };
        request.map_or(Heard::Byte, Heard::Request)
    }

    /// Whether a byte goes on with the letter of UTF-8 that another one began.
    fn is_in_letter(&mut self, byte: u8) -> bool {
        let goes_on = self.letter > 0 && continues_letter(byte);
        self.letter = match byte {
            _ if goes_on => self.letter - 1,
            0xC2..=0xDF => 1,
            0xE0..=0xEF => 2,
            0xF0..=0xF4 => 3,
            _ => 0,
        };
        goes_on
    }

    fn read(&mut self, byte: u8) {
        match (self.place, byte) {
            (Place::Checksum, b'0'..=b'9') => {
                let digit = u16::from(byte - b'0');
                self.checksum = Some(self.checksum.unwrap_or(0).saturating_mul(10).saturating_add(digit));
            }
            (Place::Checksum, _) => {}
            (_, b'*') if self.numbered || !self.text => self.place = Place::Checksum,
            _ => {
                self.xor ^= byte;
                self.read_word(byte);
            }
        }
    }

    fn read_word(&mut self, byte: u8) {
        if let Some(end) = self.comment {
            if byte == end {
                self.comment = None;
            }
            return;
        }
        self.place = match (self.place, byte) {
            (Place::Start, b' ' | b'\t') => Place::Start,
            (Place::Start, b'N' | b'n') if !self.numbered => Place::LineNumber,
            (Place::Start, b'M' | b'm') => {
                self.number = 0;
                Place::Code
            }
            (Place::Start, b'a'..=b'z') if !self.numbered => Place::SmallLetter,
            (Place::SmallLetter, b'a'..=b'z') => Place::Command,
            (Place::Command, b' ' | b'\t') => {
                self.text = true;
                Place::Rest
            }
            (Place::Command, _) => Place::Command,
            (Place::LineNumber, b'0'..=b'9') => {
                self.numbered = true;
                Place::LineNumber
            }
            // `net` and `mv` begin like a number and a code.
            (Place::LineNumber, b'a'..=b'z') if !self.numbered => Place::Command,
            (Place::Code, b'a'..=b'z') if self.number == 0 => Place::Command,
            (Place::LineNumber, b' ' | b'\t') if self.numbered => Place::Start,
            (Place::LineNumber, b' ' | b'\t') => Place::LineNumber,
            (Place::LineNumber, b'M' | b'm') if self.numbered => {
                self.number = 0;
                Place::Code
            }
            (Place::Code, b'0'..=b'9') => {
                self.number = self.number.saturating_mul(10).saturating_add(u16::from(byte - b'0'));
                Place::Code
            }
            // A subcode: another code.
            (Place::Code, b'.') => Place::Rest,
            (Place::Code, _) => {
                self.know_code();
                Place::Rest
            }
            _ => Place::Rest,
        };
        match byte {
            b'(' if !self.text => self.comment = Some(b')'),
            b';' => self.comment = Some(b'\n'),
            _ => {}
        }
    }

    /// The digits of the line's first code are over.
    fn know_code(&mut self) {
        self.code = Some(self.number);
        self.text = TEXT_M_CODES.contains(&self.number);
    }

    fn end_line(&mut self, extended: bool) -> Heard {
        if self.place == Place::Code || self.place == Place::Checksum && self.code.is_none() && self.number > 0 {
            self.know_code();
        }
        let is_whole = self.checksum.is_none_or(|sum| sum == u16::from(self.xor));
        let code = self.code.filter(|_| is_whole);
        let uploading = match (self.uploading, code) {
            (false, Some(28)) => true,
            (true, Some(29)) => false,
            (uploading, _) => uploading,
        };
        let acts = code.filter(|_| !self.uploading).and_then(|code| classify_line(code, extended));
        *self = Self { uploading, ..Self::new() };
        acts.map_or(Heard::Byte, Heard::Line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checksum_of;
    use proptest::prelude::*;

    /// Returns the requests taken out of the stream, and the lines that remain.
    fn heard(bytes: &[u8], extended: bool) -> (Vec<Realtime>, Vec<String>) {
        let (mut receiver, mut requests, mut text) = (Receiver::new(), Vec::new(), Vec::new());
        for byte in bytes {
            match receiver.hear(*byte, extended) {
                Heard::Byte => text.push(*byte),
                Heard::Letter => text.extend([LATIN_MARK, *byte]),
                Heard::Line(request) => {
                    text.push(*byte);
                    requests.push(request);
                }
                Heard::Nothing => {}
                Heard::Request(request) => requests.push(request),
            }
        }
        (requests, String::from_utf8_lossy(&text).lines().map(str::to_owned).collect())
    }

    fn requests(bytes: &[u8]) -> Vec<Realtime> {
        heard(bytes, false).0
    }

    fn numbered(line: &str) -> Vec<u8> {
        format!("{line}*{}\n", checksum_of(line.as_bytes())).into_bytes()
    }

    #[test]
    fn requests_leave_a_line_wherever_they_stand() {
        let (requests, lines) = heard(b"G1 ?X1!0 Y~2\x18\x19\n", false);
        let expected = [Realtime::Status, Realtime::Hold, Realtime::Resume, Realtime::Abort, Realtime::Stop];
        assert_eq!((&requests[..], &lines[..]), (&expected[..], &["G1 X10 Y2".to_owned()][..]));
    }

    #[test]
    fn a_line_with_a_number_keeps_its_signs() {
        for line in ["N5 M117 Hi!", "N6 G1 X1 (what?)", "  N7 ~", "n8 m117 ?!~"] {
            let (requests, lines) = heard(&numbered(line), false);
            assert!(requests.is_empty(), "{line}: {requests:?}");
            assert!(lines[0].starts_with(line), "{lines:?}");
        }
        assert_eq!(requests(b"N5 G1\n!"), [Realtime::Hold], "behind the line it acts");
        assert_eq!(requests(b"N5 M117 \x18"), [Realtime::Abort], "no letter, and the operator's last resort");
    }

    #[test]
    fn text_keeps_its_signs() {
        assert_eq!(requests(b"M117 Done? Yes!\nm23 what?.g\n"), []);
        assert_eq!(requests(b"M1170?\n"), [Realtime::Status]);
        assert_eq!(requests(b"M118?\n"), [Realtime::Status]);
    }

    #[test]
    fn what_stands_behind_a_command_keeps_its_signs() {
        let line = b"config-set \"switch\" fan.output_pin PE1!o\n";
        let (requests_of_it, lines) = heard(line, false);
        assert!(requests_of_it.is_empty() && lines[0].ends_with("PE1!o"), "{requests_of_it:?} {lines:?}");
        assert_eq!(requests(b"play Ready?.g\nmv a! b!\nnet x!\nrm ~a\n  gpio PJ1! out on\n"), []);
        assert_eq!(requests(b"ls?\n"), [Realtime::Status], "in the word itself it acts");
        assert_eq!(requests(b"g1 x1?\nm3 s5!\nG1 X1?\n"), [Realtime::Status, Realtime::Hold, Realtime::Status]);
        assert_eq!(requests(b"echo \x18\n"), [Realtime::Abort], "no letter, and the operator's last resort");
        assert_eq!(requests(b"m112\n"), [Realtime::Emergency]);
    }

    #[test]
    fn an_upload_keeps_everything() {
        let upload = b"M28 a.g\nG1 ?\nM112\n\x18!~\xC3\x84\n M29 \n?";
        assert_eq!(requests(upload), [Realtime::Status]);
        let mut checked = numbered("N1 M28 a.g");
        checked.extend(b"N2 M112*0\nM112\n");
        checked.extend(numbered("N3 M29"));
        checked.extend(b"?");
        assert_eq!(requests(&checked), [Realtime::Status]);
    }

    #[test]
    fn a_garbled_line_begins_and_ends_no_upload() {
        assert_eq!(requests(b"N1 M28 a.g*1\n?"), [Realtime::Status]);
        assert_eq!(requests(b"M28 a.g\nN9 M29*1\n?\n"), []);
    }

    #[test]
    fn an_emergency_stop_acts_when_its_line_is_whole() {
        for line in ["M112\n", "m112\r\n", "  M112 ; stop\n", "N7 M112\n", "M112 (now)\n", "M0112\n"] {
            assert_eq!(requests(line.as_bytes()), [Realtime::Emergency], "{line:?}");
        }
        assert_eq!(requests(&numbered("N7 M112")), [Realtime::Emergency]);
        assert_eq!(requests(&numbered("M112")), [Realtime::Emergency]);
        for line in ["M1120\n", "M112.1\n", "M11\n", "; M112\n", "(M112)\n", "G1 M112\n", "N7 M112*1\n", "M117 M112\n"]
        {
            assert_eq!(requests(line.as_bytes()), [], "{line:?}");
        }
    }

    #[test]
    fn lines_of_marlins_act_as_they_come_in_but_not_in_grbls_dialect() {
        for (line, acts) in [("M108", Realtime::EndWait), ("M410", Realtime::QuickStop)] {
            for whole in [format!("{line}\n").into_bytes(), numbered(&format!("N7 {line}"))] {
                assert_eq!(heard(&whole, false).0, [acts]);
                assert_eq!(heard(&whole, true).0, []);
            }
            let not = format!("G1 {line}\nM117 {line}\n; {line}\n{line}.1\n{line}0\nM28 a.g\n{line}\n");
            assert_eq!(requests(not.as_bytes()), []);
        }
    }

    #[test]
    fn bytes_beyond_ascii_are_letters_in_comments_and_in_utf8_and_break_no_line() {
        for extended in [false, true] {
            let text = "G1 X1 (Ä\u{85})\n; \u{85}\nplay Ä\u{2085}10µm.g\nM117 \u{91}\nN5 G1 \u{91}\n";
            let (requests, lines) = heard(text.as_bytes(), extended);
            assert_eq!((requests, lines.join("\n") + "\n"), (vec![], text.into()));
        }
        let alone = b"G1\x84 X1\x85\x82\x90\xA1\n";
        let acts = vec![Realtime::Door, Realtime::JogCancel, Realtime::FeedReset, Realtime::Mist];
        assert_eq!(heard(alone, true), (acts, vec!["G1 X1".into()]));
        assert_eq!(heard(alone, false), (vec![], vec!["G1 X1".into()]));
    }

    #[test]
    fn a_command_that_was_written_as_text_acts() {
        let as_text = "G1\u{91} X1\u{85}\u{A0}\u{82}2\n";
        let (requests, lines) = heard(as_text.as_bytes(), true);
        assert_eq!(requests, [Realtime::FeedUp10, Realtime::JogCancel, Realtime::Flood]);
        assert_eq!(lines, ["G1 X1\u{82}2"]);
        assert_eq!(heard(as_text.as_bytes(), false), (vec![], vec![as_text.trim_end().into()]));
        assert_eq!(
            heard(b"G1\xC2 X1\xC2\n\xC2\x90\n", true),
            (vec![Realtime::FeedReset], vec!["G1 X1".into(), "".into()])
        );
    }

    #[test]
    fn every_request_has_its_byte() {
        let bytes = (0..=255).filter_map(|byte| classify(byte).or(classify_extended(byte)));
        let lines = (0..1_024).filter_map(|code| classify_line(code, false));
        let mut known: Vec<u32> = bytes.chain(lines).map(|request| request as u32).collect();
        known.sort_unstable();
        let mut all: Vec<u32> = Realtime::ALL.into_iter().map(|request| request as u32).collect();
        all.sort_unstable();
        assert_eq!(known, all);
        assert!(all.iter().all(|bit| *bit < 32), "they are bits of a word");
    }

    proptest! {
        /// Taken together, bytes are what they are one by one.
        #[test]
        fn plain_bytes_are_bytes_of_the_line(
            text in "[GMNXm0-9 .(;)*?!~\\x18\n\u{C2}\u{85}Ä]{0,60}", looks in prop::collection::vec(0_usize..60, 1..8),
            extended: bool,
        ) {
            let bytes = text.as_bytes();
            for from in looks.into_iter().map(|look| look.min(bytes.len())) {
                let mut receiver = Receiver::new();
                for byte in &bytes[..from] {
                    receiver.hear(*byte, extended);
                }
                let mut one_by_one = receiver;
                let count = receiver.hear_plain(&bytes[from..]);
                for byte in &bytes[from..from + count] {
                    prop_assert_eq!(one_by_one.hear(*byte, extended), Heard::Byte);
                }
                prop_assert_eq!(receiver, one_by_one);
            }
        }

        /// No byte of any stream is lost from a line but those that act.
        #[test]
        fn every_byte_stays_or_acts(bytes: Vec<u8>, extended: bool) {
            let mut receiver = Receiver::new();
            for byte in bytes {
                match receiver.hear(byte, extended) {
                    Heard::Byte => {}
                    Heard::Letter => prop_assert!(extended && continues_letter(byte)),
                    Heard::Line(_) => prop_assert!(matches!(byte, b'\n' | b'\r')),
                    Heard::Request(request) => {
                        let known = classify(byte).or(classify_extended(byte).filter(|_| extended));
                        prop_assert_eq!(known, Some(request));
                    }
                    Heard::Nothing => prop_assert!(continues_letter(byte) || extended && byte == LATIN_MARK),
                }
            }
        }
    }
}
