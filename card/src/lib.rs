//! SD cards and the file systems on them, over a host controller and a device of blocks as traits. No pin in
//! here, and no memory but what is handed in.
//!
//! | module | what |
//! |---|---|
//! | [`sd`] | a card from power-on, its blocks queued, read ahead and shared by several users |
//! | [`volume`] | the volume of a card, found in its partition table, and the files on it, of either kind |
//! | [`fat`] | FAT16 and FAT32: names, directories, contents of files that are read |
//! | [`exfat`] | exFAT: the same, only read |
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod exfat;
pub mod fat;
pub mod sd;
pub mod volume;
