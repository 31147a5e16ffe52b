//! Requests that are refused: smuggling, limits, what is not spoken here.

use crate::testing::{Heard, serve, split};

/// Returns the status of the answer to a request that is refused, in pieces of any size.
fn refused(request: &str) -> u16 {
    let whole = serve(request.as_bytes(), usize::MAX, 1_024);
    for size in [1, 2, 3, 7, 64] {
        let cut = serve(request.as_bytes(), size, 1_024);
        assert_eq!((cut.status(), cut.connection.owes_answer()), (whole.status(), false), "{size}: {request:?}");
    }
    let (head, body) = split(&whole.sent);
    assert!(head.contains("\r\nConnection: close\r\n"), "{head}");
    let length = format!("\r\nContent-Length: {}\r\n", body.len());
    assert!(head.contains(&length), "{head}");
    let body = String::from_utf8(body).unwrap();
    let begin = format!("{{\"error\":{{\"code\":{},\"message\":\"", whole.status());
    assert!(body.starts_with(&begin) && body.ends_with("\"}}"), "{body}");
    assert_eq!(whole.heard.last(), Some(&Heard::Refused(whole.status())));
    whole.status()
}

fn with(lines: &str) -> String {
    format!("POST /a HTTP/1.1\r\nHost: a\r\n{lines}\r\n")
}

#[test]
fn lengths_that_two_readers_may_read_differently_are_refused() {
    for lines in [
        "Content-Length: 3\r\nTransfer-Encoding: chunked\r\n",
        "Transfer-Encoding: chunked\r\nContent-Length: 3\r\n",
        "Content-Length: 3\r\nContent-Length: 3\r\n",
        "Content-Length: 3, 3\r\n",
        "Content-Length: +3\r\n",
        "Content-Length: -0\r\n",
        "Content-Length: 0x3\r\n",
        "Content-Length: \r\n",
        "Content-Length: 3 3\r\n",
        "Content-Length: 1234567890123456\r\n",
        "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
    ] {
        assert_eq!(refused(&with(lines)), 400, "{lines:?}");
    }
    let old = "POST / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n";
    assert_eq!(refused(old), 400);
}

#[test]
fn lines_that_two_readers_may_read_differently_are_refused() {
    for request in [
        with("A : b\r\n"),
        with("A\t: b\r\n"),
        with("A: b\r\n c\r\n"),
        with(" A: b\r\n"),
        with("A: b\n"),
        with("A: b\rC: d\r\n"),
        with("A: b\0c\r\n"),
        with("A: b\x7fc\r\n"),
        with(": b\r\n"),
        with("A b\r\n"),
        with("A\u{fc}: b\r\n"),
        with("Host: b\r\n"),
        with("Cookie: a\r\ncookie: b\r\n"),
        "GET  / HTTP/1.1\r\nHost: a\r\n\r\n".into(),
        "GET / HTTP/1.1 \r\nHost: a\r\n\r\n".into(),
        "GET /\tHTTP/1.1\r\nHost: a\r\n\r\n".into(),
        "GET / HTTP/1.1\nHost: a\n\n".into(),
        " GET / HTTP/1.1\r\nHost: a\r\n\r\n".into(),
        "GET /\r\n\r\n".into(),
        "\x16\x03\x01\x02".into(),
        "\x16".into(),
        "\n".into(),
    ] {
        assert_eq!(refused(&request), 400, "{request:?}");
    }
}

#[test]
fn paths_that_mean_two_things_are_refused() {
    for target in [
        "a",
        "//",
        "/a//b",
        "/../b",
        "/a/..",
        "/a/%2e%2E/b",
        "/./a",
        "/a/.",
        "/a%00",
        "/a%0d%0a",
        "/a%5Cb",
        "/%",
        "/%2",
        "/%zz",
        "/%ff",
        "/\u{fc}",
        "/a#b",
        "*",
        "ftp://a/",
        "http://a",
        "http://b/c",
        "http:///c",
    ] {
        let request = format!("GET {target} HTTP/1.1\r\nHost: a\r\n\r\n");
        assert_eq!(refused(&request), 400, "{target}");
    }
}

#[test]
fn paths_that_mean_one_thing_are_taken() {
    for (target, path) in [
        ("/", "/"),
        ("/?a=/../b", "/"),
        ("/a/b/", "/a/b/"),
        ("/..a/b..", "/..a/b.."),
        ("/%C3%BC%2Fx", "/ü/x"),
        ("/a%252e", "/a%2e"),
        ("http://a/b?c", "/b"),
    ] {
        let desk = serve(format!("GET {target} HTTP/1.1\r\nHost: a\r\n\r\n").as_bytes(), 9, 99);
        assert!(matches!(&desk.heard[0], Heard::Request(_, heard, _) if heard == path), "{target}: {:?}", desk.heard);
    }
    let all = serve(b"OPTIONS * HTTP/1.1\r\nHost: a\r\n\r\n", 99, 99);
    assert!(matches!(&all.heard[0], Heard::Request(_, path, _) if path == "*"));
}

