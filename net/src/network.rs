//! The network as a whole.

use smoltcp::iface::{Config, Interface, PollIngressSingleResult, SocketHandle, SocketSet};
use smoltcp::phy::Device;
use smoltcp::socket::{dhcpv4, udp};
use smoltcp::time::{Duration, Instant};
use smoltcp::wire::{EthernetAddress, HardwareAddress};

use crate::address::{self, Keeper};
use crate::clock::Clock;
use crate::consoles::{self, Consoles};
use crate::line::Line;
use crate::memory::{Memory, SCRATCH_BYTES};
use crate::names::{self, MDNS_ADDRESS, Responder};
use crate::news::{Inform, News};
use crate::password::{Gate, Record, SALT_BYTES};
use crate::random::Random;
use crate::report::{AddressReport, Report};
use crate::settings::{Addressing, LINES, Settings};
use crate::streams::{self, Places, Streams};
use crate::wire::{Filter, Tap};

/// Frames that a poll reads.
const FRAMES_IN: u32 = 4;
/// Frames that a poll sends, answers among them, and those of them that are not for answers.
const FRAMES_OUT: u32 = 4;
const OF_SOCKETS: u32 = 3;
/// Time between two polls while there are visitors, and else, in microseconds. Asking every part when it has
/// something to do takes more code than such polls take time.
const REST_VISITED: u64 = 10_000;
const REST: u64 = 50_000;

/// What peers are connected to.
pub struct Peers<'a, L, S> {
    /// Consoles, one for each visitor.
    pub lines: &'a mut [L; LINES],
    /// Server of web connections.
    pub streams: &'a mut S,
}

/// The board on a network.
pub struct Network {
    settings: Settings,
    interface: Interface,
    sockets: SocketSet<'static>,
    scratch: &'static mut [u8; SCRATCH_BYTES],
    filter: Filter,
    address: Keeper,
    /// Socket of mDNS, if it is answered.
    mdns: Option<SocketHandle>,
    responder: Responder,
    /// Socket that asks for names and time.
    asker: SocketHandle,
    clock: Clock,
    consoles: Consoles,
    places: Places,
    login: streams::Login,
    gate: Gate,
    news: Inform,
    random: Random,
    is_up: bool,
    is_busy: bool,
}

impl Network {
    /// Makes the network. `seed` must be another one at each start, `now` is in microseconds.
    pub fn new(memory: &'static mut Memory, settings: Settings, device: &mut impl Device, seed: u64, now: u64) -> Self {
        let mut mac = settings.mac;
        // A group's address is nobody's.
        mac[0] &= !1;
        let settings = Settings { mac, ..settings };
        let mut config = Config::new(HardwareAddress::Ethernet(EthernetAddress(mac)));
        let mut random = Random::new(seed);
        config.random_seed = random.next();
        let interface = Interface::new(config, device, instant(now));
        let parts = memory.parts(&settings.host);
        let mut sockets = SocketSet::new(parts.sockets);
        let has_fixed = matches!(settings.addressing, Addressing::Static(fixed) if fixed.prefix().is_some());
        let dhcp = (!has_fixed).then(|| {
            let mut socket = dhcpv4::Socket::new();
            socket.set_outgoing_options(parts.options);
            let mut retry = socket.get_retry_config();
            retry.discover_timeout = Duration::from_secs(3);
            retry.initial_request_timeout = Duration::from_secs(2);
            socket.set_retry_config(retry);
            sockets.add(socket)
        });
        let mdns = settings.mdns.then(|| {
            let mut socket = parts.mdns;
            names::bind(&mut socket);
            sockets.add(socket)
        });
        let asker = sockets.add(parts.asker);
        let mut add = |mut socket| {
            consoles::prepare(&mut socket);
            sockets.add(socket)
        };
        let lines = parts.lines.each_mut().map(|buffers| add(buffers.socket()));
        let doors = parts.doors.each_mut().map(|buffers| add(buffers.socket()));
        let streams = parts.streams.each_mut().map(|buffers| {
            let mut socket = buffers.socket();
            streams::prepare(&mut socket);
            sockets.add(socket)
        });
        Self {
            interface,
            scratch: parts.scratch,
            filter: Filter::new(),
            address: Keeper::new(&settings, dhcp),
            mdns,
            responder: Responder::new(&settings),
            asker,
            clock: Clock::new(settings.time_server.clone()),
            consoles: Consoles::new(&settings, lines, doors),
            places: Places::new(settings.web, streams),
            login: streams::Login::default(),
            gate: Gate::new(settings.password_required),
            news: Inform::new(),
            random,
            is_up: false,
            is_busy: false,
            sockets,
            settings,
        }
    }

