//! YModem, the receiving end: blocks of 128 or 1,024 bytes with a CRC, several files in one go.
//!
//! Source: Chuck Forsberg, "XMODEM/YMODEM Protocol Reference" (1988), chapters 4, 5 and 7. The receiver knows
//! bytes and time alone; files are its caller's.

use heapless::Vec;
use units::Micros;

const SOH: u8 = 0x01;
const STX: u8 = 0x02;
const EOT: u8 = 0x04;
const ACK: u8 = 0x06;
const NAK: u8 = 0x15;
const CAN: u8 = 0x18;
/// Request for blocks with a CRC.
const CRC: u8 = b'C';

/// Longest block, in bytes.
pub const BLOCK: usize = 1_024;
/// Length of a block with its number twice and its CRC.
const FRAME: usize = BLOCK + 4;
/// Longest silence of the sender.
const PATIENCE: Micros = Micros::from_seconds(1);
/// Greatest number of requests for a block, or for the beginning.
const MOST_TRIES: u8 = 16;

/// Reason why a transfer ended before its end, with Smoothieware's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// The sender gave the transfer up.
    Cancelled = -1,
    /// There is no sender.
    NoSender = -2,
    /// A block came wrong too often, or out of order.
    Retries = -3,
}

/// Event for the caller of the receiver.
#[derive(Debug, PartialEq, Eq)]
pub enum Event<'r> {
    /// Nothing to do yet.
    Nothing,
    /// A file begins: its name, and its size where the sender says it. Answer with [`Receiver::accept`].
    Begins(&'r str, Option<u32>),
    /// More of the file. Answer with [`Receiver::accept`].
    Data(&'r [u8]),
    /// The file is complete.
    FileEnds,
    /// All files have come.
    Ends,
    /// The transfer ends here, broken.
    Breaks(Broken),
}

/// Next part of the protocol that is awaited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Awaited {
    /// The block that names a file.
    Name,
    /// A block of the file.
    Block,
    /// The end of the file once more.
    SecondEnd,
}

/// Receiving end of a transfer.
#[derive(Debug)]
pub struct Receiver {
    awaited: Awaited,
    /// Number of the next block.
    number: u8,
    /// First byte of a frame, which says how long it is.
    kind: Option<u8>,
    frame: Vec<u8, FRAME>,
    /// Bytes of the file that are still to come; padding follows them.
    left: Option<u32>,
    tries: u8,
    /// Whether the last event was the name of a file.
    names: bool,
    /// Whether a cancel was heard: a second one counts.
    cancel: bool,
    due: Micros,
    /// Bytes to be sent to the sender.
    answer: Vec<u8, 4>,
}

impl Receiver {
    /// Makes a receiver that asks for the first file at this time.
    #[must_use]
    pub fn new(begins: Micros) -> Self {
        Self {
            awaited: Awaited::Name,
            number: 0,
            kind: None,
            frame: Vec::new(),
            left: None,
            tries: 0,
            names: false,
            cancel: false,
            due: begins,
            answer: Vec::new(),
        }
    }

    /// Takes the bytes to be sent now.
    pub fn take_answer(&mut self) -> Vec<u8, 4> {
        core::mem::take(&mut self.answer)
    }

    fn say(&mut self, byte: u8) {
        // Never more than two bytes wait, so there is room.
        let _ = self.answer.push(byte);
    }

