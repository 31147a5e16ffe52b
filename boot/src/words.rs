//! Messages of the boot stage on the debug console. An ordinary start prints none.

use core::fmt::{self, Write};

use bsp_prime::time;
use bsp_prime::uart::UartPort;

/// Limit of the wait for the ring to empty: a third of a second at 115200 baud, and half as much more.
const LIMIT_US: u64 = 500_000;

/// Output to the debug console.
pub struct Words {
    port: UartPort,
}

impl Words {
    /// Creates the output to an open port.
    pub fn new(port: UartPort) -> Self {
        Self { port }
    }

    /// Prints a line; characters without room are lost.
    pub fn say(&mut self, words: fmt::Arguments<'_>) {
        // Text without room is cut.
        let _ = self.write_fmt(words);
        let _ = self.write_str("\r\n");
    }

    /// Waits until all text has been sent.
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
