//! Firmware download by Device Firmware Upgrade 1.1 ("DFU" in comments; USB-IF, August 2004), without ST's
//! extensions: the machine offers the way in, the boot stage the download.

mod download;
mod protocol;
mod runtime;

pub use download::{DownloadDevice, Firmware};
pub use protocol::{Refused, TRANSFER_BYTES};
pub use runtime::{Detach, DfuRuntime};
