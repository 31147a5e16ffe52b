//! Test bench for devices: a bus in memory with a host at its other end, a line, a card.

mod bus;
mod card;
mod composite;
mod descriptors;
mod device;
mod disk;
mod host;
mod line;

pub use composite::{Board, Options};
pub use descriptors::{Descriptor, walk};
pub use host::{Failure, Request};

mod tests_control;
mod tests_descriptors;
mod tests_disk;
mod tests_disk_cases;
mod tests_download;
mod tests_ports;
mod tests_table;
