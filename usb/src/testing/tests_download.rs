//! Firmware download: the entry from the machine, and the download itself.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

use proptest::prelude::*;
use usb_device::bus::UsbBusAllocator;

use super::bus::Bus;
use super::device::Device;
use super::host::Host;
use super::{Board, Failure, Options, Request, walk};
use crate::{DownloadDevice, Firmware, Guarded, Refused, SerialNumber};

const DETACH: u8 = 0;
const DNLOAD: u8 = 1;
const UPLOAD: u8 = 2;
const GETSTATUS: u8 = 3;
const CLRSTATUS: u8 = 4;
const GETSTATE: u8 = 5;
const ABORT: u8 = 6;

const IDLE: u8 = 2;
const DNLOAD_SYNC: u8 = 3;
const DNBUSY: u8 = 4;
const DNLOAD_IDLE: u8 = 5;
const MANIFEST_SYNC: u8 = 6;
const MANIFEST: u8 = 7;
const MANIFEST_WAIT_RESET: u8 = 8;
const UPLOAD_IDLE: u8 = 9;
const ERROR: u8 = 10;

// --- the machine's side ---

#[test]
fn a_machine_that_rests_detaches() {
    let mut board = Board::enumerated();
    assert_eq!(board.host.ask(Request::new(0xA1, GETSTATE, 0, 5, 1)).unwrap(), [0], "appIDLE");
    assert_eq!(board.host.ask(Request::new(0xA1, GETSTATUS, 0, 5, 6)).unwrap(), [0; 6]);
    board.host.out(Request::new(0x21, DETACH, 1000, 5, 0), &[]).unwrap();
    assert_eq!(board.machine.asked.load(Ordering::Relaxed), 1);
    assert_eq!(board.host.ask(Request::new(0xA1, GETSTATE, 0, 5, 1)).unwrap(), [1], "appDETACH");
}

#[test]
fn a_machine_that_moves_or_heats_refuses_and_goes_on() {
    let mut board = Board::enumerated();
    board.machine.is_busy.store(true, Ordering::Relaxed);
    assert_eq!(board.host.out(Request::new(0x21, DETACH, 1000, 5, 0), &[]), Err(Failure::Stall));
    assert_eq!(board.host.ask(Request::new(0xA1, GETSTATE, 0, 5, 1)).unwrap(), [0], "appIDLE");
    board.host.bulk_out(1, b"G1 X1\n").unwrap();
}

#[test]
fn the_running_machine_takes_no_firmware() {
    let mut board = Board::enumerated();
    for request in [DNLOAD, CLRSTATUS, ABORT] {
        assert_eq!(board.host.out(Request::new(0x21, request, 0, 5, 0), &[]), Err(Failure::Stall));
    }
    assert_eq!(board.host.ask(Request::new(0xA1, UPLOAD, 0, 5, 64)), Err(Failure::Stall));
    let mut without = Board::new(Options { download: false, ..Options::ALL });
    without.host.enumerate();
    assert_eq!(without.host.out(Request::new(0x21, DETACH, 0, 5, 0), &[]), Err(Failure::Stall));
}

// --- the boot stage's side ---

/// Contents of a memory, and its refusals.
#[derive(Debug, Default)]
struct Inside {
    bytes: Vec<u8>,
    whole: Option<Vec<u8>>,
    refuses_at: Option<(u32, Refused)>,
    refuses_whole: Option<Refused>,
    /// Whether the host has been told to wait.
    told: bool,
}

#[derive(Clone, Default)]
struct Memory(Arc<Mutex<Inside>>);

impl Firmware for Memory {
    fn write(&mut self, at: u32, piece: &[u8]) -> Result<(), Refused> {
        let mut inside = self.0.lock().unwrap();
        if at == 0 {
            inside.bytes.clear();
            inside.whole = None;
        }
        if let Some((from, why)) = inside.refuses_at
            && at >= from
        {
            return Err(why);
        }
        assert_eq!(inside.bytes.len(), at as usize);
        inside.bytes.extend_from_slice(piece);
        Ok(())
    }

    fn write_ms(&self, at: u32, _: usize) -> u32 {
        self.0.lock().unwrap().told = true;
        if at == 0 { 2_000 } else { 5 }
    }

    fn finish(&mut self) -> Result<(), Refused> {
        let mut inside = self.0.lock().unwrap();
        if let Some(why) = inside.refuses_whole {
            return Err(why);
        }
        inside.whole = Some(inside.bytes.clone());
        Ok(())
    }

    fn finish_ms(&self) -> u32 {
        300
    }

    fn read(&mut self, at: u32, into: &mut [u8]) -> Result<usize, Refused> {
        let inside = self.0.lock().unwrap();
        let whole = inside.whole.as_ref().ok_or(Refused::Firmware)?;
        let rest = &whole[(at as usize).min(whole.len())..];
        let count = rest.len().min(into.len());
        into[..count].copy_from_slice(&rest[..count]);
        Ok(count)
    }
}

