//! Parameters of a message.

use crate::table::{Command, Shape};
use crate::wire::read_integer;

/// Most parameters of a command.
const MOST: usize = 9;

/// Number of parameters and place of the buffer of each command.
const SHAPES: [Shape; Command::ALL.len()] = {
    let mut shapes = [Shape { count: 0, buffer: u8::MAX }; Command::ALL.len()];
    let mut index = 0;
    while index < shapes.len() {
        shapes[index] = Shape::of(Command::ALL[index].format());
        assert!(shapes[index].count as usize <= MOST, "a command with more parameters than there is room for");
        index += 1;
    }
    shapes
};

/// Parameters of one message, in the order of its format. A buffer is empty among the integers.
#[derive(Clone, Debug)]
pub struct Args<'a> {
    integers: [u32; MOST],
    /// The buffer, if the message has one.
    pub bytes: &'a [u8],
}

impl<'a> Args<'a> {
    /// Reads a message. Returns it, and the bytes behind it; `None` when it is none.
    pub fn read(content: &'a [u8]) -> Option<(Command, Self, &'a [u8])> {
        let (number, mut rest) = read_integer(content)?;
        let command = Command::of(number)?;
        let shape = SHAPES.get(command as usize)?;
        let mut args = Self { integers: [0; MOST], bytes: &[] };
        for (index, integer) in args.integers.iter_mut().enumerate().take(usize::from(shape.count)) {
            if index == usize::from(shape.buffer) {
                let (&length, behind) = rest.split_first()?;
                (args.bytes, rest) = behind.split_at_checked(usize::from(length))?;
            } else {
                (*integer, rest) = read_integer(rest)?;
            }
        }
        Some((command, args, rest))
    }

    /// Returns the parameter at `place`.
    #[inline(always)]
    pub fn at(&self, place: usize) -> u32 {
        self.integers.get(place).copied().unwrap_or(0)
    }

    /// Returns the number of an object, which is the first parameter of most commands.
    #[inline(always)]
    pub fn oid(&self) -> u8 {
        self.at(0) as u8
    }
}
