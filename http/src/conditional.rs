//! Conditions and ranges of a request (RFC 9110, sections 13 and 14): what of a file is to be sent, if
//! anything.

use crate::method::Method;
use crate::request::Request;
use crate::response::{EntityTag, Extent, Part, Response};
use crate::status::Status;
use crate::window::Window;

/// Piece of a representation that is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// All that there is.
    Whole,
    /// Nothing: the peer has it.
    NotModified,
    /// Bytes from here to there.
    Part(Part),
    /// Nothing: the part that was asked for lies behind the end.
    Unsatisfiable,
}

impl Selection {
    /// Returns what the request selects of a representation of this length, with this validator.
    ///
    /// A range that is malformed, that is more than one, or of something else than bytes, selects the whole,
    /// as the RFC lets a server do.
    #[must_use]
    pub fn of(request: &Request<'_>, tag: Option<EntityTag>, length: u64) -> Self {
        if !matches!(request.head.method, Method::Get | Method::Head) {
            return Self::Whole;
        }
        if let (Some(tag), Some(known)) = (tag, request.header("If-None-Match"))
            && names(known, tag)
        {
            return Self::NotModified;
        }
        let is_current = match request.header("If-Range") {
            None => true,
            Some(known) => tag.is_some_and(|tag| tag.text() == known.as_bytes()),
        };
        let range = request.header("Range").and_then(|range| range.strip_prefix("bytes="));
        match range.and_then(|range| part(range, length)) {
            Some(selection) if is_current && request.head.method == Method::Get => selection,
            _ => Self::Whole,
        }
    }

    /// Makes the head of the answer out of that of the whole.
    #[must_use]
    pub fn answer(self, whole: Response, length: u64) -> Response {
        let whole = Response { has_parts: true, whole: length, extent: Extent::Known(length), ..whole };
        match self {
            Self::Whole => whole,
            Self::NotModified => Response { status: Status::NotModified, content_type: "", ..whole },
            Self::Part(part) => Response {
                status: Status::PartialContent,
                extent: Extent::Known(part.last - part.first + 1),
                part: Some(part),
                ..whole
            },
            Self::Unsatisfiable => {
                Response { has_parts: true, whole: length, ..Response::new(Status::RangeNotSatisfiable) }
            }
        }
    }
}

impl EntityTag {
    /// Text of the tag as it stands in header lines.
    fn text(self) -> [u8; 18] {
        let mut text = [0; 18];
        self.put(&mut Window::new(&mut text, 0));
        text
    }
}

/// Returns whether a list of validators names this one.
fn names(list: &str, tag: EntityTag) -> bool {
    let mut tags = list.split(',').map(|known| known.trim_ascii());
    tags.any(|known| known == "*" || known.strip_prefix("W/").unwrap_or(known).as_bytes() == tag.text())
}

/// Returns what a range selects. None if it is malformed, or more than one.
fn part(range: &str, length: u64) -> Option<Selection> {
    let (first, last) = range.trim_ascii().split_once('-')?;
    let end = length.checked_sub(1);
    let (first, last) = match (number(first), number(last)) {
        (Some(first), Some(last)) if first <= last => (first, last),
        (Some(first), None) if last.is_empty() => (first, u64::MAX),
        (None, Some(0)) if first.is_empty() => return Some(Selection::Unsatisfiable),
        (None, Some(count)) if first.is_empty() => (length.saturating_sub(count), u64::MAX),
        _ => return None,
    };
    Some(match end {
        Some(end) if first <= end => Selection::Part(Part { first, last: last.min(end) }),
        _ => Selection::Unsatisfiable,
    })
}