type Downloads = DownloadDevice<'static, Guarded<Bus>, Memory>;

impl Device for Downloads {
    fn run(&mut self) {
        for _ in 0..3 {
            DownloadDevice::run(self);
        }
        self.work();
    }
}

fn boot_stage() -> (Host<Downloads>, Memory) {
    let (bus, memory) = (Bus::default(), Memory::default());
    let allocator = Box::leak(Box::new(UsbBusAllocator::new(Guarded::new(bus.clone()))));
    let serial = Box::leak(Box::new(SerialNumber::for_download([1, 2, 3])));
    let device = DownloadDevice::new(allocator, serial, memory.clone()).unwrap();
    let mut host = Host::new(bus, device);
    host.enumerate();
    (host, memory)
}

fn status(host: &mut Host<Downloads>) -> (u8, u8) {
    let answer = host.ask(Request::new(0xA1, GETSTATUS, 0, 0, 6)).unwrap();
    (answer[0], answer[4])
}

fn state(host: &mut Host<Downloads>) -> u8 {
    host.ask(Request::new(0xA1, GETSTATE, 0, 0, 1)).unwrap()[0]
}

fn send(host: &mut Host<Downloads>, number: u16, piece: &[u8]) -> Result<(), Failure> {
    host.out(Request::new(0x21, DNLOAD, number, 0, piece.len() as u16), piece)
}

/// Downloads an image as dfu-util does; returns the final status and state.
fn download(host: &mut Host<Downloads>, image: &[u8]) -> (u8, u8) {
    for (number, piece) in image.chunks(256).enumerate() {
        send(host, number as u16, piece).unwrap();
        loop {
            match status(host) {
                (0, DNBUSY) => {}
                (0, DNLOAD_IDLE) => break,
                failed => return failed,
            }
        }
    }
    send(host, image.len().div_ceil(256) as u16, &[]).unwrap();
    loop {
        match status(host) {
            (0, MANIFEST) => {}
            end => return end,
        }
    }
}

#[test]
fn the_boot_stage_is_a_device_of_its_own() {
    let (mut host, _) = boot_stage();
    let device = host.descriptor(1, 0, 18).unwrap();
    assert_eq!((&device[4..7], &device[8..12]), (&[0, 0, 0][..], &[0x50, 0x1D, 0x15, 0x60][..]));
    let configuration = walk(&host.descriptor(2, 0, 255).unwrap());
    assert_eq!(configuration.len(), 3);
    assert_eq!(configuration[1].body[..6], [0, 0, 0, 0xFE, 1, 2]);
    assert_eq!(configuration[2].body[3..5], [0x00, 0x01], "wTransferSize");
    assert_eq!(walk(&host.descriptor(15, 0, 255).unwrap()).len(), 2, "Windows is told");
    assert_eq!(state(&mut host), IDLE);
}

#[test]
fn firmware_is_taken_piece_after_piece() {
    for length in [1, 255, 256, 257, 1024, 5000] {
        let (mut host, memory) = boot_stage();
        let image: Vec<u8> = (0..length).map(|at| (at * 13) as u8).collect();
        assert_eq!(download(&mut host, &image), (0, MANIFEST_WAIT_RESET));
        assert_eq!(memory.0.lock().unwrap().whole.as_ref(), Some(&image));
        assert!(host.device.is_whole() && !host.device.is_left() && !host.device.is_in_use());
        host.reset();
        assert!(host.device.is_left(), "dfu-util resets the bus");
    }
}

#[test]
fn the_host_is_told_to_wait_before_anything_is_erased() {
    let (mut host, memory) = boot_stage();
    send(&mut host, 0, &[1; 256]).unwrap();
    assert_eq!(state(&mut host), DNLOAD_SYNC);
    assert!(host.device.is_in_use());
    assert!(memory.0.lock().unwrap().bytes.is_empty() && !memory.0.lock().unwrap().told);
    let answer = host.ask(Request::new(0xA1, GETSTATUS, 0, 0, 6)).unwrap();
    assert_eq!(answer, [0, 0xD0, 0x07, 0, DNBUSY, 0], "two seconds");
    assert_eq!(memory.0.lock().unwrap().bytes.len(), 256, "behind the answer");
    assert_eq!(state(&mut host), DNLOAD_IDLE);
}

#[test]
fn firmware_is_given_back() {
    for length in [1, 256, 300, 512] {
        let (mut host, memory) = boot_stage();
        let image: Vec<u8> = (0..length).map(|at| at as u8).collect();
        memory.0.lock().unwrap().whole = Some(image.clone());
        let mut read = Vec::new();
        for number in 0.. {
            let piece = host.ask(Request::new(0xA1, UPLOAD, number, 0, 256)).unwrap();
            read.extend_from_slice(&piece);
            if piece.len() < 256 {
                break;
            }
            assert_eq!(state(&mut host), UPLOAD_IDLE);
        }
        assert_eq!((read, state(&mut host)), (image, IDLE));
    }
    let (mut host, _) = boot_stage();
    assert_eq!(host.ask(Request::new(0xA1, UPLOAD, 0, 0, 256)), Err(Failure::Stall), "there is none");
    assert_eq!(status(&mut host), (0x0A, ERROR));
}

