//! An image that touches the core's registers itself, is driven by its interrupts and sleeps in between.

use usb_host::controller::{Port, PortEvent};
use usb_host::descriptors::BULK;
use usb_host::transfer::{Direction, Endpoint, Outcome, Request};
use usb_host::wire::Toggle;
use virtual_prime::usb_desk::UsbError;

use super::*;

const VENDOR_OUT: u8 = 0x40;
const VENDOR_IN: u8 = 0xC0;

/// Asks for the counts of bus resets, suspends, wake-ups, frames.
fn counts(desk: &mut Desk<'_>) -> [u32; 4] {
    let bytes = desk.ask(VENDOR_IN, 3, 0, 0, 16).unwrap();
    std::array::from_fn(|place| u32::from_le_bytes(bytes[4 * place..][..4].try_into().unwrap()))
}

fn bulk(device: &Device, direction: Direction) -> Endpoint {
    device.configuration.interfaces[0].endpoint(direction, BULK).unwrap().of(device.address)
}

#[test]
fn control_transfers_of_every_size_go_both_ways() {
    let (mut bench, mut host) = boot("usb_registers");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    enumerate(&mut desk);
    for size in 1..=64_u8 {
        let data: Vec<u8> = (0..size).map(|byte| byte.wrapping_mul(37)).collect();
        desk.tell(VENDOR_OUT, 1, 0, 0, &data).unwrap();
        assert_eq!(desk.ask(VENDOR_IN, 2, 0, 0, 255).unwrap(), data);
    }
    assert!(desk.tell(VENDOR_OUT, 1, 0, 0, &[0; 65]).unwrap_err().is_stall());
    assert!(desk.ask(VENDOR_IN, 9, 0, 0, 1).unwrap_err().is_stall());
    desk.tell(VENDOR_OUT, 7, 0, 0, &[]).unwrap();
    assert!(matches!(desk.pass_ms(5), Err(UsbError::Over(_))));
    assert_clean(&mut bench);
}

#[test]
fn bulk_packets_come_back_and_repeated_ones_do_not_count() {
    let (mut bench, mut host) = boot("usb_registers");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    let device = enumerate(&mut desk);
    let (input, output) = (bulk(&device, Direction::In), bulk(&device, Direction::Out));
    for size in 0..=64_usize {
        let data = vec![size as u8; size];
        desk.write(output, &data).unwrap();
        assert_eq!(desk.read(input, 64).unwrap(), data);
    }
    // Of 65 packets the last is repeated, as if its handshake had been lost.
    desk.controller(move |host, _, _| host.set_toggle(output, Toggle::Data0));
    desk.write(output, &[64; 64]).unwrap();
    desk.write(output, b"next").unwrap();
    // The host receives the first answer garbled.
    let lost = desk.submit(input, Request::Garbled);
    assert_eq!(desk.wait(lost).unwrap().data, b"next");
    assert_eq!(desk.read(input, 64).unwrap(), b"next");
    // Babble gets no answer and leaves the endpoint as it was.
    let wide = Endpoint { max_packet: 70, ..output };
    let babble = desk.submit(wide, Request::Out { data: vec![1; 70], zero: false });
    assert!(matches!(desk.wait(babble), Err(UsbError::Ended(Outcome::Failed, _))));
    desk.controller(move |host, _, _| host.set_toggle(output, Toggle::Data0));
    desk.write(output, b"well").unwrap();
    assert_eq!(desk.read(input, 64).unwrap(), b"well");
    assert_clean(&mut bench);
}

#[test]
fn the_image_sleeps_and_every_frame_wakes_it() {
    let (mut bench, mut host) = boot("usb_registers");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    enumerate(&mut desk);
    let (frames, began, instructions) = (counts(&mut desk)[3], desk.vm.now_ns(), desk.vm.instructions());
    desk.pass_ms(100).unwrap();
    let passed_ms = (desk.vm.now_ns() - began) / MS;
    let executed = desk.vm.instructions() - instructions;
    assert!(executed < 100_000, "{executed} instructions in {passed_ms} ms");
    let frames = u64::from(counts(&mut desk)[3] - frames);
    assert!((99..=102).contains(&frames), "{frames} frames in {passed_ms} ms");
}

