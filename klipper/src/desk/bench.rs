//! A host that speaks to a controller, and lets time pass for it.

use std::cell::RefCell;
use std::rc::Rc;

use motion::queue::{StepEvent, StepQueue};

use super::wires::{Desk, Wires};
use crate::wire::{BLOCK_BYTES, Framer, Incoming, read_integer, write_block, write_integer};
use crate::{Command, Controller, Moves, Response};

/// A message of the board: its kind, its integers, its buffer.
pub type Said = (Response, Vec<u32>, Vec<u8>);

/// Time that a run of the timers takes: 1 us. Without it a timer that is always due would have no end.
const RUN_TICKS: u32 = 200;

thread_local! {
    /// Memory of boards that are no more.
    static MEMORY: RefCell<Vec<(&'static mut Moves, &'static StepQueue)>> = const { RefCell::new(Vec::new()) };
}

/// A controller with a host at its line.
pub struct Bench {
    /// Levels of pins and bytes of chips.
    pub wires: Rc<Wires>,
    /// The controller that the host speaks to.
    pub controller: Controller<Desk>,
    /// Steps that wait to be played.
    pub queue: &'static StepQueue,
    /// Events that were played.
    pub played: Vec<StepEvent>,
    /// Clock at which [`Controller::run`] is due.
    due: u32,
    /// The step interrupt will come for the next event, as on the board: it looks at the queue when it is
    /// woken and when it plays, and at no other time.
    is_armed: bool,
    sequence: u8,
    reader: Framer,
    /// Numbers of the board's empty blocks.
    pub acknowledged: Vec<u8>,
}

impl Bench {
    /// A board that has just started, at this clock.
    pub fn new(clock: u32) -> Self {
        let wires = Rc::new(Wires::default());
        wires.clock.set(clock);
        wires.analog.set(Some(2000));
        let (moves, queue) = MEMORY
            .with_borrow_mut(Vec::pop)
            .unwrap_or_else(|| (Box::leak(Box::new(Moves::new())), Box::leak(Box::new(StepQueue::new()))));
        Self {
            controller: Controller::new(Desk(wires.clone()), moves, queue),
            wires,
            queue,
            played: Vec::new(),
            due: clock,
            is_armed: false,
            sequence: 0,
            reader: Framer::new(),
            acknowledged: Vec::new(),
        }
    }

    /// Gives the memory of the board to the next bench: whoever makes many must, as it lives for ever.
    pub fn give_back(self) {
        let memory = self.controller.into_memory();
        MEMORY.with_borrow_mut(|all| all.push(memory));
    }

    /// A board with so many objects to come.
    pub fn with_oids(count: u32) -> Self {
        let mut bench = Self::new(0xFFFF_0000);
        bench.tell(Command::AllocateOids, &[count]);
        bench
    }

    /// Ends the configuration of objects.
    pub fn finalize(&mut self) {
        self.tell(Command::FinalizeConfig, &[7]);
        assert!(self.wires.has_begun.get());
    }

    /// Returns the step clock.
    pub fn now(&self) -> u32 {
        self.wires.clock.get()
    }

    /// Content of a message.
    pub fn message(command: Command, integers: &[u32], buffer: Option<&[u8]>) -> Vec<u8> {
        let mut content = Vec::new();
        for value in std::iter::once(&(command.number() as u32)).chain(integers) {
            let (bytes, length) = write_integer(*value);
            content.extend(&bytes[..length]);
        }
        if let Some(buffer) = buffer {
            content.push(buffer.len() as u8);
            content.extend(buffer);
        }
        content
    }

    /// Sends a block, and returns what the board says to it.
    pub fn block(&mut self, content: &[u8]) -> Vec<Said> {
        let mut block = [0; BLOCK_BYTES];
        let length = write_block(content, self.sequence, &mut block);
        self.sequence = (self.sequence + 1) & 15;
        self.bytes(&block[..length])
    }

    /// Sends bytes, and returns what the board says to them.
    pub fn bytes(&mut self, bytes: &[u8]) -> Vec<Said> {
        let mut framer = Framer::new();
        for byte in bytes {
            match framer.take(*byte) {
                Some(Incoming::Block(block)) => self.controller.receive(&block),
                Some(Incoming::Damaged) => self.controller.damaged(),
                None => {}
            }
            self.work();
        }
        // The board calls `run` behind each block.
        self.due = self.now();
        self.heard()
    }

