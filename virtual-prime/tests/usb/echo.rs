//! Crates `stm32h7xx-hal`, `synopsys-usb-otg`, `usb-device` and `usbd-serial`, as published, on the virtual
//! board.

use usb_host::controller::Port;
use usb_host::request::{self, Setup};
use usb_host::transfer::{Outcome, Request};
use virtual_prime::usb_desk::UsbError;
use virtual_prime::usb_desk::cdc::{LineCoding, Serial};

use super::*;

#[test]
fn other_peoples_serial_port_enumerates_and_echoes() {
    let (mut bench, mut host) = boot("usb_echo");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    let device = enumerate(&mut desk);
    assert_eq!((device.descriptor.vendor, device.descriptor.product), (0x16C0, 0x27DD));
    assert_eq!(device.strings.map(Option::unwrap), ["Somebody else", "Echo", "1"]);
    assert_eq!(device.configuration.announced, 2);
    let ports = Serial::all(&desk_device(&mut desk));
    let port = ports[0];
    let line = LineCoding { rate: 250_000, stop: 2, parity: 1, bits: 7 };
    port.set_line_coding(&mut desk, line).unwrap();
    assert_eq!(port.line_coding(&mut desk), Ok(line));
    port.set_lines(&mut desk, true, true).unwrap();
    port.write(&mut desk, b"hello").unwrap();
    assert_eq!(port.read_exact(&mut desk, 5).unwrap(), b"HELLO");
    desk.submit(port.output, Request::Out { data: b"!.".to_vec(), zero: false });
    assert!(matches!(desk.pass_ms(10), Err(UsbError::Over(_))));
    assert_clean(&mut bench);
}

/// Enumerates once more, as after a reset by the host.
fn desk_device(desk: &mut Desk<'_>) -> Device {
    desk.enumerate().expect("a second enumeration")
}

#[test]
fn transfers_of_every_size_come_back_whole() {
    let (mut bench, mut host) = boot("usb_echo");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    let device = enumerate(&mut desk);
    let port = Serial::all(&device)[0];
    for size in [1, 2, 31, 63, 64, 65, 127, 128, 129, 191, 192, 511, 512, 513, 2_000] {
        let text: Vec<u8> = (0..size).map(|index| b'a' + (index % 26) as u8).collect();
        let sent = desk.submit(port.output, Request::Out { data: text.clone(), zero: size % 2 == 0 });
        let back = port.read_exact(&mut desk, size).unwrap();
        assert_eq!(back, text.to_ascii_uppercase(), "{size}");
        desk.wait(sent).unwrap();
    }
    // At full speed there are 1216 bytes in a millisecond, and this image goes half as fast.
    assert!(desk.tally().repeated == 0);
    assert_clean(&mut bench);
}

#[test]
fn requests_that_make_no_sense_are_refused_and_nothing_is_lost() {
    let (mut bench, mut host) = boot("usb_echo");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    let device = enumerate(&mut desk);
    let refused = [
        Setup { kind: 0x80, request: request::GET_DESCRIPTOR, value: 0x0600, index: 0, length: 10 },
        Setup { kind: 0x80, request: request::GET_DESCRIPTOR, value: 0x03FF, index: 0x0409, length: 64 },
        Setup { kind: 0x00, request: request::SET_CONFIGURATION, value: 9, index: 0, length: 0 },
        Setup { kind: 0x00, request: 0xFF, value: 0, index: 0, length: 0 },
        Setup { kind: 0x80, request: 0xFF, value: 0, index: 0, length: 8 },
        Setup { kind: 0xC0, request: 1, value: 0, index: 0, length: 8 },
        Setup { kind: 0x40, request: 1, value: 0, index: 0, length: 8 },
        Setup { kind: 0xA1, request: 0x77, value: 0, index: 0, length: 8 },
        Setup { kind: 0x21, request: 0x77, value: 0, index: 0, length: 8 },
    ];
    for setup in refused {
        let answer = desk.control(setup.bytes(), &[0; 8]);
        assert!(matches!(&answer, Err(error) if error.is_stall()), "{setup:?}: {answer:?}");
        assert_eq!(desk.descriptor(request::DEVICE, 0, 18).unwrap().len(), 18, "after {setup:?}");
    }
    let port = Serial::all(&device)[0];
    port.write(&mut desk, b"still here").unwrap();
    assert_eq!(port.read_exact(&mut desk, 10).unwrap(), b"STILL HERE");
    assert_clean(&mut bench);
}

