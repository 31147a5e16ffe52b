//! Values as Klipper's files have them.

use crate::environment::Nothing;
use crate::fault::{Error, Words};
use crate::literal;
use crate::memory::Memory;
use crate::run::Run;

/// Writes a Python literal into `output` as Python would write it, and returns its length.
///
/// # Errors
///
/// The text is no literal of numbers, strings, truth values, `None`, lists, tuples and dicts; memory or
/// output are too small.
pub fn rewrite(text: &str, memory: &mut [u8], output: &mut [u8]) -> core::result::Result<usize, Error> {
    let mut machine = Nothing;
    let mut memory = Memory::new(memory);
    memory.is_sealed = true;
    let mut run = Run { memory, machine: &mut machine, given: 0 };
    let written = literal::read(&mut run.memory, &mut text.bytes()).and_then(|value| run.repr_of(value));
    let result = written.and_then(|text| match output.get_mut(..text.len()) {
        _ if run.memory.is_full => run.memory.fail(Words::NoMemory),
        Some(place) => {
            place.iter_mut().zip(run.memory.bytes(text)).for_each(|(place, byte)| *place = *byte);
            Ok(place.len())
        }
        None => run.memory.fail(Words::TooLong),
    });
    result.map_err(|_| Error::new((1, 1), &run.memory))
}
