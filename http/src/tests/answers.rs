//! Answers: heads, lengths, chunks, in rooms of any size.

use proptest::prelude::*;

use crate::testing::{Heard, joined, serve, split};
use crate::{Body, Extent, Made, Method, Response, Status};

const GET: &[u8] = b"GET /a%20b/c?d=e%20f HTTP/1.1\r\nHost: velvet.local\r\n\r\n";

#[test]
fn a_request_is_heard_and_answered() {
    let desk = serve(GET, 4_096, 1_024);
    assert_eq!(desk.heard, [Heard::Request(Method::Get, "/a b/c".into(), "d=e%20f".into()), Heard::End]);
    let (head, body) = split(&desk.sent);
    assert!(head.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/plain\r\n"), "{head}");
    assert!(head.ends_with("\r\nContent-Length: 5\r\n\r\n"), "{head}");
    assert!(head.contains("\r\nCache-Control: no-store\r\n") && head.contains("nosniff"), "{head}");
    assert_eq!(body, b"hello");
}

#[test]
fn pieces_and_rooms_of_any_size_make_no_difference() {
    let whole = serve(GET, 4_096, 1_024);
    for size in (1..80).chain([200, 1_000]) {
        let cut = serve(GET, size, size);
        assert_eq!((&cut.heard, cut.text()), (&whole.heard, whole.text()), "{size}");
    }
}

#[test]
fn chunks_join_to_the_body_in_rooms_of_any_size() {
    let request = b"GET /chunks HTTP/1.1\r\nHost: a\r\n\r\n";
    let long: Vec<u8> = (0..3_000_u32).map(|n| b'a' + (n % 26) as u8).collect();
    for room in (1..140).chain([1_024, 3_006, 3_007, 3_008, 5_000]) {
        let (head, body) = split(&serve(request, 4_096, room).sent);
        assert!(head.contains("\r\nTransfer-Encoding: chunked\r\n") && !head.contains("Content-Length"), "{head}");
        assert_eq!(joined(&body), long, "{room}");
        assert!(body.len() < 3_000 + 3_000 / 40 * 7, "chunks of nothing: {room}");
    }
}

#[test]
fn a_head_alone_is_that_of_the_whole_answer() {
    for path in ["/", "/chunks", "/long"] {
        let get = split(&serve(format!("GET {path} HTTP/1.1\r\nHost: a\r\n\r\n").as_bytes(), 99, 99).sent);
        let head = split(&serve(format!("HEAD {path} HTTP/1.1\r\nHost: a\r\n\r\n").as_bytes(), 99, 99).sent);
        assert_eq!((head.0, head.1.len()), (get.0, 0), "{path}");
    }
    let refused = serve(b"HEAD /early HTTP/1.1\r\nHost: a\r\n\r\n", 99, 99);
    assert!(refused.text().ends_with("\r\n\r\n"), "{}", refused.text());
}

#[test]
fn answers_without_content_say_nothing_of_its_length() {
    let gone = serve(b"DELETE /gone HTTP/1.1\r\nHost: a\r\n\r\n", 99, 5);
    assert_eq!(gone.text(), "HTTP/1.1 204 No Content\r\nCache-Control: no-store\r\n\r\n");
    let empty = serve(b"GET /empty HTTP/1.1\r\nHost: a\r\n\r\n", 99, 5);
    assert_eq!(joined(&split(&empty.sent).1), b"");
}

#[test]
fn an_answer_that_breaks_off_is_cut() {
    let mut desk = serve(b"GET /short HTTP/1.1\r\nHost: a\r\n\r\n", 99, 99);
    assert_eq!(desk.connection.poll(0), crate::Life::Abort);
}

#[test]
fn lines_of_an_answer_are_those_that_it_has() {
    let tagged = serve(b"GET /tagged HTTP/1.1\r\nHost: a\r\n\r\n", 99, 9).text();
    for line in [
        "Content-Encoding: gzip",
        "Cache-Control: public, max-age=31536000, immutable",
        "ETag: \"00000000000000ab\"",
        "Accept-Ranges: bytes",
        "X-Mine: aX-Yours: b",
        "Content-Length: 2",
    ] {
        assert!(tagged.contains(&format!("\r\n{line}\r\n")), "{line}: {tagged}");
    }
    let method = serve(b"GET /method HTTP/1.1\r\nHost: a\r\n\r\n", 99, 99).text();
    assert!(method.starts_with("HTTP/1.1 405 Method Not Allowed\r\nContent-Type: application/json\r\n"), "{method}");
    assert!(method.contains("\r\nAllow: GET, POST\r\nRetry-After: 7\r\n"), "{method}");
    assert!(method.ends_with("\r\n\r\n{\"error\":{\"code\":405,\"message\":\"no\"}}"), "{method}");
}

#[test]
fn who_is_not_known_is_told_what_proves_it() {
    let mut desk = serve(b"GET /later HTTP/1.1\r\nHost: a\r\n\r\n", 99, 99);
    desk.connection.respond_error(crate::Response::new(crate::Status::Unauthorized), "log in \"first\"\n");
    desk.turn();
    assert!(desk.text().contains("\r\nWWW-Authenticate: Bearer\r\n"), "{}", desk.text());
    assert!(desk.text().ends_with("\"message\":\"log in first\"}}"), "{}", desk.text());
}

#[test]
fn a_body_is_made_right_in_the_room_of_the_socket() {
    struct Large(Vec<usize>);
    impl Body for Large {
        fn make(&mut self, room: &mut [u8]) -> Made {
            self.0.push(room.len());
            Made::Part(room.len())
        }
    }
    for (extent, frame) in [(Extent::Known(5_000), 0), (Extent::Open, 7)] {
        let mut desk = serve(b"GET /later HTTP/1.1\r\nHost: a\r\n\r\n", 99, 99);
        desk.connection.respond(Response::of(Status::Ok, "", extent));
        let mut body = Large(Vec::new());
        let mut room = [0; 1_000];
        assert_eq!(desk.connection.transmit(&mut room, &mut body, 0), 1_000);
        assert_eq!(desk.connection.transmit(&mut room, &mut body, 0), 1_000);
        assert_eq!(body.0.last(), Some(&(1_000 - frame)));
        assert_eq!(desk.connection.transmit(&mut room[..48], &mut body, 0), 48);
        assert_eq!(body.0.last().map(|room| (48..=52).contains(room)), Some(true), "{:?}", body.0);
    }
}

proptest! {
    #[test]
    fn requests_cut_anywhere_are_heard_and_answered_the_same(
        kinds in prop::collection::vec(0_usize..8, 1..6),
        sizes in prop::collection::vec(1_usize..60, 1..20),
        room in 1_usize..300,
    ) {
        let requests = [
            "GET /long HTTP/1.1\r\nHost: a\r\n\r\n",
            "GET /tagged?a=b HTTP/1.1\r\nHost: a\r\nCookie: x\r\n\r\n",
            "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 7\r\n\r\n\r\nabc\r\n",
            "POST /b HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n1;x\r\nd\r\n0\r\nA: b\r\n\r\n",
            "HEAD /long HTTP/1.1\r\nHost: a\r\n\r\n",
            "\r\nDELETE /gone HTTP/1.1\r\nHost: a\r\n\r\n",
            "GET /method HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n",
            "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 7, 7\r\n\r\n",
        ];
        let all: String = kinds.iter().map(|kind| requests[*kind]).collect();
        let whole = serve(all.as_bytes(), usize::MAX, 5_000);
        let mut cut = crate::testing::Desk::new();
        cut.room = room;
        let mut rest = all.as_bytes();
        for size in sizes.iter().cycle() {
            let (piece, later) = rest.split_at((*size).min(rest.len()));
            cut.feed(piece, usize::MAX);
            rest = later;
            if rest.is_empty() {
                break;
            }
        }
        prop_assert_eq!(&cut.heard, &whole.heard);
        prop_assert_eq!(cut.text(), whole.text());
    }
}
