//! Header lines of an answer. A value can never begin another line: control characters are left out.

use crate::percent;
use crate::window::Window;

/// Header lines as they are written.
#[derive(Debug)]
pub struct Fields<'w, 'o> {
    window: &'w mut Window<'o>,
}

impl<'w, 'o> Fields<'w, 'o> {
    /// Begins header lines in a window.
    pub const fn new(window: &'w mut Window<'o>) -> Self {
        Self { window }
    }

    /// Adds a line with a text.
    pub fn line(&mut self, name: &str, value: &str) {
        self.begin(name);
        self.safe(value.as_bytes(), |byte| byte == b'\t' || !byte.is_ascii_control());
        self.end();
    }

    /// Adds a line with a number.
    pub fn number(&mut self, name: &str, value: u64) {
        self.begin(name);
        self.window.number(value);
        self.end();
    }

    /// Adds a line whose value is made in parts, which hold no control character.
    pub(crate) fn parts(&mut self, name: &str, parts: impl FnOnce(&mut Window<'_>)) {
        self.begin(name);
        parts(self.window);
        self.end();
    }

    /// Adds where the peer is to look: a path of this server, not encoded, and the query, encoded.
    pub fn location(&mut self, path: &str, query: &str) {
        self.begin("Location");
        for byte in path.bytes() {
            self.encoded(byte, byte == b'/');
        }
        if !query.is_empty() {
            self.window.put(b"?");
            self.safe(query.as_bytes(), |byte| byte.is_ascii_graphic());
        }
        self.end();
    }

    /// Has the peer save the answer as a file of this name (RFC 6266), and never show it.
    pub fn attachment(&mut self, name: &str) {
        self.begin("Content-Disposition");
        self.window.put(b"attachment; filename*=UTF-8''");
        for byte in name.bytes() {
            self.encoded(byte, false);
        }
        self.end();
    }

    fn encoded(&mut self, byte: u8, is_plain: bool) {
        if is_plain || percent::is_plain(byte) {
            self.window.put(&[byte]);
        } else {
            let digit = |value: u8| b"0123456789ABCDEF".get(usize::from(value & 15)).copied().unwrap_or(b'0');
            self.window.put(&[b'%', digit(byte >> 4), digit(byte)]);
        }
    }

    fn begin(&mut self, name: &str) {
        self.safe(name.as_bytes(), |byte| byte.is_ascii_alphanumeric() || byte == b'-');
        self.window.put(b": ");
    }

    fn safe(&mut self, text: &[u8], is_safe: fn(u8) -> bool) {
        text.iter().filter(|byte| is_safe(**byte)).for_each(|byte| self.window.put(&[*byte]));
    }

    fn end(&mut self) {
        self.window.put(b"\r\n");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(make: impl Fn(&mut Fields<'_, '_>)) -> String {
        let mut room = [0; 256];
        let mut window = Window::new(&mut room, 0);
        make(&mut Fields::new(&mut window));
        let length = window.written();
        String::from_utf8(room[..length].to_vec()).unwrap()
    }

    #[test]
    fn no_value_begins_another_line() {
        assert_eq!(written(|fields| fields.line("X-A\r\n", "b\r\nSet-Cookie: c\0")), "X-A: bSet-Cookie: c\r\n");
        assert_eq!(
            written(|fields| fields.location("/a\r\nb ü", "c\r\n=d e")),
            "Location: /a%0D%0Ab%20%C3%BC?c=de\r\n"
        );
        let line = "Content-Disposition: attachment; filename*=UTF-8''a%22%3B%0D%0A%2F.g\r\n";
        assert_eq!(written(|fields| fields.attachment("a\";\r\n/.g")), line);
    }

    #[test]
    fn lines_are_written_as_they_are() {
        assert_eq!(written(|fields| fields.line("X-Hash", "a b\tü")), "X-Hash: a b\tü\r\n");
        assert_eq!(written(|fields| fields.number("Retry-After", 30)), "Retry-After: 30\r\n");
    }
}
