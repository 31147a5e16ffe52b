//! A board of memory, and a host that speaks to it.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

use motion::queue::{StepEvent, StepQueue};

use crate::board::{self, Board, MotorSettings, Pull, SpiSettings};
use crate::wire::{BLOCK_BYTES, Framer, Incoming, read_integer, write_block, write_integer};
use crate::{Command, Controller, Moves, Reason, Response};

/// Levels and bytes at the board's pins and chips.
#[derive(Default)]
pub struct Wires {
    pub clock: Cell<u32>,
    /// Every change of an output: clock, pin, level.
    pub changes: RefCell<Vec<(u32, u32, bool)>>,
    pub levels: RefCell<BTreeMap<u32, bool>>,
    pub analog: Cell<Option<u16>>,
    pub claimed: RefCell<Vec<u32>>,
    pub pwm: RefCell<Vec<(u32, u16)>>,
    pub spi: RefCell<Vec<(Option<u32>, Vec<u8>)>>,
    pub has_begun: Cell<bool>,
}

pub struct Pin(Rc<Wires>, u32);

impl board::Output for Pin {
    fn set(&mut self, high: bool) {
        if self.0.levels.borrow_mut().insert(self.1, high) != Some(high) {
            self.0.changes.borrow_mut().push((self.0.clock.get(), self.1, high));
        }
    }
}

impl board::Input for Pin {
    fn is_high(&self) -> bool {
        self.0.levels.borrow().get(&self.1).copied().unwrap_or(false)
    }
}

pub struct Chip(Rc<Wires>, Option<u32>);

impl board::Spi for Chip {
    fn exchange(&mut self, bytes: &mut [u8]) {
        self.0.spi.borrow_mut().push((self.1, bytes.to_vec()));
        bytes.reverse();
    }
}

pub struct Desk(pub Rc<Wires>);

impl Desk {
    fn claim(&self, pin: u32) -> Option<()> {
        let mut claimed = self.0.claimed.borrow_mut();
        if pin >= 176 || claimed.contains(&pin) {
            return None;
        }
        claimed.push(pin);
        Some(())
    }
}

impl Board for Desk {
    type Output = Pin;
    type Input = Pin;
    type Analog = u32;
    type Pwm = u32;
    type Spi = Chip;

    fn clock(&self) -> u32 {
        self.0.clock.get()
    }

    fn clock_turns(&self) -> u32 {
        0
    }

    fn output(&mut self, pin: u32, high: bool) -> Option<Pin> {
        self.claim(pin)?;
        self.0.levels.borrow_mut().insert(pin, high);
        Some(Pin(self.0.clone(), pin))
    }

    fn input(&mut self, pin: u32, _pull: Pull) -> Option<Pin> {
        self.claim(pin)?;
        Some(Pin(self.0.clone(), pin))
    }

    fn analog(&mut self, pin: u32) -> Option<u32> {
        Some(pin)
    }

    fn read_analog(&mut self, _input: u32) -> Option<u16> {
        self.0.analog.get()
    }

    fn pwm(&mut self, pin: u32, _cycle_ticks: u32, value: u16) -> Result<u32, Reason> {
        self.0.pwm.borrow_mut().push((pin, value));
        Ok(pin)
    }

    fn set_pwm(&mut self, channel: u32, value: u16) {
        self.0.pwm.borrow_mut().push((channel, value));
    }

    fn motor(&mut self, _index: usize, settings: MotorSettings) -> Option<()> {
        self.claim(settings.step_pin)?;
        self.claim(settings.dir_pin)
    }

    fn spi(&mut self, settings: SpiSettings) -> Result<Chip, Reason> {
        Ok(Chip(self.0.clone(), settings.select))
    }

    fn begin(&mut self) {
        self.0.has_begun.set(true);
    }

    fn power_outputs(&mut self, _on: bool) {}

    fn read_factory(&self, _bytes: u8, address: u32) -> Option<u32> {
        (address == 0x1FF1_E820).then_some(0x1234)
    }

    fn wake_steps(&self) {}
}

/// A message of the board: its kind, its integers, its buffer.
pub type Said = (Response, Vec<u32>, Vec<u8>);

/// A controller with a host at its line.
pub struct Bench {
    pub wires: Rc<Wires>,
    pub controller: Controller<Desk>,
    pub queue: &'static StepQueue,
    /// Events that were played.
    pub played: Vec<StepEvent>,
    /// Clock at which [`Controller::run`] is due.
    due: u32,
    sequence: u8,
    reader: Framer,
    pub acknowledged: Vec<u8>,
}

impl Bench {
    /// A board that has just started, at this clock.
    pub fn new(clock: u32) -> Self {
        let wires = Rc::new(Wires::default());
        wires.clock.set(clock);
        wires.analog.set(Some(2000));
        let queue: &'static StepQueue = Box::leak(Box::new(StepQueue::new()));
        let moves: &'static mut Moves = Box::leak(Box::new(Moves::new()));
        Self {
            controller: Controller::new(Desk(wires.clone()), moves, queue),
            wires,
            queue,
            played: Vec::new(),
            due: clock,
            sequence: 0,
            reader: Framer::new(),
            acknowledged: Vec::new(),
        }
    }

    /// A board with so many objects to come.
    pub fn with_oids(count: u32) -> Self {
        let mut bench = Self::new(0xFFFF_0000);
        bench.tell(Command::AllocateOids, &[count]);
        bench
    }

    pub fn finalize(&mut self) {
        self.tell(Command::FinalizeConfig, &[7]);
        assert!(self.wires.has_begun.get());
    }

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
            while let Some(mut job) = self.controller.take_job() {
                job.run();
                self.controller.finish(job);
            }
        }
        // The board calls `run` behind each block.
        self.due = self.now();
        self.heard()
    }

    pub fn tell(&mut self, command: Command, integers: &[u32]) -> Vec<Said> {
        self.block(&Self::message(command, integers, None))
    }

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
            let step = self.queue.front().map_or(i32::MAX, |event| event.at.wrapping_sub(now) as i32);
            let due = self.due.wrapping_sub(now) as i32;
            let left = end.wrapping_sub(now) as i32;
            assert!(step >= 0, "an event is {} ticks late", -step);
            let wait = step.min(due.max(0)).min(left);
            self.wires.clock.set(now.wrapping_add(wait as u32));
            if wait == left && step > left && due > left {
                return;
            }
            let now = self.now();
            while let Some(event) = self.queue.front().filter(|event| event.at == now) {
                self.queue.advance();
                self.played.push(event);
            }
            if self.due.wrapping_sub(now) as i32 <= 0 {
                let wait = self.controller.run();
                self.due = now.wrapping_add(wait);
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
