//! The board's address: from a server, from the configuration, or made up; claimed, defended and given up.

mod claim;
mod decline;

use core::net::Ipv4Addr;

use smoltcp::iface::{Interface, SocketHandle, SocketSet};
use smoltcp::phy::Device;
use smoltcp::socket::dhcpv4;
use smoltcp::time::{Duration, Instant};
use smoltcp::wire::{IpCidr, Ipv4Cidr};

use crate::news::{Inform, Loss, News, Origin};
use crate::random::Random;
use crate::settings::{Addressing, Settings, is_host};
use crate::wire::{Arp, Tap, send_arp};
use claim::{Claim, Pace, Verdict, Wish};
use decline::Decline;

/// Time that a server has before the board makes an address up.
const SERVER_TIME: Duration = Duration::from_secs(8);
/// Pause after a conflict, for the next address of a server (RFC 2131 section 3.1) or the same once more.
const PAUSE: Duration = Duration::from_secs(10);
/// Conflicts after which made-up addresses are tried slowly (RFC 3927 section 2.2.1), and how slowly.
const CONFLICTS: u32 = 10;
const SLOWLY: Duration = Duration::from_secs(60);
/// Servers of names that are remembered.
const SERVERS: usize = 2;

/// What belongs to an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    pub address: Ipv4Cidr,
    pub origin: Origin,
    pub gateway: Option<Ipv4Addr>,
    pub dns: [Option<Ipv4Addr>; SERVERS],
    /// Server that gave it.
    pub server: Option<Ipv4Addr>,
}

/// Owner of the board's address.
#[derive(Debug)]
pub struct Keeper {
    mac: [u8; 6],
    fixed: Option<Terms>,
    dhcp: Option<SocketHandle>,
    /// Address in use.
    current: Option<(Claim, Terms)>,
    /// Address that is being probed.
    next: Option<(Claim, Terms)>,
    /// Answer or defence that is to be sent.
    reply: Option<Arp>,
    /// Refusal of a server's address that is to be sent.
    decline: Option<Decline>,
    /// Time from which an address is made up, or the fixed one tried.
    try_at: Instant,
    /// Time from which the server is asked anew.
    restart_at: Option<Instant>,
    conflicts: u32,
    /// Choice of made-up addresses, the same at every start.
    choice: Random,
}

/// What the keeper works with.
pub struct Means<'a, 'd, D: Device> {
    pub interface: &'a mut Interface,
    pub sockets: &'a mut SocketSet<'static>,
    pub device: &'a mut Tap<'d, D>,
    pub random: &'a mut Random,
    pub news: &'a mut Inform,
}

impl Keeper {
    /// Makes the keeper; `dhcp` is the socket that asks servers, if any are to be asked.
    pub fn new(settings: &Settings, dhcp: Option<SocketHandle>) -> Self {
        let seed = settings.mac.iter().fold(0, |seed: u64, byte| seed << 8 | u64::from(*byte));
        Self {
            mac: settings.mac,
            fixed: fixed(settings),
            dhcp,
            current: None,
            next: None,
            reply: None,
            decline: None,
            try_at: Instant::ZERO,
            restart_at: None,
            conflicts: 0,
            choice: Random::new(seed),
        }
    }

    /// Returns the address in use and what belongs to it.
    pub fn terms(&self) -> Option<&Terms> {
        self.current.as_ref().map(|(_, terms)| terms)
    }

    /// Returns the address that is being probed.
    pub fn candidate(&self) -> Option<Ipv4Addr> {
        self.next.as_ref().map(|(claim, _)| claim.address().address())
    }

    /// Begins on a wire that has come up.
    pub fn link_up(&mut self, sockets: &mut SocketSet<'static>, now: Instant) {
        if let Some(handle) = self.dhcp {
            sockets.get_mut::<dhcpv4::Socket>(handle).reset();
        }
        self.restart_at = None;
        self.try_at = if self.fixed.is_some() { now } else { now + SERVER_TIME };
    }

