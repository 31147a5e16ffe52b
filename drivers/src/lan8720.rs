//! LAN8720A and LAN8742A Ethernet transceivers (PHY): registers over the management interface (MDIO), which
//! the caller moves.
//!
//! LAN8720A data sheet (DS00002165), chapter 4 the registers, section 3.2 auto-negotiation and parallel
//! detection; IEEE 802.3 clause 22 the registers that all PHYs have, clause 28 auto-negotiation. The LAN8742A
//! differs in nothing that is used here.
//!
//! A management frame takes tens of microseconds, so nothing here waits for one: [`Lan8720::next`] says which
//! register is due to be read or written, and [`Lan8720::answer`] takes what came of it. The order:
//!
//! 1. The identifier at both addresses that the chip can be strapped to.
//! 2. A software reset, because straps and an earlier firmware may have left anything.
//! 3. What to advertise, and auto-negotiation. A speed is chosen by advertising nothing else, never by
//!    turning auto-negotiation off: an end that does not negotiate makes the other one fall back to half
//!    duplex.
//! 4. The link, ten times a second. Once there is one: whether the settings are still in force, whether the
//!    other end negotiates, and what came of it.

use units::Micros;

/// Numbers of the registers (chapter 4).
mod register {
    pub const CONTROL: u8 = 0;
    pub const STATUS: u8 = 1;
    pub const FIRST_ID: u8 = 2;
    pub const SECOND_ID: u8 = 3;
    pub const ADVERTISEMENT: u8 = 4;
    pub const EXPANSION: u8 = 6;
    pub const SPECIAL_STATUS: u8 = 31;
}

/// Bits of the basic control register.
mod control {
    pub const SOFT_RESET: u16 = 1 << 15;
    pub const LOOPBACK: u16 = 1 << 14;
    pub const NEGOTIATE: u16 = 1 << 12;
    pub const POWER_DOWN: u16 = 1 << 11;
    pub const ISOLATE: u16 = 1 << 10;
    pub const RESTART: u16 = 1 << 9;
    /// Bits that decide whether there can be a link as it was asked for.
    pub const KEPT: u16 = SOFT_RESET | LOOPBACK | NEGOTIATE | POWER_DOWN | ISOLATE;
}

/// Bits of the basic status register. The link's latches low: a reading without it may be of the past.
mod status {
    pub const LINK: u16 = 1 << 2;
    /// Extended registers, which these chips have.
    pub const EXTENDED: u16 = 1 << 0;
}

/// Abilities in the advertisement: the selector of IEEE 802.3, then 10BASE-T and 100BASE-TX, each in half and
/// full duplex. No pause frames: the controller neither sends nor obeys them.
mod ability {
    pub const SELECTOR: u16 = 1;
    pub const TEN: u16 = 0b11 << 5;
    pub const HUNDRED: u16 = 0b11 << 7;
}

/// Expansion register: the other end can negotiate.
const PARTNER_NEGOTIATES: u16 = 1 << 0;
/// Special status register: the negotiation is over, with or without the other end.
const NEGOTIATION_DONE: u16 = 1 << 12;

/// Upper word of the identifier of both chips, and the lower one's without its four bits of revision.
const FIRST_ID: u16 = 0x0007;
const SECOND_IDS: [u16; 2] = [0xC0F0, 0xC130];
const REVISION: u16 = 0x000F;

/// Addresses that the strap PHYAD0 can select.
const LAST_ADDRESS: u8 = 1;

/// Reading of a line that nobody drives, as it is pulled up; and of one that is stuck at ground.
const UNDRIVEN: u16 = 0xFFFF;
const GROUNDED: u16 = 0x0000;

/// Time between two looks at the link.
const POLL: Micros = Micros::from_millis(100);
/// Time between two looks for the end of a reset, and its limit (section 3.8.5: within 0.5 s).
const RESET_POLL: Micros = Micros::from_millis(10);
const RESET_LIMIT: Micros = Micros::from_millis(500);
/// Time between two searches for the chip.
const RETRY: Micros = Micros::from_seconds(1);

/// Speeds that are offered to the other end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinkMode {
    /// 10 and 100 Mbit/s.
    #[default]
    Auto,
    /// 100 Mbit/s alone.
    Hundred,
    /// 10 Mbit/s alone: for long or noisy cables.
    Ten,
}

