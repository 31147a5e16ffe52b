//! Input for a console from outside, typed by a person or fed by a pipe: no more of it at a time than the
//! wire takes.

use std::io::Read;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;

use crate::console::Line;

/// Bytes that may wait for the wire: 22 ms of it at 115200 baud. So no server of the line ever has more to do
/// for it than that, and a typed byte is soon through.
pub const AHEAD: usize = 256;
/// Number of pieces that may be read before the line takes them.
const PIECES: usize = 2;

/// An input that is read by a thread of its own, since reading blocks. The writer is held back as by a
/// terminal.
#[derive(Debug)]
pub struct Typed {
    pieces: Receiver<Vec<u8>>,
    over: bool,
}

impl Typed {
    /// Starts a thread that reads the input.
    #[must_use]
    pub fn read(mut from: impl Read + Send + 'static) -> Self {
        let (sender, pieces) = mpsc::sync_channel(PIECES);
        thread::spawn(move || {
            let mut bytes = [0; AHEAD];
            loop {
                // An input that cannot be read counts as ended.
                let count = from.read(&mut bytes).unwrap_or(0);
                if count == 0 || sender.send(bytes[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        Self { pieces, over: false }
    }

    /// Puts typed bytes on the line, as long as its wire is not far behind.
    pub fn hand_to(&mut self, line: &Line) {
        while line.unsent() < AHEAD {
            match self.pieces.try_recv() {
                Ok(bytes) => line.send(&bytes),
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.over = true;
                    return;
                }
            }
        }
    }

    /// Whether the input has ended, and all of it is on the line.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.over
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    #[test]
    fn an_endless_input_waits_for_the_wire() {
        let (mut typed, line) = (Typed::read(io::repeat(b'x')), Line::default());
        for _ in 0..1_000 {
            typed.hand_to(&line);
            assert!(line.unsent() < 2 * AHEAD, "{} bytes wait", line.unsent());
            thread::yield_now();
        }
        assert!(!typed.is_over());
    }

    #[test]
    fn all_of_an_input_arrives_before_its_end() {
        let text = "0123456789".repeat(100);
        let (mut typed, line) = (Typed::read(io::Cursor::new(text.clone())), Line::default());
        let mut taken = 0;
        while !typed.is_over() {
            typed.hand_to(&line);
            taken += line.take_unsent().len();
            thread::yield_now();
        }
        assert_eq!(taken, text.len());
    }
}
