//! WebSockets: handshake, frames in and out, pings, ends.

use crate::limits::MESSAGE_BYTES;
use crate::testing::{Desk, Heard, serve};
use crate::{Kind, Life};

const UPGRADE: &str = "GET /ws HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: keep-alive, Upgrade\r\n\
    Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";
const MASK: [u8; 4] = [0x37, 0xFA, 0x21, 0x3D];

/// Makes a frame of a client.
fn frame(first: u8, data: &[u8]) -> Vec<u8> {
    let mut frame = vec![first];
    match data.len() {
        0..126 => frame.push(0x80 | data.len() as u8),
        126..0x1_0000 => frame.extend([&[0xFE], (data.len() as u16).to_be_bytes().as_slice()].concat()),
        length => frame.extend([&[0xFF], (length as u64).to_be_bytes().as_slice()].concat()),
    }
    frame.extend(MASK);
    frame.extend(data.iter().zip(MASK.iter().cycle()).map(|(byte, mask)| byte ^ mask));
    frame
}

/// Opens a WebSocket and sends frames in pieces of this size.
fn socket(frames: &[&[u8]], size: usize) -> Desk {
    let mut desk = Desk::new();
    desk.feed(UPGRADE.as_bytes(), 999);
    desk.sent.clear();
    desk.heard.clear();
    desk.feed(&frames.concat(), size);
    desk
}

/// Returns the messages, control frames too, that were sent: first byte of the first frame, and data.
fn told(mut sent: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let mut told: Vec<(u8, Vec<u8>)> = Vec::new();
    let mut open: Option<(u8, Vec<u8>)> = None;
    while let [first, length, rest @ ..] = sent {
        assert!(*length < 127, "a mask, or a frame that is too long");
        let (length, rest) = if *length == 126 {
            (usize::from(u16::from_be_bytes([rest[0], rest[1]])), &rest[2..])
        } else {
            (usize::from(*length), rest)
        };
        assert!(length <= 1_020);
        let data = rest[..length].to_vec();
        sent = &rest[length..];
        if first & 8 != 0 {
            told.push((*first, data));
            continue;
        }
        let (kind, mut message) = open.take().unwrap_or((*first & 15, Vec::new()));
        assert_eq!(first & 15 == 0, !message.is_empty(), "a continuation of nothing");
        message.extend(data);
        if first & 0x80 != 0 { told.push((kind, message)) } else { open = Some((kind, message)) }
    }
    assert!(open.is_none() && sent.is_empty(), "half a message");
    told
}

#[test]
fn the_handshake_is_the_one_of_the_rfc() {
    let desk = serve(UPGRADE.as_bytes(), 9, 9);
    let text = desk.text();
    assert!(text.starts_with("HTTP/1.1 101 Switching Protocols\r\n"), "{text}");
    let lines =
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n\r\n";
    assert!(text.ends_with(lines) && !text.contains("Content-Length"), "{text}");
    assert!(desk.connection.is_socket());
}

#[test]
fn handshakes_that_are_none_are_refused() {
    for (status, from, to) in [
        (426, "Sec-WebSocket-Version: 13", "Sec-WebSocket-Version: 8"),
        (426, "Sec-WebSocket-Version: 13\r\n", ""),
        (426, "Upgrade: websocket", "Upgrade: h2c"),
        (426, "keep-alive, Upgrade", "keep-alive"),
        (426, "GET /ws", "POST /ws"),
        (426, "HTTP/1.1", "HTTP/1.0"),
        (400, "Q==", "Q="),
        (400, "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n", ""),
        (400, "Host: a\r\n", "Host: a\r\nContent-Length: 1\r\n"),
    ] {
        let mut head = UPGRADE.replace(from, to).into_bytes();
        let mut connection = crate::Connection::new(2_048, 0);
        let (_, crate::Event::Request(request)) = connection.receive(&mut head, 0) else { panic!("no head") };
        assert!(!connection.upgrade(&request), "{to}");
        let desk = serve(UPGRADE.replace(from, to).as_bytes(), 99, 99);
        assert_eq!((desk.status(), desk.connection.is_socket()), (status, false), "{to}: {}", desk.text());
        let hint = "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n";
        assert_eq!(desk.text().contains(hint), status == 426, "{}", desk.text());
    }
}

