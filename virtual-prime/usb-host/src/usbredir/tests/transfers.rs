use super::*;
use crate::mock::{CONFIGURATION, DEVICE, FOR_EVER};

#[test]
fn control_transfers_go_both_ways() {
    let mut bench = Bench::announced();
    bench.control(1, descriptor(1, 64), &[]);
    bench.control(2, descriptor(2, 20), &[]);
    let line = Setup { kind: 0x21, request: 0x20, value: 0, index: 0, length: 7 };
    bench.control(3, line, &[0, 0xC2, 1, 0, 0, 0, 8]);
    bench.control(4, descriptor(9, 64), &[]);
    bench.pass_ms(3);
    let told = bench.told.clone();
    let answers = bench.answers();
    assert_eq!(
        answers,
        [(1, 0, DEVICE.to_vec()), (2, 0, CONFIGURATION[..20].to_vec()), (3, 0, vec![]), (4, 4, vec![]),]
    );
    let Message::ControlPacket(head, _) = &told[0].1 else { panic!("{told:?}") };
    assert_eq!((head.length, head.value, head.endpoint), (18, 0x0100, 0x80), "what came, and what was asked");
    let Message::ControlPacket(head, _) = &told[2].1 else { panic!("{told:?}") };
    assert_eq!(head.length, 7);
}

#[test]
fn the_peers_address_is_no_affair_of_the_device() {
    let mut bench = Bench::announced();
    bench.control(1, Setup { kind: 0, request: request::SET_ADDRESS, value: 5, index: 0, length: 0 }, &[]);
    bench.control(2, descriptor(1, 8), &[]);
    bench.pass_ms(2);
    assert_eq!(bench.answers(), [(1, 0, vec![]), (2, 0, DEVICE[..8].to_vec())]);
}

#[test]
fn requests_that_cannot_be_are_invalid_and_each_is_answered() {
    let mut bench = Bench::configured();
    let head = BulkHead { endpoint: 0x83, status: 0, length: 64, stream: 0 };
    bench.say(1, &Message::BulkPacket(head, Vec::new()));
    bench.say(2, &Message::BulkPacket(BulkHead { endpoint: 1, length: 5, ..head }, vec![1, 2]));
    bench.say(3, &Message::BulkPacket(BulkHead { endpoint: 0x81, stream: 1, ..head }, Vec::new()));
    bench.say(4, &Message::BulkPacket(BulkHead { endpoint: 0x82, ..head }, Vec::new()));
    bench.say(5, &Message::StartInterruptReceiving { endpoint: 0x81 });
    bench.say(6, &Message::InterruptPacket { endpoint: 2, status: 0, length: 1, data: vec![1] });
    let line = Setup { kind: 0x21, request: 0x20, value: 0, index: 0, length: 7 };
    bench.control(7, line, &[1]);
    bench.say(8, &Message::StartIsoStream { endpoint: 0x83 });
    bench.pass_ms(1);
    assert_eq!(bench.told.pop(), Some((8, Message::IsoStreamStatus { status: 2, endpoint: 0x83 })));
    let answers = bench.answers();
    assert_eq!(
        answers.iter().map(|(id, status, _)| (*id, *status)).collect::<Vec<_>>(),
        [1, 2, 3, 4, 5, 6, 7].map(|id| (id, 2))
    );
    assert!(bench.device.heard.is_empty());
}

#[test]
fn bulk_data_go_both_ways_in_order_and_wait_for_the_device() {
    let mut bench = Bench::configured();
    (10..26).for_each(|id| bench.read(id, 128));
    bench.device.room = 64;
    bench.write(30, &[b'x'; 100]);
    bench.write(31, b"last");
    bench.pass_ms(50);
    assert!(bench.told.is_empty(), "a NAK is no answer");
    bench.device.room = 1_000;
    bench.device.to_say =
        [vec![b'a'; 64], vec![b'b'; 3], vec![b'c'; 64], vec![], vec![b'd'; 64], vec![b'e'; 64]].into();
    bench.pass_ms(5);
    let answers = bench.answers();
    let of = |id| answers.iter().find(|one| one.0 == id).map(|(_, status, data)| (*status, data.len()));
    assert_eq!([of(10), of(11), of(12)], [Some((0, 67)), Some((0, 64)), Some((0, 128))], "short, empty, full");
    assert_eq!([of(30), of(31)], [Some((0, 0)), Some((0, 0))]);
    assert_eq!(answers.len(), 5);
    assert_eq!(bench.device.heard, [&[b'x'; 100][..], b"last"].concat());
    assert_eq!(bench.controller.tally.sent[1], 104);
}

