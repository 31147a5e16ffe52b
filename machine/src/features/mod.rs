//! The features of the machine, a folder each.

pub(crate) mod automatic_outputs;
pub(crate) mod brown_out;
pub(crate) mod door;
pub(crate) mod event_log;
pub(crate) mod filament;
pub(crate) mod grbl;
pub(crate) mod lights;
pub(crate) mod objects;
pub(crate) mod power_loss;
pub(crate) mod stalls;
pub(crate) mod statistics;
pub(crate) mod update;
pub(crate) mod usb_disk;
