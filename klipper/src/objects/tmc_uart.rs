//! Serial lines of TMC drivers, as bits: the host makes datagrams out of them (TMC2209 data sheet, "UART
//! single wire interface").

use crate::board::Wire;
use crate::reason::Reason;

/// Most bytes of bits in either direction: eight bytes with their start and stop bits.
const MOST_BYTES: usize = 10;
/// Time between a command and its first bit: 200 us at 200 MHz.
const START_TICKS: u32 = 40_000;
/// Looks for the beginning of an answer come four to a bit.
const LOOKS_PER_BIT: u32 = 4;
/// Bits in which an answer must begin.
const MOST_WAIT_BITS: u32 = 64;
/// Bits between what is written and the first look for an answer.
const TURN_BITS: u32 = 4;
/// Bits of a byte on the line, with start and stop bit.
const FRAME_BITS: u32 = 10;

/// Stage of an exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Idle,
    /// Bit to write next.
    Write(u32),
    /// Looks that are left to see the line high before an answer.
    AwaitHigh(u32),
    /// Looks that are left to see a start bit, and the bits that have been read.
    AwaitStart(u32, u32),
    /// Bit to read next.
    Read(u32),
}

/// A line with its exchange.
#[derive(Debug)]
pub struct TmcUart<W> {
    /// Line that is read, and written if there is no other.
    line: W,
    transmitter: Option<W>,
    bit_ticks: u32,
    stage: Stage,
    bits: [u8; MOST_BYTES],
    write_bits: u32,
    read_bits: u32,
}

/// Outcome of a call at a timer's time.
pub enum Next {
    /// The exchange goes on at this time.
    At(u32),
    /// The exchange is over: the bits of the answer; none when there was no answer.
    Answer(heapless::Vec<u8, MOST_BYTES>),
}

impl<W: Wire> TmcUart<W> {
    /// A line at rest, which is high.
    pub fn new(mut line: W, mut transmitter: Option<W>, bit_ticks: u32) -> Self {
        transmitter.as_mut().unwrap_or(&mut line).set(true);
        Self {
            line,
            transmitter,
            bit_ticks: bit_ticks.max(LOOKS_PER_BIT),
            stage: Stage::Idle,
            bits: [0; MOST_BYTES],
            write_bits: 0,
            read_bits: 0,
        }
    }

    /// Begins to write bits, and to read so many bytes of them. Returns when to call first; `None` while an
    /// exchange is under way, which goes on: the host asks again.
    ///
    /// # Errors
    /// Too many bits.
    pub fn send(&mut self, write: &[u8], read_bytes: u32, now: u32) -> Result<Option<u32>, Reason> {
        let Some(place) = self.bits.get_mut(..write.len()) else { return Err(Reason::UartTooLong) };
        if read_bytes as usize > MOST_BYTES {
            return Err(Reason::UartTooLong);
        }
        if self.stage != Stage::Idle {
            return Ok(None);
        }
        place.copy_from_slice(write);
        (self.write_bits, self.read_bits) = (write.len() as u32 * 8, read_bytes * 8);
        self.stage = Stage::Write(0);
        Ok(Some(now.wrapping_add(START_TICKS)))
    }

    fn put(&mut self, high: bool) {
        self.transmitter.as_mut().unwrap_or(&mut self.line).set(high);
    }

    /// The time has come that was named.
    pub fn on_timer(&mut self, due: u32) -> Next {
        let bit = self.bit_ticks;
        let in_bits = |bits: u32| Next::At(due.wrapping_add(bits * bit));
        let at_next_look = Next::At(due.wrapping_add(bit / LOOKS_PER_BIT));
        match self.stage {
            Stage::Idle => self.end(0),
            Stage::Write(place) if place < self.write_bits => {
                let byte = self.bits.get(place as usize / 8).copied().unwrap_or(0xFF);
                self.put(byte >> (place % 8) & 1 != 0);
                self.stage = Stage::Write(place + 1);
                in_bits(1)
            }
            Stage::Write(_) => {
                self.put(true);
                if self.read_bits == 0 {
                    return self.end(0);
                }
                self.bits = [0; MOST_BYTES];
                self.stage = Stage::AwaitHigh(MOST_WAIT_BITS * LOOKS_PER_BIT);
                in_bits(TURN_BITS)
            }
            Stage::AwaitHigh(0) | Stage::AwaitStart(0, 0) => self.end(0),
            Stage::AwaitHigh(looks) => {
                self.stage = if self.line.is_high() {
                    Stage::AwaitStart(MOST_WAIT_BITS * LOOKS_PER_BIT, 0)
                } else {
                    Stage::AwaitHigh(looks - 1)
                };
                at_next_look
            }
            Stage::AwaitStart(looks, bits) if self.line.is_high() && looks > 0 => {
                self.stage = Stage::AwaitStart(looks - 1, bits);
                at_next_look
            }
            // A start bit, half a look ago on the mean: its middle is read next.
            Stage::AwaitStart(_, bits) => {
                self.stage = Stage::Read(bits);
                Next::At(due.wrapping_add(bit / 2 - bit / (2 * LOOKS_PER_BIT)))
            }
            Stage::Read(place) => self.read(place, due),
        }
    }

    /// Reads a bit. Behind each stop bit the next start bit is looked for, so that a driver whose clock is a
    /// few per cent off is read to its end.
    fn read(&mut self, place: u32, due: u32) -> Next {
        if self.line.is_high()
            && let Some(byte) = self.bits.get_mut(place as usize / 8)
        {
            *byte |= 1 << (place % 8);
        }
        let next = place + 1;
        if next >= self.read_bits {
            return self.end(self.read_bits as usize / 8);
        }
        if next.is_multiple_of(FRAME_BITS) {
            // At most one bit of waiting: bytes of a datagram follow each other at once.
            self.stage = Stage::AwaitStart(LOOKS_PER_BIT, next);
            return Next::At(due.wrapping_add(self.bit_ticks / LOOKS_PER_BIT));
        }
        self.stage = Stage::Read(next);
        Next::At(due.wrapping_add(self.bit_ticks))
    }

    fn end(&mut self, bytes: usize) -> Next {
        self.stage = Stage::Idle;
        let answer = self.bits.get(..bytes).unwrap_or(&[]);
        Next::Answer(heapless::Vec::from_slice(answer).unwrap_or_default())
    }

    /// Ends an exchange: the line is at rest.
    pub fn shut_down(&mut self) {
        self.stage = Stage::Idle;
        self.put(true);
    }
}
