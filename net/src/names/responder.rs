//! Responder of mDNS: makes sure that the name is the board's alone, announces it, and answers for it.

use core::net::Ipv4Addr;

use smoltcp::socket::udp::{RecvError, Socket, UdpMetadata};
use smoltcp::time::{Duration, Instant};
use smoltcp::wire::{IpAddress, IpEndpoint, Ipv4Cidr};

use super::message::{ANY, IN, Message, Part, Question, Record, Section, TOP, Writer};
use super::records::{Life, Own, Records, Set};
use crate::news::{Inform, News};
use crate::random::Random;
use crate::settings::{HostName, Settings};

/// Group and port of mDNS.
pub const MDNS_ADDRESS: Ipv4Addr = Ipv4Addr::new(224, 0, 0, 251);
/// Port of mDNS.
pub const MDNS_PORT: u16 = 5353;

/// Datagrams that are read in a turn.
const READS: usize = 2;
/// Longest message that is sent.
const MOST_BYTES: usize = 900;
/// Probes of a name, and the time between them (RFC 6762 section 8.1).
const PROBES: u8 = 3;
const PROBE_EVERY: Duration = Duration::from_millis(250);
/// Announcements of a name, and the time between them (section 8.3).
const ANNOUNCEMENTS: u8 = 2;
const ANNOUNCE_EVERY: Duration = Duration::from_secs(1);
/// Time to wait when another machine that wants the name comes first (section 8.2).
const LOST_TIE: Duration = Duration::from_secs(1);
/// Conflicts after which a name is tried slowly, and how slowly (section 8.1).
const CONFLICTS: u32 = 15;
const SLOWLY: Duration = Duration::from_secs(5);
/// Time in which a record is sent to all only once (section 6).
const ONCE_IN: Duration = Duration::from_secs(1);
/// Time after which what cannot be sent is dropped.
const STUCK: Duration = Duration::from_secs(2);
/// Flags of an answer.
const ANSWER: u16 = 0x8400;

/// State of the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// There is no address to speak from.
    Off,
    /// So many probes are still to be sent.
    Probing(u8),
    /// The name is the board's; so many announcements are still to be made.
    Announcing(u8),
    Settled,
}

/// What the responder works with.
pub struct Means<'a> {
    pub random: &'a mut Random,
    pub news: &'a mut Inform,
    pub scratch: &'a mut [u8],
}

/// The responder.
#[derive(Debug)]
pub struct Responder {
    base: HostName,
    /// Number behind the name, 0 and 1 for none.
    number: u32,
    records: Records,
    network: Option<Ipv4Cidr>,
    stage: Stage,
    /// Time of the next probe or announcement.
    next: Instant,
    /// Records that all are to be told, and when.
    pending: Set,
    due: Instant,
    /// Time at which each record was sent to all.
    told: [Option<Instant>; Own::ALL.len()],
    is_leaving: bool,
    /// Time since which something waits to be sent.
    waits: Option<Instant>,
}

/// Binds the socket, and drops what waits in it.
pub fn bind(socket: &mut Socket<'static>) {
    socket.close();
    let _is_closed = socket.bind(MDNS_PORT);
    // Answers that crossed a router would have less (section 11).
    socket.set_hop_limit(Some(255));
}

impl Responder {
    /// Makes a responder that is silent until there is an address.
    pub fn new(settings: &Settings) -> Self {
        let records = Records {
            host: settings.host.clone(),
            address: Ipv4Addr::UNSPECIFIED,
            telnet: settings.telnet,
            grbl: settings.grbl,
        };
        Self {
            base: settings.host.clone(),
            number: 1,
            records,
            network: None,
            stage: Stage::Off,
            next: Instant::ZERO,
            pending: Set::NONE,
            due: Instant::ZERO,
            told: [None; Own::ALL.len()],
            is_leaving: false,
            waits: None,
        }
    }

    /// Returns the name, without `.local`.
    pub fn name(&self) -> &str {
        self.records.host.as_str()
    }

    /// Returns whether the name is the board's.
    pub const fn is_named(&self) -> bool {
        matches!(self.stage, Stage::Announcing(_) | Stage::Settled)
    }

    /// Begins anew with another address, or ends.
    pub fn set_address(&mut self, network: Option<Ipv4Cidr>, now: Instant, random: &mut Random) {
        self.network = network;
        self.told = [None; Own::ALL.len()];
        self.pending = Set::NONE;
        match network {
            None => self.stage = Stage::Off,
            Some(network) => {
                self.records.address = network.address();
                self.stage = Stage::Probing(PROBES);
                self.next = now + Duration::from_millis(u64::from(random.below(250)));
            }
        }
    }

