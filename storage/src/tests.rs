//! The storage port on volumes in memory, judged by a foreign tool (`fatfs`) and by the checker of
//! `card::fat`'s tests.

mod card;
#[path = "../../card/src/fat/tests/checker.rs"]
mod checker;
mod contents;
mod costs;
mod cuts;
mod damaged;
mod exfat;
mod full;
#[path = "../../card/src/exfat/tests/maker.rs"]
mod maker;
mod readers;
mod sequences;