fn number(digits: &str) -> Option<u64> {
    let is_number = !digits.is_empty() && digits.len() <= 19 && digits.bytes().all(|digit| digit.is_ascii_digit());
    is_number.then(|| digits.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAG: EntityTag = EntityTag(0xAB);
    const SAME: &str = "\"00000000000000ab\"";

    fn select(method: &str, lines: &str, length: u64) -> Selection {
        let mut head = format!("{method} / HTTP/1.1\r\nHost: a\r\n{lines}\r\n").into_bytes();
        Selection::of(&Request::read(&mut head).expect("a head"), Some(TAG), length)
    }

    fn part_of(first: u64, last: u64) -> Selection {
        Selection::Part(Part { first, last })
    }

    #[test]
    fn ranges_select_what_the_rfc_says() {
        // Section 14.1.2, with 10000 bytes.
        for (range, selection) in [
            ("bytes=0-499", part_of(0, 499)),
            ("bytes=500-999", part_of(500, 999)),
            ("bytes=-500", part_of(9_500, 9_999)),
            ("bytes=9500-", part_of(9_500, 9_999)),
            ("bytes=0-0", part_of(0, 0)),
            ("bytes=-1", part_of(9_999, 9_999)),
            ("bytes=-20000", part_of(0, 9_999)),
            ("bytes=9999-20000", part_of(9_999, 9_999)),
            ("bytes=10000-", Selection::Unsatisfiable),
            ("bytes=10000-10001", Selection::Unsatisfiable),
            ("bytes=-0", Selection::Unsatisfiable),
            ("bytes=0-9999999999999999999", part_of(0, 9_999)),
        ] {
            assert_eq!(select("GET", &format!("Range: {range}\r\n"), 10_000), selection, "{range}");
            assert_eq!(select("HEAD", &format!("Range: {range}\r\n"), 10_000), Selection::Whole, "{range}");
        }
        assert_eq!(select("GET", "Range: bytes=0-\r\n", 0), Selection::Unsatisfiable);
        assert_eq!(select("GET", "Range: bytes=-5\r\n", 0), Selection::Unsatisfiable);
    }

    #[test]
    fn other_ranges_select_the_whole() {
        for range in [
            "bytes=5-4",
            "bytes=0-1,3-4",
            "bytes=a-",
            "bytes=-",
            "bytes=",
            "bytes=+1-2",
            "bytes=1--2",
            "lines=0-1",
            "0-1",
            "bytes=0-99999999999999999999",
            "bytes= -",
        ] {
            assert_eq!(select("GET", &format!("Range: {range}\r\n"), 10_000), Selection::Whole, "{range}");
        }
    }

    #[test]
    fn who_has_it_is_not_sent_it_again() {
        for (known, selection) in [
            (SAME, Selection::NotModified),
            ("*", Selection::NotModified),
            ("\"x\", W/\"00000000000000ab\"", Selection::NotModified),
            ("\"00000000000000ac\"", Selection::Whole),
            ("00000000000000ab", Selection::Whole),
            ("", Selection::Whole),
        ] {
            assert_eq!(select("GET", &format!("If-None-Match: {known}\r\n"), 9), selection, "{known}");
            assert_eq!(select("HEAD", &format!("If-None-Match: {known}\r\n"), 9), selection, "{known}");
            assert_eq!(select("POST", &format!("If-None-Match: {known}\r\n"), 9), Selection::Whole, "{known}");
        }
    }

    #[test]
    fn a_part_of_something_else_is_not_sent() {
        for (known, selection) in [
            (SAME, part_of(1, 2)),
            ("\"00000000000000ac\"", Selection::Whole),
            ("W/\"00000000000000ab\"", Selection::Whole),
            ("Sat, 29 Oct 1994 19:43:31 GMT", Selection::Whole),
        ] {
            assert_eq!(select("GET", &format!("Range: bytes=1-2\r\nIf-Range: {known}\r\n"), 9), selection, "{known}");
        }
    }

    #[test]
    fn without_a_validator_nothing_is_the_same() {
        let mut head =
            format!("GET / HTTP/1.1\r\nHost: a\r\nRange: bytes=1-2\r\nIf-Range: {SAME}\r\n\r\n").into_bytes();
        assert_eq!(Selection::of(&Request::read(&mut head).expect("a head"), None, 9), Selection::Whole);
        let mut head = *b"GET / HTTP/1.1\r\nHost: a\r\nRange: bytes=1-2\r\nIf-None-Match: *\r\n\r\n";
        assert_eq!(Selection::of(&Request::read(&mut head).expect("a head"), None, 9), part_of(1, 2));
    }

    #[test]
    fn answers_say_what_they_are() {
        let whole = Response { tag: Some(TAG), ..Response::of(Status::Ok, "text/plain", Extent::Open) };
        let head = |selection: Selection| {
            let mut room = [0; 1_000];
            let mut window = Window::new(&mut room, 0);
            let response = selection.answer(whole, 10);
            response.write(&mut window);
            let length = window.written();
            (response.status.code(), response.extent, String::from_utf8(room[..length].to_vec()).unwrap())
        };
        let (status, extent, text) = head(part_of(2, 4));
        assert_eq!((status, extent), (206, Extent::Known(3)));
        assert!(text.contains("\r\nContent-Range: bytes 2-4/10\r\n") && text.contains("\r\nETag:"), "{text}");
        let (status, extent, text) = head(Selection::Unsatisfiable);
        assert_eq!((status, extent), (416, Extent::Known(0)));
        assert!(text.contains("\r\nContent-Range: bytes */10\r\n") && !text.contains("ETag"), "{text}");
        let (status, _, text) = head(Selection::NotModified);
        assert!(status == 304 && text.contains("\r\nETag:") && !text.contains("Content-Type"), "{text}");
        let (status, extent, text) = head(Selection::Whole);
        assert_eq!((status, extent), (200, Extent::Known(10)));
        assert!(text.contains("\r\nAccept-Ranges: bytes\r\n") && !text.contains("Content-Range"), "{text}");
    }
}
