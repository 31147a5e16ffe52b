//! The board at another computer's USB, by USB/IP: `usbip attach` of Linux, usbip-win, PyUSB with
//! `pyusb-usbip-backend`.
//!
//! [`packet`] is the protocol, [`session`] makes transfers of it. None of it does input or output.

pub mod packet;
pub mod session;

#[cfg(test)]
mod tests;
