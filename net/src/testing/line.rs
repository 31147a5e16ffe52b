//! Console of tests: keeps what it receives, acts at `?`, `!` and Ctrl-X.

use std::collections::VecDeque;
use std::ops::Range;

use crate::line::{Line, Visitor};

/// Console that remembers everything.
pub struct TestLine {
    /// Bytes that wait in the queue, and its size.
    pub queue: VecDeque<u8>,
    pub size: usize,
    /// All that was received and has not acted.
    pub received: Vec<u8>,
    /// Bytes that acted, whenever they did.
    pub acted: Vec<u8>,
    pub visitor: Option<Visitor>,
    pub visits: u32,
}

impl TestLine {
    pub fn new() -> Self {
        Self { queue: VecDeque::new(), size: 1_024, received: Vec::new(), acted: Vec::new(), visitor: None, visits: 0 }
    }

    /// Reads so many bytes out of the queue.
    pub fn read(&mut self, count: usize) {
        let count = count.min(self.queue.len());
        self.received.extend(self.queue.drain(..count));
    }

    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.received).into_owned()
    }
}

impl Line for TestLine {
    fn room(&self) -> usize {
        self.size.saturating_sub(self.queue.len())
    }

    fn receive(&mut self, bytes: &[u8]) {
        assert!(self.visitor.is_some(), "bytes of nobody");
        assert!(bytes.len() <= self.room(), "more than there is room for");
        for byte in bytes {
            match byte {
                b'?' | b'!' => self.acted.push(*byte),
                0x18 => {
                    self.acted.push(*byte);
                    self.queue.clear();
                }
                _ => self.queue.push_back(*byte),
            }
        }
    }

    fn look_ahead(&mut self, waiting: &[u8], looked: usize) -> Option<Range<usize>> {
        assert!(self.visitor.is_some() && looked <= waiting.len());
        let at = looked + waiting[looked..].iter().position(|byte| matches!(byte, b'?' | b'!' | 0x18))?;
        self.acted.push(waiting[at]);
        if waiting[at] == 0x18 {
            self.queue.clear();
            return Some(0..at + 1);
        }
        Some(at..at + 1)
    }

    fn open(&mut self, visitor: Visitor) {
        assert!(self.visitor.is_none(), "opened twice");
        self.visitor = Some(visitor);
        self.visits += 1;
    }

    fn close(&mut self) {
        assert!(self.visitor.take().is_some(), "closed twice");
    }
}
