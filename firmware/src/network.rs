//! The network for the machine: Ethernet, the stack over it, and the consoles that visitors are connected to.
//!
//! All of it belongs to the executor, which polls it while it rests: frames are never a reason for a late
//! step. The interrupt only says that there is something to do.

use core::cell::Cell;
use core::fmt::Write as _;
use core::mem::MaybeUninit;
use core::ops::Range;
use core::sync::atomic::{AtomicBool, Ordering};

use base::ports::{
    AddressOrigin, KeysRecord, NetworkAddress, NetworkLink, NetworkNews, NetworkReport, NetworkService, NetworkTraffic,
    PasswordRecord, Storage,
};
use base::sessions::{Intake, Rights};
use bsp_prime::ethernet::{Duplex, Ethernet, EthernetError, Link, LinkMode, Parts, Speed};
use bsp_prime::random::RandomWords;
use bsp_prime::time;
use config::{Address, LinkSpeed, NetworkConfig};
use net::{
    Addressing, HostName, LINES, Line, Memory, News, Origin, Peers, Role, STREAMS, Service, Settings, StaticAddress,
    TimeServer, Visitor,
};
use site::Site;
use units::Micros;

use crate::consoles::Console;
use crate::executor;
use crate::page::{Page, Served};

/// Longest time between two looks at the link and at the stack's timers.
const LOOK_EVERY: Micros = Micros::from_millis(10);
/// The same while the link is being made: each look moves the transceiver's registers on.
const LOOK_OFTEN: Micros = Micros::from_millis(1);
/// The same while frames are left, which bring no event: a flood would else be looked at without end.
const LOOK_AT_LEFT: Micros = Micros(250);
/// Room of an inbox, bytes, below which its visitor's bytes may have to wait.
const SCARCE_ROOM: usize = 512;

/// Whether the controller has interrupted since the last look.
static HAS_EVENT: AtomicBool = AtomicBool::new(false);

/// Buffers of the connections, all zero as the section is.
#[unsafe(link_section = ".axisram")]
static mut MEMORY: Memory = Memory::new();

/// Place of the network in use.
#[unsafe(link_section = ".axisram")]
static mut PLACE: MaybeUninit<Joined> = MaybeUninit::uninit();

/// Notes that the controller has interrupted.
pub fn note_event() {
    HAS_EVENT.store(true, Ordering::Release);
}

/// Marks the consoles of the network as unused. Call before there are sessions.
pub fn begin() {
    (0..LINES as u8).for_each(|place| Console::Network(place).inbox().set_open(false));
    Console::Page.inbox().set_open(false);
}

/// Console of the machine at which a visitor sits.
struct NetworkLine {
    console: Console,
    intake: Intake,
    rights: Rights,
    /// Room of the inbox when the stack last asked.
    asked_room: Cell<usize>,
}

impl NetworkLine {
    fn new(place: usize) -> Self {
        let console = Console::Network(place as u8);
        Self { console, intake: Intake::new(), rights: Rights::Watch, asked_room: Cell::new(usize::MAX) }
    }

    /// Whether bytes that wait for room may have some now.
    fn has_new_room(&self) -> bool {
        let asked = self.asked_room.get();
        asked < SCARCE_ROOM && self.console.inbox().room() > asked
    }
}

impl Line for NetworkLine {
    fn room(&self) -> usize {
        let room = self.console.inbox().room();
        self.asked_room.set(room);
        room
    }

    fn receive(&mut self, bytes: &[u8]) {
        // The inbox has room for the bytes.
        let _taken = self.console.inbox().receive_all(&mut self.intake, bytes);
        executor::wake_for_session();
    }

    fn look_ahead(&mut self, waiting: &[u8], looked: usize) -> Option<Range<usize>> {
        let acts = self.console.inbox().look_ahead(&mut self.intake, waiting, looked);
        executor::wake_for_session();
        acts
    }

    fn open(&mut self, visitor: Visitor) {
        self.rights = match visitor.role {
            Role::Operate => Rights::Operate,
            Role::Own => Rights::Own,
        };
        self.console.inbox().open(&mut self.intake);
        executor::wake_for_session();
    }

    fn close(&mut self) {
        self.console.inbox().set_open(false);
        self.asked_room.set(usize::MAX);
        executor::wake_for_session();
    }
}

/// Hardware that the network needs.
pub struct Hardware {
    pub ethernet: Parts,
    pub random: RandomWords,
    /// Address of the controller.
    pub mac: [u8; 6],
}

/// The network of the board: the hardware at rest, until the machine joins.
pub struct BoardNetwork {
    hardware: Option<Hardware>,
    joined: Option<&'static mut Joined>,
}

