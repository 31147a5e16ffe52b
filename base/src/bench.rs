//! Test bench for sequences, never part of an image: a card in memory, sessions that listen, and a machine of
//! switches and motors around the real motion, in which time passes only while somebody waits.

mod card;
mod desk;
mod drivers;
mod hands;
mod world;

use gcode::{Block, Blocks, NoParameters};
use program::{Action, Dialect, Facts, Interpreter, Meaning, Words};

pub use card::Card;
pub use desk::{Desk, Line};
pub use drivers::BenchDrivers;
pub use hands::BenchHands;
pub use world::World;

/// Returns the words of a line, as the row of its code reads them.
///
/// # Panics
/// When the line has no code with a function of the machine's.
#[must_use]
pub fn words(line: &str) -> Words<'static> {
    let line: &'static str = Box::leak(line.to_string().into_boxed_str());
    let block = Box::leak(Box::new(Block::new(None, 1)));
    let is_read = Blocks::new(line.as_bytes()).read(block, &mut NoParameters);
    assert_eq!(is_read, Ok(true), "{line}");
    let config = Box::leak(Box::default());
    let mut program = Interpreter::new(crate::program_setup::setup(config));
    let row = program.row(block, Dialect::Smoothie).expect("a code");
    match program.run(block, row, Facts::default(), Dialect::Smoothie) {
        Ok(Meaning::Action(Action::Function(_, words))) => words,
        other => panic!("{line}: {other:?}"),
    }
}
