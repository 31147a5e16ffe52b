//! Life of a connection: what follows an answer, and what time ends.

use crate::testing::{Desk, Heard, serve, split};
use crate::{Connection, Life, Method};

const GET: &str = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";

#[test]
fn requests_behind_each_other_are_answered_in_turn() {
    let requests = format!("{GET}POST /b HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\n\r\nab\r\n{GET}");
    for size in [1, 5, 1_000] {
        let desk = serve(requests.as_bytes(), size, 64);
        assert_eq!(desk.text().matches("HTTP/1.1 200 OK").count(), 3);
        let paths = desk.heard.iter().filter(|heard| matches!(heard, Heard::Request(..))).count();
        assert_eq!((paths, &desk.heard[3]), (3, &Heard::Body(b"ab".to_vec())));
        assert!(!desk.text().contains("Connection:"));
    }
}

#[test]
fn a_connection_ends_where_the_peer_wants_it() {
    for (version, line, stays) in [
        ("1.1", "", true),
        ("1.1", "Connection: close\r\n", false),
        ("1.1", "Connection: x, CLOSE ,y\r\n", false),
        ("1.1", "Connection: closed\r\n", true),
        ("1.0", "", false),
        ("1.0", "Connection: Keep-Alive\r\n", true),
        ("1.0", "Connection: keep-alive, close\r\n", false),
    ] {
        let mut desk = serve(format!("GET / HTTP/{version}\r\nHost: a\r\n{line}\r\n").as_bytes(), 99, 99);
        let life = desk.connection.poll(0);
        assert_eq!(life, if stays { Life::Open } else { Life::Finish }, "{version} {line}");
        let text = desk.text();
        assert_eq!(text.contains("\r\nConnection: close\r\n"), !stays, "{text}");
        assert_eq!(text.contains("\r\nConnection: keep-alive\r\n"), version == "1.0" && stays, "{text}");
        desk.feed(GET.as_bytes(), 99);
        assert_eq!(desk.heard.len(), if stays { 4 } else { 2 }, "a request behind the end");
        if !stays {
            assert_eq!((desk.pass(1_999), desk.pass(1)), (Life::Finish, Life::Abort));
        }
    }
}

#[test]
fn an_old_peer_gets_a_body_without_chunks() {
    let desk = serve(b"GET /chunks HTTP/1.0\r\nConnection: keep-alive\r\n\r\n", 99, 70);
    let (head, body) = split(&desk.sent);
    assert!(head.contains("\r\nConnection: close\r\n") && !head.contains("chunked"), "{head}");
    assert_eq!(body.len(), 3_000);
    let desk = serve(b"GET /empty HTTP/1.0\r\nConnection: keep-alive\r\n\r\n", 99, 3);
    assert!(split(&desk.sent).1.is_empty());
}

#[test]
fn a_head_has_to_come_in_time() {
    let mut desk = Desk::new();
    assert_eq!(desk.pass(14_999), Life::Open);
    desk.feed(b"GET", 9);
    assert_eq!(desk.pass(4_999), Life::Open);
    desk.feed(b" / HTTP/1.1\r\n", 1);
    assert_eq!((desk.pass(1), desk.status()), (Life::Finish, 408));
    let mut quiet = Desk::new();
    assert_eq!((quiet.pass(14_999), quiet.pass(1), quiet.text().as_str()), (Life::Open, Life::Finish, ""));
    let mut kept = serve(GET.as_bytes(), 99, 99);
    assert_eq!((kept.pass(14_999), kept.pass(1)), (Life::Open, Life::Finish));
}

#[test]
fn empty_lines_keep_no_connection() {
    let mut desk = Desk::new();
    (0..50).for_each(|_| {
        desk.feed(b"\r\n", 1);
        desk.pass(100);
    });
    assert_eq!((desk.connection.poll(5_000), desk.connection.poll(15_000)), (Life::Open, Life::Finish));
}

