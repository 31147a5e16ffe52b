//! Programs and what carries them out.

mod compute;
mod loops;

use crate::arguments::Arguments;
use crate::code::Op;
use crate::environment::Environment;
use crate::fault::{Error, Fault, Result, Words};
use crate::lexer::Lexer;
use crate::memory::{Memory, Text, Use};
use crate::names::{self, Function};
use crate::parser::Parser;
use crate::run::{Run, VARIABLES, undefined, wrong};
use crate::value::{DEEPEST, Map, SIZE, Seq, Value, View};

/// Most instructions of a rendering: some seconds on the board.
const MOST_INSTRUCTIONS: u32 = 2_000_000;

/// A template that was read: where its code and strings are in the caller's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    code: u16,
    strings: u16,
    length: u16,
}

/// Reads a template into memory.
///
/// # Errors
///
/// The template has a mistake, uses a tag that is not known, or is too long for the memory.
pub fn compile(source: &mut dyn Iterator<Item = u8>, memory: &mut [u8]) -> core::result::Result<Program, Error> {
    let length = memory.len();
    let mut memory = Memory::new(memory);
    let mut parser = Parser::new(&mut memory, Lexer::new(source));
    let result = parser.template();
    let place = parser.place;
    match result {
        Ok(()) => {
            let (code, strings) = (memory.top as u16, memory.pool as u16);
            Ok(Program { code, strings, length: length.min(usize::from(u16::MAX)) as u16 })
        }
        Err(_) => Err(Error::new(place, &memory)),
    }
}

impl Program {
    /// Bytes of memory that the program takes.
    #[must_use]
    pub fn size(&self) -> usize {
        usize::from(self.code) + usize::from(self.length - self.strings)
    }

    /// Writes the text of the template into `output` and returns its length. The memory is the one that
    /// [`compile`] has filled; it stays usable for further renderings.
    ///
    /// # Errors
    ///
    /// A value is missing or of the wrong type, the macro raises an error, or memory or output are too small.
    pub fn render(
        &self,
        memory: &mut [u8],
        output: &mut [u8],
        machine: &mut dyn Environment,
    ) -> core::result::Result<usize, Error> {
        let mut memory = Memory::new(memory);
        memory.top = usize::from(self.code);
        memory.low = usize::from(self.strings);
        (memory.keep, memory.floor, memory.pool) = (memory.top, memory.top, memory.low);
        memory.is_sealed = true;
        let run = Run { memory, machine, given: 0 };
        let mut machine = Machine { run, output, written: 0, next: 0, frame: 0, place: (1, 1) };
        match machine.carry_out() {
            Ok(()) => Ok(machine.written),
            Err(_) => Err(Error::new(machine.place, &machine.run.memory)),
        }
    }
}

/// A rendering that goes on. What it runs on comes first, so that both have one address.
#[repr(C)]
struct Machine<'r, 'a> {
    run: Run<'r, 'a>,
    output: &'r mut [u8],
    /// Bytes of the output that are written.
    written: usize,
    /// Place of the next byte of code.
    next: usize,
    /// First place on the stack of the innermost loop or block, whose variables are above it.
    frame: usize,
    /// Line and column of the tag that is carried out.
    place: (u16, u16),
}

impl Machine<'_, '_> {
    fn carry_out(&mut self) -> Result<()> {
        for _ in 0..MOST_INSTRUCTIONS {
            if self.run.memory.is_full {
                return self.run.memory.fail(Words::NoMemory);
            }
            let op = Op::from_byte(self.byte());
            match op {
                Op::End => return Ok(()),
                Op::At => {
                    self.place = (self.word(), self.word());
                    self.run.memory.top = self.run.memory.keep;
                }
                Op::Text => {
                    let text = self.string();
                    self.write(text)?;
                }
                Op::Emit => {
                    let value = self.run.memory.pop();
                    let text = self.run.text_of(value)?;
                    self.write(text)?;
                }
                Op::None | Op::True | Op::False | Op::Missing | Op::Small | Op::Int | Op::Float | Op::Str => {
                    let value = self.constant(op)?;
                    self.run.memory.push(value);
                }
                Op::Load => self.load()?,
                Op::List | Op::Tuple | Op::Dict => self.container(op)?,
                Op::Jump | Op::Unless | Op::And | Op::Or | Op::Chain => self.jump(op)?,
                Op::Keyword => {
                    let name = self.word();
                    self.run.memory.name_last(Use::Keyword, name);
                }
                Op::Spread => self.run.memory.name_last(Use::Spread, 0),
                Op::SpreadNamed => self.run.memory.name_last(Use::SpreadNamed, 0),
                Op::Filter | Op::Test | Op::Unknown | Op::Call | Op::Method => self.call(op)?,
                Op::Store | Op::StoreMember | Op::Declare | Op::Unpack | Op::Drop => self.store(op)?,
                Op::CaptureBegin | Op::CaptureEnd | Op::FrameBegin | Op::FrameEnd => self.frames(op)?,
                Op::ForBegin | Op::ForNext | Op::ForCount | Op::ForAgain | Op::ForEnd => self.turn(op)?,
                _ => self.compute(op)?,
            }
        }
        self.run.memory.fail(Words::TooSlow)
    }

    fn byte(&mut self) -> u8 {
        self.next += 1;
        self.run.memory.byte(self.next - 1)
    }

    fn word(&mut self) -> u16 {
        self.next += 2;
        self.run.memory.word(self.next - 2)
    }

    fn eight(&mut self) -> u64 {
        self.next += 8;
        self.run.memory.eight(self.next - 8)
    }

    fn string(&mut self) -> Text {
        let at = self.word();
        if at == 0 { Text::default() } else { self.run.memory.interned(at) }
    }

