use super::super::message::{DeviceInfo, EndpointInfo, InterfaceInfo, place};
use super::*;
use crate::usbredir::message::Status;

/// Capabilities that both QEMU and this server have.
const AGREED: Capabilities = Capabilities::OURS;

/// Messages with the bytes that the protocol's description gives for them.
fn samples() -> Vec<(Message, Vec<u8>)> {
    let head =
        ControlHead { endpoint: 0x80, request: 6, kind: 0x80, status: 4, value: 0x0302, index: 0x0409, length: 0x1FF };
    let bulk = BulkHead { endpoint: 0x81, status: 1, length: 122_880, stream: 0 };
    let device = DeviceInfo { speed: 1, class: [0xEF, 2, 1], vendor: 0x1D50, product: 0x6015, release: 0x0102 };
    vec![
        (Message::DeviceConnect(device), vec![1, 0xEF, 2, 1, 0x50, 0x1D, 0x15, 0x60, 2, 1]),
        (Message::DeviceDisconnect, vec![]),
        (Message::Reset, vec![]),
        (Message::SetConfiguration { configuration: 1 }, vec![1]),
        (Message::GetConfiguration, vec![]),
        (Message::ConfigurationStatus { status: 4, configuration: 1 }, vec![4, 1]),
        (Message::SetAltSetting { interface: 2, alt: 1 }, vec![2, 1]),
        (Message::GetAltSetting { interface: 2 }, vec![2]),
        (Message::AltSettingStatus { status: 0, interface: 2, alt: 1 }, vec![0, 2, 1]),
        (Message::StartInterruptReceiving { endpoint: 0x82 }, vec![0x82]),
        (Message::StopInterruptReceiving { endpoint: 0x82 }, vec![0x82]),
        (Message::InterruptReceivingStatus { status: 0, endpoint: 0x82 }, vec![0, 0x82]),
        (Message::IsoStreamStatus { status: 2, endpoint: 3 }, vec![2, 3]),
        (Message::CancelDataPacket, vec![]),
        (Message::FilterReject, vec![]),
        (Message::FilterFilter("-1,-1,-1,-1,1".into()), b"-1,-1,-1,-1,1\0".to_vec()),
        (Message::DeviceDisconnectAck, vec![]),
        (Message::ControlPacket(head, vec![7]), vec![0x80, 6, 0x80, 4, 2, 3, 9, 4, 0xFF, 1, 7]),
        (Message::BulkPacket(bulk, b"ok".to_vec()), vec![0x81, 1, 0, 0xE0, 0, 0, 0, 0, 1, 0, b'o', b'k']),
        (
            Message::InterruptPacket { endpoint: 0x82, status: 0, length: 2, data: vec![8, 9] },
            vec![0x82, 0, 2, 0, 8, 9],
        ),
    ]
}

#[test]
fn messages_are_the_bytes_of_the_description_both_ways() {
    for (message, bytes) in samples() {
        assert_eq!(message.body(AGREED), bytes, "{message:?}");
        assert_eq!(Message::parse(message.kind(), &bytes, AGREED).as_ref(), Ok(&message));
    }
}

#[test]
fn what_was_not_agreed_on_is_left_out() {
    let old = Capabilities::default();
    let device = DeviceInfo { speed: 1, class: [0; 3], vendor: 1, product: 2, release: 0 };
    assert_eq!(Message::DeviceConnect(device).body(old).len(), 8);
    let bulk = BulkHead { endpoint: 1, status: 0, length: 2, stream: 0 };
    assert_eq!(Message::BulkPacket(bulk, vec![1, 2]).body(old), [1, 0, 2, 0, 0, 0, 0, 0, 1, 2]);
    let endpoints = Message::EpInfo(Box::new([EndpointInfo::NONE; 32]));
    assert_eq!((endpoints.body(old).len(), endpoints.body(AGREED).len()), (96, 160));
}

#[test]
fn tables_have_a_column_for_each_property() {
    let interfaces =
        vec![InterfaceInfo { number: 0, class: [2, 2, 1] }, InterfaceInfo { number: 1, class: [10, 0, 0] }];
    let message = Message::InterfaceInfo(interfaces);
    let body = message.body(AGREED);
    assert_eq!(
        (body.len(), &body[..4], &body[4..6], &body[36..38]),
        (132, &[2, 0, 0, 0][..], &[0, 1][..], &[2, 10][..])
    );
    assert_eq!(Message::parse(4, &body, AGREED), Ok(message));
    let mut all = Box::new([EndpointInfo::NONE; 32]);
    all[place(0x82)] = EndpointInfo { kind: 3, interval: 16, interface: 5, max_packet: 0x0108 };
    let message = Message::EpInfo(all);
    let body = message.body(AGREED);
    assert_eq!([body[18], body[32 + 18], body[64 + 18]], [3, 16, 5]);
    assert_eq!((body[96 + 36], body[96 + 37], body[17]), (8, 1, 255));
    assert_eq!(Message::parse(5, &body, AGREED), Ok(message));
}

#[test]
fn endpoints_have_their_places() {
    assert_eq!([0, 1, 0x80, 0x81, 0x8F].map(place), [0, 1, 16, 17, 31]);
}