    /// Handles time that passes without a byte.
    pub fn wait(&mut self, now: Micros) -> Event<'_> {
        if now < self.due {
            return Event::Nothing;
        }
        self.ask_again(now)
    }

    fn ask_again(&mut self, now: Micros) -> Event<'static> {
        self.tries += 1;
        self.kind = None;
        self.frame.clear();
        self.due = now.plus(PATIENCE);
        if self.tries > MOST_TRIES {
            self.cancel();
            let none = self.awaited == Awaited::Name && self.number == 0;
            return Event::Breaks(if none { Broken::NoSender } else { Broken::Retries });
        }
        self.say(if self.awaited == Awaited::Name { CRC } else { NAK });
        Event::Nothing
    }

    /// Has the sender stop the transfer.
    pub fn cancel(&mut self) {
        self.answer.clear();
        self.say(CAN);
        self.say(CAN);
    }

    /// Takes a byte of the sender.
    pub fn hear(&mut self, byte: u8, now: Micros) -> Event<'_> {
        let Some(kind) = self.kind else { return self.begin(byte, now) };
        self.due = now.plus(PATIENCE);
        // There is room: the frame ends with its last byte.
        let _ = self.frame.push(byte);
        let length = if kind == STX { BLOCK } else { 128 };
        if self.frame.len() < length + 4 {
            return Event::Nothing;
        }
        self.kind = None;
        self.end_frame(length, now)
    }

    fn begin(&mut self, byte: u8, now: Micros) -> Event<'_> {
        let was_cancel = core::mem::take(&mut self.cancel);
        match byte {
            SOH | STX => {
                self.kind = Some(byte);
                self.frame.clear();
                self.due = now.plus(PATIENCE);
                Event::Nothing
            }
            EOT if self.awaited == Awaited::Block => {
                self.due = now.plus(PATIENCE);
                // The first end byte may be noise: a sender repeats it.
                self.awaited = Awaited::SecondEnd;
                self.say(NAK);
                Event::Nothing
            }
            EOT if self.awaited == Awaited::SecondEnd => {
                self.due = now.plus(PATIENCE);
                self.awaited = Awaited::Name;
                (self.number, self.tries) = (0, 0);
                self.say(ACK);
                self.say(CRC);
                Event::FileEnds
            }
            CAN if was_cancel => {
                self.say(ACK);
                Event::Breaks(Broken::Cancelled)
            }
            CAN => {
                self.cancel = true;
                Event::Nothing
            }
            // Noise between blocks does not put off the next request: polling for status would delay it for
            // ever.
            _ => Event::Nothing,
        }
    }

    fn end_frame(&mut self, length: usize, now: Micros) -> Event<'_> {
        let (Some(head), Some(data), Some(tail)) =
            (self.frame.get(..2), self.frame.get(2..length + 2), self.frame.get(length + 2..))
        else {
            return Event::Nothing;
        };
        let (number, sum) = (head.first().copied().unwrap_or(0), crc(data).to_be_bytes());
        if head.get(1) != Some(&!number) || tail != sum {
            return self.ask_again(now);
        }
        self.tries = 0;
        match self.awaited {
            Awaited::Name if number == 0 => self.file_begins(length),
            Awaited::Block | Awaited::SecondEnd if number == self.number => {
                self.awaited = Awaited::Block;
                let most = self.left.map_or(length, |left| length.min(left as usize));
                self.left = self.left.map(|left| left - most as u32);
                Event::Data(self.frame.get(2..2 + most).unwrap_or(&[]))
            }
            // The acknowledgement was lost, and the block comes again.
            _ if number == self.number.wrapping_sub(1) => {
                self.say(ACK);
                Event::Nothing
            }
            _ => {
                self.cancel();
                Event::Breaks(Broken::Retries)
            }
        }
    }

    /// Reads the block that names a file; a nameless one ends the transfer.
    fn file_begins(&mut self, length: usize) -> Event<'_> {
        let data = self.frame.get(2..2 + length).unwrap_or(&[]);
        let mut parts = data.split(|byte| *byte == 0);
        let text = |part: Option<&'_ [u8]>| part.and_then(|bytes| core::str::from_utf8(bytes).ok().map(str::len));
        let name_length = text(parts.next()).unwrap_or(0);
        let size = parts.next().and_then(|part| core::str::from_utf8(part).ok());
        self.left = size.and_then(|text| text.split(' ').next()?.parse().ok());
        if name_length == 0 {
            self.say(ACK);
            return Event::Ends;
        }
        self.awaited = Awaited::Block;
        self.names = true;
        let name = self.frame.get(2..2 + name_length).and_then(|bytes| core::str::from_utf8(bytes).ok());
        Event::Begins(name.unwrap_or(""), self.left)
    }

    /// Confirms the last event: the next block may come.
    pub fn accept(&mut self) {
        self.say(ACK);
        // Behind the name of a file its blocks are asked for.
        if core::mem::take(&mut self.names) {
            self.say(CRC);
        }
        self.number = self.number.wrapping_add(1);
    }
}

