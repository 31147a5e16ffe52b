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

/// Settings of three motors, of which the first has a driver on the board.
pub const THREE_MOTORS: &str = "\
[actuator]
alpha.steps_per_mm = 80
alpha.step_pin = PD3
alpha.dir_pin = PD4
beta.steps_per_mm = 80
beta.step_pin = PK2
beta.dir_pin = PG2
beta.driver = external
gamma.steps_per_mm = 80
gamma.step_pin = PG3
gamma.dir_pin = PG4
gamma.driver = external
[tmc2590]
alpha.spi_cs_pin = PJ13
alpha.sense_resistor = 50
alpha.max_current = 3000
[current control]
alpha.current = 1.2
";

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