    /// Has all be told that the board goes.
    pub fn leave(&mut self) {
        self.is_leaving = self.is_named();
    }

    /// Reads what has come, and sends what is due.
    pub fn run(&mut self, socket: &mut Socket<'static>, means: &mut Means<'_>, now: Instant) {
        self.unstick(socket, now);
        for _ in 0..READS {
            if !self.read(socket, means, now) {
                break;
            }
        }
        if self.stage == Stage::Off || socket.send_queue() > 0 {
            return;
        }
        if core::mem::take(&mut self.is_leaving) {
            self.tell_all(Set::ANNOUNCED, Life::Over, socket, now);
        } else if now >= self.next && !matches!(self.stage, Stage::Settled | Stage::Off) {
            self.go_on(socket, means.news, now);
        } else if !self.pending.is_empty() && now >= self.due {
            let pending = core::mem::take(&mut self.pending);
            self.tell_all(self.not_told(pending, now), Life::Usual, socket, now);
        }
    }

    /// Drops what cannot be sent, so that it does not hold up the rest.
    fn unstick(&mut self, socket: &mut Socket<'static>, now: Instant) {
        if socket.send_queue() == 0 {
            self.waits = None;
        } else if now >= *self.waits.get_or_insert(now) + STUCK {
            bind(socket);
            self.waits = None;
        }
    }

    /// Reads a datagram. False if there is none.
    fn read(&mut self, socket: &mut Socket<'static>, means: &mut Means<'_>, now: Instant) -> bool {
        let Means { random, news, scratch } = means;
        let (bytes, from) = match socket.recv_slice(scratch) {
            Ok((length, from)) => (scratch.get(..length).unwrap_or_default(), from),
            Err(RecvError::Truncated) => return true,
            Err(RecvError::Exhausted) => return false,
        };
        let IpAddress::Ipv4(address) = from.endpoint.addr;
        let is_near = self.network.is_some_and(|network| network.contains_addr(&address));
        let Some(message) = Message::new(bytes).filter(|message| is_near && message.is_plain()) else { return true };
        if message.is_response() {
            if from.endpoint.port == MDNS_PORT && self.is_contradicted(message) {
                self.defend_name(news, random, now);
            }
            return true;
        }
        if let Stage::Probing(_) = self.stage {
            if self.loses_tie(message) {
                (self.stage, self.next) = (Stage::Probing(PROBES), now + LOST_TIE);
            }
            return true;
        }
        if self.stage == Stage::Off {
            return true;
        }
        let is_legacy = from.endpoint.port != MDNS_PORT;
        let asked = self.asked(message, is_legacy);
        if !asked.to_all.is_empty() {
            self.promise(asked.to_all, message, random, now);
        }
        if !asked.alone.is_empty() {
            let question = message.questions().next().filter(|_| is_legacy);
            let id = if is_legacy { message.id() } else { 0 };
            let life = if is_legacy { Life::Legacy } else { Life::Usual };
            let (mut answer, records) = ([0; MOST_BYTES], &self.records);
            let length = compose(records, asked.alone, id, question, life, &mut answer);
            send(socket, from.endpoint, answer.get(..length).unwrap_or_default());
        }
        true
    }

    /// Returns what a question is for, without what the asker knows already (section 7.1).
    fn asked(&mut self, message: Message<'_>, is_legacy: bool) -> Asked {
        let mut asked = Asked { alone: Set::NONE, to_all: Set::NONE };
        for question in message.questions() {
            if !matches!(question.class & !TOP, IN | ANY) {
                continue;
            }
            let set = self.records.asked(question.name, question.kind);
            let part = if is_legacy || question.class & TOP != 0 { &mut asked.alone } else { &mut asked.to_all };
            *part = part.with(set);
        }
        let continues = message.questions().next().is_none();
        for record in message.records().filter(|record| record.section == Section::Answer) {
            if let Some((own, true)) = self.records.compare(&record)
                && record.ttl >= Records::ttl(own) / 2
            {
                asked.alone.remove(own);
                asked.to_all.remove(own);
                if continues {
                    self.pending.remove(own);
                }
            }
        }
        asked
    }

    /// Has records told to all: at once if nobody else has them, else after a random time (section 6).
    fn promise(&mut self, set: Set, message: Message<'_>, random: &mut Random, now: Instant) {
        let is_shared = Own::ALL.into_iter().any(|own| set.has(own) && !Records::is_unique(own));
        let delay = match (message.is_cut(), is_shared) {
            (true, _) => 400 + random.below(100),
            (false, true) => 20 + random.below(100),
            (false, false) => 0,
        };
        let due = now + Duration::from_millis(u64::from(delay));
        self.due = if self.pending.is_empty() { due } else { self.due.min(due) };
        self.pending = self.pending.with(set);
    }