    /// Does the work on buses, in no time.
    fn work(&mut self) {
        while let Some(mut job) = self.controller.take_job() {
            let now = self.now();
            job.run(|| now);
            self.controller.finish(job);
            // The board calls `run` behind each job, as behind each block.
            self.due = now;
        }
        self.controller.note_turn(0);
    }

    /// Sends a message of integers, and returns what the board says to it.
    pub fn tell(&mut self, command: Command, integers: &[u32]) -> Vec<Said> {
        self.block(&Self::message(command, integers, None))
    }

    /// Sends a message of integers with a buffer behind them.
    pub fn tell_bytes(&mut self, command: Command, integers: &[u32], bytes: &[u8]) -> Vec<Said> {
        self.block(&Self::message(command, integers, Some(bytes)))
    }

    /// Takes what the board has said.
    pub fn heard(&mut self) -> Vec<Said> {
        let mut all = Vec::new();
        let mut buffer = [0; 64];
        loop {
            let count = self.controller.fetch(&mut buffer);
            if count == 0 {
                return all;
            }
            for byte in &buffer[..count] {
                match self.reader.take(*byte) {
                    Some(Incoming::Block(block)) if block.content().is_empty() => {
                        self.acknowledged.push(block.sequence());
                    }
                    Some(Incoming::Block(block)) => all.push(read(block.content())),
                    Some(Incoming::Damaged) => panic!("the board has sent a damaged block"),
                    None => {}
                }
            }
        }
    }

    /// Lets time pass: the board is called when it wants to be, steps are played at their times.
    pub fn pass(&mut self, ticks: u32) {
        let end = self.now().wrapping_add(ticks);
        loop {
            let now = self.now();
            let next = self.queue.front().filter(|_| self.is_armed);
            let step = next.map_or(i32::MAX, |event| event.at.wrapping_sub(now) as i32);
            let due = self.due.wrapping_sub(now) as i32;
            let left = end.wrapping_sub(now) as i32;
            assert!(step >= 0, "an event is {} ticks late", -step);
            let wait = step.min(due.max(0)).min(left);
            self.wires.clock.set(now.wrapping_add(wait as u32));
            if wait == left && step > left && due > left {
                return;
            }
            let now = self.now();
            while let Some(event) = self.queue.front().filter(|event| self.is_armed && event.at == now) {
                self.queue.advance();
                self.played.push(event);
            }
            self.is_armed &= !self.queue.is_empty();
            if self.due.wrapping_sub(now) as i32 <= 0 {
                let wait = self.controller.run();
                self.due = now.wrapping_add(wait.max(RUN_TICKS));
                self.work();
                self.is_armed |= self.wires.steps_woken.take();
            }
            if self.now() == end {
                return;
            }
        }
    }

    /// Times of the steps of a motor, and its directions as they were then.
    pub fn steps(&self, motor: usize) -> Vec<(u32, bool)> {
        let mut forward = true;
        let mut steps = Vec::new();
        for event in self.played.iter().filter(|event| event.motor() == motor) {
            if event.is_turn() {
                forward = event.is_forward();
            } else {
                steps.push((event.at, !forward));
            }
        }
        steps
    }
}

/// Reads a message of the board by the table.
fn read(content: &[u8]) -> Said {
    let (number, mut rest) = read_integer(content).expect("a message has a number");
    let response = Response::ALL.iter().find(|response| response.number() as u32 == number);
    let response = *response.expect("the number is in the table");
    let (mut integers, mut buffer) = (Vec::new(), Vec::new());
    for parameter in response.format().split(' ').skip(1) {
        if parameter.contains('*') {
            let (length, behind) = rest.split_first().expect("a buffer has a length");
            (buffer, rest) = (behind[..usize::from(*length)].to_vec(), &behind[usize::from(*length)..]);
        } else {
            let (value, behind) = read_integer(rest).expect("a parameter is missing");
            integers.push(value);
            rest = behind;
        }
    }
    assert!(rest.is_empty(), "bytes behind {response:?}");
    (response, integers, buffer)
}
