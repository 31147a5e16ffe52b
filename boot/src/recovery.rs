//! What the boot stage does when nothing in flash may run: it says so, and waits for an image.

use bsp_prime::time;
use update::{Flaw, Next, PRIME, settle};

use crate::card::CardFiles;
use crate::patience::Patience;
use crate::words::Words;

/// Between two looks at the card.
const LOOK_EVERY_US: u64 = 2_000_000;
/// All LEDs on, all off.
const BLINK_US: u64 = 250_000;

/// Comes back when an image may run.
pub fn run(flash: &mut Patience, card: &mut CardFiles, words: &mut Words, flaw: Flaw) {
    words.say(format_args!("boot stage: no firmware that may run: {flaw}"));
    words.say(format_args!("put flashme.bin on a card, or hold BOOT0 and press RESET for dfu-util"));
    loop {
        wait(flash, LOOK_EVERY_US);
        card.forget();
        if let Next::Start(_) = settle(flash, card, &PRIME) {
            return;
        }
    }
}

/// Waits, with the LEDs blinking.
fn wait(flash: &mut Patience, time_us: u64) {
    let start = time::now().0;
    while time::now().0 - start < time_us {
        flash.feed();
        flash.show(if (time::now().0 / BLINK_US).is_multiple_of(2) { 0 } else { 15 });
        cortex_m::asm::wfi();
    }
    flash.show(0);
}
