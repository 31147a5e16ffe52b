//! A Klipper host, written from the protocol's description: it shares nothing with the image.

use virtual_prime::usb_desk::UsbHost;
use virtual_prime::usb_desk::cdc::Serial;
use virtual_prime::vm::Span;

use super::{Bench, MS};

/// Time in which an answer comes, milliseconds.
const PATIENCE_MS: u64 = 100;

/// CRC-16/MCRF4XX.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc: u16, _| if crc & 1 != 0 { crc >> 1 ^ 0x8408 } else { crc >> 1 })
    })
}

/// Appends an integer: groups of seven bits, the highest first.
fn put(bytes: &mut Vec<u8>, value: u32) {
    let value = i64::from(value as i32);
    for shift in [28, 21, 14, 7] {
        let limit = 1_i64 << (shift - 2);
        if value >= 3 * limit || value < -limit {
            bytes.push((value >> shift) as u8 & 0x7F | 0x80);
        }
    }
    bytes.push(value as u8 & 0x7F);
}

/// Takes an integer from the front.
pub fn take(bytes: &mut &[u8]) -> u32 {
    let mut next = || {
        let (first, rest) = bytes.split_first().expect("an integer");
        *bytes = rest;
        *first
    };
    let mut byte = next();
    let sign = if byte & 0x60 == 0x60 { !0x1F } else { 0 };
    let mut value = u32::from(byte & 0x7F) | sign;
    while byte & 0x80 != 0 {
        byte = next();
        value = value << 7 | u32::from(byte & 0x7F);
    }
    value
}

/// A parameter of a command.
pub enum Word<'a> {
    Number(u32),
    Bytes(&'a [u8]),
}

/// A way for bytes to the board and back, in which time passes.
pub trait Wire {
    fn send(&mut self, bytes: &[u8]);
    fn receive(&mut self) -> Vec<u8>;
}

impl Wire for Bench {
    fn send(&mut self, bytes: &[u8]) {
        self.console.send(bytes);
    }

    fn receive(&mut self) -> Vec<u8> {
        assert_eq!(self.vm.run_for(MS), Span::Reached);
        self.console.receive()
    }
}

/// A serial port of the USB socket.
pub struct Socket {
    pub bench: Bench,
    pub host: UsbHost,
    pub port: Serial,
}

impl Wire for Socket {
    fn send(&mut self, bytes: &[u8]) {
        self.port.write(&mut self.host.at(&mut self.bench.vm), bytes).expect("the board takes it");
    }

    fn receive(&mut self) -> Vec<u8> {
        let mut desk = self.host.at(&mut self.bench.vm);
        let listening = self.port.listen(&mut desk, 64);
        desk.wait(listening).expect("an answer").data
    }
}

/// A host with the number of its next block, and the dictionary that the board has told it.
pub struct Host<W> {
    pub wire: W,
    sequence: u8,
    heard: Vec<u8>,
    /// The dictionary's text.
    pub dictionary: String,
}

impl<W: Wire> Host<W> {
    /// Identifies the board.
    pub fn new(wire: W) -> Self {
        let mut host = Self { wire, sequence: 1, heard: Vec::new(), dictionary: String::new() };
        let mut packed = Vec::new();
        loop {
            let mut command = vec![1];
            put(&mut command, packed.len() as u32);
            put(&mut command, 40);
            let answers = host.exchange(&command);
            let Some(mut answer) = answers.iter().find_map(|answer| answer.strip_prefix(&[0])) else { continue };
            assert_eq!(take(&mut answer), packed.len() as u32);
            assert_eq!(usize::from(answer[0]), answer.len() - 1);
            if answer.len() == 1 {
                break;
            }
            packed.extend_from_slice(&answer[1..]);
        }
        let text = miniz_oxide::inflate::decompress_to_vec_zlib(&packed).expect("zlib data");
        host.dictionary = String::from_utf8(text).expect("text");
        host
    }

