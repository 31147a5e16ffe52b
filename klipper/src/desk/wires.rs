//! A board of memory: levels of pins, bytes of chips, a clock that the bench sets.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

use super::chip::I2cChip;
use crate::Reason;
use crate::board::{self, Board, MotorSettings, Pull, SpiSettings};

/// Levels and bytes at the board's pins and chips.
#[derive(Default)]
pub struct Wires {
    /// The step clock, which the bench sets.
    pub clock: Cell<u32>,
    /// Every change of an output: clock, pin, level.
    pub changes: RefCell<Vec<(u32, u32, bool)>>,
    /// Levels of pins, those that tests set among them.
    pub levels: RefCell<BTreeMap<u32, bool>>,
    /// The next conversion of every analog input.
    pub analog: Cell<Option<u16>>,
    /// Pins that have an owner.
    pub claimed: RefCell<Vec<u32>>,
    /// Every value of a channel of hardware PWM: pin, value.
    pub pwm: RefCell<Vec<(u32, u16)>>,
    /// Every exchange on a bus: select pin, bytes.
    pub spi: RefCell<Vec<(Option<u32>, Vec<u8>)>>,
    /// The configuration is whole.
    pub has_begun: Cell<bool>,
    /// Open-drain lines that the board lets go of.
    pub lines: RefCell<BTreeMap<u32, bool>>,
    /// Every change of an open-drain line: clock, pin, level.
    pub written: RefCell<Vec<(u32, u32, bool)>>,
    /// An answer on a line.
    pub answer: RefCell<Option<LineAnswer>>,
    /// A chip on the I2C bus of the pins 1 (clock) and 2 (data).
    pub chip: RefCell<I2cChip>,
    /// Samples in the FIFO of an ADXL345: x, y, z.
    pub accelerations: RefCell<VecDeque<[i16; 3]>>,
    /// The step interrupt was asked to look at its queue.
    pub steps_woken: Cell<bool>,
    /// Colours that were sent to strips.
    pub strips: RefCell<Vec<Vec<u8>>>,
    /// Strips take nothing now.
    pub strip_is_busy: Cell<bool>,
}

/// Bits of an answer on an open-drain line.
#[derive(Clone, Debug)]
pub struct LineAnswer {
    /// Pin of the line.
    pub pin: u32,
    /// Clock of the first bit.
    pub begin: u32,
    /// Length of a bit, ticks.
    pub bit_ticks: u32,
    /// Levels of the bits.
    pub bits: Vec<bool>,
}

/// A pin of the board.
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

/// An open-drain line of the board.
pub struct Line(Rc<Wires>, u32);

impl board::Wire for Line {
    fn set(&mut self, high: bool) {
        if self.0.lines.borrow_mut().insert(self.1, high) != Some(high) {
            self.0.written.borrow_mut().push((self.0.clock.get(), self.1, high));
        }
        let level = |pin| self.0.lines.borrow().get(&pin).copied().unwrap_or(true);
        self.0.chip.borrow_mut().see(level(1), level(2));
    }

    fn is_high(&self) -> bool {
        if let Some(answer) = &*self.0.answer.borrow()
            && answer.pin == self.1
            && let place = self.0.clock.get().wrapping_sub(answer.begin) / answer.bit_ticks
            && let Some(high) = answer.bits.get(place as usize)
        {
            return *high;
        }
        let is_held = self.1 == 2 && self.0.chip.borrow().pulls_low();
        self.0.lines.borrow().get(&self.1).copied().unwrap_or(true) && !is_held
    }
}

/// A chip on a bus, with its select pin. It answers with the bytes in reverse.
pub struct Chip(Rc<Wires>, Option<u32>);

impl board::Spi for Chip {
    fn exchange(&mut self, bytes: &mut [u8]) {
        let waiting = |fifo: &VecDeque<_>| fifo.len() as u8;
        let fifo = &self.0.accelerations;
        match bytes {
            // Data, FIFO_CTL and FIFO_STATUS of an ADXL345.
            [0xF2, data @ .., control, status] if !fifo.borrow().is_empty() => {
                let [x, y, z] = fifo.borrow_mut().pop_front().unwrap_or_default();
                let sample = [x, y, z].map(i16::to_le_bytes).concat();
                data.copy_from_slice(&sample);
                (*control, *status) = (0x90, waiting(&fifo.borrow()));
            }
            [0xB9, status] => *status = waiting(&fifo.borrow()),
            _ => {
                self.0.spi.borrow_mut().push((self.1, bytes.to_vec()));
                bytes.reverse();
            }
        }
    }
}

/// The board itself, as the controller has it.
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
    type Wire = Line;
    type Strip = u32;

    fn wire(&mut self, pin: u32, _pull: Pull) -> Option<Line> {
        self.0.lines.borrow_mut().insert(pin, true);
        Some(Line(self.0.clone(), pin))
    }

    fn pause(_ticks: u32) {}

    fn strip(&mut self, pin: u32) -> Result<u32, Reason> {
        self.claim(pin).map(|()| pin).ok_or(Reason::NotAPwmPin)
    }

    fn send_to_strip(&mut self, _strip: u32, bytes: &[u8]) -> bool {
        if self.0.strip_is_busy.get() {
            return false;
        }
        self.0.strips.borrow_mut().push(bytes.to_vec());
        true
    }

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

    fn wake_steps(&self) {
        self.0.steps_woken.set(true);
    }
}
