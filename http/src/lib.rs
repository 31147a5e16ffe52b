//! A web server's protocols over bytes: HTTP/1.1 (RFC 9110, RFC 9112) and WebSocket (RFC 6455).
//!
//! Bytes come in as they arrive, bytes go out into whatever room there is, and the time is an argument: no
//! code here waits, allocates, or knows a socket. A [`Connection`] is what is kept of one: some 300 bytes.
//! Answers are made as they go, by a [`Body`] that is asked for its next piece.
//!
//! Sockets, files and the machine are outside this crate.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod body;
mod connection;
mod fields;
pub mod limits;
mod method;
pub mod percent;
mod request;
mod response;
pub mod security;
mod status;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod utf8;
mod websocket;
mod window;

pub use body::{Body, Empty, Made, Slice};
pub use connection::{Connection, Event, Life};
pub use fields::Fields;
pub use method::{Method, Methods};
pub use request::{Head, Length, Query, Request, Upgrade};
pub use response::{Cache, EntityTag, Extent, Part, Response};
pub use status::Status;
pub use websocket::{Kind, codes};
pub use window::Window;