    /// Forgets the wire.
    pub fn link_down(&mut self, interface: &mut Interface, news: &mut Inform) {
        self.next = None;
        self.reply = None;
        self.decline = None;
        self.drop_current(Loss::LinkDown, interface, news);
    }

    /// Does what is due. True when the address in use has changed.
    pub fn run<D: Device>(&mut self, means: &mut Means<'_, '_, D>, now: Instant) -> bool {
        let before = self.current.as_ref().map(|(_, terms)| terms.address);
        self.ask_server(means, now);
        while let Some(arp) = means.device.filter().take_arp() {
            self.hear(&arp, means, now);
        }
        self.begin(means.random, now);
        self.send(means, now);
        self.promote(means);
        before != self.current.as_ref().map(|(_, terms)| terms.address)
    }

    fn ask_server<D: Device>(&mut self, means: &mut Means<'_, '_, D>, now: Instant) {
        let Some(handle) = self.dhcp else { return };
        let socket = means.sockets.get_mut::<dhcpv4::Socket>(handle);
        if self.restart_at.is_some_and(|at| now >= at) {
            self.restart_at = None;
            socket.reset();
        }
        let terms = match socket.poll() {
            None => return,
            Some(dhcpv4::Event::Deconfigured) => None,
            Some(dhcpv4::Event::Configured(config)) => {
                let mut servers = config.dns_servers.iter().copied();
                Some(Terms {
                    address: config.address,
                    origin: Origin::Dhcp,
                    gateway: config.router.filter(|router| is_host(*router)),
                    dns: [servers.next(), servers.next()],
                    server: Some(config.server.identifier),
                })
            }
        };
        match terms {
            Some(terms) => self.take_lease(terms, means, now),
            None => self.lose_lease(means, now),
        }
    }

    fn take_lease<D: Device>(&mut self, terms: Terms, means: &mut Means<'_, '_, D>, now: Instant) {
        if self.restart_at.is_some() {
            return;
        }
        if let Some((_, current)) = self.current.as_mut().filter(|(_, current)| current.address == terms.address) {
            // The lease goes on; gateway or servers may be others.
            *current = terms;
            apply(Some(&terms), means.interface);
            return;
        }
        self.next = Some((Claim::new(terms.address, Pace::FAST, now, means.random), terms));
    }

    fn lose_lease<D: Device>(&mut self, means: &mut Means<'_, '_, D>, now: Instant) {
        self.next = self.next.take().filter(|(_, terms)| terms.origin != Origin::Dhcp);
        if self.terms().is_some_and(|terms| terms.origin == Origin::Dhcp) {
            self.drop_current(Loss::LeaseOver, means.interface, means.news);
            self.try_at = now + SERVER_TIME;
        }
    }

    /// Holds an ARP frame against both claims.
    fn hear<D: Device>(&mut self, arp: &Arp, means: &mut Means<'_, '_, D>, now: Instant) {
        if let Some((claim, terms)) = &mut self.next
            && claim.hear(arp, self.mac, false, now) == Verdict::Lost
        {
            let terms = *terms;
            self.next = None;
            self.give_up(&terms, arp, means, now);
        }
        let Some((claim, terms)) = &mut self.current else { return };
        let terms = *terms;
        let address = terms.address.address();
        match claim.hear(arp, self.mac, terms.origin == Origin::Static, now) {
            Verdict::Harmless => {}
            Verdict::Asked => self.reply = Some(arp.answer(self.mac)),
            Verdict::Defended => {
                self.reply = Some(Arp::announcement(self.mac, address));
                means.news.tell(News::AddressTaken { address, by: arp.mac });
            }
            Verdict::Lost => {
                self.drop_current(Loss::Taken, means.interface, means.news);
                self.give_up(&terms, arp, means, now);
            }
        }
    }