/// The network in use.
struct Joined {
    ethernet: Ethernet,
    stack: net::Network,
    lines: [NetworkLine; LINES],
    page: &'static mut Page,
    random: RandomWords,
    link: Option<Link>,
    /// Number of times that the link has come.
    links: u32,
    /// Time of the next look, if nothing happens before.
    due: Micros,
    services: heapless::Vec<(Service, u16), 2>,
    web_port: Option<u16>,
    has_mdns: bool,
    /// Name that the network was last told to know the machine by.
    name: HostName,
    /// Whether a new password's record is wanted.
    wants_record: bool,
    clock_set_at: Option<Micros>,
    /// Fault of the hardware that has been told.
    told: Option<EthernetError>,
}

impl BoardNetwork {
    /// Makes the network of hardware at rest.
    pub const fn new(hardware: Hardware) -> Self {
        Self { hardware: Some(hardware), joined: None }
    }

    /// Starts the hardware and the stack, as the configuration says.
    ///
    /// Never inlined: the network is on the stack before it is at its place.
    ///
    /// # Errors
    /// The hardware does not work.
    #[inline(never)]
    pub fn join(&mut self, config: &NetworkConfig) -> Result<(), &'static str> {
        let Some(Hardware { ethernet, mut random, mac }) = self.hardware.take() else { return Ok(()) };
        let mode = match config.link {
            LinkSpeed::Auto => LinkMode::Auto,
            LinkSpeed::Fast => LinkMode::Hundred,
            LinkSpeed::Slow => LinkMode::Ten,
        };
        let mut ethernet = Ethernet::start(ethernet, mac, mode).map_err(EthernetError::message)?;
        let now = time::now();
        let [low, high] = random.take();
        let seed = u64::from(high) << 32 | u64::from(low);
        let settings = settings(config, mac);
        let name = settings.host.clone();
        let services =
            Service::ALL.into_iter().filter_map(|service| Some((service, settings.port(service)?))).collect();
        let (memory, place) = (&raw mut MEMORY, &raw mut PLACE);
        let without = match (config.password_required, config.watch_without_password) {
            (false, _) => site::Role::Operate,
            (true, true) => site::Role::Watch,
            (true, false) => site::Role::Nobody,
        };
        // SAFETY: the hardware was taken, so this runs once.
        let page = unsafe { Page::make(name.as_str(), without, config.web) };
        // SAFETY: the hardware was taken, so this runs once, and nothing else names the two statics; they are
        // cleared at the start.
        let joined = unsafe {
            let stack = net::Network::new(&mut *memory, settings, &mut ethernet, seed, now.0);
            (*place).write(Joined {
                ethernet,
                stack,
                lines: core::array::from_fn(NetworkLine::new),
                page,
                random,
                link: None,
                links: 0,
                due: now,
                services,
                web_port: config.web.then_some(config.web_port),
                has_mdns: config.mdns,
                name,
                wants_record: false,
                clock_set_at: None,
                told: None,
            })
        };
        self.joined = Some(joined);
        Ok(())
    }

    /// Does a bounded piece of work, if there is some. Returns whether there is more at once.
    pub fn poll(&mut self, now: Micros, card: &mut impl Storage) -> bool {
        self.joined.as_mut().is_some_and(|joined| joined.poll(now, card))
    }

    /// Takes bytes for the visitor of a console: as many as fit, all if there is none.
    pub fn write(&mut self, place: u8, bytes: &[u8]) -> usize {
        let Some(joined) = self.joined.as_mut() else { return bytes.len() };
        joined.due = Micros(0);
        joined.stack.write(usize::from(place), bytes)
    }

    /// Has the network told that the machine goes, as it is about to start anew.
    pub fn leave(&mut self) {
        if let Some(joined) = self.joined.as_mut() {
            joined.stack.leave();
            joined.due = Micros(0);
        }
    }

    /// Returns the rights of a console's visitor.
    pub fn rights(&self, place: u8) -> Rights {
        let line = self.joined.as_ref().and_then(|joined| joined.lines.get(usize::from(place)));
        line.map_or(Rights::Watch, |line| line.rights)
    }

    /// Returns the rights of the page's console.
    pub fn page_rights(&self) -> Rights {
        self.joined.as_ref().map_or(Rights::Watch, |joined| joined.page.rights())
    }

    /// Tells the page's visitors what the machine says. Returns how many bytes were taken.
    pub fn tell_page(&mut self, bytes: &[u8]) -> usize {
        self.told_page().map_or(bytes.len(), |page| page.hear(bytes))
    }

    /// Returns the page, where the network is used, which has something new to tell: soon.
    pub fn told_page(&mut self) -> Option<&mut Page> {
        let joined = self.joined.as_mut()?;
        joined.due = Micros(0);
        Some(joined.page)
    }

    /// Returns the page's site, where the network is used.
    pub fn page(&mut self) -> Option<&mut Site<STREAMS>> {
        self.joined.as_mut().map(|joined| joined.page.site())
    }

    /// Returns whether a visitor of the page wants to see the machine as it is now.
    pub fn wants_snapshot(&self) -> bool {
        self.joined.as_ref().is_some_and(|joined| joined.page.wants_snapshot())
    }

    /// Returns whether the page has yet to be given the heights of the mesh of this number.
    pub fn wants_heights(&self, number: u32) -> bool {
        self.joined.as_ref().is_some_and(|joined| joined.page.wants_heights(number))
    }

    /// Returns the state of the network; none before it is used.
    pub fn report(&self) -> Option<NetworkReport> {
        self.joined.as_ref().map(|joined| joined.report())
    }

    /// Takes the next change.
    pub fn take_news(&mut self) -> Option<NetworkNews> {
        self.joined.as_mut()?.take_news()
    }

    /// Sets the record by which passwords are verified.
    ///
    /// # Errors
    /// The record is none.
    pub fn set_record(&mut self, record: Option<&[u8]>) -> Result<(), &'static str> {
        let record = match record {
            Some(text) => Some(net::Record::read(text).ok_or("this is no record of a password")?),
            None => None,
        };
        if let Some(joined) = self.joined.as_mut() {
            joined.stack.set_password_record(record);
            joined.page.change_password();
        }
        Ok(())
    }

    /// Takes the keys of programs that are to be kept.
    pub fn take_keys(&mut self) -> Option<KeysRecord> {
        self.joined.as_mut()?.page.take_keys()
    }

    /// Sets the keys of programs, by their record.
    pub fn set_keys(&mut self, record: &[u8]) {
        if let Some(joined) = self.joined.as_mut() {
            joined.page.set_keys(record);
        }
    }

    /// Tells the page's visitor whether a change of password or keys is kept.
    pub fn tell_kept(&mut self, kept: Result<(), &'static str>) {
        if let Some(joined) = self.joined.as_mut() {
            joined.page.tell_kept(kept);
            joined.due = Micros(0);
        }
    }

    /// Begins to make the record of a password. False when it cannot be one.
    pub fn begin_password(&mut self, password: &[u8]) -> bool {
        let Some(joined) = self.joined.as_mut() else { return false };
        let mut salt = [0; net::SALT_BYTES];
        let words: [u32; net::SALT_BYTES / 4] = joined.random.take();
        for (place, byte) in salt.iter_mut().zip(words.into_iter().flat_map(u32::to_le_bytes)) {
            *place = byte;
        }
        joined.due = Micros(0);
        joined.wants_record = joined.stack.set_password(password, salt);
        joined.wants_record
    }

    /// Takes the record of a new password when it is made.
    pub fn take_record(&mut self) -> Option<PasswordRecord> {
        let joined = self.joined.as_mut()?;
        let is_made = joined.wants_record && !joined.stack.is_setting_password();
        if !is_made && !joined.page.take_password() {
            return None;
        }
        joined.wants_record = false;
        let mut text = PasswordRecord::new();
        // A record fits.
        let _fits = write!(text, "{}", joined.stack.password_record()?);
        Some(text)
    }
}