#[test]
fn messages_come_and_go_in_pieces_of_any_size() {
    let long: Vec<u8> = (0..70_000_u32).map(|n| n as u8).take(30_000).collect();
    for size in [1, 2, 3, 5, 6, 7, 50, 1_000, 99_999] {
        let text = frame(0x81, "Hellö".as_bytes());
        let binary = frame(0x82, &long);
        let mut desk = socket(&[&text], size);
        desk.room = size.min(2_000);
        desk.feed(&binary, size);
        desk.feed(&frame(0x81, b""), size);
        let heard = [
            Heard::Message(Kind::Text, "Hellö".into(), true),
            Heard::Message(Kind::Binary, long.clone(), true),
            Heard::Message(Kind::Text, Vec::new(), true),
        ];
        assert!(desk.heard == heard, "{size}");
        let told = told(&desk.sent);
        assert!(told == [(1, "Hellö".into()), (2, long.clone()), (1, Vec::new())], "{size}");
    }
    // Section 5.7: "Hello" from a client.
    let desk = socket(&[b"\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58"], 1);
    assert_eq!(desk.heard, [Heard::Message(Kind::Text, b"Hello".to_vec(), true)]);
}

#[test]
fn fragments_join_with_control_frames_between_them() {
    for size in [1, 4, 1_000] {
        // The letter of two bytes is cut in the middle.
        let frames =
            [frame(0x01, b"a\xC3"), frame(0x89, b"one"), frame(0x00, b""), frame(0x8A, b"x"), frame(0x80, b"\xBCb")];
        let frames: Vec<&[u8]> = frames.iter().map(Vec::as_slice).collect();
        let desk = socket(&frames, size);
        assert_eq!(desk.heard, [Heard::Message(Kind::Text, "aüb".into(), true)], "{size}");
        assert_eq!(told(&desk.sent), [(0x8A, b"one".to_vec()), (1, "aüb".into())]);
    }
}

#[test]
fn pings_are_answered_with_all_their_data() {
    let data: Vec<u8> = (0..125).collect();
    let mut desk = socket(&[], 1);
    desk.room = 10;
    desk.feed(&[frame(0x89, &data), frame(0x89, b""), frame(0x81, b"x")].concat(), 999);
    assert_eq!(told(&desk.sent), [(0x8A, data), (0x8A, Vec::new()), (1, b"x".to_vec())]);
}

/// Returns the code that the connection ends with when the frames come.
fn ends(frames: &[&[u8]]) -> u16 {
    let whole = socket(frames, 99_999);
    let Some(Heard::Closed(code)) = whole.heard.last() else { panic!("{frames:x?} are taken: {:?}", whole.heard) };
    for size in [1, 3] {
        let mut cut = socket(frames, size);
        assert!(cut.heard.last() == whole.heard.last(), "{size} {frames:x?}");
        assert_eq!(cut.connection.poll(0), Life::Finish);
        let close = told(&cut.sent).pop().expect("a frame");
        let echoed = if *code == 1_005 { Vec::new() } else { code.to_be_bytes().to_vec() };
        assert_eq!(close, (0x88, echoed), "{frames:x?}");
    }
    *code
}

#[test]
fn frames_that_break_the_protocol_end_the_connection() {
    let text = frame(0x01, b"a");
    for (code, frames) in [
        (1_002, vec![b"\x81\x05Hello".to_vec()]),
        (1_002, vec![frame(0xC1, b"")]),
        (1_002, vec![frame(0xA1, b"")]),
        (1_002, vec![frame(0x91, b"")]),
        (1_002, vec![frame(0x83, b"")]),
        (1_002, vec![frame(0x8B, b"")]),
        (1_002, vec![frame(0x80, b"a")]),
        (1_002, vec![text.clone(), frame(0x81, b"a")]),
        (1_002, vec![text.clone(), frame(0x80, b"a"), frame(0x80, b"a")]),
        (1_002, vec![frame(0x09, b"")]),
        (1_002, vec![frame(0x89, &[0; 126])]),
        (1_002, vec![frame(0x88, b"\x03")]),
        (1_002, vec![b"\x81\xFE\x00\x7D\0\0\0\0".to_vec()]),
        (1_002, vec![b"\x81\xFF\0\0\0\0\0\0\xFF\xFF\0\0\0\0".to_vec()]),
        (1_002, vec![b"\x81\xFF\x80\0\0\0\0\x01\0\0\0\0\0\0".to_vec()]),
        (1_007, vec![frame(0x81, b"\xC3")]),
        (1_007, vec![frame(0x81, b"\xFF")]),
        (1_007, vec![text.clone(), frame(0x00, b"\xC3"), frame(0x80, b"a")]),
        (1_007, vec![frame(0x88, b"\x03\xE8\xFF")]),
        (1_009, vec![frame(0x82, &vec![0; MESSAGE_BYTES as usize + 1])]),
        (1_009, vec![frame(0x02, &vec![0; MESSAGE_BYTES as usize]), frame(0x80, b"a")]),
        (1_009, vec![b"\x82\xFF\0\0\0\x01\0\0\0\0\0\0\0\0".to_vec()]),
    ] {
        let frames: Vec<&[u8]> = frames.iter().map(Vec::as_slice).collect();
        assert_eq!(ends(&frames), code, "{:x?}", &frames[0][..frames[0].len().min(20)]);
    }
    let most = socket(&[&frame(0x82, &vec![0; MESSAGE_BYTES as usize])], 999);
    assert!(matches!(most.heard[..], [Heard::Message(_, _, true)]));
}