    /// Draws the consequences of a conflict about an address that is not used, or no longer.
    fn give_up<D: Device>(&mut self, terms: &Terms, arp: &Arp, means: &mut Means<'_, '_, D>, now: Instant) {
        let address = terms.address.address();
        means.news.tell(News::AddressTaken { address, by: arp.mac });
        self.conflicts = self.conflicts.saturating_add(1);
        self.try_at = match terms.origin {
            Origin::Static | Origin::Dhcp => now + PAUSE,
            Origin::LinkLocal if self.conflicts > CONFLICTS => now + SLOWLY,
            Origin::LinkLocal => now,
        };
        if terms.origin == Origin::Dhcp {
            self.restart_at = Some(now + PAUSE);
            self.decline = terms.server.map(|server| Decline { mac: self.mac, address, server });
        }
    }

    /// Begins a claim if there is nothing better to do.
    fn begin(&mut self, random: &mut Random, now: Instant) {
        if self.current.is_some() || self.next.is_some() || now < self.try_at {
            return;
        }
        let (terms, pace) = match self.fixed {
            Some(terms) => (terms, Pace::FAST),
            None => (self.made_up(), Pace::SLOW),
        };
        self.next = Some((Claim::new(terms.address, pace, now, random), terms));
    }

    /// Makes an address up: 169.254.1.0 to 169.254.254.255 (RFC 3927 section 2.1).
    fn made_up(&mut self) -> Terms {
        let [high, low] = (0x0100 + self.choice.below(0xFE00) as u16).to_be_bytes();
        let address = Ipv4Cidr::new(Ipv4Addr::new(169, 254, high, low), 16);
        Terms { address, origin: Origin::LinkLocal, gateway: None, dns: [None; SERVERS], server: None }
    }

    /// Sends what is due, as long as the device takes it.
    fn send<D: Device>(&mut self, means: &mut Means<'_, '_, D>, now: Instant) {
        if let Some(reply) = self.reply
            && send_arp(means.device, now, reply)
        {
            self.reply = None;
        }
        if let Some(decline) = &self.decline
            && decline.send(means.device, means.random, now)
        {
            self.decline = None;
        }
        for (claim, terms) in [&mut self.next, &mut self.current].into_iter().flatten() {
            let address = terms.address.address();
            let arp = match claim.wish(now) {
                Some(Wish::Probe) => Arp::probe(self.mac, address),
                Some(Wish::Announce) => Arp::announcement(self.mac, address),
                None => continue,
            };
            if send_arp(means.device, now, arp) {
                claim.sent(now, means.random);
            }
        }
    }

    /// Puts an address into use that nobody else has.
    fn promote<D: Device>(&mut self, means: &mut Means<'_, '_, D>) {
        let Some((claim, terms)) = self.next.take_if(|(claim, _)| claim.is_held()) else { return };
        self.drop_current(Loss::Replaced, means.interface, means.news);
        apply(Some(&terms), means.interface);
        means.news.tell(News::Address { address: terms.address.address(), origin: terms.origin });
        self.current = Some((claim, terms));
    }

    fn drop_current(&mut self, loss: Loss, interface: &mut Interface, news: &mut Inform) {
        let Some((_, terms)) = self.current.take() else { return };
        apply(None, interface);
        news.tell(News::AddressLost { address: terms.address.address(), loss });
    }
}

/// Returns the address of the configuration, if it names one that can be used.
fn fixed(settings: &Settings) -> Option<Terms> {
    let Addressing::Static(fixed) = settings.addressing else { return None };
    Some(Terms {
        address: Ipv4Cidr::new(fixed.address, fixed.prefix()?),
        origin: Origin::Static,
        gateway: fixed.gateway.filter(|gateway| is_host(*gateway)),
        dns: [fixed.dns.filter(|dns| is_host(*dns)), None],
        server: None,
    })
}

/// Has the stack use an address, or none.
fn apply(terms: Option<&Terms>, interface: &mut Interface) {
    interface.update_ip_addrs(|addresses| {
        addresses.clear();
        if let Some(terms) = terms {
            let _has_room = addresses.push(IpCidr::Ipv4(terms.address));
        }
    });
    let routes = interface.routes_mut();
    routes.remove_default_ipv4_route();
    if let Some(gateway) = terms.and_then(|terms| terms.gateway) {
        let _has_room = routes.add_default_ipv4_route(gateway);
    }
}
