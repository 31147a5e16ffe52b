//! A computer at the USB socket that says and hears all it can, on every serial port there is.

use usb_host::transfer::{Request, TransferId};
use virtual_prime::usb_desk::cdc::Serial;
use virtual_prime::usb_desk::{Desk, UsbError, UsbHost};
use virtual_prime::vm::Vm;

/// A comment of 124 characters, as many of them as make more than the bus takes in a slice, and what the
/// others ask.
const WORDS: &str = "(a comment that goes on and on, as long as a line may be so that there are few answers, and then it goes on for some more)\n";
const AT_A_TIME: usize = 200;
const QUESTIONS: &str = "version\nM105\n";
/// Reads on their way at each port, and how long each is: as many as fill a slice.
const READS: usize = 8;
const READ_BYTES: usize = 4_096;

/// The computer, once it is plugged in.
#[derive(Default)]
pub struct Computer {
    host: UsbHost,
    ports: Vec<Serial>,
    sending: Vec<Option<TransferId>>,
    listening: Vec<[Option<TransferId>; READS]>,
}

impl Computer {
    /// Plugs in and opens the ports; takes a seventh of a second of virtual time.
    ///
    /// # Errors
    /// The board does not do what a device must.
    pub fn plug(&mut self, vm: &mut Vm) -> Result<(), UsbError> {
        let mut desk = self.host.at(vm);
        desk.plug();
        self.ports = Serial::all(&desk.enumerate()?);
        self.sending = vec![None; self.ports.len()];
        self.listening = vec![[None; READS]; self.ports.len()];
        self.ports.iter().try_for_each(|port| port.set_lines(&mut desk, true, true))
    }

    /// Whether it is plugged in.
    pub const fn is_plugged(&self) -> bool {
        !self.ports.is_empty()
    }

    /// Keeps every endpoint busy.
    pub fn flood(&mut self, vm: &mut Vm) {
        let mut desk = self.host.at(vm);
        for (number, port) in self.ports.iter().enumerate() {
            if is_over(&mut desk, self.sending[number]) {
                let words = if number == 0 { WORDS.repeat(AT_A_TIME) } else { QUESTIONS.to_owned() };
                let request = Request::Out { data: words.into_bytes(), zero: false };
                self.sending[number] = desk.submit(port.output, request);
            }
            for read in &mut self.listening[number] {
                if is_over(&mut desk, *read) {
                    *read = port.listen(&mut desk, READ_BYTES);
                }
            }
        }
    }
}

fn is_over(desk: &mut Desk<'_>, id: Option<TransferId>) -> bool {
    id.is_none_or(|id| desk.ended(id).is_some())
}