#[test]
fn chapter_9_is_answered() {
    let (mut bench, mut host) = boot("usb_echo");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    let device = enumerate(&mut desk);
    let port = Serial::all(&device)[0];
    let output = u16::from(port.output.number);
    assert_eq!(desk.ask(request::DEVICE_IN, request::GET_STATUS, 0, 0, 2).unwrap(), [0, 0]);
    assert_eq!(desk.ask(request::INTERFACE_IN, request::GET_STATUS, 0, 0, 2).unwrap(), [0, 0]);
    assert_eq!(desk.ask(request::DEVICE_IN, request::GET_CONFIGURATION, 0, 0, 1).unwrap(), [1]);
    assert_eq!(desk.ask(request::INTERFACE_IN, request::GET_INTERFACE, 0, 1, 1).unwrap(), [0]);
    // The host makes a short read of a long descriptor, and a long read of a short descriptor.
    assert_eq!(desk.descriptor(request::CONFIGURATION, 0, 20).unwrap(), device.configuration_bytes[..20]);
    assert_eq!(desk.descriptor(request::CONFIGURATION, 0, 0xFFFF).unwrap(), device.configuration_bytes);
    // A halt stops the endpoint, and its end starts the toggle over.
    port.write(&mut desk, b"a").unwrap();
    port.read_exact(&mut desk, 1).unwrap();
    desk.tell(request::ENDPOINT_OUT, request::SET_FEATURE, request::ENDPOINT_HALT, output, &[]).unwrap();
    assert_eq!(desk.ask(request::ENDPOINT_IN, request::GET_STATUS, 0, output, 2).unwrap(), [1, 0]);
    assert!(port.write(&mut desk, b"b").unwrap_err().is_stall());
    desk.tell(request::DEVICE_OUT, request::SET_CONFIGURATION, 0, 0, &[]).unwrap();
    assert_eq!(desk.ask(request::DEVICE_IN, request::GET_CONFIGURATION, 0, 0, 1).unwrap(), [0]);
}

#[test]
fn a_control_transfer_may_be_given_up_at_any_point() {
    let (mut bench, mut host) = boot("usb_echo");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    let device = enumerate(&mut desk);
    let read = Setup { kind: 0x80, request: request::GET_DESCRIPTOR, value: 0x0200, index: 0, length: 67 };
    let write = Setup { kind: 0x21, request: 0x20, value: 0, index: 0, length: 7 };
    for (setup, data) in [(read, vec![]), (write, vec![0x80, 0x25, 0, 0, 0, 0, 8])] {
        for after in 1..=8 {
            let endpoint = desk.control_endpoint();
            let id = desk.submit(endpoint, Request::Abandoned { setup: setup.bytes(), data: data.clone(), after });
            desk.wait(id).unwrap();
            let all = desk.descriptor(request::CONFIGURATION, 0, 67);
            assert_eq!(all.as_ref(), Ok(&device.configuration_bytes), "after {after} of {setup:?}");
        }
    }
    assert_clean(&mut bench);
}

#[test]
fn the_cable_may_be_pulled_out_at_any_moment() {
    let (mut bench, mut host) = boot("usb_echo");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    for round in 0..12_u64 {
        let device = enumerate(&mut desk);
        let port = Serial::all(&device)[0];
        // The reset comes in the middle of traffic both ways.
        let sent = desk.submit(port.output, Request::Out { data: vec![b'x'; 4_096], zero: false }).unwrap();
        let heard = port.listen(&mut desk, 4_096).unwrap();
        desk.pass(300_000 + round * 77_777).unwrap();
        desk.unplug();
        assert_eq!(desk.ended(sent).unwrap().outcome, Outcome::Gone);
        desk.ended(heard).unwrap();
        desk.pass(round * 1_300_000).unwrap();
    }
    let device = enumerate(&mut desk);
    let port = Serial::all(&device)[0];
    // Earlier bytes for the image may still come.
    port.write(&mut desk, b"the end").unwrap();
    port.read_until(&mut desk, b"THE END").unwrap();
    assert_clean(&mut bench);
}

#[test]
fn suspend_and_resume_keep_the_configuration() {
    let (mut bench, mut host) = boot("usb_echo");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    let device = enumerate(&mut desk);
    let port = Serial::all(&device)[0];
    desk.suspend();
    desk.pass_ms(50).unwrap();
    assert_eq!(desk.port(), Port::Suspended);
    desk.resume().unwrap();
    port.write(&mut desk, b"awake").unwrap();
    assert_eq!(port.read_exact(&mut desk, 5).unwrap(), b"AWAKE");
    assert_clean(&mut bench);
}

#[test]
fn a_run_is_the_same_each_time_and_however_it_is_cut() {
    let run = |slice_ns: u64| {
        let (mut bench, mut host) = boot("usb_echo");
        bench.vm.run_for(10 * MS);
        let mut desk = host.at(&mut bench.vm);
        let device = enumerate(&mut desk);
        let port = Serial::all(&device)[0];
        let heard = port.listen(&mut desk, 64).unwrap();
        let sent = desk.submit(port.output, Request::Out { data: b"once upon".to_vec(), zero: false }).unwrap();
        let end = desk.vm.now_ns() + 5 * MS;
        while desk.vm.now_ns() < end {
            desk.pass(slice_ns.min(end - desk.vm.now_ns())).unwrap();
        }
        let times = [heard, sent].map(|id| desk.ended(id).unwrap().at_ns);
        (times, desk.tally(), desk.vm.instructions())
    };
    let whole = run(5 * MS);
    assert_eq!(run(5 * MS), whole);
    assert_eq!(run(77_777), whole);
}
