use super::super::packet::{Command, Operation, Submit, command, operation};
use super::*;

#[test]
fn the_example_of_the_kernels_documentation_is_read() {
    let wanted = words(&[1, 0xD05, 0x1000F, 1, 1, 0x200, 0x40, u32::MAX, 0, 4, 0, 0]);
    let submit = Submit {
        sequence: 0xD05,
        input: true,
        endpoint: 1,
        flags: 0x200,
        length: 0x40,
        setup: [0; 8],
        isochronous: false,
        data: Vec::new(),
    };
    assert_eq!(command(&wanted), Ok(Some((Command::Submit(submit.clone()), 48))));
    let mut sent = words(&[1, 0xD06, 0x1000F, 0, 1, 0, 0x40, u32::MAX, 0, 4, 0, 0]);
    sent.extend([0xAB; 64]);
    let submit = Submit { sequence: 0xD06, input: false, flags: 0, data: vec![0xAB; 64], ..submit };
    assert_eq!(command(&sent), Ok(Some((Command::Submit(submit), 112))));
    for cut in [0, 1, 47, 48, 111] {
        assert_eq!(command(&sent[..cut]), Ok(None), "{cut} bytes of it");
    }
    let unlink = words(&[2, 0xD07, 0x1000F, 0, 0, 0xD05, 0, 0, 0, 0, 0, 0]);
    assert_eq!(command(&unlink), Ok(Some((Command::Unlink(0xD07, 0xD05), 48))));
}

#[test]
fn operations_are_read() {
    assert_eq!(operation(&LIST), Ok(Some((Operation::List, 8))));
    assert_eq!(operation(&import("1-1")), Ok(Some((Operation::Import("1-1".into()), 40))));
    assert_eq!(operation(&import("1-1")[..39]), Ok(None));
    assert_eq!(operation(&LIST[..7]), Ok(None));
}

#[test]
fn what_is_no_usbip_is_said_to_be() {
    assert!(operation(b"GET / HT").is_err());
    assert!(operation(&[1, 6, 0x80, 5, 0, 0, 0, 0]).is_err(), "another version");
    assert!(operation(&[1, 0x11, 0x80, 7, 0, 0, 0, 0]).is_err());
    assert!(command(&[0; 48]).is_err());
    assert!(command(&submit(1, true, 16, 0, 0, [0; 8])).is_err(), "endpoint 16");
    assert!(command(&submit(1, false, 1, 0, u32::MAX, [0; 8])).is_err(), "four gigabytes");
}

#[test]
fn an_isochronous_transfer_is_read_whole_and_refused() {
    let mut bench = Bench::configured();
    let head = words(&[1, 9, 0x1_0002, 1, 1, 0, 64, 0, 2, 0, 0, 0]);
    bench.session.receive(&[head, vec![0; 32]].concat());
    bench.write(10, 0, b"next");
    bench.pass_ms(2);
    assert_eq!(bench.answers(), [([3, 9, -22, 0], vec![]), ([3, 10, 0, 4], vec![])]);
}

#[test]
fn a_device_is_listed_with_its_interfaces_and_imported_without() {
    let mut bench = Bench::new(Mock::connected());
    bench.session.receive(&LIST);
    bench.pass_ms(200);
    let list = bench.take();
    assert_eq!(list.len(), 12 + 312 + 2 * 4);
    assert_eq!(list[..12], [1, 0x11, 0, 5, 0, 0, 0, 0, 0, 0, 0, 1]);
    assert_eq!(&list[0x10C..0x110], b"1-1\0");
    // The fields are bus, device, speed; vendor, product, release; class; configuration, configurations,
    // interfaces.
    assert_eq!(list[0x12C..0x138], words(&[1, 2, 2]));
    assert_eq!(list[0x138..0x144], [0x1D, 0x50, 0x60, 0x15, 1, 2, 0xEF, 2, 1, 0, 1, 2]);
    assert_eq!(list[0x144..], [2, 2, 1, 0, 10, 0, 0, 0]);
    bench.session.receive(&import("1-1"));
    bench.pass_ms(1);
    let device = bench.take();
    assert_eq!((device.len(), &device[..8]), (320, &[1, 0x11, 0, 3, 0, 0, 0, 0][..]));
    assert_eq!(device[8..], list[12..324]);
}

#[test]
fn a_device_that_cannot_be_had_is_refused_with_the_reason() {
    let refusal = |device: Mock, others, name| {
        let mut bench = Bench { others, ..Bench::new(device) };
        bench.session.receive(&import(name));
        bench.pass_ms(1_500);
        assert!(bench.session.is_over());
        bench.take()
    };
    let none = Mock::default;
    assert_eq!(refusal(none(), None, "1-1"), [1, 0x11, 0, 3, 0, 0, 0, 4], "there is none");
    assert_eq!(refusal(Mock::connected(), Some(Refusal::Busy), "1-1"), [1, 0x11, 0, 3, 0, 0, 0, 2]);
    assert_eq!(refusal(Mock::connected(), None, "3-2"), [1, 0x11, 0, 3, 0, 0, 0, 4], "not of this name");
    let mut dead = Mock::connected();
    dead.dead = true;
    assert_eq!(refusal(dead, None, "1-1"), [1, 0x11, 0, 3, 0, 0, 0, 3], "it does not answer");
    let mut bench = Bench { others: Some(Refusal::Busy), ..Bench::new(Mock::connected()) };
    bench.session.receive(&LIST);
    bench.pass_ms(1);
    assert_eq!(bench.take(), [1, 0x11, 0, 5, 0, 0, 0, 0, 0, 0, 0, 0]);
}
