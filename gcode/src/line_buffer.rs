//! Gathers the bytes of one console or file into lines.

/// Longest line in bytes, without its line end.
pub const MAX_LINE_LENGTH: usize = 255;

const BACKSPACE: u8 = 8;
const DELETE: u8 = 127;

/// Line, or end of a line, that a byte completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gathered<'a> {
    /// A line, without its end; may be empty.
    Line(&'a [u8]),
    /// The end of a line that was too long; only [`LineBuffer::beginning`] is left of it.
    TooLong,
}

impl Gathered<'_> {
    /// Copies the line; false where it was too long. Each line of a file is copied so: this crate is compiled
    /// for speed, and where a crate is compiled for size the copy is a loop of eight instructions a byte.
    pub fn copy_to(self, line: &mut heapless::Vec<u8, MAX_LINE_LENGTH>) -> bool {
        line.clear();
        matches!(self, Gathered::Line(bytes) if line.extend_from_slice(bytes).is_ok())
    }
}

/// A line being typed. CR, LF and CR LF all end it; BS and DEL take back a byte. There is no echo.
///
/// Bytes that act at once ([`crate::realtime`]) must be taken out before.
#[derive(Clone, Debug)]
pub struct LineBuffer {
    bytes: [u8; MAX_LINE_LENGTH],
    length: usize,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Gathering,
    /// The line overflowed: skip to its end.
    Skipping,
    /// A CR has just ended a line: an LF right after it belongs to that end.
    AfterReturn,
}

impl LineBuffer {
    /// Creates a buffer with an empty line.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; MAX_LINE_LENGTH], length: 0, state: State::Gathering }
    }

    /// Takes one byte; gives the line that it ended.
    pub fn push(&mut self, byte: u8) -> Option<Gathered<'_>> {
        let was = self.state;
        match byte {
            b'\n' if was == State::AfterReturn => {
                self.state = State::Gathering;
                None
            }
            b'\n' | b'\r' => {
                self.state = if byte == b'\r' { State::AfterReturn } else { State::Gathering };
                Some(self.end(was))
            }
            _ if was == State::Skipping => None,
            _ => {
                self.state = State::Gathering;
                self.store(byte);
                None
            }
        }
    }

    /// Takes the printable ASCII at the beginning of these: as [`Self::push`] of each, and quicker. Gives how
    /// many there were.
    pub fn push_run(&mut self, bytes: &[u8]) -> usize {
        let length = plain_run(bytes);
        if length == 0 || self.state == State::Skipping {
            return length;
        }
        self.state = State::Gathering;
        let (run, end) = (bytes.get(..length).unwrap_or(&[]), self.length + length);
        match self.bytes.get_mut(self.length..end) {
            Some(place) => {
                place.copy_from_slice(run);
                self.length = end;
            }
            None => {
                let rest = self.bytes.get_mut(self.length..).unwrap_or(&mut []);
                rest.iter_mut().zip(run).for_each(|(place, byte)| *place = *byte);
                self.skip();
            }
        }
        length
    }

    /// The first [`MAX_LINE_LENGTH`] bytes of a line that was too long, right behind its end.
    #[must_use]
    pub const fn beginning(&self) -> &[u8] {
        &self.bytes
    }

    /// The unfinished line at the end of a file, if there is one.
    pub fn finish(&mut self) -> Option<Gathered<'_>> {
        let was = core::mem::replace(&mut self.state, State::Gathering);
        if self.length == 0 && was != State::Skipping { None } else { Some(self.end(was)) }
    }

    /// Whether the next byte begins a line.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.length == 0 && self.state == State::Gathering
    }

    /// Forgets the unfinished line, as an abort does.
    pub fn clear(&mut self) {
        self.length = 0;
        self.state = State::Gathering;
    }

    fn end(&mut self, was: State) -> Gathered<'_> {
        let length = core::mem::replace(&mut self.length, 0);
        if was == State::Skipping { Gathered::TooLong } else { Gathered::Line(self.bytes.get(..length).unwrap_or(&[])) }
    }

    fn skip(&mut self) {
        self.length = 0;
        self.state = State::Skipping;
    }

    fn store(&mut self, byte: u8) {
        if matches!(byte, BACKSPACE | DELETE) {
            self.length = self.length.saturating_sub(1);
        } else if let Some(place) = self.bytes.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        } else {
            self.skip();
        }
    }
}

