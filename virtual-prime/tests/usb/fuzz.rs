//! Requests of any kind at the image: nothing that a host says on endpoint 0, and to the card reader, ends
//! it, hangs it, or makes the machine move or heat.

use std::time::{Duration, Instant};

use usb_host::request::DEVICE;
use usb_host::transfer::Request;
use virtual_prime::usb_desk::UsbError;
use virtual_prime::usb_desk::bulk_only::{BulkOnly, Data};

use super::velvet::{Plugged, plug, two_ports};
use crate::common::MS;
use crate::common::machine::{changes, watch};
use crate::common::velvet::SECOND;

/// Pins that switch heaters, and their supply.
const HEATERS: [&str; 3] = ["PE0", "PE3", "PD7"];
/// Requests between two checks of the machine's health, and the most of them behind one enumeration.
const A_ROUND: u32 = 40;
/// Time limit of an answer: a request that is never answered is given up, as by a host in a hurry.
const PATIENCE_MS: u64 = 60;

/// Xorshift64 generator (Marsaglia 2003).
struct Dice(u64);

impl Dice {
    const fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    const fn up_to(&mut self, end: u64) -> u64 {
        (self.next() >> 11) % end
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.up_to(choices.len() as u64) as usize]
    }

    fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.next() as u8).collect()
    }

    /// Returns eight bytes: any at all, or a valid request with each field near existing values.
    fn setup(&mut self) -> [u8; 8] {
        let mut setup = [0; 8];
        if self.up_to(4) == 0 {
            setup.copy_from_slice(&self.bytes(8));
        } else {
            let kind = self.of(&[0x00, 0x01, 0x02, 0x80, 0x81, 0x82, 0x21, 0xA1, 0x40, 0xC0, 0xC1, 0x22, 0xA2]);
            let request = self.of(&[0, 1, 3, 6, 7, 8, 9, 10, 11, 12, 0x20, 0x21, 0x22, 0x23, 0xFE, 0xFF, 2, 4, 5]);
            let value = self.of(&[0, 1, 2, 0x0100, 0x0200, 0x0300, 0x0301, 0x0302, 0x0303, 0x0600, 0x0F00, 0xFFFF]);
            let index = self.of(&[0_u16, 1, 2, 3, 4, 5, 6, 7, 0x80, 0x81, 0x85, 0x0409, 0x0103, 0xFFFF]);
            let length = self.of(&[0_u16, 1, 2, 6, 7, 8, 18, 63, 64, 65, 128, 255, 256, 257, 4_096, 0xFFFF]);
            setup[0] = kind;
            setup[1] = request;
            setup[2..4].copy_from_slice(&u16::to_le_bytes(value));
            setup[4..6].copy_from_slice(&index.to_le_bytes());
            setup[6..8].copy_from_slice(&length.to_le_bytes());
        }
        // A new address would only lose the device.
        if setup[..2] == [0, 5] {
            setup[1] = 9;
        }
        setup
    }
}

/// Starts a machine with a long job, so that a request for the download is refused as well.
fn machine() -> Plugged {
    let plan = two_ports().set("[system] msc_enable = true").set("[system] dfu_enable = true");
    let mut plugged = plug(plan.file("long.g", &"G4 P50\n".repeat(60_000)));
    plugged.velvet.type_in("play long.g");
    plugged.velvet.hear(100);
    watch(&mut plugged.velvet, &HEATERS);
    changes(&mut plugged.velvet);
    plugged.host.patience_ms = PATIENCE_MS;
    plugged
}

/// Makes a request, or a command of the reader, that may end in any way; only the image must not end.
fn one(plugged: &mut Plugged, dice: &mut Dice) {
    let ends = |ended: Result<(), UsbError>| assert!(!matches!(ended, Err(UsbError::Over(_))), "{ended:?}");
    let disk = BulkOnly::of(&plugged.device).expect("a card reader");
    let mut desk = plugged.desk();
    match dice.up_to(16) {
        0 => {
            let (endpoint, data) = (desk.control_endpoint(), dice.bytes(70));
            let request = Request::Abandoned { setup: dice.setup(), data, after: 1 + dice.up_to(5) as u32 };
            let id = desk.submit(endpoint, request);
            ends(desk.wait(id).map(drop));
        }
        1 => {
            let mut wrapper = BulkOnly::wrapper(1, 0, &dice.bytes(16), Data::None);
            wrapper[8..15].copy_from_slice(&dice.bytes(7));
            let length = dice.of(&[31, 31, 31, 30, 13, 1, 64]).min(wrapper.len());
            ends(desk.write(disk.output, &wrapper[..length]));
            ends(desk.read(disk.input, 64).map(drop));
        }
        2 => ends(desk.write(disk.output, &vec![0x55; dice.up_to(200) as usize])),
        3 => {
            desk.suspend();
            let _asleep = desk.pass(dice.up_to(8 * MS));
            ends(desk.resume());
        }
        _ => {
            let setup = dice.setup();
            let length = usize::from(u16::from_le_bytes([setup[6], setup[7]]));
            ends(desk.control(setup, &dice.bytes(length.min(600))).map(drop));
        }
    }
}

/// Asserts that the machine is well: it enumerates, its consoles answer, and nothing was switched on.
#[track_caller]
fn assert_well(plugged: &mut Plugged) {
    plugged.host.patience_ms = 5_000;
    plugged.device = plugged.desk().enumerate().expect("it is a device still");
    assert_eq!(plugged.desk().descriptor(DEVICE, 0, 18).expect("a descriptor").len(), 18);
    plugged.velvet.type_in("M105");
    plugged.velvet.hear_until("T:", SECOND);
    assert_eq!(changes(&mut plugged.velvet).len(), 0, "an output of a heater has changed");
    assert_eq!(plugged.velvet.said().matches("Smoothie").count(), 1, "it has started once");
    plugged.host.patience_ms = PATIENCE_MS;
}

#[test]
fn any_request_leaves_the_machine_as_it_is() {
    let mut plugged = machine();
    let mut dice = Dice(0x2545_F491_4F6C_DD1D);
    for _ in 0..4 {
        (0..A_ROUND).for_each(|_| one(&mut plugged, &mut dice));
        assert_well(&mut plugged);
    }
    plugged.assert_clean();
}

/// Makes requests for as long as `VELVET_FUZZ_SECONDS` says, an hour without; `VELVET_FUZZ_SEED` sets the
/// seed.
#[test]
#[ignore = "an hour, or as long as one says: make usb-fuzz"]
fn any_request_for_long() {
    let number =
        |name: &str, otherwise| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise);
    let limit = Duration::from_secs(number("VELVET_FUZZ_SECONDS", 3_600));
    let mut seed = number("VELVET_FUZZ_SEED", 1);
    let (began, mut requests) = (Instant::now(), 0_u64);
    while began.elapsed() < limit {
        let mut plugged = machine();
        let mut dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        for _ in 0..50 {
            (0..A_ROUND).for_each(|_| one(&mut plugged, &mut dice));
            assert_well(&mut plugged);
            requests += u64::from(A_ROUND);
            println!("seed {seed}: {requests} requests in {} s", began.elapsed().as_secs());
            if began.elapsed() >= limit {
                break;
            }
        }
        plugged.assert_clean();
        seed += 1;
    }
}
