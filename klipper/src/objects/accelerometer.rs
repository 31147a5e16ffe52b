//! The accelerometer ADXL345 on an SPI bus, for measuring resonances: its FIFO is read in time, and samples
//! go to the host in messages (ADXL345 data sheet, "Register map" and "FIFO").

use crate::board::Spi;

/// Bytes of samples in a message, of which a sample has five: what hosts expect.
const MESSAGE_BYTES: usize = 50;
/// Reads of several registers, from DATAX0 (0x32) on: six bytes of data, FIFO_CTL and FIFO_STATUS.
const READ_SAMPLE: u8 = 0x80 | 0x40 | 0x32;
/// A read of FIFO_STATUS.
const READ_FIFO_STATUS: u8 = 0x80 | 0x39;
/// FIFO_CTL as hosts set it: stream mode, watermark 16. Anything else is a broken wire or a chip that was
/// reset.
const FIFO_CTL: u8 = 0x90;
/// Number of samples in FIFO_STATUS.
const FIFO_ENTRIES: u8 = 0x7F;
/// Samples that the FIFO holds: with so many, some may be lost.
const FIFO_FULL: u8 = 32;
/// A sample that is none.
const NO_SAMPLE: [u8; 5] = [0xFF; 5];

/// Samples on their way to the host.
pub type Samples = heapless::Vec<u8, MESSAGE_BYTES>;

/// Work on the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// A sample, and how many wait behind it.
    Sample,
    /// The number of samples that wait.
    Status,
}

/// Answer of the chip.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// The sample as hosts have it, if one was asked for.
    pub sample: [u8; 5],
    /// Samples that wait in the FIFO.
    pub waiting: u8,
    /// Clock before the exchange, and its length.
    pub clock: u32,
    /// Length of the exchange, ticks.
    pub ticks: u32,
}

/// A sample out of the six bytes of the data registers: thirteen bits of each axis in five bytes.
fn packed(data: &[u8; 9]) -> [u8; 5] {
    let [_, x_low, x_high, y_low, y_high, z_low, z_high, control, _] = *data;
    if control != FIFO_CTL {
        return NO_SAMPLE;
    }
    [x_low, y_low, z_low, x_high & 0x1F | z_high << 5 & 0xE0, y_high & 0x1F | z_high << 2 & 0x60]
}

/// Asks the chip. `clock` is the step clock.
pub fn ask(chip: &mut impl Spi, request: Request, clock: impl Fn() -> u32) -> Answer {
    let begun = clock();
    let (sample, waiting) = match request {
        Request::Sample => {
            let mut data = [0; 9];
            data[0] = READ_SAMPLE;
            chip.exchange(&mut data);
            (packed(&data), data[8])
        }
        Request::Status => {
            let mut data = [READ_FIFO_STATUS, 0];
            chip.exchange(&mut data);
            (NO_SAMPLE, data[1])
        }
    };
    Answer { sample, waiting: waiting & FIFO_ENTRIES, clock: begun, ticks: clock().wrapping_sub(begun) }
}

/// An accelerometer with what it has measured.
#[derive(Debug)]
pub struct Accelerometer {
    /// The chip, by its object.
    pub device: u8,
    rest_ticks: u32,
    sequence: u16,
    possible_overflows: u16,
    samples: Samples,
    /// Question that waits for the bus.
    wants: Option<Request>,
}

impl Accelerometer {
    /// An accelerometer that does not measure.
    pub const fn new(device: u8) -> Self {
        let samples = heapless::Vec::new();
        Self { device, rest_ticks: 0, sequence: 0, possible_overflows: 0, samples, wants: None }
    }

    /// Begins to measure, or ends it. Returns when to look first.
    pub fn begin(&mut self, rest_ticks: u32, now: u32) -> Option<u32> {
        *self = Self { rest_ticks, ..Self::new(self.device) };
        (rest_ticks != 0).then(|| now.wrapping_add(rest_ticks))
    }

    /// Has the chip asked, when its bus is free.
    pub fn want(&mut self, request: Request) {
        self.wants = Some(request);
    }

    /// Takes what the chip is to be asked.
    pub fn take_request(&mut self) -> Option<Request> {
        self.wants.take()
    }

    /// Takes a sample. Returns a whole message, with its number, and when to look again; at once, without a
    /// time, while more samples wait.
    pub fn take(&mut self, answer: &Answer, now: u32) -> (Option<(u16, Samples)>, Option<u32>) {
        if self.rest_ticks == 0 {
            return (None, None);
        }
        // There is room: a message is sent when it has its bytes.
        let _fits = self.samples.extend_from_slice(&answer.sample);
        let is_whole = self.samples.len() == MESSAGE_BYTES;
        let message = is_whole.then(|| {
            let number = self.sequence;
            self.sequence = number.wrapping_add(1);
            (number, core::mem::take(&mut self.samples))
        });
        if answer.waiting >= FIFO_FULL - 1 {
            self.possible_overflows = self.possible_overflows.wrapping_add(1);
        }
        if answer.waiting > 1 && answer.waiting <= FIFO_FULL {
            self.wants = Some(Request::Sample);
            return (message, None);
        }
        (message, Some(now.wrapping_add(self.rest_ticks)))
    }

    /// State as hosts want it: clock, length of the query, number of the next message, bytes that wait here
    /// and in the chip, times that some may have been lost.
    pub fn state(&self, answer: &Answer) -> [u32; 5] {
        let waiting = self.samples.len() as u32 + 5 * u32::from(answer.waiting);
        [answer.clock, answer.ticks, u32::from(self.sequence), waiting, u32::from(self.possible_overflows)]
    }
}