#[test]
fn a_short_body_is_malformed_and_an_unknown_kind_is_passed_over() {
    for (message, bytes) in samples() {
        // Messages that end in data of any length may be cut anywhere after the head.
        if !bytes.is_empty() && !matches!(message, Message::FilterFilter(_)) {
            let head = if message.kind() < 100 { bytes.len() } else { 4 };
            assert!(Message::parse(message.kind(), &bytes[..head - 1], AGREED).is_err(), "{message:?}");
        }
    }
    assert_eq!(Message::parse(25, &[1, 2, 3], AGREED), Ok(Message::Other(25)));
    assert_eq!([0, 1, 2, 3, 4, 5, 6, 9].map(|byte| Status::of(byte) as u8), [0, 1, 2, 3, 4, 5, 6, 3]);
}

/// Encodes HELLO with this name and these capabilities.
fn hello(name: &str, known: &[u32]) -> Vec<u8> {
    let mut bytes = [0_u32, 64 + 4 * known.len() as u32, 0].map(u32::to_le_bytes).concat();
    bytes.extend(name.bytes());
    bytes.resize(12 + 64, 0);
    bytes.extend(known.iter().flat_map(|word| word.to_le_bytes()));
    bytes
}

#[test]
fn the_first_message_has_a_short_head_and_the_next_a_long_one() {
    let mut stream = Stream::new("me", Capabilities::OURS);
    stream.send(7, &Message::Reset);
    assert_eq!(*stream.output(), hello("me", &[0x7E]), "and nothing else before the peer's HELLO");
    stream.output().clear();
    // The bytes come singly, with a head cut after every byte.
    let mut bytes = hello("qemu usb-redir guest 7.2", &[0xFF]);
    bytes.extend([3, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8]);
    let mut heard = Vec::new();
    for byte in bytes {
        stream.receive(&[byte]);
        heard.extend(stream.take_message().unwrap());
    }
    assert_eq!(heard[0].1, Message::Hello("qemu usb-redir guest 7.2".into(), QEMU));
    assert_eq!(heard[1], (0x0807_0605_0403_0201, Message::Reset));
    assert_eq!(stream.agreed(), Some(Capabilities::OURS));
    stream.send(0x1_0000_0002, &Message::DeviceDisconnect);
    assert_eq!(*stream.output(), [2, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0]);
}

#[test]
fn a_peer_of_old_keeps_short_heads() {
    for known in [&[][..], &[0x1E][..]] {
        let mut stream = Stream::new("me", Capabilities::OURS);
        stream.output().clear();
        stream.receive(&hello("old", known));
        stream.receive(&[3, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0]);
        stream.take_message().unwrap().unwrap();
        assert_eq!(stream.take_message(), Ok(Some((9, Message::Reset))));
        stream.send(9, &Message::DeviceDisconnect);
        assert_eq!(stream.output().len(), 12);
    }
}

#[test]
fn what_is_no_usbredir_is_said_to_be() {
    let mut stream = Stream::new("me", Capabilities::OURS);
    stream.receive(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    assert!(stream.take_message().is_err());
    let mut stream = Stream::new("me", Capabilities::OURS);
    stream.receive(&hello("peer", &[0xFF]));
    stream.take_message().unwrap();
    stream.receive(&hello("peer", &[0xFF]));
    assert!(stream.take_message().is_err(), "a second HELLO");
    let mut stream = Stream::new("me", Capabilities::OURS);
    stream.receive(&hello("peer", &[0xFF]));
    stream.take_message().unwrap();
    stream.receive(&[101, 0, 0, 0, 0, 0, 0, 0xFF, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert!(stream.take_message().is_err(), "four gigabytes");
}

fn bytes_of(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

/// A recording of QEMU 7.2 with Linux 6.1 as guest, from its first byte on: HELLO, a reset, the first
/// question for the device descriptor, SET_CONFIGURATION, a read of cdc_acm and its end, notifications wanted
/// and not.
#[test]
fn what_qemu_really_sends_is_read() {
    let recorded = [
        "03000000000000000000000000000000",
        "640000000a0000000020ab0600000000800680ac000100004000",
        "06000000010000007022ab060000000001",
        "650000000a00000000b0aa060000000082008000000000000000",
        "150000000000000000b0aa0600000000",
        "0f00000001000000000000000000000081",
        "1000000001000000000000000000000081",
    ];
    let mut stream = Stream::new("me", Capabilities::OURS);
    stream.receive(&hello("qemu usb-redir guest 7.2.22", &[0xFF]));
    stream.receive(&bytes_of(&recorded.concat()));
    let mut heard = Vec::new();
    while let Some(message) = stream.take_message().unwrap() {
        heard.push(message);
    }
    let question =
        ControlHead { endpoint: 0x80, request: 6, kind: 0x80, status: 0xAC, value: 0x100, index: 0, length: 64 };
    let read = BulkHead { endpoint: 0x82, status: 0, length: 128, stream: 0 };
    let expected = [
        (0, Message::Hello("qemu usb-redir guest 7.2.22".into(), QEMU)),
        (0, Message::Reset),
        (0x06AB_2000, Message::ControlPacket(question, vec![])),
        (0x06AB_2270, Message::SetConfiguration { configuration: 1 }),
        (0x06AA_B000, Message::BulkPacket(read, vec![])),
        (0x06AA_B000, Message::CancelDataPacket),
        (0, Message::StartInterruptReceiving { endpoint: 0x81 }),
        (0, Message::StopInterruptReceiving { endpoint: 0x81 }),
    ];
    assert_eq!(heard, expected);
}
