//! Velvet's own image at a USB host.

use usb_host::transfer::Request;
use virtual_prime::usb_desk::cdc::Serial;
use virtual_prime::usb_desk::{Desk, Device, UsbHost};

use crate::common::velvet::{Plan, Velvet};

/// Greeting of a port after a program has opened it.
pub const GREETING: &str = "Welcome to Smoothie\nok\n";

/// A printer at a host, with its device configured.
pub struct Plugged {
    pub velvet: Velvet,
    pub host: UsbHost,
    pub device: Device,
    pub ports: Vec<Serial>,
}

/// Plugs a machine in as soon as it has booted.
#[track_caller]
pub fn plug(plan: Plan) -> Plugged {
    let mut velvet = plan.start();
    let mut host = UsbHost::new();
    let mut desk = host.at(&mut velvet.bench.vm);
    desk.plug();
    let device = desk.enumerate().expect("the machine is a USB device");
    let ports = Serial::all(&device);
    Plugged { velvet, host, device, ports }
}

impl Plugged {
    /// Returns the desk of the host.
    pub const fn desk(&mut self) -> Desk<'_> {
        self.host.at(&mut self.velvet.bench.vm)
    }

    /// Opens a port, and reads the greeting.
    #[track_caller]
    pub fn open(&mut self, port: usize) {
        let serial = self.ports[port];
        let mut desk = self.desk();
        serial.set_lines(&mut desk, true, true).unwrap();
        assert_eq!(self.hear_until(port, "ok\n"), GREETING);
    }

    /// Reads everything on a port up to these words.
    #[track_caller]
    pub fn hear_until(&mut self, port: usize, words: &str) -> String {
        let serial = self.ports[port];
        let said =
            serial.read_until(&mut self.desk(), words.as_bytes()).unwrap_or_else(|why| panic!("{words:?}: {why}"));
        String::from_utf8_lossy(&said).into_owned()
    }

    /// Sends a line and returns the answer.
    #[track_caller]
    pub fn say(&mut self, port: usize, line: &str) -> String {
        let serial = self.ports[port];
        serial.write(&mut self.desk(), format!("{line}\n").as_bytes()).unwrap();
        self.hear_until(port, "ok")
    }

    /// Submits bytes without waiting for their end.
    pub fn send(&mut self, port: usize, bytes: &[u8]) {
        let output = self.ports[port].output;
        self.desk().submit(output, Request::Out { data: bytes.to_vec(), zero: false });
    }

    /// Asserts that the board has nothing to complain about in the end.
    #[track_caller]
    pub fn assert_clean(&mut self) {
        assert_eq!(self.velvet.bench.vm.complaints(), Vec::<String>::new());
    }
}

/// Plans a machine with both serial ports.
pub fn two_ports() -> Plan {
    Plan::new().set("[consoles] second_usb_serial_enable = true")
}