#[test]
fn a_body_has_to_go_on() {
    let mut desk = Desk::new();
    desk.feed(b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 9\r\n\r\n", 99);
    assert_eq!(desk.pass(19_998), Life::Open);
    desk.feed(b"x", 1);
    desk.now += 3_600_000;
    desk.connection.hold(desk.now);
    assert_eq!(desk.pass(2), Life::Open, "the peer is not to blame");
    assert_eq!((desk.pass(1), desk.status()), (Life::Finish, 408), "a byte buys a millisecond");
    let mut slow = Desk::new();
    slow.allow = Some(1 << 40);
    slow.feed(b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 900000\r\n\r\n", 99);
    for _ in 0..800 {
        assert_eq!(slow.pass(1_000), Life::Open, "1 kB/s is enough");
        slow.feed(&[b'x'; 1_000], 1_000);
    }
}

#[test]
fn a_peer_that_takes_nothing_is_left() {
    let mut desk = Desk::new();
    desk.room = 0;
    desk.feed(GET.as_bytes(), 99);
    assert_eq!((desk.pass(0), desk.pass(19_999), desk.pass(1)), (Life::Open, Life::Open, Life::Abort));
    let mut slow = Desk::new();
    slow.room = 0;
    slow.feed(b"GET /later HTTP/1.1\r\nHost: a\r\n\r\n", 99);
    assert_eq!(slow.pass(3_600_000), Life::Open, "the answer takes an hour");
    assert!(slow.connection.owes_answer());
    slow.connection.respond(crate::Response::new(crate::Status::Ok));
    assert_eq!(
        (slow.connection.poll(3_600_000), slow.pass(19_999), slow.pass(1)),
        (Life::Open, Life::Open, Life::Abort)
    );
}

#[test]
fn a_peer_that_waits_is_told_to_go_on() {
    let head = b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\nExpect: 100-continue\r\n\r\n";
    let mut desk = serve(head, 99, 7);
    assert_eq!(desk.text(), "HTTP/1.1 100 Continue\r\n\r\n");
    desk.feed(b"ab", 1);
    assert_eq!((desk.heard.len(), desk.status()), (3, 200));
    let silent = String::from_utf8_lossy(head).replace("Expect: 100-continue\r\n", "");
    assert_eq!(serve(silent.as_bytes(), 99, 99).text(), "", "nobody asked");
    let old = String::from_utf8_lossy(head).replace("HTTP/1.1", "HTTP/1.0");
    assert_eq!(serve(old.as_bytes(), 99, 99).text(), "", "HTTP/1.0 has no such answer");
    let eager = serve(&[head.as_slice(), b"ab"].concat(), 999, 99);
    assert!(eager.text().starts_with("HTTP/1.1 200 OK"));
    let early = String::from_utf8_lossy(head).replace(" / ", " /early ");
    let refused = serve(early.as_bytes(), 99, 99);
    assert!(refused.text().starts_with("HTTP/1.1 403 Forbidden"));
    let mut without = serve(b"GET / HTTP/1.1\r\nHost: a\r\nExpect: 100-continue\r\n\r\n", 99, 99);
    assert!(without.text().starts_with("HTTP/1.1 200 OK") && without.connection.poll(0) == Life::Open);
}

#[test]
fn what_follows_an_early_answer_is_thrown_away() {
    let mut desk = serve(b"POST /early HTTP/1.1\r\nHost: a\r\nContent-Length: 9000\r\n\r\nabc", 99, 99);
    let text = desk.text();
    assert!(text.contains("\r\nConnection: close\r\n") && text.ends_with("\"message\":\"not you\"}}"), "{text}");
    desk.feed(GET.as_bytes(), 9);
    assert_eq!((desk.heard.len(), desk.connection.poll(0)), (1, Life::Finish));
    // Without a body the connection stays.
    let mut short = serve(b"GET /early HTTP/1.1\r\nHost: a\r\n\r\n", 99, 99);
    assert_eq!((short.status(), short.connection.poll(0)), (403, Life::Open));
}

#[test]
fn the_end_of_what_a_peer_sends_ends_what_is_half() {
    let mut quiet = Connection::new(2_048, 0);
    quiet.hear_end();
    assert_eq!(quiet.poll(0), Life::Abort);
    let mut half = serve(b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 9\r\n\r\nx", 99, 99);
    half.connection.hear_end();
    assert_eq!((half.connection.poll(0), half.text().as_str()), (Life::Abort, ""));
    let mut whole = serve(b"GET /later HTTP/1.1\r\nHost: a\r\n\r\n", 99, 99);
    whole.connection.hear_end();
    assert_eq!(whole.connection.poll(0), Life::Open);
    whole.connection.respond(crate::Response::new(crate::Status::NoContent));
    whole.turn();
    assert_eq!((whole.status(), whole.connection.poll(0)), (204, Life::Finish));
}

#[test]
fn a_body_may_be_as_long_as_its_route_lets_it_be() {
    for (allow, length, status) in [(10, 10, 200), (10, 11, 413), (1 << 40, 40_000, 200)] {
        for chunked in [false, true] {
            let mut desk = Desk::new();
            desk.allow = Some(allow);
            let body = "x".repeat(length);
            let request = if chunked {
                format!(
                    "POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n{length:x}\r\n{body}\r\n0\r\n\r\n"
                )
            } else {
                format!("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: {length}\r\n\r\n{body}")
            };
            desk.feed(request.as_bytes(), 1_000);
            assert_eq!(desk.status(), status, "{allow} {length} {chunked}");
            assert!(matches!(desk.heard[0], Heard::Request(Method::Post, ..)));
        }
    }
}

#[test]
fn a_body_that_is_too_long_is_refused_before_it_comes() {
    let mut head = *b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 11\r\nExpect: 100-continue\r\n\r\n";
    let mut connection = Connection::new(2_048, 0);
    assert!(matches!(connection.receive(&mut head, 0).1, crate::Event::Request(_)));
    assert!(connection.owes_answer() && !connection.is_sending());
    assert!(!connection.allow_body(10) && connection.is_sending() && !connection.owes_answer());
    let mut room = [0; 1_000];
    let count = connection.transmit(&mut room, &mut crate::Empty, 0);
    assert!(room[..count].starts_with(b"HTTP/1.1 413 ") && connection.poll(0) == Life::Finish);
}

#[test]
fn a_small_buffer_is_the_limit_of_a_head() {
    let mut small = Connection::new(64, 0);
    let mut head = [b'x'; 64];
    head[..8].copy_from_slice(b"GET /x\r\n");
    assert!(matches!(
        small.receive(&mut head, 0),
        (64, crate::Event::Refused(crate::Status::RequestHeaderFieldsTooLarge))
    ));
    // Pointers of the board are half as long.
    assert!(core::mem::size_of::<Connection>() <= 416, "{}", core::mem::size_of::<Connection>());
}
