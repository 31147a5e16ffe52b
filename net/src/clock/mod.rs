//! The time: which server tells it, when it is asked, what is believed.

mod lookup;
mod sntp;

use core::net::Ipv4Addr;

use smoltcp::socket::udp::{RecvError, Socket, UdpMetadata};
use smoltcp::time::{Duration, Instant};
use smoltcp::wire::{IpAddress, IpEndpoint};

use crate::names::{MDNS_ADDRESS, MDNS_PORT};
use crate::news::{Inform, News};
use crate::random::Random;
use crate::settings::{SERVER_BYTES, TimeServer};
use lookup::Answer;
use sntp::Reply;

/// Port of name servers, and of time servers.
const DNS_PORT: u16 = 53;
const NTP_PORT: u16 = 123;
/// Time that an answer may take.
const PATIENCE: Duration = Duration::from_secs(3);
/// Questions to name servers before giving up.
const LOOKUPS: u8 = 4;
/// Questions to a time server before its name is looked up anew.
const TRIES: u8 = 3;
/// Time between two times.
const EVERY: Duration = Duration::from_secs(3_600);
/// Time after the first failure, which doubles with each.
const PAUSE: Duration = Duration::from_secs(15);
/// Doublings that make the greatest pause: 64 minutes.
const DOUBLINGS: u32 = 8;
/// First port that requests go out of.
const FIRST_PORT: u16 = 49_152;
/// Longest message that is sent: a name server's question.
const MOST_BYTES: usize = 12 + SERVER_BYTES + 2 + 4;

/// What the clock is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Resting,
    /// Asking name servers; so many questions were sent.
    Looking(u8),
    /// Asking the time server; so many questions were sent.
    Asking(u8),
}

/// The clock's part on the network.
#[derive(Debug)]
pub struct Clock {
    server: Option<TimeServer>,
    address: Option<Ipv4Addr>,
    stage: Stage,
    /// Time at which the stage is over, or has lasted too long.
    until: Instant,
    /// Number that the answer must bear.
    nonce: u64,
    asked: Instant,
    failures: u32,
    /// Time of the last answer.
    told: Option<Instant>,
}

impl Clock {
    /// Makes the clock; it does nothing without a server.
    pub const fn new(server: Option<TimeServer>) -> Self {
        Self {
            server,
            address: None,
            stage: Stage::Resting,
            until: Instant::ZERO,
            nonce: 0,
            asked: Instant::ZERO,
            failures: 0,
            told: None,
        }
    }

    /// Begins anew on another network.
    pub fn restart(&mut self, now: Instant) {
        (self.stage, self.until) = (Stage::Resting, now);
        (self.address, self.failures) = (None, 0);
    }

    /// Returns the server's address, and when it answered last.
    pub fn state(&self) -> (Option<Ipv4Addr>, Option<Instant>) {
        (self.address, self.told)
    }

    /// Reads what has come, and asks what is to be asked.
    pub fn run(
        &mut self,
        socket: &mut Socket<'static>,
        dns: [Option<Ipv4Addr>; 2],
        random: &mut Random,
        news: &mut Inform,
        now: Instant,
    ) {
        if self.server.is_none() {
            return;
        }
        self.read(socket, news, now);
        if now < self.until {
            return;
        }
        match self.stage {
            Stage::Resting if self.address.is_some() => self.ask(0, socket, random, now),
            Stage::Resting => self.begin(dns, socket, random, news, now),
            Stage::Looking(asked) if asked < LOOKUPS => self.look(asked, dns, socket, random, news, now),
            Stage::Asking(asked) if asked < TRIES => self.ask(asked, socket, random, now),
            Stage::Looking(_) | Stage::Asking(_) => self.fail(0, news, now),
        }
    }

    fn begin(
        &mut self,
        dns: [Option<Ipv4Addr>; 2],
        socket: &mut Socket<'static>,
        random: &mut Random,
        news: &mut Inform,
        now: Instant,
    ) {
        match &self.server {
            Some(TimeServer::Address(address)) => {
                self.address = Some(*address);
                self.ask(0, socket, random, now);
            }
            Some(TimeServer::Name(_)) => self.look(0, dns, socket, random, news, now),
            None => {}
        }
    }

