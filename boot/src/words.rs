//! Messages of the boot stage on the debug console. An ordinary start prints none.

use core::fmt::{self, Write};

use bsp_prime::time;
use bsp_prime::uart::UartPort;

/// The ring at 115200 baud takes a third of a second; half as much more.
const LIMIT_US: u64 = 500_000;

/// The debug console, to write to.
pub struct Words {
    port: UartPort,
}

impl Words {
    /// Of this port, open.
    pub fn new(port: UartPort) -> Self {
        Self { port }
    }

    /// Prints a line; characters without room are lost.
    pub fn say(&mut self, words: fmt::Arguments<'_>) {
        // A text takes what has room in it.
        let _ = self.write_fmt(words);
        let _ = self.write_str("\r\n");
    }

    /// Waits until all of it is on its way.
    pub fn finish(&mut self) {
        let end = time::now().0 + LIMIT_US;
        while !self.port.is_drained() && time::now().0 < end {
            cortex_m::asm::wfi();
        }
    }
}

impl Write for Words {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.port.write(text.as_bytes());
        Ok(())
    }
}
