//! The boot stage: the first code after every reset, from the first sector of the flash. The boot stage
//! finishes or undoes updates (`update` decides, see there), verifies the image behind it and starts it. If
//! no image may run, it waits for a new one.
//!
//! The boot stage has no machine and no configuration. Every output is off while it runs.
#![no_std]
#![no_main]
#![allow(unsafe_code, reason = "interrupts are let through here")]

mod card;
mod crippled;
mod download;
mod end;
mod interrupts;
mod patience;
mod waiting;
mod words;

use bsp_prime::boot_stage::BootStage;
use bsp_prime::identity::Cause;
use cortex_m_rt::entry;
use update::{Ended, Next, PRIME, VECTOR_TABLE, settle};

use crate::card::CardFiles;
use crate::patience::Patience;
use crate::waiting::Why;
use crate::words::Words;

#[entry]
fn main() -> ! {
    let (Some(core), Some(device)) = (cortex_m::Peripherals::take(), bsp_prime::pac::Peripherals::take()) else {
        end::again()
    };
    let board = match BootStage::take(core, device) {
        Ok(board) => board,
        Err(crippled) => crippled::run(crippled),
    };
    interrupts::start(board.tick, board.debug.0);
    let mut words = Words::new(board.debug.1);
    let mut card = CardFiles::new(board.sd);
    let mut flash = Patience::new(board.flash, board.watchdog, board.leds);
    if board.download {
        waiting::run(&mut flash, &mut card, &mut words, board.usb, Why::Asked);
    }
    if let Next::Recover(flaw) = settle(&mut flash, &mut card, &PRIME, ended(board.reset_cause)) {
        waiting::run(&mut flash, &mut card, &mut words, board.usb, Why::Nothing(flaw));
    }
    board.hand_over.start(PRIME.image_address() + VECTOR_TABLE)
}

/// Returns how the application's last run ended, by the cause of the reset.
const fn ended(cause: Cause) -> Ended {
    match cause {
        Cause::Watchdog => Ended::Watchdog,
        Cause::Software => Ended::Itself,
        Cause::PowerOn | Cause::BrownOut | Cause::Pin | Cause::Unknown => Ended::Early,
    }
}
