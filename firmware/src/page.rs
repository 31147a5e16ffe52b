//! The page and its API: the site over the network's web connections, and its console of the machine.

use core::mem::MaybeUninit;
use core::net::Ipv4Addr;

use base::ports::{KeysRecord, NetworkNews, Storage};
use base::sessions::{Intake, Rights};
use base::snapshot::Snapshot;
use bsp_prime::random::RandomWords;
use bsp_prime::time;
use gcode::realtime::Realtime;
use net::{Network, STREAMS, Streams, Verdict, Wish, Word};
use site::{Life, Role, Site};

use crate::consoles::Console;
use crate::executor;

/// Bytes that a connection holds of what came in.
const STREAM_BYTES: usize = net::STREAM_BYTES;

/// Place of the page in use.
#[unsafe(link_section = ".axisram")]
static mut PLACE: MaybeUninit<Page> = MaybeUninit::uninit();

/// Memory of the site that may be slow. All zero, as the section is.
#[unsafe(link_section = ".d2ram")]
static mut MEMORY: site::Memory = site::Memory::new();

/// The page.
pub struct Page {
    site: Site<STREAMS>,
    intake: Intake,
    /// Rights of the line that was handed over last.
    rights: Rights,
    /// Progress of a password that a visitor has set.
    password: NewPassword,
}

/// Progress of a password that a visitor of the page has set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NewPassword {
    Nothing,
    /// Its record is being made.
    Making,
    /// Its record is made, and to be kept.
    Made,
}

impl Page {
    /// Makes the page of a board that has this name in the network. `without` is what visitors may do who
    /// have neither logged in nor a key. The page's console opens only where it is served.
    ///
    /// Never inlined: the page is on the stack before it is at its place.
    ///
    /// # Safety
    /// May be called once only: each call gives out the one place.
    #[inline(never)]
    pub unsafe fn make(host: &str, without: Role, is_served: bool) -> &'static mut Self {
        let (place, memory) = (&raw mut PLACE, &raw mut MEMORY);
        // SAFETY: the caller calls this once, and nothing else names the statics; the board is up, so the
        // memory has been zeroed, which is what it is at first.
        let page = unsafe { (*place).write(Self::new(without, is_served, &mut *memory)) };
        page.set_host(host);
        page
    }

    fn new(without: Role, is_served: bool, memory: &'static mut site::Memory) -> Self {
        let mut intake = Intake::new();
        if is_served {
            Console::Page.inbox().open(&mut intake);
        }
        let site = Site::new(env!("VELVET_VERSION"), without, memory);
        Self { site, intake, rights: Rights::Watch, password: NewPassword::Nothing }
    }

    /// Returns the page's site.
    pub const fn site(&mut self) -> &mut Site<STREAMS> {
        &mut self.site
    }

    /// Returns the rights of the line that the page's console has.
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

    /// Returns whether the site has yet to be given the heights of the mesh of this number.
    pub fn wants_heights(&self, number: u32) -> bool {
        self.site.wants_heights(number)
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
            && let Some((line, role)) = self.site.next_line(now)
        {
            self.rights = match role {
                Role::Nobody | Role::Watch => Rights::Watch,
                Role::Operate => Rights::Operate,
                Role::Own => Rights::Own,
            };
            // The inbox has room for the line.
            let _taken = inbox.receive_all(&mut self.intake, line.as_bytes());
            executor::wake_for_session();
        }
        is_busy
    }
}

impl Page {
    /// Gives the site what it asks of the board: random bytes, and a password to be made.
    pub fn serve(&mut self, stack: &mut Network, random: &mut RandomWords) {
        while self.site.wants_random() {
            self.site.add_random(bytes(random.take()));
        }
        if let Some(word) = self.site.take_password() {
            let is_begun = stack.set_password(&word, bytes(random.take()));
            self.password = NewPassword::Making;
            if !is_begun {
                self.tell_kept(Err("the password is too long"));
            }
        }
        if self.password == NewPassword::Making && !stack.is_setting_password() {
            self.password = NewPassword::Made;
        }
        self.site.set_has_password(stack.password_record().is_some());
    }

    /// Takes what the machine has to do for visitors.
    pub fn take_news(&mut self) -> Option<NetworkNews> {
        if let Some((code, from)) = self.site.take_code() {
            return Some(NetworkNews::Code(code, Ipv4Addr::from(from)));
        }
        if self.password == NewPassword::Made {
            return Some(NetworkNews::NewPassword);
        }
        self.site.has_keys_to_keep().then_some(NetworkNews::NewKeys)
    }

    /// Takes whether the record of a visitor's password is made and to be kept.
    pub fn take_password(&mut self) -> bool {
        let is_made = self.password == NewPassword::Made;
        if is_made {
            self.password = NewPassword::Nothing;
        }
        is_made
    }

    /// Takes the keys of programs that are to be kept.
    pub fn take_keys(&mut self) -> Option<KeysRecord> {
        self.site.take_keys()
    }

    /// Sets the keys of programs, by their record.
    pub fn set_keys(&mut self, record: &[u8]) {
        self.site.read_keys(record);
    }

    /// The password is another one: all who have logged in are nobody again.
    pub fn change_password(&mut self) {
        self.site.change_password();
    }

    /// Hears whether a visitor's password or keys are kept.
    pub fn tell_kept(&mut self, kept: Result<(), &'static str>) {
        self.password = NewPassword::Nothing;
        self.site.hear_kept(kept);
    }
}

/// Returns the bytes of random words.
fn bytes(words: [u32; 4]) -> [u8; 16] {
    let mut bytes = [0; 16];
    for (place, byte) in bytes.iter_mut().zip(words.into_iter().flat_map(u32::to_le_bytes)) {
        *place = byte;
    }
    bytes
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
    fn open(&mut self, place: usize, from: Ipv4Addr, now: u64) {
        self.page.site.open(place, from, STREAM_BYTES, now_ms(now));
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

    fn take_word(&mut self) -> Option<Word> {
        self.page.site.take_word().map(|(from, bytes)| Word { from: Ipv4Addr::from(from), bytes })
    }

    fn hear_verdict(&mut self, verdict: Verdict) {
        self.page.site.hear_verdict(match verdict {
            Verdict::Right => site::Verdict::Right,
            Verdict::Wrong => site::Verdict::Wrong,
            Verdict::NoPassword => site::Verdict::NoPassword,
            Verdict::Wait(seconds) => site::Verdict::Wait(seconds),
        });
    }
}