    /// Asks a name server for the time server's address.
    fn look(
        &mut self,
        asked: u8,
        dns: [Option<Ipv4Addr>; 2],
        socket: &mut Socket<'static>,
        random: &mut Random,
        news: &mut Inform,
        now: Instant,
    ) {
        let Some(TimeServer::Name(name)) = &self.server else { return };
        let [first, second] = dns;
        let server = if asked.is_multiple_of(2) { first.or(second) } else { second.or(first) };
        let to =
            if name.ends_with(".local") { Some((MDNS_ADDRESS, MDNS_PORT)) } else { server.map(|to| (to, DNS_PORT)) };
        let Some(to) = to else {
            self.fail(0, news, now);
            return;
        };
        self.nonce = random.next();
        let mut question = [0; MOST_BYTES];
        let length = lookup::write(self.nonce as u16, name, &mut question).unwrap_or(0);
        send(socket, to, question.get(..length).unwrap_or_default(), random);
        (self.stage, self.until, self.asked) = (Stage::Looking(asked + 1), now + PATIENCE, now);
    }

    /// Asks the time server.
    fn ask(&mut self, asked: u8, socket: &mut Socket<'static>, random: &mut Random, now: Instant) {
        let Some(address) = self.address else { return };
        self.nonce = random.next();
        send(socket, (address, NTP_PORT), &sntp::request(self.nonce), random);
        (self.stage, self.until, self.asked) = (Stage::Asking(asked + 1), now + PATIENCE, now);
    }

    /// Rests after a failure: the longer, the more there were, and at least so many doublings.
    fn fail(&mut self, least: u32, news: &mut Inform, now: Instant) {
        if self.failures == 0 {
            news.tell(News::NoTime);
        }
        self.failures = self.failures.saturating_add(1);
        let doublings = (self.failures - 1).max(least).min(DOUBLINGS);
        (self.stage, self.until) = (Stage::Resting, now + PAUSE * (1 << doublings));
        // The name may stand for another server by then.
        self.address = None;
    }

    /// Reads a datagram, if there is one.
    fn read(&mut self, socket: &mut Socket<'static>, news: &mut Inform, now: Instant) {
        let (bytes, from) = match socket.recv() {
            Ok(datagram) => datagram,
            Err(RecvError::Exhausted | RecvError::Truncated) => return,
        };
        let IpAddress::Ipv4(address) = from.endpoint.addr;
        match (self.stage, &self.server) {
            (Stage::Looking(_), Some(TimeServer::Name(name))) => {
                match lookup::read(self.nonce as u16, name, bytes) {
                    Answer::Address(address) => {
                        self.address = Some(address);
                        (self.stage, self.until) = (Stage::Resting, now);
                    }
                    // The next server may know it.
                    Answer::Unknown => self.until = now,
                    Answer::Foreign => {}
                }
            }
            (Stage::Asking(_), _) if self.address == Some(address) && from.endpoint.port == NTP_PORT => {
                match sntp::read(self.nonce, bytes) {
                    Reply::Time(unix_ms) => {
                        let way = (now - self.asked).total_millis() / 2;
                        news.tell(News::Time { unix_ms: unix_ms + way });
                        (self.stage, self.until) = (Stage::Resting, now + EVERY);
                        (self.failures, self.told) = (0, Some(now));
                    }
                    Reply::Refused => self.fail(DOUBLINGS, news, now),
                    Reply::Foreign => {}
                }
            }
            _ => {}
        }
    }
}

/// Sends a request out of a port of its own; what waited in the socket is dropped.
fn send(socket: &mut Socket<'static>, to: (Ipv4Addr, u16), message: &[u8], random: &mut Random) {
    socket.close();
    let _is_closed = socket.bind(FIRST_PORT + random.below(16_000) as u16);
    let to = IpEndpoint::new(IpAddress::Ipv4(to.0), to.1);
    let _has_room = socket.send_slice(message, UdpMetadata::from(to));
}
