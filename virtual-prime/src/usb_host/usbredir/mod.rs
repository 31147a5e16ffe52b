//! The board at another computer's USB, by the USB network redirection protocol: QEMU's `-device usb-redir`,
//! virt-viewer, `usbredirect`.
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
