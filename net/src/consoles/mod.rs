//! Consoles over TCP: who listens at which port, who sits where, and who is turned away.

mod ahead;
mod door;
mod login;
mod seat;
mod telnet;

use smoltcp::iface::{SocketHandle, SocketSet};
use smoltcp::socket::tcp::{Socket, State};
use smoltcp::time::{Duration, Instant};

use crate::line::{Line, Visitor};
use crate::settings::{LINES, Service, Settings, service_of};
use crate::wire::Peer;
use door::Door;
pub use seat::Means;
use seat::Seat;

/// Time after which a connection that is not yet one makes room for another.
const HALF_OPEN: Duration = Duration::from_millis(200);
/// Time without a sign of life after which a peer is given up.
const TIMEOUT: Duration = Duration::from_secs(20);

const SERVICES: usize = Service::ALL.len();

/// All seats and doors.
#[derive(Debug)]
pub struct Consoles {
    seats: [Seat; LINES],
    doors: [Door; SERVICES],
    ports: [Option<u16>; SERVICES],
    /// Time since which the socket of each seat has been half open.
    half_open: [Option<Instant>; LINES],
}

/// Sets a socket up for a console.
pub fn prepare(socket: &mut Socket<'static>) {
    socket.set_timeout(Some(TIMEOUT));
    // Answers are short, and senders wait for each of them.
    socket.set_nagle_enabled(false);
}

impl Consoles {
    /// Makes the consoles, with a socket for each line and each door.
    pub fn new(settings: &Settings, lines: [SocketHandle; LINES], doors: [SocketHandle; SERVICES]) -> Self {
        let mut line = 0;
        let seats = lines.map(|handle| {
            line += 1;
            Seat::new(handle, line - 1, service_of(line - 1))
        });
        let ports = Service::ALL.map(|service| settings.port(service).filter(|port| *port != 0));
        Self { seats, doors: doors.map(Door::new), ports, half_open: [None; LINES] }
    }

    /// Returns who sits where.
    pub fn visitors(&self) -> [Option<Visitor>; LINES] {
        self.seats.each_ref().map(Seat::visitor)
    }

    /// Returns the connections as they are seen from the wire.
    pub fn peers(&self, sockets: &SocketSet<'static>) -> [Option<Peer>; LINES] {
        self.seats.each_ref().map(|seat| seat.peer(sockets.get(seat.handle())))
    }

    /// Ends all connections.
    pub fn abort<L: Line>(&mut self, sockets: &mut SocketSet<'static>, lines: &mut [L; LINES], means: &mut Means<'_>) {
        for (seat, line) in self.seats.iter_mut().zip(lines) {
            seat.abort(sockets.get_mut(seat.handle()), line, means);
        }
        for door in &self.doors {
            sockets.get_mut::<Socket>(door.handle()).abort();
        }
    }

    /// Serves every visitor.
    pub fn run<L: Line>(&mut self, sockets: &mut SocketSet<'static>, lines: &mut [L; LINES], means: &mut Means<'_>) {
        means.scarce = Service::ALL.map(|service| {
            let mut seats = self.seats.iter().filter(|seat| seat.service() == service);
            !seats.any(|seat| sockets.get::<Socket>(seat.handle()).is_listening())
        });
        for (seat, line) in self.seats.iter_mut().zip(lines) {
            seat.run(sockets.get_mut(seat.handle()), line, means);
        }
    }

    /// Has sockets listen for the next visitors. Returns the ports at which none does.
    pub fn listen(&mut self, sockets: &mut SocketSet<'static>, now: Instant) -> [Option<u16>; SERVICES] {
        let mut waiting = [None; SERVICES];
        let services = Service::ALL.into_iter().zip(&mut self.doors).zip(self.ports).zip(&mut waiting);
        for (((service, door), port), waiting) in services {
            let Some(port) = port else { continue };
            let (mut is_full, mut listens) = (true, false);
            let mut oldest: Option<(Instant, usize)> = None;
            for (index, seat) in self.seats.iter().enumerate().filter(|(_, seat)| seat.service() == service) {
                let socket = sockets.get_mut::<Socket>(seat.handle());
                if socket.state() == State::Closed && !seat.is_taken() {
                    let _listens = socket.listen(port);
                }
                let state = socket.state();
                listens |= state == State::Listen;
                is_full &= seat.is_taken() || !matches!(state, State::Listen | State::SynReceived);
                let Some(since) = self.half_open.get_mut(index) else { continue };
                if state == State::SynReceived {
                    let since = *since.get_or_insert(now);
                    oldest = [oldest, Some((since, index))].into_iter().flatten().min();
                } else {
                    *since = None;
                }
            }
            door.run(sockets.get_mut(door.handle()), port, is_full, now);
            listens |= sockets.get::<Socket>(door.handle()).is_listening();
            let overdue = oldest.filter(|(since, _)| !listens && now >= *since + HALF_OPEN);
            if let Some(seat) = overdue.and_then(|(_, index)| self.seats.get(index)) {
                let socket = sockets.get_mut::<Socket>(seat.handle());
                socket.abort();
                listens = socket.listen(port).is_ok();
            }
            *waiting = Some(port).filter(|_| !listens);
        }
        waiting
    }

    /// Takes bytes for the visitor of a line. Returns how many.
    pub fn write(&mut self, sockets: &mut SocketSet<'static>, line: usize, bytes: &[u8]) -> usize {
        match self.seats.get_mut(line) {
            Some(seat) => seat.write(sockets.get_mut(seat.handle()), bytes),
            None => bytes.len(),
        }
    }
}
