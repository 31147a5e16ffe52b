//! The board at another computer's USB, by the USB network redirection protocol. The peer is QEMU's
//! `-device usb-redir`, or anything else with a USB host controller to offer; this is the side that has the
//! device.
//!
//! [`message`] and [`codec`] are the protocol's messages, [`stream`] puts them one after another,
//! [`session`] makes transfers of them. None of it does input or output.

pub mod codec;
pub mod message;
pub mod session;
pub mod stream;

mod announce;
mod request;

#[cfg(test)]
mod tests;