#[test]
fn a_peer_that_closes_is_answered_with_its_code() {
    for code in [1_000, 1_001, 1_003, 1_007, 1_014, 3_000, 4_999_u16] {
        let reason = [code.to_be_bytes().as_slice(), "gehört".as_bytes()].concat();
        assert_eq!(ends(&[&frame(0x88, &reason)]), code);
    }
    assert_eq!(ends(&[&frame(0x88, b"")]), 1_005);
    for code in [0, 999, 1_004, 1_005, 1_006, 1_015, 1_016, 2_999, 5_000, 65_535_u16] {
        assert_eq!(ends(&[&frame(0x88, &code.to_be_bytes())]), 1_002, "{code}");
    }
    let mut desk = socket(&[&frame(0x88, b""), &frame(0x81, b"late")], 99);
    assert_eq!((desk.heard.len(), desk.pass(2_000)), (1, Life::Abort));
}

#[test]
fn a_server_closes_behind_the_frame_that_is_on_its_way() {
    let mut desk = socket(&[], 1);
    desk.room = 10;
    desk.feed(&frame(0x81, &[b'x'; 300]), 999);
    let mut desk = socket(&[], 1);
    assert!(desk.connection.send(Kind::Text) && !desk.connection.send(Kind::Text));
    desk.connection.close(1_001);
    desk.connection.close(1_000);
    assert!(!desk.connection.send(Kind::Text) && !desk.connection.is_socket());
    desk.turn();
    assert_eq!(told(&desk.sent), [(0x88, b"\x03\xE9".to_vec())]);
    assert_eq!(desk.connection.poll(0), Life::Finish);
    let mut ping = socket(&[], 1);
    ping.room = 3;
    let mut bytes = frame(0x89, b"abcdef");
    let _ping = ping.connection.receive(&mut bytes, 0);
    let mut part = [0; 3];
    assert_eq!(ping.connection.transmit(&mut part, &mut crate::Empty, 0), 3);
    ping.connection.close(1_000);
    ping.sent.extend(part);
    ping.turn();
    assert_eq!(told(&ping.sent), [(0x8A, b"abcdef".to_vec()), (0x88, b"\x03\xE8".to_vec())]);
}

#[test]
fn a_peer_that_is_silent_is_pinged_and_left() {
    let mut desk = socket(&[], 1);
    assert_eq!((desk.pass(9_999), desk.sent.len()), (Life::Open, 0));
    assert_eq!((desk.pass(1), desk.sent.as_slice()), (Life::Open, b"\x89\x00".as_slice()));
    assert_eq!((desk.pass(5_000), desk.sent.len()), (Life::Open, 2));
    desk.feed(&frame(0x8A, b""), 9);
    assert_eq!((desk.pass(9_999), desk.sent.len(), desk.heard.len()), (Life::Open, 2, 0));
    assert_eq!((desk.pass(1), desk.sent.len()), (Life::Open, 4));
    assert_eq!((desk.pass(9_999), desk.pass(1)), (Life::Open, Life::Abort));
}

#[test]
fn a_message_that_cannot_be_made_ends_the_connection() {
    struct Broken(bool);
    impl crate::Body for Broken {
        fn make(&mut self, room: &mut [u8]) -> crate::Made {
            room[0] = b'x';
            if core::mem::replace(&mut self.0, true) { crate::Made::Failed } else { crate::Made::Part(1) }
        }
    }
    let mut desk = socket(&[], 1);
    desk.connection.send(Kind::Binary);
    let mut room = [0; 200];
    let count = desk.connection.transmit(&mut room, &mut Broken(false), 0);
    assert_eq!(&room[..count], b"\x02\x01x\x88\x02\x03\xF3");
    assert_eq!(desk.connection.poll(0), Life::Finish);
}