#[test]
fn what_is_not_spoken_is_refused_by_its_status() {
    for (status, request) in [
        (400, "GET / HTTP/1.1\r\n\r\n".into()),
        (411, "PUT / HTTP/1.1\r\nHost: a\r\n\r\n".into()),
        (413, with("Content-Length: 32769\r\n")),
        (417, with("Expect: tea\r\n")),
        (501, "BREW / HTTP/1.1\r\nHost: a\r\n\r\n".into()),
        (501, "CONNECT a:1 HTTP/1.1\r\nHost: a\r\n\r\n".into()),
        (501, with("Transfer-Encoding: gzip, chunked\r\n")),
        (501, with("Transfer-Encoding: identity\r\n")),
        (505, "GET / HTTP/2.0\r\nHost: a\r\n\r\n".into()),
        (505, "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".into()),
    ] {
        assert_eq!(refused(&request), status, "{request:?}");
    }
}

#[test]
fn limits_of_a_head_hold() {
    let target = |length: usize| format!("GET /{} HTTP/1.1\r\nHost: a\r\n\r\n", "x".repeat(length - 1));
    assert_eq!(serve(target(512).as_bytes(), 100, 100).status(), 200);
    assert_eq!(refused(&target(513)), 414);
    assert_eq!(refused(&target(5_000)), 414);
    let head = |length: usize| with(&format!("A: {}\r\n", "x".repeat(length - 34)));
    assert_eq!(head(2_048).len(), 2_048);
    assert_eq!(serve(head(2_048).as_bytes(), 100, 100).status(), 200);
    assert_eq!(refused(&head(2_049)), 431);
    assert_eq!(refused(&head(5_000)), 431);
    let lines = |count: usize| with(&"A: b\r\n".repeat(count - 1));
    assert_eq!(serve(lines(32).as_bytes(), 100, 100).status(), 200);
    assert_eq!(refused(&lines(33)), 431);
}

#[test]
fn chunks_that_are_none_are_refused() {
    for (status, body) in [
        (400, "\r\n"),
        (400, "g\r\n"),
        (400, " 5\r\nhello"),
        (400, "5 \r\nhello"),
        (400, "+5\r\nhello"),
        (400, "0x5\r\nhello"),
        (400, "-5\r\n"),
        (400, "5\nhello"),
        (400, "5\rhello"),
        (400, "5\r\rhello"),
        (400, "5;a\nhello"),
        (400, "5;a\0\r\nhello"),
        (400, "5\r\nhellox\r\n"),
        (400, "5\r\nhello\r\r"),
        (400, "5\r\nhello\n0\r\n\r\n"),
        (400, "000000005\r\n"),
        // More than is allowed, if it were a size.
        (400, "63731\x1e"),
        (400, "0\r\nA: b\n"),
        (400, "0\r\n A: b\r\n"),
        (400, "0\r\nA\0: b\r\n"),
        (400, "0\r\nA: b\r\r"),
        (400, "0\r\n\r\r"),
        (413, "8001\r\n"),
        (413, "FFFFFFFF\r\n"),
        (413, "7000\r\n"),
    ] {
        let filler = if body == "7000\r\n" { format!("{}\r\n1001\r\n", "x".repeat(0x7000)) } else { String::new() };
        let request = format!("{}{body}{filler}", with("Transfer-Encoding: chunked\r\n"));
        assert_eq!(refused(&request), status, "{body:?}");
    }
}

#[test]
fn limits_of_chunks_hold() {
    let chunked = |body: &str| format!("{}{body}", with("Transfer-Encoding: CHUNKED\r\n"));
    let line = |length: usize| chunked(&format!("2;{}\r\nab\r\n0\r\n\r\n", "x".repeat(length - 2)));
    assert_eq!(serve(line(64).as_bytes(), 9, 99).status(), 200);
    assert_eq!(refused(&line(65)), 400);
    let trailer = |length: usize| chunked(&format!("2\r\nab\r\n0\r\nA:{}\r\n\r\n", "x".repeat(length - 2)));
    assert_eq!(serve(trailer(512).as_bytes(), 9, 99).status(), 200);
    assert_eq!(refused(&trailer(513)), 431);
    let lines = chunked(&format!("0\r\n{}\r\n", "A: b\r\n".repeat(100)));
    assert_eq!(refused(&lines), 431);
}