#[test]
fn suspend_is_noticed_and_remote_wake_up_ends_it() {
    let (mut bench, mut host) = boot("usb_registers");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    enumerate(&mut desk);
    let before = counts(&mut desk);
    desk.suspend();
    desk.pass_ms(20).unwrap();
    desk.resume().unwrap();
    let after = counts(&mut desk);
    assert_eq!(after[..3], [before[0], before[1] + 1, before[2] + 1]);
    desk.tell(VENDOR_OUT, 4, 0, 0, &[]).unwrap();
    desk.take_events();
    desk.suspend();
    // The times are 6 ms until suspend, 5 ms until the device wakes the host, 20 ms of resume.
    desk.pass_ms(35).unwrap();
    assert_eq!(desk.port(), Port::Enabled);
    let events = desk.take_events();
    assert!(matches!(events[..], [PortEvent::Woken(4_990_000..=5_010_000)]), "{events:?}");
    assert_eq!(counts(&mut desk)[1], after[1] + 1);
    assert_clean(&mut bench);
}

#[test]
fn a_soft_disconnect_ends_everything_and_a_new_connection_begins_it() {
    let (mut bench, mut host) = boot("usb_registers");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    let device = enumerate(&mut desk);
    let waits = desk.submit(bulk(&device, Direction::In), Request::In(64)).unwrap();
    desk.tell(VENDOR_OUT, 6, 0, 0, &[]).unwrap();
    desk.take_events();
    desk.pass_ms(5).unwrap();
    assert_eq!(desk.port(), Port::Empty);
    assert_eq!(desk.ended(waits).unwrap().outcome, Outcome::Gone);
    desk.pass_ms(30).unwrap();
    assert_eq!(desk.take_events(), [PortEvent::Disconnected, PortEvent::Connected]);
    enumerate(&mut desk);
    assert_clean(&mut bench);
}

#[test]
fn a_reset_of_the_part_is_a_disconnect_and_the_device_comes_back() {
    let (mut bench, mut host) = boot("usb_registers");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    enumerate(&mut desk);
    desk.take_events();
    desk.vm.with(|stopped| stopped.session.reset_by_pin(stopped.stop.at, stopped.stop.instruction_count, stopped.host));
    desk.pass_ms(20).unwrap();
    assert_eq!(desk.take_events(), [PortEvent::Disconnected, PortEvent::Connected]);
    enumerate(&mut desk);
    assert_eq!(counts(&mut desk)[0], 1, "a fresh image");
    let complaints = bench.vm.complaints();
    assert!(complaints.len() == 1 && complaints[0].starts_with("reset"), "{complaints:?}");
}

#[test]
fn the_ulpis_clock_enabled_for_sleep_is_a_trap() {
    let (mut bench, mut host) = boot("usb_registers");
    bench.vm.run_for(10 * MS);
    let mut desk = host.at(&mut bench.vm);
    enumerate(&mut desk);
    desk.tell(VENDOR_OUT, 5, 0, 0, &[]).unwrap();
    desk.pass_ms(5).unwrap();
    let answer = desk.ask(VENDOR_IN, 3, 0, 0, 16);
    assert!(matches!(answer, Err(UsbError::Ended(Outcome::Failed, _))), "{answer:?}");
    let complaints = bench.vm.complaints();
    assert!(complaints.len() == 1 && complaints[0].contains("USB2OTGHSULPILPEN"), "{complaints:?}");
}

#[test]
fn without_a_host_nothing_is_said_and_nothing_happens() {
    let (mut bench, _) = boot("usb_registers");
    // The wait lasts until the device has noticed that the line is idle.
    bench.vm.run_for(30 * MS);
    let before = bench.vm.instructions();
    bench.vm.run_for(1_000 * MS);
    assert_eq!(bench.vm.instructions(), before, "the image sleeps");
    assert_clean(&mut bench);
}
