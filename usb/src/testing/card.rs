//! Simulated card in memory.

use std::sync::{Arc, Mutex, MutexGuard};

use crate::storage::{BLOCK_BYTES, Fault, Half, Medium, Progress, State};

/// State of a card, with settings and a record of operations.
#[derive(Debug)]
pub struct Inside {
    pub blocks: Vec<u8>,
    pub state: State,
    /// Number of polls before an operation ends.
    pub slowness: u32,
    /// Block that fails, with the fault.
    pub bad: Option<(u32, Fault)>,
    /// Operations begun: kind, first block, count.
    pub operations: Vec<(char, u32, u32)>,
    pub ejected: u32,
}

/// Card that tests and the device share.
#[derive(Clone)]
pub struct Card {
    inside: Arc<Mutex<Inside>>,
    buffers: [Vec<u8>; 2],
    /// Operation in progress (read, block, count, buffer), and the number of polls left.
    under_way: Option<(bool, u32, u32, Half, u32)>,
    outcome: Progress,
}

impl Card {
    /// Creates a card with this number of blocks, each filled with its own pattern.
    pub fn new(blocks: u32) -> Self {
        let bytes = (0..blocks).flat_map(|block| (0..BLOCK_BYTES).map(move |at| (block as usize * 7 + at) as u8));
        let inside = Inside {
            blocks: bytes.collect(),
            state: State::Ready { blocks, is_read_only: false, visit: 1 },
            slowness: 3,
            bad: None,
            operations: Vec::new(),
            ejected: 0,
        };
        let buffer = vec![0xEE; BLOCK_BYTES * Self::BUFFER_BLOCKS as usize];
        Self {
            inside: Arc::new(Mutex::new(inside)),
            buffers: [buffer.clone(), buffer],
            under_way: None,
            outcome: Progress::Done,
        }
    }

    pub fn inside(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap()
    }

    fn begin(&mut self, is_read: bool, block: u32, count: u32, buffer: Half) {
        assert!(self.under_way.is_none(), "two operations at once");
        assert!((1..=Self::BUFFER_BLOCKS).contains(&count));
        let slowness = {
            let mut inside = self.inside();
            assert!((block + count) as usize * BLOCK_BYTES <= inside.blocks.len(), "behind the end");
            inside.operations.push((if is_read { 'r' } else { 'w' }, block, count));
            inside.slowness
        };
        self.under_way = Some((is_read, block, count, buffer, slowness));
    }

    fn finish(&mut self, is_read: bool, block: u32, count: u32, buffer: Half) -> Progress {
        let bytes = block as usize * BLOCK_BYTES..(block + count) as usize * BLOCK_BYTES;
        let mut inside = self.inside.lock().unwrap();
        if matches!(inside.state, State::Absent) {
            return Progress::Failed(Fault::Gone);
        }
        if let Some((bad, fault)) = inside.bad
            && (block..block + count).contains(&bad)
        {
            return Progress::Failed(fault);
        }
        let buffer = &mut self.buffers[buffer as usize][..bytes.len()];
        if is_read {
            buffer.copy_from_slice(&inside.blocks[bytes]);
        } else {
            inside.blocks[bytes].copy_from_slice(buffer);
        }
        Progress::Done
    }
}

impl Medium for Card {
    const BUFFER_BLOCKS: u32 = 4;

    fn state(&self) -> State {
        self.inside().state
    }

    fn begin_read(&mut self, block: u32, count: u32, buffer: Half) {
        self.begin(true, block, count, buffer);
    }

    fn begin_write(&mut self, block: u32, count: u32, buffer: Half) {
        self.begin(false, block, count, buffer);
    }

    fn progress(&mut self) -> Progress {
        match self.under_way {
            Some((is_read, block, count, buffer, 0)) => {
                self.under_way = None;
                self.outcome = self.finish(is_read, block, count, buffer);
            }
            Some((.., ref mut looks)) => {
                *looks -= 1;
                return Progress::Busy;
            }
            None => {}
        }
        self.outcome
    }

    fn fetch(&self, buffer: Half, at: usize, into: &mut [u8]) {
        if let Some((true, _, _, loading, _)) = self.under_way {
            assert_ne!(loading, buffer, "the buffer that is being filled is read");
        }
        into.copy_from_slice(&self.buffers[buffer as usize][at..at + into.len()]);
    }

    fn store(&mut self, buffer: Half, at: usize, bytes: &[u8]) {
        if let Some((false, _, _, writing, _)) = self.under_way {
            assert_ne!(writing, buffer, "the buffer that is being written is overwritten");
        }
        self.buffers[buffer as usize][at..at + bytes.len()].copy_from_slice(bytes);
    }

    fn eject(&mut self) {
        let mut inside = self.inside();
        inside.state = State::Absent;
        inside.ejected += 1;
    }
}