    /// Does a bounded piece of work: reads at most four frames, sends at most four, serves every console and
    /// every web connection. `now` is in microseconds, `is_up` says that the cable carries.
    pub fn poll<D: Device>(
        &mut self,
        now: u64,
        is_up: bool,
        device: &mut D,
        peers: &mut Peers<'_, impl Line, impl Streams>,
    ) {
        let now = instant(now);
        let has_hashed = self.gate.run();
        if self.is_up != is_up {
            self.is_up = is_up;
            self.turn_link(peers, now);
        }
        if !is_up {
            self.is_busy = has_hashed;
            return;
        }
        let worked = self.exchange(device, peers, now);
        self.is_busy = worked || has_hashed;
    }

    /// Moves frames and bytes. Returns whether there was any.
    fn exchange<D: Device>(
        &mut self,
        device: &mut D,
        peers: &mut Peers<'_, impl Line, impl Streams>,
        now: Instant,
    ) -> bool {
        let before = self.filter.counts();
        let has_changed = self.exchange_frames(device, now);
        if has_changed {
            self.change_address(peers, now);
        }
        self.run_names(now);
        let mut means = consoles::Means::new(now, &mut self.gate, &mut self.news, &mut self.scratch[..]);
        self.consoles.run(&mut self.sockets, peers.lines, &mut means);
        self.places.run(&mut self.sockets, peers.streams, &mut self.scratch[..], now);
        if let Some(from) = self.login.run(&mut self.gate, peers.streams, now) {
            self.news.tell(News::WrongPassword { from });
        }
        before != self.filter.counts()
    }

    /// Sends frames and reads some: first what keeps the address, then what sockets have, and answers in the
    /// end, so that no flood of questions holds up the rest. Returns whether the address is another.
    fn exchange_frames<D: Device>(&mut self, device: &mut D, now: Instant) -> bool {
        let mut tap = Tap::new(device, &mut self.filter, OF_SOCKETS);
        let mut means = address::Means {
            interface: &mut self.interface,
            sockets: &mut self.sockets,
            device: &mut tap,
            random: &mut self.random,
            news: &mut self.news,
        };
        let has_changed = self.address.run(&mut means, now);
        tap.filter().watch(self.consoles.peers(&self.sockets), now);
        if let Some(terms) = self.address.terms() {
            tap.probe(self.settings.mac, terms.address.address(), now);
        }
        self.interface.poll_maintenance(now);
        let _sent = self.interface.poll_egress(now, &mut tap, &mut self.sockets);
        tap.allow(tap.may_send() + FRAMES_OUT - OF_SOCKETS);
        for _ in 0..FRAMES_IN {
            let [telnet, grbl] = self.consoles.listen(&mut self.sockets, now);
            tap.filter().hold_off([telnet, grbl, self.places.listen(&mut self.sockets, now)]);
            let heard = self.interface.poll_ingress_single(now, &mut tap, &mut self.sockets);
            if heard == PollIngressSingleResult::None {
                break;
            }
        }
        has_changed
    }

    /// Answers for the name, and asks for the time.
    fn run_names(&mut self, now: Instant) {
        let Some(terms) = self.address.terms() else { return };
        let dns = terms.dns;
        if let Some(handle) = self.mdns {
            let mut means =
                names::Means { random: &mut self.random, news: &mut self.news, scratch: &mut self.scratch[..] };
            self.responder.run(self.sockets.get_mut(handle), &mut means, now);
        }
        let socket = self.sockets.get_mut::<udp::Socket>(self.asker);
        self.clock.run(socket, dns, &mut self.random, &mut self.news, now);
    }