#[test]
fn firmware_that_is_refused_can_be_sent_again() {
    let (mut host, memory) = boot_stage();
    memory.0.lock().unwrap().refuses_at = Some((512, Refused::Write));
    assert_eq!(download(&mut host, &[3; 2000]), (0x03, ERROR));
    assert_eq!(send(&mut host, 3, &[0; 256]), Err(Failure::Stall), "an error is seen first");
    host.out(Request::new(0x21, CLRSTATUS, 0, 0, 0), &[]).unwrap();
    assert_eq!(status(&mut host), (0, IDLE));
    memory.0.lock().unwrap().refuses_at = None;
    memory.0.lock().unwrap().refuses_whole = Some(Refused::File);
    assert_eq!(download(&mut host, &[3; 2000]), (0x02, ERROR));
    host.reset();
    assert!(!host.device.is_left(), "nothing to start");
    host.enumerate();
    memory.0.lock().unwrap().refuses_whole = None;
    assert_eq!(download(&mut host, &[4; 100]), (0, MANIFEST_WAIT_RESET));
}

/// errVENDOR gives its reason in a string (DFU 1.1 section 6.1.2, iString).
#[test]
fn what_has_no_copy_to_come_back_to_says_so_in_a_string() {
    let (mut host, memory) = boot_stage();
    memory.0.lock().unwrap().refuses_at = Some((0, Refused::NoCopy));
    send(&mut host, 0, &[3; 256]).unwrap();
    status(&mut host);
    let answer = host.ask(Request::new(0xA1, GETSTATUS, 0, 0, 6)).unwrap();
    assert_eq!((answer[0], answer[4]), (0x0B, ERROR));
    let string = host.descriptor(3, answer[5], 255).unwrap();
    let words: Vec<u16> = string[2..].chunks(2).map(|unit| u16::from_le_bytes([unit[0], unit[1]])).collect();
    assert!(String::from_utf16(&words).unwrap().contains("firmware.previous"));
}

#[test]
fn requests_out_of_their_order_are_refused() {
    let (mut host, _) = boot_stage();
    assert_eq!(send(&mut host, 0, &[]), Err(Failure::Stall), "nothing is no firmware");
    assert_eq!(status(&mut host), (0x0F, ERROR));
    host.out(Request::new(0x21, CLRSTATUS, 0, 0, 0), &[]).unwrap();
    send(&mut host, 0, &[0; 256]).unwrap();
    assert_eq!(send(&mut host, 1, &[0; 256]), Err(Failure::Stall), "the first has not been taken");
    host.out(Request::new(0x21, CLRSTATUS, 0, 0, 0), &[]).unwrap();
    send(&mut host, 0, &[0; 256]).unwrap();
    assert_eq!(status(&mut host).1, DNBUSY);
    assert_eq!(send(&mut host, 7, &[0; 256]), Err(Failure::Stall), "a piece is missing");
    host.out(Request::new(0x21, CLRSTATUS, 0, 0, 0), &[]).unwrap();
    send(&mut host, 0, &[0; 256]).unwrap();
    host.out(Request::new(0x21, ABORT, 0, 0, 0), &[]).unwrap();
    assert_eq!(state(&mut host), IDLE);
    for request in [DETACH, CLRSTATUS] {
        assert_eq!(host.out(Request::new(0x21, request, 0, 0, 0), &[]), Err(Failure::Stall));
        assert_eq!(status(&mut host), (0x0F, ERROR));
        host.out(Request::new(0x21, CLRSTATUS, 0, 0, 0), &[]).unwrap();
    }
    assert_eq!(host.ask(Request::new(0xA1, UPLOAD, 0, 0, 257)), Err(Failure::Stall), "more than a piece");
    let _ = MANIFEST_SYNC;
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    /// After any order of requests, all of which are answered, a download is complete.
    #[test]
    fn any_order_of_requests_leads_back(requests in prop::collection::vec((0_u8..8, 0_u16..4, 0_u16..300), 0..20)) {
        let (mut host, memory) = boot_stage();
        for (request, value, length) in requests {
            let failed = if matches!(request, UPLOAD | GETSTATUS | GETSTATE) {
                host.ask(Request::new(0xA1, request, value, 0, length)).err()
            } else {
                let data = vec![9; if request == DNLOAD { length.into() } else { 0 }];
                host.out(Request::new(0x21, request, value, 0, data.len() as u16), &data).err()
            };
            prop_assert_ne!(failed, Some(Failure::Timeout));
        }
        host.enumerate();
        prop_assert_eq!(download(&mut host, &[7; 600]), (0, MANIFEST_WAIT_RESET));
        prop_assert_eq!(memory.0.lock().unwrap().whole.clone(), Some(vec![7; 600]));
    }
}
