//! Subcommands, a module for each, and their shared parts.

pub mod bench;
pub mod clock_file;
pub mod computer;
pub mod console;
pub mod job;
pub mod log;
pub mod machine;
pub mod net;
mod network_load;
pub mod onlooker;
pub mod pace;
pub mod run;
pub mod serial;
pub mod test;
pub mod usb;