#[test]
fn an_identifier_may_come_again_once_it_is_answered() {
    let mut bench = Bench::configured();
    for round in 0..3_u8 {
        bench.read(1, 64);
        bench.device.to_say.push_back(vec![round]);
        bench.pass_ms(2);
        assert_eq!(bench.answers(), [(1, 0, vec![round])]);
    }
}

#[test]
fn a_pending_request_is_cancelled_with_what_was_done_and_any_other_is_not() {
    let mut bench = Bench::configured();
    (1..17).for_each(|id| bench.read(id, 128));
    bench.device.to_say = [vec![b'a'; 64]].into();
    bench.device.room = 64;
    bench.write(40, &[b'x'; 100]);
    bench.pass_ms(3);
    (1..17).for_each(|id| bench.say(id, &Message::CancelDataPacket));
    bench.say(40, &Message::CancelDataPacket);
    bench.say(99, &Message::CancelDataPacket);
    bench.pass_ms(2);
    let told = bench.told.clone();
    let mut answers = bench.answers();
    answers.sort();
    assert_eq!(answers.len(), 17, "and no answer to 99");
    assert!(answers.iter().all(|(_, status, _)| *status == 1));
    assert_eq!(answers[0], (1, 1, vec![b'a'; 64]));
    let written = told.iter().find(|(id, _)| *id == 40).unwrap();
    let Message::BulkPacket(head, data) = &written.1 else { panic!("{written:?}") };
    assert_eq!((head.length, data.len()), (64, 0), "what was acknowledged");
    bench.say(1, &Message::CancelDataPacket);
    bench.pass_ms(2);
    assert!(bench.told.is_empty(), "it was answered before");
    bench.device.room = 100;
    bench.write(41, b"more");
    bench.pass_ms(2);
    assert_eq!(bench.answers(), [(41, 0, vec![])]);
}

#[test]
fn a_control_transfer_that_hangs_may_be_cancelled() {
    let mut bench = Bench::announced();
    bench.control(1, FOR_EVER, &[]);
    bench.control(2, descriptor(1, 8), &[]);
    bench.pass_ms(100);
    assert!(bench.told.is_empty());
    bench.say(1, &Message::CancelDataPacket);
    bench.pass_ms(3);
    assert_eq!(bench.answers(), [(1, 1, vec![]), (2, 0, DEVICE[..8].to_vec())]);
}

#[test]
fn a_stall_is_passed_on_and_its_end_starts_over() {
    let mut bench = Bench::configured();
    bench.write(1, b"one");
    bench.pass_ms(2);
    bench.device.halted = true;
    bench.write(2, b"two");
    bench.read(3, 64);
    bench.pass_ms(2);
    let mut answers = bench.answers();
    answers.sort();
    assert_eq!(answers, [(1, 0, vec![]), (2, 4, vec![]), (3, 4, vec![])]);
    for (id, endpoint) in [(4, 0x01), (5, 0x81)] {
        let clear = Setup {
            kind: request::ENDPOINT_OUT,
            request: request::CLEAR_FEATURE,
            value: 0,
            index: endpoint,
            length: 0,
        };
        bench.control(id, clear, &[]);
        bench.pass_ms(2);
    }
    bench.write(6, b"three");
    bench.read(7, 64);
    bench.device.to_say.push_back(b"well".to_vec());
    bench.pass_ms(2);
    bench.told.retain(|(id, _)| *id > 5);
    let mut answers = bench.answers();
    answers.sort();
    assert_eq!(answers, [(6, 0, vec![]), (7, 0, b"well".to_vec())]);
    assert_eq!(bench.device.heard, b"onethree");
}

#[test]
fn notifications_are_pushed_while_they_are_wanted() {
    let mut bench = Bench::configured();
    bench.device.to_notify = [vec![1], vec![2, 3]].into();
    bench.pass_ms(40);
    assert!(bench.told.is_empty(), "nobody has asked");
    bench.say(9, &Message::StartInterruptReceiving { endpoint: 0x82 });
    bench.say(10, &Message::StartInterruptReceiving { endpoint: 0x82 });
    bench.pass_ms(60);
    assert_eq!(bench.answers(), [(9, 0, vec![0x82]), (10, 0, vec![0x82]), (0, 0, vec![1]), (1, 0, vec![2, 3])]);
    bench.say(11, &Message::StopInterruptReceiving { endpoint: 0x82 });
    bench.device.to_notify = [vec![4]].into();
    bench.pass_ms(60);
    assert_eq!(bench.answers(), [(11, 0, vec![0x82])]);
    bench.say(12, &Message::StartInterruptReceiving { endpoint: 0x82 });
    bench.pass_ms(60);
    assert_eq!(bench.answers(), [(12, 0, vec![0x82]), (0, 0, vec![4])]);
}