impl Joined {
    fn poll(&mut self, now: Micros, card: &mut impl Storage) -> bool {
        let has_event = HAS_EVENT.load(Ordering::Relaxed) && HAS_EVENT.swap(false, Ordering::AcqRel);
        (has_event || now >= self.due || self.lines.iter().any(NetworkLine::has_new_room))
            && self.serve_network(now, card)
    }

    /// Looks at the link, carries frames both ways, and lets the stack's timers act. Returns whether there is
    /// more at once. The performance ledger counts its instructions by its name.
    #[inline(never)]
    fn serve_network(&mut self, now: Micros, card: &mut impl Storage) -> bool {
        let link = self.ethernet.supervise(now);
        self.links += u32::from(link.is_some() && self.link.is_none());
        self.link = link;
        let mut peers = Peers { lines: &mut self.lines, streams: &mut Served { page: self.page, card } };
        self.stack.poll(now.0, link.is_some(), &mut self.ethernet, &mut peers);
        self.page.serve(&mut self.stack, &mut self.random);
        let is_busy = self.page.run(card);
        let has_left = self.ethernet.has_work();
        let rest = if has_left { LOOK_AT_LEFT } else { link.map_or(LOOK_OFTEN, |_| LOOK_EVERY) };
        let next = self.stack.next_in();
        // Work on files goes on whenever the executor rests.
        self.due = if is_busy { now } else { now.plus(rest.min(Micros(next))) };
        next == 0
    }