    /// The board has another address, or none.
    fn change_address(&mut self, peers: &mut Peers<'_, impl Line, impl Streams>, now: Instant) {
        self.abort(peers, now);
        let address = self.address.terms().map(|terms| terms.address);
        self.clock.restart(now);
        let Some(handle) = self.mdns else { return };
        names::bind(self.sockets.get_mut(handle));
        self.responder.set_address(address, now, &mut self.random);
        let _was_there = self.interface.leave_multicast_group(MDNS_ADDRESS);
        if address.is_some() {
            let _has_room = self.interface.join_multicast_group(MDNS_ADDRESS);
        }
    }

    /// The cable carries again, or no longer.
    fn turn_link(&mut self, peers: &mut Peers<'_, impl Line, impl Streams>, now: Instant) {
        self.filter.forget();
        if self.is_up {
            self.address.link_up(&mut self.sockets, now);
        } else {
            self.address.link_down(&mut self.interface, &mut self.news);
            self.change_address(peers, now);
        }
    }

    /// Ends all connections.
    fn abort(&mut self, peers: &mut Peers<'_, impl Line, impl Streams>, now: Instant) {
        let mut means = consoles::Means::new(now, &mut self.gate, &mut self.news, &mut self.scratch[..]);
        self.consoles.abort(&mut self.sockets, peers.lines, &mut means);
        self.places.abort(&mut self.sockets, peers.streams);
    }

    /// Takes bytes for the visitor of a line. Returns how many: as many as have room, all if nobody listens.
    pub fn write(&mut self, line: usize, bytes: &[u8]) -> usize {
        let count = self.consoles.write(&mut self.sockets, line, bytes);
        self.is_busy |= count > 0;
        count
    }

    /// Returns the time until the next poll, in microseconds. Earlier, if a frame comes, a line has more room
    /// than it had, or something was written.
    #[must_use]
    pub fn next_in(&self) -> u64 {
        let is_visited = self.consoles.visitors().iter().any(Option::is_some) || self.places.peers() > 0;
        match (self.is_busy || self.gate.is_busy(), is_visited) {
            (true, _) => 0,
            (false, true) => REST_VISITED,
            (false, false) => REST,
        }
    }

    /// Has others be told that the board goes, as it is about to start anew. The next polls do it.
    pub fn leave(&mut self) {
        self.responder.leave();
    }

    /// Takes the next event, if there is one. The oldest are dropped where nobody takes them.
    pub fn take_news(&mut self) -> Option<News> {
        self.news.take()
    }

    /// Returns the state of everything.
    #[must_use]
    pub fn report(&self) -> Report<'_> {
        let address = self.address.terms().map(|terms| AddressReport {
            address: terms.address.address(),
            prefix: terms.address.prefix_len(),
            origin: terms.origin,
            gateway: terms.gateway,
            dns: terms.dns,
            server: terms.server,
        });
        Report {
            is_up: self.is_up,
            mac: self.settings.mac,
            name: self.responder.name(),
            is_named: self.responder.is_named(),
            address,
            candidate: self.address.candidate(),
            visitors: self.consoles.visitors(),
            web_peers: self.places.peers(),
            time_server: self.clock.state().0,
            time_at: self.clock.state().1.map(|at| at.total_micros().unsigned_abs()),
            counts: self.filter.counts(),
        }
    }

    /// Sets the record of the password, or that there is none.
    pub fn set_password_record(&mut self, record: Option<Record>) {
        self.gate.set_record(record);
    }

    /// Returns the record of the password, if there is one. Its text is what is kept.
    #[must_use]
    pub const fn password_record(&self) -> Option<&Record> {
        self.gate.record()
    }

    /// Returns whether a word is still on its way to be the password.
    #[must_use]
    pub const fn is_setting_password(&self) -> bool {
        self.gate.is_setting()
    }

    /// Begins to make a word the password, see [`Self::is_setting_password`]. `salt` must not be told by
    /// anything that was before. False if the word is empty or longer than 64 bytes.
    pub fn set_password(&mut self, word: &[u8], salt: [u8; SALT_BYTES]) -> bool {
        self.gate.set(word, salt)
    }
}

/// Returns the stack's time of one in microseconds.
fn instant(now: u64) -> Instant {
    Instant::from_micros(i64::try_from(now).unwrap_or(i64::MAX))
}
