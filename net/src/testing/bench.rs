//! Board, wire and desk together, in virtual time.

use std::net::Ipv4Addr;

use smoltcp::iface::SocketHandle;
use smoltcp::time::Instant;

use super::desk::Desk;
use super::line::TestLine;
use super::streams::TestStreams;
use super::wire::{Port, Wire};
use crate::{LINES, Memory, Network, News, Peers, Settings, TimeServer};

/// Microseconds.
pub const MS: u64 = 1_000;
pub const SECOND: u64 = 1_000_000;

/// Address that the desk's DHCP server gives.
pub const BOARD: Ipv4Addr = Ipv4Addr::new(10, 0, 0, 42);
/// Ethernet address of the board.
pub const BOARD_MAC: [u8; 6] = [2, 0, 0, 0, 0, 0xB0];

/// Everything.
pub struct Bench {
    pub now: u64,
    pub is_up: bool,
    pub network: Network,
    pub lines: [TestLine; LINES],
    pub streams: TestStreams,
    pub port: Port,
    pub wire: Wire,
    pub desk: Desk,
    /// All events so far.
    pub news: Vec<News>,
    /// Bytes that each line reads out of its queue in a turn.
    pub reads: usize,
}

impl Bench {
    /// Settings of most tests: both services, no password.
    pub fn settings() -> Settings {
        let mut settings = Settings::new(BOARD_MAC);
        (settings.telnet, settings.grbl, settings.password_required) = (Some(23), Some(2323), false);
        settings
    }

    pub fn new(settings: Settings) -> Self {
        Self::with_port(settings, Port::new(4))
    }

    /// A bench whose board leaves checksums unchecked.
    pub fn trusting(settings: Settings) -> Self {
        let mut port = Port::new(4);
        port.is_trusting = true;
        Self::with_port(settings, port)
    }

    fn with_port(settings: Settings, mut port: Port) -> Self {
        let memory = Box::leak(Box::new(Memory::new()));
        Self {
            now: 0,
            is_up: true,
            network: Network::new(memory, settings, &mut port, 1, 0),
            lines: std::array::from_fn(|_| TestLine::new()),
            streams: TestStreams::default(),
            port,
            wire: Wire::new(1),
            desk: Desk::new(BOARD),
            news: Vec::new(),
            reads: usize::MAX,
        }
    }

    /// Lets the board get its address.
    pub fn with_address() -> Self {
        let mut bench = Self::new(Self::settings());
        bench.get_address();
        bench
    }

    pub fn get_address(&mut self) {
        assert!(self.until(20 * SECOND, |bench| bench.network.report().address.is_some()), "{:?}", self.news);
    }

    /// One turn of everybody, and time goes on to the next reason for one.
    pub fn step(&mut self) {
        let instant = Instant::from_micros(self.now as i64);
        if self.is_up {
            self.wire.land(self.now, &mut self.port, &mut self.desk.port);
        } else {
            self.wire.cut();
            self.port.clear();
            self.desk.port.clear();
        }
        self.desk.run(instant);
        let mut peers = Peers { lines: &mut self.lines, streams: &mut self.streams };
        self.network.poll(self.now, self.is_up, &mut self.port, &mut peers);
        while let Some(news) = self.network.take_news() {
            self.news.push(news);
        }
        let waiting: usize = self.lines.iter().map(|line| line.queue.len()).sum();
        for line in &mut self.lines {
            line.read(self.reads);
        }
        self.wire.take(self.now, &mut self.port, &mut self.desk.port);
        let has_more_room = waiting > 0 && self.reads > 0;
        self.now = if has_more_room { self.now + 100 } else { self.next() };
    }

    fn next(&mut self) -> u64 {
        let instant = Instant::from_micros(self.now as i64);
        let of_board = self.now + self.network.next_in();
        let of_desk = self.desk.interface.poll_at(instant, &self.desk.sockets);
        let of_desk = of_desk.map(|at| at.total_micros() as u64);
        let waits = (self.port.waits() || self.desk.port.waits()).then_some(self.now);
        let next = [Some(of_board), of_desk, self.wire.next(), waits].into_iter().flatten().min();
        next.unwrap_or(self.now + SECOND).clamp(self.now + 50, self.now + SECOND)
    }

    pub fn run(&mut self, duration: u64) {
        let end = self.now + duration;
        while self.now < end {
            self.step();
        }
    }

    /// Runs until something holds. False if that takes longer than this.
    pub fn until(&mut self, most: u64, mut holds: impl FnMut(&mut Self) -> bool) -> bool {
        let end = self.now + most;
        while self.now < end {
            self.step();
            if holds(self) {
                return true;
            }
        }
        false
    }

    /// Connects to a service of the board, and waits until that stands.
    pub fn connect(&mut self, port: u16) -> SocketHandle {
        let address = self.network.report().address.expect("an address").address;
        let handle = self.desk.connect(address, port);
        assert!(self.until(30 * SECOND, |bench| bench.desk.tcp(handle).may_send()), "{:?}", self.news);
        handle
    }

    /// Reads what comes within a time.
    pub fn hear(&mut self, handle: SocketHandle, duration: u64) -> String {
        let end = self.now + duration;
        let mut heard = String::new();
        while self.now < end {
            self.step();
            heard += &self.desk.text(handle);
        }
        heard
    }

    /// Writes everything to a line of the board.
    pub fn write(&mut self, line: usize, bytes: &[u8]) {
        let mut left = bytes;
        while !left.is_empty() {
            let count = self.network.write(line, left);
            left = &left[count..];
            self.step();
        }
    }
}

/// Returns the time server of this address or name.
pub fn time_server(text: &str) -> Option<TimeServer> {
    text.parse().map_or_else(|_| TimeServer::named(text), |address| Some(TimeServer::Address(address)))
}
