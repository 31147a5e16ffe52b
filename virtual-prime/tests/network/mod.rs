//! The network on the real image: the board at a cable, with a computer at its other end.

mod abuse;
mod access;
mod addresses;
mod cables;
mod consoles;
mod jogs;
mod motion;
mod page;
mod path;
mod print_beside;
mod storms;
mod uploads;

use virtual_prime::net_desk::peer::{Connection, Peer};

use crate::common::MS;
use crate::common::velvet::{Plan, SECOND, Velvet};

/// Virtual time between two rounds of the computer.
const ROUND_NS: u64 = 250_000;

/// Velvet and the computer at the other end of its cable.
struct Net {
    velvet: Velvet,
    peer: Peer,
}

/// Plans the sample printer with a network, and these lines of the configuration.
fn plan(lines: &[&str]) -> Plan {
    let network = ["[network] enable = true", "[network] shell_enable = true"];
    network.iter().chain(lines).fold(Plan::new(), |plan, line| plan.set(line))
}

impl Net {
    /// Switches the board on, with the cable in.
    #[track_caller]
    fn start(plan: Plan) -> Self {
        let mut velvet = plan.start();
        let peer = Peer::new(7);
        peer.plug(&mut velvet.bench.vm);
        Self { velvet, peer }
    }

    /// The same, and waits for the address of the computer's DHCP server.
    #[track_caller]
    fn with_address(plan: Plan) -> Self {
        let mut net = Self::start(plan);
        net.hear_until("// network: 10.0.2.15 (from DHCP)", 15 * SECOND);
        net
    }

    /// Runs board and computer for so many milliseconds.
    #[track_caller]
    fn run(&mut self, ms: u64) {
        let end_ns = self.velvet.bench.vm.now_ns() + ms * MS;
        while self.velvet.bench.vm.now_ns() < end_ns {
            self.velvet.hear_for(ROUND_NS);
            self.peer.serve(&mut self.velvet.bench.vm);
        }
    }

    /// Runs board and computer until the debug console has said this.
    #[track_caller]
    fn hear_until(&mut self, words: &str, patience_ms: u64) {
        let (before, end) = (self.velvet.said().len(), self.velvet.now_ms() + patience_ms);
        while !self.velvet.said()[before..].contains(words) {
            let said = &self.velvet.said()[before..];
            assert!(self.velvet.now_ms() < end, "no {words:?} within {patience_ms} ms; it said: {said}");
            self.run(5);
        }
    }

    /// Types a line at the debug console, and waits for its answer. Returns all words of that time.
    #[track_caller]
    fn ask(&mut self, line: &str) -> String {
        let before = self.velvet.said().len();
        self.velvet.type_in(line);
        self.hear_until("ok\n", 5 * SECOND);
        self.velvet.said()[before..].to_owned()
    }

    /// Connects to a port of the board's.
    #[track_caller]
    fn connect(&mut self, port: u16) -> Connection {
        let connection = self.peer.connect(port).expect("an address");
        let end = self.velvet.now_ms() + 5 * SECOND;
        while !self.peer.is_connected(connection) {
            assert!(self.velvet.now_ms() < end, "port {port} does not answer");
            self.run(1);
        }
        connection
    }

    /// Waits for these words on a connection. Returns all words of that time.
    #[track_caller]
    fn expect(&mut self, connection: Connection, words: &str, patience_ms: u64) -> String {
        let (mut heard, end) = (String::new(), self.velvet.now_ms() + patience_ms);
        while !heard.contains(words) {
            assert!(self.velvet.now_ms() < end, "no {words:?} within {patience_ms} ms; it said: {heard}");
            self.run(1);
            heard += &String::from_utf8_lossy(&self.peer.receive(connection));
        }
        heard
    }

    /// Sends a line and waits for these words.
    #[track_caller]
    fn say(&mut self, connection: Connection, line: &str, words: &str) -> String {
        self.send(connection, format!("{line}\n").as_bytes());
        self.expect(connection, words, 5 * SECOND)
    }

    #[track_caller]
    fn send(&mut self, connection: Connection, bytes: &[u8]) {
        assert_eq!(self.peer.send(connection, bytes), bytes.len(), "the computer's own buffer is full");
    }
}
