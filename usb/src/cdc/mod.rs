//! Serial ports: communications device class, abstract control model (CDC 1.2, PSTN 1.2).

mod coding;
mod port;

pub use coding::{LineCoding, Parity, StopBits};
pub use port::{Endpoints, Line, SerialPort};
