//! The boot stage without an application to start: it reports the reason, and takes an image over USB, or, if
//! none may run, from the card. The wait ends with a reset; the next start runs the new image.

use bsp_prime::usb::{OtgBus, UsbSocket};
use bsp_prime::{boot_stage, time};
use update::{Flaw, PRIME, may_recover};
use usb::{DownloadDevice, Guarded, SerialNumber, UsbBusAllocator};

use crate::card::CardFiles;
use crate::download::Incoming;
use crate::interrupts;
use crate::patience::Patience;
use crate::words::Words;

/// Time between two checks of the card for an image.
const LOOK_EVERY_US: u64 = 2_000_000;
/// Time of the LEDs on, and of the LEDs off.
const BLINK_US: u64 = 250_000;
/// Time after which a requested download that nobody begins is given up.
const NOBODY_COMES_US: u64 = 300_000_000;
/// Time that a host which has sent an image has to reset the bus, though it need not.
const LEAVE_US: u64 = 1_000_000;

/// Reason for waiting in the boot stage.
#[derive(Clone, Copy)]
pub enum Why {
    /// A host or person asked for the download.
    Asked,
    /// No image in flash may run.
    Nothing(Flaw),
}

impl Why {
    /// Returns the LED patterns of both halves of a blink.
    const fn patterns(self) -> [u32; 2] {
        match self {
            Self::Asked => [0b0011, 0b1100],
            Self::Nothing(_) => [0b1111, 0b0000],
        }
    }
}

/// Waits for an image; ends with a reset.
pub fn run(flash: &mut Patience, card: &mut CardFiles, words: &mut Words, usb: (UsbSocket, [u32; 3]), why: Why) -> ! {
    say(words, why);
    let (socket, unique_id) = usb;
    match socket.start() {
        Ok(bus) => with_usb(flash, card, words, (bus, unique_id), why),
        Err(_) => {
            words.say(format_args!("boot stage: USB does not start"));
            alone(flash, card, why)
        }
    }
}

fn say(words: &mut Words, why: Why) {
    match why {
        Why::Asked => {
            words.say(format_args!("boot stage: waits for firmware over USB: dfu-util -D flashme.bin; RESET leaves"));
        }
        Why::Nothing(flaw) => {
            words.say(format_args!("boot stage: no firmware that may run: {flaw}"));
            words.say(format_args!("put flashme.bin on a card, or send it over USB: dfu-util -D flashme.bin"));
        }
    }
}

fn with_usb(
    flash: &mut Patience,
    card: &mut CardFiles,
    words: &mut Words,
    (bus, unique_id): (OtgBus, [u32; 3]),
    why: Why,
) -> ! {
    let bus = UsbBusAllocator::new(Guarded::new(bus));
    let serial = SerialNumber::for_download(unique_id);
    let Ok(mut device) = DownloadDevice::new(&bus, &serial, Incoming::new(flash, card)) else {
        boot_stage::reset();
    };
    bsp_prime::usb::connect();
    let mut watch = Watch::new();
    loop {
        device.run();
        device.work();
        if device.firmware().take_lacks_copy() {
            words.say(format_args!("boot stage: not taken: the card holds no firmware to come back to"));
            words.say(format_args!("put in a card with firmware.previous: any flashme.bin by that name"));
        }
        let now = time::now().0;
        let flash = device.firmware().flash();
        flash.feed();
        if now >= watch.blink_at {
            watch.blink(now, flash, why);
        }
        if device.is_in_use() {
            watch.in_use_until = now + NOBODY_COMES_US;
        }
        if device.is_left() {
            leave(words);
        }
        if device.is_whole() {
            if now >= watch.whole_since.get_or_insert(now).saturating_add(LEAVE_US) {
                leave(words);
            }
            continue;
        }
        watch.whole_since = None;
        match why {
            Why::Asked if now >= watch.in_use_until => leave(words),
            // A connected host has priority, as a check of the card may take a second.
            Why::Nothing(_) if now >= watch.look_at && !device.is_addressed() => {
                watch.look_at = now + LOOK_EVERY_US;
                let (flash, card) = device.firmware().flash_and_card();
                look(flash, card);
            }
            _ => {}
        }
        interrupts::wait();
    }
}

/// Times at which tasks are due.
struct Watch {
    blink_at: u64,
    phase: bool,
    look_at: u64,
    in_use_until: u64,
    whole_since: Option<u64>,
}

impl Watch {
    fn new() -> Self {
        let now = time::now().0;
        let in_use_until = now + NOBODY_COMES_US;
        Self { blink_at: now, phase: false, look_at: now + LOOK_EVERY_US, in_use_until, whole_since: None }
    }

    fn blink(&mut self, now: u64, flash: &mut Patience, why: Why) {
        self.blink_at = now + BLINK_US;
        self.phase = !self.phase;
        let [one, other] = why.patterns();
        flash.show(if self.phase { one } else { other });
    }
}

/// Without USB, only the card can bring an image.
fn alone(flash: &mut Patience, card: &mut CardFiles, why: Why) -> ! {
    let mut watch = Watch::new();
    loop {
        let now = time::now().0;
        flash.feed();
        if now >= watch.blink_at {
            watch.blink(now, flash, why);
        }
        if now >= watch.look_at {
            watch.look_at = now + LOOK_EVERY_US;
            match why {
                Why::Asked => boot_stage::reset(),
                Why::Nothing(_) => look(flash, card),
            }
        }
        interrupts::wait();
    }
}

/// Resets the board if the card has an image by now, so that the next start installs it.
fn look(flash: &mut Patience, card: &mut CardFiles) {
    card.forget();
    if may_recover(flash, card, &PRIME) {
        boot_stage::reset();
    }
}

fn leave(words: &mut Words) -> ! {
    words.finish();
    boot_stage::reset()
}
