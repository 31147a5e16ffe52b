use super::*;
use crate::mock::{CONFIGURATION, DEVICE, FOR_EVER};

const ADDRESS: Setup = Setup { kind: 0, request: request::SET_ADDRESS, value: 9, index: 0, length: 0 };

const fn descriptor(kind: u8, length: u16) -> Setup {
    let value = (kind as u16) << 8;
    Setup { kind: request::DEVICE_IN, request: request::GET_DESCRIPTOR, value, index: 0, length }
}

#[test]
fn control_transfers_go_both_ways_and_the_address_stays_as_it_is() {
    let mut bench = Bench::imported();
    bench.control(100, descriptor(1, 64), &[]);
    bench.control(2, ADDRESS, &[]);
    bench.control(101, descriptor(2, 9), &[]);
    bench.control(4, Setup { kind: 0x21, request: 0x20, value: 0, index: 0, length: 7 }, &[1; 7]);
    bench.control(102, descriptor(9, 64), &[]);
    bench.pass_ms(3);
    let mut answers = bench.answers();
    answers.sort_by_key(|(head, _)| head[1]);
    assert_eq!(
        answers,
        [
            ([3, 2, 0, 0], vec![]),
            ([3, 4, 0, 7], vec![]),
            ([3, 100, 0, 18], DEVICE.to_vec()),
            ([3, 101, 0, 9], CONFIGURATION[..9].to_vec()),
            ([3, 102, -32, 0], vec![]),
        ]
    );
}

#[test]
fn bulk_data_go_both_ways_and_wait_for_the_device() {
    let mut bench = Bench::configured();
    bench.read(100, 0, 128);
    bench.read(101, 1, 128);
    bench.read(102, 0, 64);
    bench.device.room = 0;
    bench.write(5, 0x40, &[b'x'; 64]);
    bench.pass_ms(20);
    assert!(bench.take().is_empty());
    bench.device.room = 64;
    bench.device.to_say = [b"one".to_vec(), b"two".to_vec(), vec![b'3'; 64]].into();
    bench.pass_ms(3);
    let mut answers = bench.answers();
    answers.sort_by_key(|(head, _)| head[1]);
    let remote_io = -121;
    assert_eq!(
        answers,
        [
            ([3, 5, 0, 64], vec![]),
            ([3, 100, 0, 3], b"one".to_vec()),
            ([3, 101, remote_io, 3], b"two".to_vec()),
            ([3, 102, 0, 64], vec![b'3'; 64]),
        ]
    );
    assert_eq!(bench.device.heard.len(), 64);
}

#[test]
fn an_endpoint_that_is_not_there_is_an_error() {
    let mut bench = Bench::imported();
    bench.read(100, 0, 64);
    bench.control(2, Setup { kind: 0x21, request: 0x20, value: 0, index: 0, length: 7 }, &[1; 7]);
    bench.session.receive(&submit(3, false, 0, 0, 0, descriptor(1, 18).bytes()));
    bench.pass_ms(2);
    let mut answers = bench.answers();
    answers.sort_by_key(|(head, _)| head[1]);
    assert_eq!(answers, [([3, 2, 0, 7], vec![]), ([3, 3, -22, 0], vec![]), ([3, 100, -2, 0], vec![])]);
}

#[test]
fn an_unlinked_transfer_has_no_end_of_its_own() {
    let mut bench = Bench::configured();
    bench.read(100, 0, 128);
    bench.read(101, 0, 128);
    bench.pass_ms(2);
    bench.unlink(7, 100);
    bench.pass_ms(2);
    assert_eq!(bench.answers(), [([4, 7, -104, 0], vec![])]);
    bench.device.to_say.push_back(b"for the next".to_vec());
    bench.pass_ms(2);
    bench.unlink(8, 101);
    bench.pass_ms(2);
    assert_eq!(bench.answers(), [([3, 101, 0, 12], b"for the next".to_vec()), ([4, 8, 0, 0], vec![])]);
}

#[test]
fn a_control_transfer_that_hangs_may_be_unlinked() {
    let mut bench = Bench::imported();
    bench.control(5, FOR_EVER, &[]);
    bench.control(100, descriptor(1, 8), &[]);
    bench.pass_ms(50);
    bench.unlink(6, 5);
    bench.pass_ms(3);
    assert_eq!(bench.answers(), [([4, 6, -104, 0], vec![]), ([3, 100, 0, 8], DEVICE[..8].to_vec())]);
}

#[test]
fn a_reset_of_the_port_is_one_and_what_follows_waits() {
    let mut bench = Bench::configured();
    bench.control(5, Setup { kind: 0x23, request: 3, value: 4, index: 1, length: 0 }, &[]);
    bench.control(100, descriptor(1, 8), &[]);
    bench.control(101, descriptor(1, 8), &[]);
    bench.unlink(6, 101);
    bench.pass_ms(2);
    assert_eq!(bench.answers(), [([3, 5, 0, 0], vec![]), ([4, 6, -104, 0], vec![])]);
    bench.pass_ms(40);
    assert_eq!(bench.answers(), [([3, 100, 0, 8], DEVICE[..8].to_vec())]);
    assert_eq!((bench.device.resets, bench.device.configuration), (2, 0));
}

#[test]
fn a_stall_is_passed_on_and_its_end_starts_over() {
    let mut bench = Bench::configured();
    bench.write(2, 0, b"one");
    bench.pass_ms(2);
    bench.device.halted = true;
    bench.write(3, 0, b"two");
    bench.pass_ms(2);
    bench.control(4, Setup { kind: 2, request: request::CLEAR_FEATURE, value: 0, index: 1, length: 0 }, &[]);
    bench.pass_ms(2);
    bench.write(5, 0, b"three");
    bench.pass_ms(2);
    let statuses: Vec<_> = bench.answers().iter().map(|(head, _)| (head[1], head[2])).collect();
    assert_eq!(statuses, [(2, 0), (3, -32), (4, 0), (5, 0)]);
    assert_eq!(bench.device.heard, b"onethree");
}

#[test]
fn a_device_that_goes_ends_everything() {
    let mut bench = Bench::configured();
    bench.read(100, 0, 128);
    bench.pass_ms(2);
    bench.device.connected = false;
    bench.pass_ms(2);
    assert_eq!(bench.answers(), [([3, 100, -108, 0], vec![])]);
    assert!(bench.session.is_over() && bench.session.had_device());
}
