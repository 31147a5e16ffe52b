//! A web server's protocols over bytes: HTTP/1.1 (RFC 9110, RFC 9112), WebSocket (RFC 6455), JSON
//! (RFC 8259), and forms with files (RFC 7578).
//!
//! Bytes come in as they arrive, bytes go out into whatever room there is, and the time is an argument: no
//! code here waits, allocates, or knows a socket. A [`Connection`] is what is kept of one: some 300 bytes.
//! Answers are made as they go, by a [`Body`] that is asked for its next piece.
//!
//! Sockets, files and the machine are outside this crate.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod body;
mod conditional;
mod connection;
mod credentials;
mod fields;
pub mod json;
pub mod limits;
mod method;
pub mod multipart;
mod origin;
pub mod percent;
mod request;
mod response;
mod routes;
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
pub use conditional::Selection;
pub use connection::{Connection, Event, Life};
pub use credentials::{SetCookie, bearer, cookie, is_same};
pub use fields::Fields;
pub use method::{Method, Methods};
pub use origin::Known;
pub use request::{Head, Length, Query, Request, Upgrade};
pub use response::{Cache, EntityTag, Extent, Part, Response};
pub use routes::{Content, Found, Role, Route, Routes};
pub use status::Status;
pub use websocket::{Kind, codes};
pub use window::Window;
