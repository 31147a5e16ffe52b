//! Serial ports: communications device class, abstract control model (CDC 1.2, PSTN 1.2). `usbd-serial`
//! implements the class; this module adds connection tracking and the class's missing parts.

mod coding;
mod guard;
mod port;

pub use guard::{Numbers, Ports};
pub use port::{Line, SerialPort};
