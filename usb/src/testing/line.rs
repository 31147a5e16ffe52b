//! Line of a serial port, in memory.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};

use crate::cdc::Line;

/// Machine's side of a line.
#[derive(Debug)]
pub struct State {
    /// Bytes that the host has sent.
    pub received: Vec<u8>,
    /// Number of further bytes that fit.
    pub room: usize,
    /// Bytes for the host.
    pub to_send: VecDeque<u8>,
    /// Begins (true) and ends (false) of visits.
    pub visits: Vec<bool>,
    /// Number of received bytes at each begin or end of a visit.
    pub received_at: Vec<usize>,
    /// Number of visits that were resumed.
    pub come_back: usize,
}

/// Line that tests and the device share.
#[derive(Clone, Debug)]
pub struct Memory(Arc<Mutex<State>>);

impl Default for Memory {
    fn default() -> Self {
        let (received, to_send, visits) = (Vec::new(), VecDeque::new(), Vec::new());
        let received_at = Vec::new();
        Self(Arc::new(Mutex::new(State { received, room: 1_000_000, to_send, visits, received_at, come_back: 0 })))
    }
}

impl Memory {
    pub fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap()
    }

    pub fn say(&self, text: &[u8]) {
        self.state().to_send.extend(text);
    }

    pub fn is_open(&self) -> bool {
        self.state().visits.last().copied().unwrap_or(false)
    }
}

impl Line for Memory {
    fn room(&self) -> usize {
        self.state().room
    }

    fn receive(&mut self, bytes: &[u8]) {
        let mut state = self.state();
        assert!(bytes.len() <= state.room, "{} bytes with room for {}", bytes.len(), state.room);
        state.room -= bytes.len();
        state.received.extend_from_slice(bytes);
    }

    fn fetch(&mut self, into: &mut [u8]) -> usize {
        let mut state = self.state();
        let count = into.len().min(state.to_send.len());
        into.iter_mut().zip(state.to_send.drain(..count)).for_each(|(place, byte)| *place = byte);
        count
    }

    fn set_open(&mut self, open: bool) {
        let mut state = self.state();
        state.visits.push(open);
        let received = state.received.len();
        state.received_at.push(received);
        if !open {
            state.to_send.clear();
        }
    }

    fn come_back(&mut self) {
        self.state().come_back += 1;
        self.set_open(true);
    }
}