    fn report(&self) -> NetworkReport {
        let report = self.stack.report();
        let counters = self.ethernet.counters();
        let peers =
            |service| report.visitors.iter().flatten().filter(|visitor| visitor.service == service).count() as u8;
        NetworkReport {
            mac: report.mac,
            link: self.link.map(|link| NetworkLink {
                mbit: if link.speed == Speed::Hundred { 100 } else { 10 },
                is_full_duplex: link.duplex == Duplex::Full,
            }),
            address: self.address(),
            name: if self.has_mdns { report.name.try_into().unwrap_or_default() } else { heapless::String::new() },
            traffic: NetworkTraffic {
                received: (counters.received, counters.received_bytes),
                sent: (counters.sent, counters.sent_bytes),
                damaged: counters.damaged.wrapping_add(counters.check_errors),
                lost: counters.missed,
                broadcasts_left_out: counters.too_many,
                links: self.links,
            },
            services: self
                .services
                .iter()
                .map(|&(service, port)| NetworkService { name: name_of(service), port, peers: peers(service) })
                .chain(self.web_port.map(|port| NetworkService { name: "Page", port, peers: report.web_peers as u8 }))
                .collect(),
            has_password: self.stack.password_record().is_some(),
            clock_set_ago: self.clock_set_at.map(|at| (time::now().since(at).0 / 1_000_000) as u32),
        }
    }

    fn address(&self) -> Option<NetworkAddress> {
        self.stack.report().address.map(|address| NetworkAddress {
            address: address.address,
            mask_bits: address.prefix,
            gateway: address.gateway,
            dns: address.dns[0],
            origin: match address.origin {
                Origin::Static => AddressOrigin::Configuration,
                Origin::Dhcp => AddressOrigin::Dhcp,
                Origin::LinkLocal => AddressOrigin::LinkLocal,
            },
        })
    }

    fn take_news(&mut self) -> Option<NetworkNews> {
        let fault = self.ethernet.fault();
        if fault != self.told {
            self.told = fault;
            if let Some(fault) = fault {
                return Some(NetworkNews::Fault(fault.message()));
            }
        }
        if let Some(news) = self.page.take_news() {
            return Some(news);
        }
        while let Some(news) = self.stack.take_news() {
            match news {
                News::Address { .. } => {
                    let address = self.address()?;
                    self.page.set_address(address.address);
                    return Some(NetworkNews::Address(address));
                }
                News::AddressLost { loss: net::Loss::Replaced, .. } => {}
                News::AddressLost { .. } => return Some(NetworkNews::NoAddress),
                News::AddressTaken { address, .. } => return Some(NetworkNews::AddressTaken(address)),
                News::Named(name) if name != self.name => {
                    self.name = name;
                    self.page.set_host(self.name.as_str());
                    return Some(NetworkNews::Renamed(self.name.as_str().try_into().unwrap_or_default()));
                }
                News::Time { unix_ms } => {
                    self.clock_set_at = Some(time::now());
                    return Some(NetworkNews::Time(unix_ms.saturating_add(500) / 1_000));
                }
                News::WrongPassword { from } => return Some(NetworkNews::WrongPassword(from)),
                News::Named(_) | News::NameTaken(_) | News::NoTime | News::Came(_) | News::Left(_) => {}
            }
        }
        None
    }
}

const fn name_of(service: Service) -> &'static str {
    match service {
        Service::Telnet => "Telnet",
        Service::Grbl => "GRBL",
    }
}

/// Returns the stack's settings for those of the configuration, which have been checked.
fn settings(config: &NetworkConfig, mac: [u8; 6]) -> Settings {
    let addressing = match (config.address.given(), config.mask.given()) {
        (Some(address), Some(mask)) => Addressing::Static(StaticAddress {
            address,
            mask,
            gateway: config.gateway.given(),
            dns: config.dns.given(),
        }),
        _ => Addressing::Dhcp,
    };
    Settings {
        host: HostName::new(&config.host_name),
        addressing,
        time_server: if config.ntp { time_server(&config.ntp_server) } else { None },
        telnet: config.shell.then_some(config.shell_port),
        grbl: config.grbl.then_some(config.grbl_port),
        web: config.web.then_some(config.web_port),
        mdns: config.mdns,
        password_required: config.password_required,
        ..Settings::new(mac)
    }
}

fn time_server(text: &str) -> Option<TimeServer> {
    Address::read(text).given().map_or_else(|| TimeServer::named(text), |address| Some(TimeServer::Address(address)))
}