impl LinkMode {
    const fn advertisement(self) -> u16 {
        ability::SELECTOR
            | match self {
                Self::Auto => ability::TEN | ability::HUNDRED,
                Self::Hundred => ability::HUNDRED,
                Self::Ten => ability::TEN,
            }
    }
}

/// Speed of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// 10 Mbit/s.
    Ten,
    /// 100 Mbit/s.
    Hundred,
}

/// Whether both ends may send at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Duplex {
    /// One end at a time.
    Half,
    /// Both ends at once.
    Full,
}

/// A link to the other end of the cable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Speed of both ends.
    pub speed: Speed,
    /// Duplex mode, the same at both ends if both negotiated.
    pub duplex: Duplex,
    /// Whether the other end negotiates. One that does not is taken to be half duplex, rightly or not.
    pub is_negotiated: bool,
}

/// Reason why there can be no link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No chip answers at either address.
    Absent,
    /// The data line stays low.
    Low,
    /// A chip of another kind answers.
    Other,
    /// The chip does not come out of its reset.
    NoReset,
    /// The chip does not keep its settings.
    Garbled,
    /// The controller does not finish a management frame.
    NoBus,
}

impl Fault {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Absent => "the Ethernet PHY does not answer: check its supply, and MDC and MDIO",
            Self::Low => "the Ethernet PHY's data line MDIO stays low: check its solder joints and pull-up",
            Self::Other => "the Ethernet PHY is neither a LAN8720A nor a LAN8742A: this firmware cannot use it",
            Self::NoReset => "the Ethernet PHY does not end its reset: switch the board off and on",
            Self::Garbled => "the Ethernet PHY does not keep its settings: check its supply, and MDC and MDIO",
            Self::NoBus => "the Ethernet controller does not end a frame to the PHY: switch the board off and on",
        }
    }
}

/// Access to a register of the PHY.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// Address of the PHY.
    pub address: u8,
    /// Number of the register.
    pub register: u8,
    /// Value to be written; `None` reads.
    pub write: Option<u16>,
}

/// The next access, and what it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    ReadFirstId,
    ReadSecondId,
    Reset,
    AwaitReset,
    Advertise,
    Negotiate,
    ReadStatus,
    /// The reading before it had no link, which may have been of the past.
    ReadStatusAgain,
    CheckControl,
    CheckAdvertisement,
    ReadExpansion,
    ReadResult,
}

/// The transceiver, from the search for it to its link.
#[derive(Debug)]
pub struct Lan8720 {
    mode: LinkMode,
    address: u8,
    step: Step,
    /// Earliest time of the next access.
    due: Micros,
    reset_since: Micros,
    /// Verdict on the addresses searched so far.
    found: Fault,
    is_negotiated: bool,
    link: Option<Link>,
    fault: Option<Fault>,
}

impl Lan8720 {
    /// Creates a driver that has yet to find its chip.
    #[must_use]
    pub const fn new(mode: LinkMode) -> Self {
        Self {
            mode,
            address: 0,
            step: Step::ReadFirstId,
            due: Micros(0),
            reset_since: Micros(0),
            found: Fault::Absent,
            is_negotiated: false,
            link: None,
            fault: None,
        }
    }

    /// Returns the link, as of the last look at it.
    #[must_use]
    pub const fn link(&self) -> Option<Link> {
        self.link
    }

    /// Returns the reason why there can be no link. Without a reason and a link, no cable is plugged in, or
    /// its other end is off.
    #[must_use]
    pub const fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Returns the access that is due. It stays the same until [`Self::answer`] or [`Self::fail`] is called.
    #[must_use]
    pub fn next(&self, now: Micros) -> Option<Access> {
        if now < self.due {
            return None;
        }
        let (register, write) = match self.step {
            Step::ReadFirstId => (register::FIRST_ID, None),
            Step::ReadSecondId => (register::SECOND_ID, None),
            Step::Reset => (register::CONTROL, Some(control::SOFT_RESET)),
            Step::AwaitReset | Step::CheckControl => (register::CONTROL, None),
            Step::Advertise => (register::ADVERTISEMENT, Some(self.mode.advertisement())),
            Step::Negotiate => (register::CONTROL, Some(control::NEGOTIATE | control::RESTART)),
            Step::ReadStatus | Step::ReadStatusAgain => (register::STATUS, None),
            Step::CheckAdvertisement => (register::ADVERTISEMENT, None),
            Step::ReadExpansion => (register::EXPANSION, None),
            Step::ReadResult => (register::SPECIAL_STATUS, None),
        };
        Some(Access { address: self.address, register, write })
    }