/// Returns the CRC-16 with the polynomial x^16 + x^12 + x^5 + 1, from 0.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| if crc & 0x8000 == 0 { crc << 1 } else { crc << 1 ^ 0x1021 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Micros = Micros(0);

    /// Makes a block as a sender does.
    fn block(number: u8, data: &[u8]) -> std::vec::Vec<u8> {
        let length = if data.len() > 128 { BLOCK } else { 128 };
        let mut padded = data.to_vec();
        padded.resize(length, if number == 0 { 0 } else { 0x1A });
        let mut frame = std::vec![if length == BLOCK { STX } else { SOH }, number, !number];
        frame.extend(&padded);
        frame.extend(crc(&padded).to_be_bytes());
        frame
    }

    /// Returns the last event of these bytes, in words, and the answer.
    fn heard(receiver: &mut Receiver, bytes: &[u8]) -> (std::string::String, std::vec::Vec<u8>) {
        let mut said = std::string::String::new();
        for byte in bytes {
            let accepts = match receiver.hear(*byte, NOW) {
                Event::Nothing => false,
                event => {
                    said = std::format!("{event:?}");
                    matches!(event, Event::Begins(..) | Event::Data(_))
                }
            };
            if accepts {
                receiver.accept();
            }
        }
        (said, receiver.take_answer().to_vec())
    }

    #[test]
    fn the_crc_is_that_of_xmodem() {
        assert_eq!(crc(b"123456789"), 0x31C3, "the check value of CRC-16/XMODEM");
    }

    #[test]
    fn a_cancelled_sender_hears_it_twice_and_nothing_else() {
        let mut receiver = Receiver::new(NOW);
        assert_eq!(receiver.wait(NOW), Event::Nothing);
        receiver.cancel();
        assert_eq!(receiver.take_answer(), [CAN, CAN]);
    }

    #[test]
    fn files_come_one_behind_the_other() {
        let mut receiver = Receiver::new(NOW);
        assert_eq!(receiver.wait(NOW), Event::Nothing);
        assert_eq!(receiver.take_answer(), [CRC]);
        for name in ["a.g", "b.g"] {
            let head = std::format!("{name}\x003 0 0");
            let begins = std::format!("Begins({name:?}, Some(3))");
            assert_eq!(heard(&mut receiver, &block(0, head.as_bytes())), (begins, std::vec![ACK, CRC]));
            assert_eq!(heard(&mut receiver, &block(1, b"G28")).1, [ACK]);
            assert_eq!(heard(&mut receiver, &[EOT]), (std::string::String::new(), std::vec![NAK]));
            assert_eq!(heard(&mut receiver, &[EOT]), ("FileEnds".into(), std::vec![ACK, CRC]));
        }
        assert_eq!(heard(&mut receiver, &block(0, b"")), ("Ends".into(), std::vec![ACK]));
    }

    #[test]
    fn padding_is_no_part_of_the_file() {
        let mut receiver = Receiver::new(NOW);
        heard(&mut receiver, &block(0, b"a\x00130"));
        let long = [b'x'; 1_024];
        assert_eq!(heard(&mut receiver, &block(1, &long[..128])).0, std::format!("Data({:?})", &long[..128]));
        assert_eq!(heard(&mut receiver, &block(2, &long)).0, "Data([120, 120])");
        assert_eq!(heard(&mut receiver, &block(3, &long)).0, "Data([])");
    }

    #[test]
    fn a_wrong_block_is_asked_for_again_and_one_that_comes_twice_counts_once() {
        let mut receiver = Receiver::new(NOW);
        heard(&mut receiver, &block(0, b"a"));
        let mut wrong = block(1, b"G28");
        wrong[9] ^= 1;
        assert_eq!(heard(&mut receiver, &wrong), (std::string::String::new(), std::vec![NAK]));
        assert!(heard(&mut receiver, &block(1, b"G28")).0.starts_with("Data"));
        assert_eq!(heard(&mut receiver, &block(1, b"G28")), (std::string::String::new(), std::vec![ACK]));
        assert_eq!(heard(&mut receiver, &block(3, b"G28")), ("Breaks(Retries)".into(), std::vec![CAN, CAN]));
    }

    #[test]
    fn numbers_begin_anew_behind_block_255() {
        let mut receiver = Receiver::new(NOW);
        heard(&mut receiver, &block(0, b"a"));
        for number in 1..=600_u32 {
            let (said, answer) = heard(&mut receiver, &block(number as u8, b"x"));
            assert!(said.starts_with("Data") && answer == [ACK], "block {number}: {said} {answer:?}");
        }
    }

    #[test]
    fn it_ends_when_nobody_sends_or_the_sender_gives_up() {
        let mut receiver = Receiver::new(NOW);
        let mut now = NOW;
        let broken = loop {
            if let Event::Breaks(broken) = receiver.wait(now) {
                break broken;
            }
            now = now.plus(PATIENCE);
        };
        assert_eq!((broken, now.seconds()), (Broken::NoSender, 16.0));
        let mut receiver = Receiver::new(NOW);
        heard(&mut receiver, &block(0, b"a"));
        assert_eq!(heard(&mut receiver, &[CAN]).0, "", "one may be noise");
        assert_eq!(heard(&mut receiver, &[CAN, CAN]).0, "Breaks(Cancelled)");
    }

    #[test]
    fn a_program_that_asks_for_the_status_does_not_hold_it_for_ever() {
        let mut receiver = Receiver::new(NOW);
        for turn in 0..100 {
            let now = Micros(turn * 200_000);
            assert_eq!(receiver.hear(b'?', now), Event::Nothing);
            if receiver.wait(now) == Event::Breaks(Broken::NoSender) {
                return;
            }
        }
        panic!("it still waits after 20 seconds");
    }
}