impl Default for LineBuffer {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns the line at the beginning of these bytes, without its line feed, if it has nothing but printable
/// ASCII: what [`LineBuffer`] makes of it as well.
#[must_use]
#[inline]
pub fn plain_line(bytes: &[u8]) -> Option<&[u8]> {
    let length = plain_run(bytes);
    (bytes.get(length) == Some(&b'\n')).then(|| bytes.get(..length)).flatten()
}

/// Returns the number of bytes of printable ASCII at the beginning. Other bytes, tabs, line ends and
/// backspaces are taken singly.
fn plain_run(bytes: &[u8]) -> usize {
    /// The highest bit of each byte of a word.
    const HIGH: u32 = 0x8080_8080;
    const BLANKS: u32 = 0x2020_2020;
    const ONES: u32 = 0x0101_0101;
    // Four at a time: with a byte from 0x7F on, one of the first two has a high bit; with one below a blank,
    // and none of those, the third.
    let is_plain = |word: u32| (word | word.wrapping_add(ONES) | word.wrapping_sub(BLANKS)) & HIGH == 0;
    let (words, _) = bytes.as_chunks::<4>();
    let whole = 4 * words.iter().take_while(|word| is_plain(u32::from_le_bytes(**word))).count();
    let rest = bytes.get(whole..).unwrap_or(&[]);
    whole + rest.iter().take_while(|byte| byte.wrapping_sub(b' ') < DELETE - b' ').count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Every line gathered from `bytes`; none stands for one that was too long.
    fn gather(bytes: &[u8]) -> Vec<Option<Vec<u8>>> {
        let mut buffer = LineBuffer::new();
        let mut lines = Vec::new();
        let mut keep = |gathered: Gathered| {
            lines.push(match gathered {
                Gathered::Line(line) => Some(line.to_vec()),
                Gathered::TooLong => None,
            });
        };
        for &byte in bytes {
            if let Some(gathered) = buffer.push(byte) {
                keep(gathered);
            }
        }
        if let Some(gathered) = buffer.finish() {
            keep(gathered);
        }
        lines
    }

    fn line(text: &str) -> Option<Vec<u8>> {
        Some(text.as_bytes().to_vec())
    }

    #[test]
    fn every_kind_of_line_end_ends_one_line() {
        assert_eq!(
            gather(b"G28\nG1 X1\r\nM5\rM2\n\rT1"),
            [line("G28"), line("G1 X1"), line("M5"), line("M2"), line(""), line("T1")]
        );
    }

    #[test]
    fn backspace_and_delete_take_back_and_stop_at_the_start() {
        assert_eq!(gather(b"\x08G29\x088\x7f\x7f\x7f\x7fM1\n"), [line("M1")]);
    }

    #[test]
    fn the_longest_line_is_kept_and_one_byte_more_is_refused_once() {
        let longest = [b'a'; MAX_LINE_LENGTH];
        let mut bytes = longest.to_vec();
        bytes.extend(b"\n");
        bytes.extend([b'b'; MAX_LINE_LENGTH + 1]);
        bytes.extend(b"\nG1\n");
        bytes.extend([b'c'; 5 * MAX_LINE_LENGTH]);
        assert_eq!(gather(&bytes), [Some(longest.to_vec()), None, line("G1"), None]);
    }

    proptest! {
        #[test]
        fn lines_come_back_as_they_were_sent(sent in proptest::collection::vec("[ -~]{0,255}", 0..8)) {
            let text: String = sent.iter().map(|line| format!("{line}\n")).collect();
            prop_assert_eq!(gather(text.as_bytes()), sent.iter().map(|s| line(s)).collect::<Vec<_>>());
        }

        #[test]
        fn a_plain_run_ends_at_the_first_byte_that_is_not(
            bytes in proptest::collection::vec(prop_oneof![9 => b' '..DELETE, 1 => any::<u8>()], 0..40),
        ) {
            let plain = |byte: &u8| (b' '..DELETE).contains(byte);
            prop_assert_eq!(plain_run(&bytes), bytes.iter().take_while(|byte| plain(byte)).count());
        }

        #[test]
        fn a_run_is_taken_as_its_bytes_are(
            bytes in proptest::collection::vec(prop_oneof![10 => Just(b'x'), 1 => proptest::sample::select(b"\n\r\x08\x7f".as_slice())], 0..900),
            cuts in proptest::collection::vec(1..300_usize, 1..20),
        ) {
            let (mut singly, mut in_runs) = (LineBuffer::new(), LineBuffer::new());
            let (mut rest, mut cuts) = (bytes.as_slice(), cuts.into_iter().cycle());
            while !rest.is_empty() {
                let (chunk, later) = rest.split_at(cuts.next().unwrap().min(rest.len()));
                let run = in_runs.push_run(chunk);
                for byte in &chunk[..run] {
                    prop_assert_eq!(singly.push(*byte), None);
                }
                rest = &rest[run..];
                if run < chunk.len() {
                    prop_assert_eq!(singly.push(chunk[run]), in_runs.push(chunk[run]));
                    rest = &rest[1..];
                } else {
                    prop_assert_eq!(rest.len(), later.len());
                }
                prop_assert_eq!((singly.length, singly.state), (in_runs.length, in_runs.state));
                prop_assert!(singly.state != State::Skipping || singly.beginning() == in_runs.beginning());
            }
        }

        #[test]
        fn no_bytes_make_it_fail_or_overflow(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
            for line in gather(&bytes).into_iter().flatten() {
                prop_assert!(line.len() <= MAX_LINE_LENGTH);
            }
        }
    }
}