    /// Takes the value of the register that was due, which after a write is of no importance.
    pub fn answer(&mut self, now: Micros, value: u16) {
        match self.step {
            Step::ReadFirstId if value == FIRST_ID => self.step = Step::ReadSecondId,
            Step::ReadSecondId if SECOND_IDS.contains(&(value & !REVISION)) => {
                self.fault = None;
                self.step = Step::Reset;
            }
            Step::ReadFirstId | Step::ReadSecondId => self.search_on(now, value),
            Step::Reset => {
                self.reset_since = now;
                self.go_on(Step::AwaitReset, now.plus(RESET_POLL));
            }
            Step::AwaitReset if value & control::SOFT_RESET == 0 => self.step = Step::Advertise,
            Step::AwaitReset if now.since(self.reset_since) > RESET_LIMIT => self.start_over(now, Fault::NoReset),
            Step::AwaitReset => self.due = now.plus(RESET_POLL),
            Step::Advertise => self.step = Step::Negotiate,
            Step::Negotiate => self.look_later(now),
            _ if value == UNDRIVEN => self.start_over(now, Fault::Absent),
            Step::ReadStatus | Step::ReadStatusAgain => self.take_status(now, value),
            Step::CheckControl if value & control::KEPT == control::NEGOTIATE => self.look_later(now),
            Step::CheckAdvertisement if value == self.mode.advertisement() => self.step = Step::ReadExpansion,
            Step::CheckControl | Step::CheckAdvertisement => {
                self.fault = Some(Fault::Garbled);
                self.step = Step::Reset;
            }
            Step::ReadExpansion => {
                self.is_negotiated = value & PARTNER_NEGOTIATES != 0;
                self.step = Step::ReadResult;
            }
            Step::ReadResult => {
                self.link = result(value, self.is_negotiated);
                if self.link.is_some() {
                    self.fault = None;
                }
                self.look_later(now);
            }
        }
    }

    /// Notes that the access that was due has come to nothing, and begins again.
    pub fn fail(&mut self, now: Micros) {
        self.start_over(now, Fault::NoBus);
    }

    fn go_on(&mut self, step: Step, due: Micros) {
        (self.step, self.due) = (step, due);
    }

    fn look_later(&mut self, now: Micros) {
        self.go_on(Step::ReadStatus, now.plus(POLL));
    }

    /// Begins again with the search, a while from now.
    fn start_over(&mut self, now: Micros, fault: Fault) {
        (self.link, self.fault) = (None, Some(fault));
        (self.address, self.found) = (0, Fault::Absent);
        self.go_on(Step::ReadFirstId, now.plus(RETRY));
    }

    /// Searches at the next address, after one with this in its identifier.
    fn search_on(&mut self, now: Micros, value: u16) {
        self.found = match value {
            UNDRIVEN => self.found,
            GROUNDED if self.found == Fault::Absent => Fault::Low,
            GROUNDED => self.found,
            _ => Fault::Other,
        };
        if self.address < LAST_ADDRESS {
            self.address += 1;
            self.step = Step::ReadFirstId;
        } else {
            self.start_over(now, self.found);
        }
    }

    fn take_status(&mut self, now: Micros, value: u16) {
        if value & status::EXTENDED == 0 {
            return self.start_over(now, Fault::Low);
        }
        let is_up = value & status::LINK != 0;
        match self.step {
            _ if is_up && self.link.is_some() => self.look_later(now),
            _ if is_up => self.step = Step::CheckAdvertisement,
            Step::ReadStatus => {
                // The link was lost since the last look, even if it is back.
                self.link = None;
                self.step = Step::ReadStatusAgain;
            }
            _ => self.step = Step::CheckControl,
        }
    }
}

/// Returns the link by the special status register: its speed indication is that of the negotiation, or of
/// the parallel detection. `None` while neither is over.
const fn result(value: u16, is_negotiated: bool) -> Option<Link> {
    if value & NEGOTIATION_DONE == 0 {
        return None;
    }
    let (speed, duplex) = match value >> 2 & 0b111 {
        0b001 => (Speed::Ten, Duplex::Half),
        0b101 => (Speed::Ten, Duplex::Full),
        0b010 => (Speed::Hundred, Duplex::Half),
        0b110 => (Speed::Hundred, Duplex::Full),
        _ => return None,
    };
    Some(Link { speed, duplex, is_negotiated })
}

#[cfg(test)]
mod tests;