    /// Number of a message, from the dictionary: a format is the name and words with an equals sign.
    pub fn number(&self, name: &str) -> u32 {
        let is_format = |text: &str| {
            let mut words = text.split(' ');
            words.next() == Some(name) && words.all(|word| word.contains('='))
        };
        let texts: Vec<&str> = self.dictionary.split('"').collect();
        let number = texts.windows(2).filter(|pair| is_format(pair[0])).find_map(|pair| {
            let number = pair[1].trim_matches(|c: char| !c.is_ascii_digit() && c != '-');
            number.parse::<i32>().ok()
        });
        number.unwrap_or_else(|| panic!("no {name} in {}", self.dictionary)) as u32
    }

    /// Sends a block until it is acknowledged. Returns the contents of the blocks that came meanwhile.
    fn exchange(&mut self, content: &[u8]) -> Vec<Vec<u8>> {
        let mut answers = Vec::new();
        for _ in 0..3 {
            let mut block = vec![content.len() as u8 + 5, 0x10 | self.sequence];
            block.extend_from_slice(content);
            let sum = crc(&block);
            block.extend_from_slice(&[(sum >> 8) as u8, sum as u8, 0x7E]);
            self.wire.send(&block);
            let sent = self.sequence;
            for _ in 0..PATIENCE_MS {
                let is_acknowledged = self.listen(&mut answers);
                if is_acknowledged && self.sequence == (sent + 1) & 15 {
                    return answers;
                }
                if is_acknowledged {
                    break;
                }
            }
        }
        panic!("a block is not acknowledged");
    }

    /// Takes what came in. Returns whether an empty block was among it.
    fn listen(&mut self, answers: &mut Vec<Vec<u8>>) -> bool {
        self.heard.extend(self.wire.receive());
        let mut is_acknowledged = false;
        while let Some(&length) = self.heard.first().filter(|length| self.heard.len() >= usize::from(**length)) {
            let block: Vec<u8> = self.heard.drain(..usize::from(length)).collect();
            let (body, end) = block.split_at(block.len() - 3);
            assert_eq!(end, [(crc(body) >> 8) as u8, crc(body) as u8, 0x7E], "{block:02x?}");
            self.sequence = body[1] & 15;
            if body.len() == 2 { is_acknowledged = true } else { answers.push(body[2..].to_vec()) }
        }
        is_acknowledged
    }

    /// Gives a command, and returns the numbers of the first answer of this name.
    pub fn ask(&mut self, command: &str, words: &[Word<'_>], answer: &str) -> Vec<u32> {
        let number = self.number(answer);
        let answers = self.give(command, words);
        let mut found = answers.iter().filter_map(|answer| {
            let mut rest = answer.as_slice();
            (take(&mut rest) == number).then_some(rest)
        });
        let mut rest = found.next().unwrap_or_else(|| panic!("{command}: no {answer} in {answers:02x?}"));
        let mut numbers = Vec::new();
        while !rest.is_empty() {
            numbers.push(take(&mut rest));
        }
        numbers
    }

    pub fn give(&mut self, command: &str, words: &[Word<'_>]) -> Vec<Vec<u8>> {
        let mut content = Vec::new();
        put(&mut content, self.number(command));
        for word in words {
            match word {
                Word::Number(number) => put(&mut content, *number),
                Word::Bytes(bytes) => {
                    content.push(bytes.len() as u8);
                    content.extend_from_slice(bytes);
                }
            }
        }
        self.exchange(&content)
    }

    /// Gives a command of numbers alone, to which nothing is answered.
    pub fn tell(&mut self, command: &str, numbers: &[u32]) {
        let words: Vec<Word<'_>> = numbers.iter().copied().map(Word::Number).collect();
        let answers = self.give(command, &words);
        let refusal = self.number("is_shutdown");
        let is_refused = answers.iter().any(|answer| take(&mut answer.as_slice()) == refusal);
        assert!(!is_refused, "{command} {numbers:?}: {answers:02x?}");
    }

    pub fn clock(&mut self) -> u32 {
        self.ask("get_clock", &[], "clock")[0]
    }

    /// Lets time pass. Returns the answers that came.
    pub fn pass(&mut self, ms: u64) -> Vec<Vec<u8>> {
        let mut answers = Vec::new();
        for _ in 0..ms {
            self.listen(&mut answers);
        }
        answers
    }
}
