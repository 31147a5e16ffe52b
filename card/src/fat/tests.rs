//! Tests with volumes in memory: made by one foreign tool (`fatfs`), changed here, read back by that tool and
//! by a separate checker.

mod card;
mod changes;
mod checker;
mod cuts;
mod damaged;
mod limits;
mod names;
mod operations;