    fn write(&mut self, text: Text) -> Result<()> {
        let bytes = self.run.memory.bytes(text);
        let Some(place) = self.output.get_mut(self.written..self.written + bytes.len()) else {
            let about = crate::fault::About::Number(self.output.len());
            return Err(Fault::with(&self.run.memory, Words::NoOutput, about));
        };
        place.iter_mut().zip(bytes).for_each(|(place, byte)| *place = *byte);
        self.written += bytes.len();
        Ok(())
    }

    fn constant(&mut self, op: Op) -> Result<Value> {
        Ok(match op {
            Op::True => Value::bool(true),
            Op::False => Value::bool(false),
            Op::Missing => Value::undefined(self.string()),
            Op::Small => Value::count(usize::from(self.word())),
            Op::Int => {
                let int = self.eight() as i64;
                return Ok(self.run.memory.int(int));
            }
            Op::Float => Value::float(f64::from_bits(self.eight())),
            Op::Str => Value::str(self.string()),
            _ => Value::NONE,
        })
    }

    /// The value of a variable: of the template, of the machine, or a function.
    fn load(&mut self) -> Result<()> {
        let name = self.string();
        let value = self.variable(name)?;
        self.run.memory.push(value);
        Ok(())
    }

    fn variable(&mut self, name: Text) -> Result<Value> {
        let memory = &self.run.memory;
        let found =
            (0..memory.depth()).rev().find(|index| memory.name_at(*index, Use::Variable) == Some(name.at() as u16));
        if let Some(index) = found {
            return Ok(memory.at(index));
        }
        let function = names::find(Function::NAMES, memory.bytes(name));
        let is_own = function.is_some_and(|number| number <= Function::CallRemoteMethod as u8);
        let value = if is_own { Value::MISSING } else { self.given(name)? };
        if !value.is_undefined() {
            return Ok(value);
        }
        Ok(function.map_or(Value::undefined(name), Value::function))
    }

    /// A variable of the machine's. Lists and dicts are made once, so that what a template changes in them
    /// stays changed.
    fn given(&mut self, name: Text) -> Result<Value> {
        if let Some(value) = self.run.given_before(VARIABLES, name) {
            return Ok(value);
        }
        let given = self.run.machine.variable(self.run.memory.text(name));
        let Some(given) = given else { return Ok(Value::MISSING) };
        let value = Run::take(&mut self.run.memory, given)?;
        let value = self.run.settle(value, DEEPEST)?;
        if value.head().is_some() {
            self.run.note_given(VARIABLES, name, value);
        }
        Ok(value)
    }

    /// A list, tuple or dict of the last values.
    #[inline(never)]
    fn container(&mut self, op: Op) -> Result<()> {
        let count = usize::from(self.word());
        let places = if op == Op::Dict { 2 * count } else { count };
        let first = self.run.memory.depth().saturating_sub(places);
        let value = if op == Op::Dict {
            let map = self.run.map(Map::Dict, count);
            let Some(head) = map.head() else { return Ok(()) };
            for index in 0..count {
                let [key, value] = [0, 1].map(|offset| self.run.memory.at(first + 2 * index + offset));
                self.run.put(head, key, value)?;
            }
            map
        } else {
            let head = self.run.memory.new_block(count, SIZE);
            for index in 0..count {
                let value = self.run.memory.at(first + index);
                self.run.append(head, value);
            }
            Value::seq(if op == Op::List { Seq::List } else { Seq::Tuple }, head)
        };
        self.run.memory.cut(first);
        self.run.memory.push(value);
        Ok(())
    }

    #[inline(never)]
    fn jump(&mut self, op: Op) -> Result<()> {
        let is_taken = match op {
            Op::Jump => true,
            Op::Chain => {
                let comparison = Op::from_byte(self.byte());
                let (b, a) = (self.run.memory.pop(), self.run.memory.pop());
                let holds = compute::compare(&mut self.run, comparison, a, b)?;
                self.run.memory.push(if holds { b } else { Value::bool(false) });
                !holds
            }
            _ => {
                let last = self.run.memory.pop();
                let is_true = self.run.truth(last);
                let is_taken = is_true == (op == Op::Or);
                if is_taken && op != Op::Unless {
                    self.run.memory.push(last);
                }
                is_taken
            }
        };
        let distance = self.word();
        if is_taken {
            self.next = usize::from((self.next as u16).wrapping_add(distance));
        }
        Ok(())
    }

    #[inline(never)]
    fn call(&mut self, op: Op) -> Result<()> {
        if op == Op::Unknown {
            let name = self.string();
            return Err(Fault::about(&self.run.memory, Words::NoFilterOrTest, name));
        }
        let (word, count) = match op {
            Op::Method => (self.word(), self.byte()),
            Op::Call => (0, self.byte()),
            _ => (u16::from(self.byte()), self.byte()),
        };
        let count = usize::from(count);
        let first = self.run.memory.depth().saturating_sub(count);
        let subject = self.run.memory.at(first.saturating_sub(1));
        let arguments = Arguments { first, count }.spread(&mut self.run)?;
        let run = &mut self.run;
        let result = match (op, subject.view()) {
            (Op::Filter, _) => crate::filters::apply(run, word as u8, subject, arguments)?,
            (Op::Test, _) => Value::bool(crate::filters::check(run, word as u8, subject, arguments)?),
            (Op::Method, _) => crate::methods::call(run, subject, run.memory.interned(word), arguments)?,
            (_, View::Function(number)) => crate::functions::call(run, number, arguments)?,
            (_, View::Undefined(name)) => return Err(undefined(&run.memory, name)),
            _ => return Err(wrong(&run.memory, Words::NotCallable, subject)),
        };
        self.run.memory.cut(first.saturating_sub(1));
        self.run.memory.push(result);
        Ok(())
    }
}
