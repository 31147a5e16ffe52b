//! Serial ports: communications device class, abstract control model (CDC 1.2, PSTN 1.2). `usbd-serial` is
//! the class; who is there, and what it lacks, is here.

mod coding;
mod guard;
mod port;

pub use guard::{Numbers, Ports};
pub use port::{Line, SerialPort};
