//! Bytes with a few bytes of foresight, lines and columns; every end of a line is one `\n`.

/// Number of bytes of foresight.
const AHEAD: usize = 4;

/// Bytes of the source, a few of them looked at before they are taken.
pub struct Reader<'s> {
    source: &'s mut dyn Iterator<Item = u8>,
    ahead: [u8; AHEAD],
    count: usize,
    /// A byte of the source that was looked at.
    raw: Option<u8>,
    /// The last byte that was taken.
    pub last: u8,
    /// Line and column of the next byte.
    pub place: (u16, u16),
}

impl<'s> Reader<'s> {
    /// A reader at the beginning of a source.
    pub fn new(source: &'s mut dyn Iterator<Item = u8>) -> Self {
        let raw = source.next();
        let mut reader = Self { source, ahead: [0; AHEAD], count: 0, raw, last: 0, place: (1, 1) };
        reader.fill();
        reader
    }

    /// The next byte, with `\r` and `\r\n` as `\n`, and without the last end of a line of all.
    fn read(&mut self) -> Option<u8> {
        let byte = self.raw?;
        self.raw = self.source.next();
        if byte != b'\r' && byte != b'\n' {
            return Some(byte);
        }
        if byte == b'\r' && self.raw == Some(b'\n') {
            self.raw = self.source.next();
        }
        self.raw.is_some().then_some(b'\n')
    }

    fn fill(&mut self) {
        while self.count < AHEAD
            && let Some(byte) = self.read()
        {
            if let Some(place) = self.ahead.get_mut(self.count) {
                *place = byte;
            }
            self.count += 1;
        }
    }

    /// A byte that is still to come; 0 behind the end.
    #[inline(never)]
    pub fn peek(&self, index: usize) -> u8 {
        if index < self.count { self.ahead.get(index).copied().unwrap_or(0) } else { 0 }
    }

    /// Whether all bytes are taken.
    pub fn is_at_end(&self) -> bool {
        self.count == 0
    }

    /// Takes the next byte; 0 behind the end.
    pub fn take(&mut self) -> u8 {
        let byte = self.peek(0);
        if self.count > 0 {
            self.ahead.rotate_left(1);
            self.count -= 1;
            self.fill();
        }
        self.last = byte;
        let (line, column) = self.place;
        self.place = match byte {
            b'\n' => (line.saturating_add(1), 1),
            0x80..0xc0 => (line, column),
            _ => (line, column.saturating_add(1)),
        };
        byte
    }

    /// Takes so many bytes away.
    pub fn skip(&mut self, count: usize) {
        for _ in 0..count {
            self.take();
        }
    }

    /// Whether a blank comes next, in ASCII or beyond.
    pub fn is_blank(&self) -> bool {
        let length = match self.peek(0) {
            0 => return false,
            byte if byte.is_ascii() => 1,
            0xc0..0xe0 => 2,
            _ => 3,
        };
        let bytes = self.ahead.get(..length.min(self.count)).unwrap_or_default();
        core::str::from_utf8(bytes).is_ok_and(|text| text.chars().all(crate::chars::is_blank))
    }

    /// Takes the blanks that come next.
    pub fn skip_blanks(&mut self) {
        while self.is_blank() {
            let length = match self.peek(0) {
                byte if byte.is_ascii() => 1,
                0xc0..0xe0 => 2,
                _ => 3,
            };
            self.skip(length);
        }
    }
}
