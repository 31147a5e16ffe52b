//! The page and its API: the site over the network's web connections, and its console of the machine.

use core::net::Ipv4Addr;

use base::ports::Storage;
use base::sessions::{Intake, Rights};
use base::snapshot::Snapshot;
use bsp_prime::time;
use gcode::realtime::Realtime;
use net::{STREAMS, Streams, Wish};
use site::{Life, Role, Site};

use crate::consoles::Console;
use crate::executor;

/// Bytes that a connection holds of what came in.
const STREAM_BYTES: usize = net::STREAM_BYTES;

/// The page.
pub struct Page {
    site: Site<STREAMS>,
    intake: Intake,
    rights: Rights,
}

impl Page {
    /// Makes the page of a board that has this name in the network. Its console opens only where the page is
    /// served.
    pub fn new(host: &str, rights: Rights, is_served: bool) -> Self {
        let role = match rights {
            Rights::Watch => Role::Nobody,
            Rights::Operate => Role::Operate,
            Rights::Own => Role::Own,
        };
        let mut intake = Intake::new();
        if is_served {
            Console::Page.inbox().open(&mut intake);
        }
        Self { site: Site::new(host, env!("VELVET_VERSION"), role), intake, rights }
    }

    /// Returns the page's site.
    pub const fn site(&mut self) -> &mut Site<STREAMS> {
        &mut self.site
    }

    /// Returns the rights of the page's console.
    pub const fn rights(&self) -> Rights {
        self.rights
    }

    /// Sets the board's name in the network.
    pub fn set_host(&mut self, host: &str) {
        self.site.set_host(host);
    }

    /// Sets the board's address.
    pub const fn set_address(&mut self, address: Ipv4Addr) {
        self.site.set_address(address);
    }

    /// Hears what the machine says on the page's console. Returns how many bytes.
    pub fn hear(&mut self, bytes: &[u8]) -> usize {
        self.site.hear(bytes, now_ms(time::now().0))
    }

    /// Returns whether somebody wants to see the machine as it is now.
    pub fn wants_snapshot(&self) -> bool {
        self.site.wants_snapshot(now_ms(time::now().0))
    }

    /// Shows the machine as it is now.
    pub fn show(&mut self, snapshot: &Snapshot) {
        self.site.show(snapshot, now_ms(time::now().0));
    }

    /// Hands the machine what visitors ask for, and works on files for them. Returns whether there is more of
    /// that soon.
    pub fn run(&mut self, card: &mut impl Storage) -> bool {
        let is_busy = self.site.run(now_ms(time::now().0), card);
        let inbox = Console::Page.inbox();
        if self.site.take_stop().is_some() {
            inbox.request(Realtime::Emergency);
            executor::wake_for_session();
        }
        let now = now_ms(time::now().0);
        if self.site.breaks_off(now) {
            // The request that ends an answer, and sets nothing going.
            inbox.request(Realtime::JogCancel);
            executor::wake_for_session();
        }
        if self.site.take_jog_end(now) {
            inbox.cancel_jogs();
            executor::wake_for_session();
        }
        if inbox.room() >= site::SCRIPT_BYTES
            && let Some(line) = self.site.next_line(now)
        {
            // The inbox has room for the line.
            let _taken = inbox.receive_all(&mut self.intake, line.as_bytes());
            executor::wake_for_session();
        }
        is_busy
    }
}

/// The page with the card that its files are on.
pub struct Served<'s, S> {
    pub page: &'s mut Page,
    pub card: &'s mut S,
}

/// Returns a time of the network in milliseconds.
const fn now_ms(micros: u64) -> u64 {
    micros / 1_000
}

impl<S: Storage> Streams for Served<'_, S> {
    fn open(&mut self, place: usize, _from: Ipv4Addr, now: u64) {
        self.page.site.open(place, STREAM_BYTES, now_ms(now));
    }

    fn receive(&mut self, place: usize, bytes: &mut [u8], now: u64) -> usize {
        self.page.site.receive(place, bytes, now_ms(now), self.card)
    }

    fn hear_end(&mut self, place: usize) {
        self.page.site.hear_end(place);
    }

    fn transmit(&mut self, place: usize, room: &mut [u8], now: u64) -> usize {
        self.page.site.transmit(place, room, now_ms(now), self.card)
    }

    fn wish(&mut self, place: usize, now: u64) -> Wish {
        match self.page.site.life(place, now_ms(now)) {
            Life::Open => Wish::Open,
            Life::Finish => Wish::Finish,
            Life::Abort => Wish::Abort,
        }
    }

    fn close(&mut self, place: usize) {
        self.page.site.close(place, self.card);
    }
}
