//! Proofs of who a request is from: cookies (RFC 6265), bearer tokens (RFC 6750).

use crate::fields::Fields;
use crate::window::Window;

/// Returns the value of the first cookie of this name, out of a `Cookie` line.
#[must_use]
pub fn cookie<'b>(line: &'b str, name: &str) -> Option<&'b str> {
    let mut pairs = line.split(';').filter_map(|pair| pair.trim_ascii().split_once('='));
    pairs.find(|(known, _)| *known == name).map(|(_, value)| value)
}

/// Returns the token of an `Authorization` line.
#[must_use]
pub fn bearer(line: &str) -> Option<&str> {
    let (scheme, token) = line.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then_some(token.trim_ascii())
}

/// Returns whether two secrets are the same, in a time that does not tell where they differ.
#[must_use]
pub fn is_same(one: &[u8], other: &[u8]) -> bool {
    let difference = one.iter().zip(other).fold(0, |all, (one, other)| core::hint::black_box(all | (one ^ other)));
    one.len() == other.len() && difference == 0
}

/// Cookie that only this server gets, and no script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetCookie<'c> {
    /// Name of the cookie: letters and digits.
    pub name: &'c str,
    /// Value of the cookie: letters and digits.
    pub value: &'c str,
    /// Time that browsers keep it, seconds; 0 has them forget it.
    pub max_age_s: u32,
}

impl Fields<'_, '_> {
    /// Adds a cookie. Other sites cannot have it sent along, not even by a link.
    pub fn cookie(&mut self, cookie: &SetCookie<'_>) {
        let put = |window: &mut Window<'_>, text: &str| {
            let safe = text.bytes().filter(|byte| byte.is_ascii_alphanumeric() || b"-_.".contains(byte));
            safe.for_each(|byte| window.put(&[byte]));
        };
        self.parts("Set-Cookie", |window| {
            put(window, cookie.name);
            window.text("=");
            put(window, cookie.value);
            window.text("; Max-Age=");
            window.number(u64::from(cookie.max_age_s));
            window.text("; Path=/; HttpOnly; SameSite=Strict");
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cookies_are_found_by_their_whole_name() {
        let line = "a=1; session=x=y ;session=2;\tb=; =c; d";
        assert_eq!(cookie(line, "session"), Some("x=y"));
        assert_eq!((cookie(line, "a"), cookie(line, "b"), cookie(line, "")), (Some("1"), Some(""), Some("c")));
        assert_eq!((cookie(line, "ession"), cookie(line, "d"), cookie("", "a")), (None, None, None));
    }

    #[test]
    fn a_token_is_taken_from_its_scheme() {
        assert_eq!(bearer("Bearer abc"), Some("abc"));
        assert_eq!(bearer("bEARER  abc "), Some("abc"));
        assert_eq!((bearer("Basic abc"), bearer("Bearer"), bearer("")), (None, None, None));
    }

    #[test]
    fn secrets_are_the_same_or_not() {
        assert!(is_same(b"abc", b"abc") && is_same(b"", b""));
        for other in [b"abd".as_slice(), b"xbc", b"ab", b"abcd", b""] {
            assert!(!is_same(b"abc", other) && !is_same(other, b"abc"));
        }
    }

    #[test]
    fn a_cookie_is_for_this_server_alone() {
        let mut room = [0; 128];
        let mut window = Window::new(&mut room, 0);
        Fields::new(&mut window).cookie(&SetCookie { name: "session", value: "a1;b\r\nc", max_age_s: 60 });
        let length = window.written();
        let line = b"Set-Cookie: session=a1bc; Max-Age=60; Path=/; HttpOnly; SameSite=Strict\r\n";
        assert_eq!(&room[..length], line);
    }
}