    fn not_told(&self, mut set: Set, now: Instant) -> Set {
        for (own, told) in Own::ALL.into_iter().zip(self.told) {
            if told.is_some_and(|at| now < at + ONCE_IN) {
                set.remove(own);
            }
        }
        set
    }

    /// Returns whether another machine says something else of what is the board's alone.
    fn is_contradicted(&self, message: Message<'_>) -> bool {
        let is_probing = matches!(self.stage, Stage::Probing(_));
        let contradicts = |record: &Record<'_>| match self.records.compare(record) {
            Some((own, same)) => !same && matches!(own, Own::Host | Own::Port),
            None => is_probing && self.records.is_own(record),
        };
        self.stage != Stage::Off && message.records().any(|record| record.ttl > 0 && contradicts(&record))
    }

    /// Returns whether another machine that wants the name now has the better claim (section 8.2).
    fn loses_tie(&self, message: Message<'_>) -> bool {
        let theirs = message.records().filter(|record| record.section == Section::Authority);
        let first =
            theirs.filter(|record| self.records.is_host(record.name)).map(|record| (record.kind, record.data)).min();
        first.is_some_and(|first| first > (super::message::A, &self.records.address.octets()[..]))
    }

    /// Makes sure of the name once more; while it is being made sure of, tries another.
    fn defend_name(&mut self, news: &mut Inform, random: &mut Random, now: Instant) {
        if let Stage::Probing(_) = self.stage {
            news.tell(News::NameTaken(self.records.host.clone()));
            self.number = self.number.saturating_add(1);
            self.records.host = self.base.numbered(self.number);
        }
        self.stage = Stage::Probing(PROBES);
        self.pending = Set::NONE;
        let delay = Duration::from_millis(u64::from(random.below(250)));
        self.next = now + if self.number > CONFLICTS { SLOWLY } else { delay };
    }

    /// Sends the next probe or announcement.
    fn go_on(&mut self, socket: &mut Socket<'static>, news: &mut Inform, now: Instant) {
        match self.stage {
            Stage::Probing(0) => {
                news.tell(News::Named(self.records.host.clone()));
                self.stage = Stage::Announcing(ANNOUNCEMENTS);
            }
            Stage::Probing(left) => {
                let mut probe = [0; MOST_BYTES];
                let length = Writer::new(&mut probe, 0, 0).map_or(0, |mut writer| {
                    self.records.write_probe(&mut writer);
                    writer.len()
                });
                send(socket, everybody(), probe.get(..length).unwrap_or_default());
                (self.stage, self.next) = (Stage::Probing(left - 1), now + PROBE_EVERY);
            }
            Stage::Announcing(left) => {
                self.tell_all(Set::ANNOUNCED, Life::Usual, socket, now);
                self.stage = if left > 1 { Stage::Announcing(left - 1) } else { Stage::Settled };
                self.next = now + ANNOUNCE_EVERY;
            }
            Stage::Settled | Stage::Off => {}
        }
    }

    /// Sends records to all.
    fn tell_all(&mut self, set: Set, life: Life, socket: &mut Socket<'static>, now: Instant) {
        if set.is_empty() {
            return;
        }
        for (own, told) in Own::ALL.into_iter().zip(&mut self.told) {
            if set.has(own) {
                *told = Some(now);
            }
        }
        let mut answer = [0; MOST_BYTES];
        let length = compose(&self.records, set, 0, None, life, &mut answer);
        send(socket, everybody(), answer.get(..length).unwrap_or_default());
    }
}

/// Records that a message asks for.
struct Asked {
    /// To be told to the asker alone.
    alone: Set,
    to_all: Set,
}

fn everybody() -> IpEndpoint {
    IpEndpoint::new(IpAddress::Ipv4(MDNS_ADDRESS), MDNS_PORT)
}

/// Sends a message; what has no room is lost, as anything may be.
fn send(socket: &mut Socket<'static>, to: IpEndpoint, message: &[u8]) {
    let _has_room = socket.send_slice(message, UdpMetadata::from(to));
}

/// Writes an answer. Returns its length.
fn compose(records: &Records, set: Set, id: u16, question: Option<Question<'_>>, life: Life, into: &mut [u8]) -> usize {
    let Some(mut writer) = Writer::new(into, id, ANSWER) else { return 0 };
    if let Some(Question { name, kind, class }) = question {
        writer.add(Part::Questions, |writer| {
            writer.copy(name)?;
            writer.word(kind)?;
            writer.word(class)
        });
    }
    records.write_set(set, Part::Answers, life, &mut writer);
    records.write_set(records.beside(set), Part::Additionals, life, &mut writer);
    writer.len()
}
