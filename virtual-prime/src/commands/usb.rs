//! The board's USB socket for other computers: `console --usb`.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use clap::Args;
use rigless::time::VirtualNanos;
use usb_host::remote::Remote;
use usb_host::usbip::session::BUSID;
use virtual_prime::vm::Vm;

/// Where the socket is offered.
#[derive(Args)]
pub struct UsbOptions {
    /// Offer the USB socket to other computers: by usbredir (QEMU) and by usbip (Linux).
    #[arg(long)]
    usb: bool,
    /// TCP port for usbredir; 0 lets the system choose.
    #[arg(long, default_value_t = 7400)]
    usbredir_port: u16,
    /// TCP port for usbip; 0 lets the system choose.
    #[arg(long, default_value_t = 3240)]
    usbip_port: u16,
}

/// The offered USB socket.
#[derive(Clone)]
pub struct UsbSocket(Arc<Mutex<Remote>>);

impl UsbSocket {
    /// Begins to listen, if that is asked for, and prints instructions for plugging in.
    ///
    /// # Errors
    /// Which port cannot be had.
    pub fn open(options: &UsbOptions) -> Result<Option<Self>, String> {
        if !options.usb {
            return Ok(None);
        }
        let at = |port| SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        let remote = Remote::listen(at(options.usbredir_port), at(options.usbip_port)).map_err(|error| {
            format!("{error}: say other ones with USBREDIR_PORT and USBIP_PORT (--usbredir-port, --usbip-port)")
        })?;
        let [usbredir, usbip] = remote.addresses().map_err(|error| error.to_string())?;
        eprintln!("USB by usbredir on tcp {usbredir}. For QEMU:");
        eprintln!(
            "    -device qemu-xhci -chardev socket,id=usb,host={},port={},nodelay=on -device usb-redir,chardev=usb",
            usbredir.ip(),
            usbredir.port()
        );
        let elsewhere = if usbip.port() == 3240 { String::new() } else { format!(" --tcp-port {}", usbip.port()) };
        eprintln!("USB by usbip on tcp {usbip}. For this computer, or one that sees this port:");
        eprintln!("    sudo modprobe vhci-hcd; sudo usbip{elsewhere} attach -r {} -b {BUSID}", usbip.ip());
        Ok(Some(Self(Arc::new(Mutex::new(remote)))))
    }

    fn lock(&self) -> MutexGuard<'_, Remote> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a computer has the cable.
    pub fn is_plugged(&self) -> bool {
        self.lock().is_plugged()
    }

    /// Bytes that the image has acknowledged since power-on, by OUT endpoint.
    pub fn sent(&self) -> [u64; 16] {
        self.lock().sent()
    }

    /// Has the cable pulled out at the next call of [`Self::serve`], whichever computer has it.
    pub fn unplug(&self) {
        self.lock().unplug();
    }

    /// Serves the connected computers at this instant; does nothing once the image has ended.
    pub fn serve(&self, vm: &mut Vm) {
        let remote = self.clone();
        vm.with(move |stopped| {
            let at = VirtualNanos(stopped.stop.at.0);
            stopped.session.board_mut().mcu.usb(at, |host, device, now_ns| remote.lock().serve(now_ns, host, device));
        });
        for note in self.lock().take_notes() {
            eprintln!("{note}");
        }
    }
}
