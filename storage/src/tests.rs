//! The storage port on volumes in memory, judged by a foreign tool (`fatfs`) and by the checker of
//! `drivers::fat`'s tests.

mod beside;
mod card;
#[path = "../../drivers/src/fat/tests/checker.rs"]
mod checker;
mod contents;
mod costs;
mod cuts;
mod damaged;
mod exfat;
mod full;
#[path = "../../drivers/src/exfat/tests/maker.rs"]
mod maker;
mod sequences;
