//! The card as a disk: mass storage class, bulk-only transport (USB Mass Storage Class, Bulk-Only Transport,
//! revision 1.0: "BOT" in comments) with the SCSI commands that hosts use (SPC-4, SBC-3; "SPC", "SBC").

mod class;
mod medium;
mod reply;
mod scsi;
mod sense;
mod transfer;
mod wrapper;

pub use class::MassStorage;
pub use medium::{BLOCK_BYTES, Fault, Half, Medium, Progress, State};
