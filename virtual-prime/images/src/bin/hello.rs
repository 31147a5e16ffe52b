//! Starts the board and talks on the debug console: greets, then echoes bytes in upper case until a full
//! stop.
#![no_std]
#![no_main]

use core::fmt::Write;

use cortex_m_rt::entry;
use images::{Console, pac, pass, start_clocks};

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    let mut console = Console::new(&dp);
    let _ = writeln!(console, "hello from {:#x}", dp.DBGMCU.idc.read().bits());
    loop {
        match console.get() {
            Some(b'.') => break,
            Some(byte) => console.put(byte.to_ascii_uppercase()),
            None => {}
        }
    }
    console.drain();
    pass()
}
