//! Claim on an address: nobody else may have it (RFC 5227), neither before it is used nor later.
//!
//! The delays of RFC 5227 are for links that take seconds to carry a frame. An address of a server or of the
//! configuration is probed faster, which Ethernet allows; one that the board made up itself is probed as
//! slowly as RFC 3927 says, as others make up theirs at the same moment.

use core::net::Ipv4Addr;

use smoltcp::time::{Duration, Instant};
use smoltcp::wire::Ipv4Cidr;

use crate::random::Random;
use crate::wire::Arp;

/// Probes before an address is used.
const PROBES: u8 = 3;
/// Announcements of an address that is used.
const ANNOUNCEMENTS: u8 = 2;
/// Time between two announcements.
const ANNOUNCE_EVERY: Duration = Duration::from_secs(2);
/// Time within which an address is defended only once.
const DEFEND_EVERY: Duration = Duration::from_secs(10);

/// Delays of probing, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// Greatest delay before the first probe.
    first: u32,
    /// Least time between two probes.
    least: u32,
    /// Greatest time between two probes.
    greatest: u32,
    /// Time after the last probe.
    last: u32,
}

impl Pace {
    /// For an address that is meant for this board.
    pub const FAST: Self = Self { first: 100, least: 200, greatest: 400, last: 500 };
    /// For an address that others may choose too.
    pub const SLOW: Self = Self { first: 1_000, least: 1_000, greatest: 2_000, last: 2_000 };
}

/// State of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// So many probes are still to be sent.
    Probing(u8),
    /// So many announcements are still to be made. The address is used.
    Announcing(u8),
    /// The address is used.
    Holding,
}

/// Frame that a claim wants to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// The question whether anybody has the address.
    Probe,
    /// The announcement of having it.
    Announce,
}

/// What another machine's frame means for a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The frame has nothing to do with it.
    Harmless,
    /// The other machine asks whether anybody has the address: it is to be answered.
    Asked,
    /// The other machine uses the address, and is told off.
    Defended,
    /// The other machine has the address.
    Lost,
}

/// Claim on an address.
#[derive(Clone, Debug)]
pub struct Claim {
    address: Ipv4Cidr,
    stage: Stage,
    pace: Pace,
    /// Time of what is next.
    next: Instant,
    defended: Option<Instant>,
}

impl Claim {
    /// Makes a claim that begins to probe after a random delay.
    pub fn new(address: Ipv4Cidr, pace: Pace, now: Instant, random: &mut Random) -> Self {
        let next = now + millis(random.below(pace.first));
        Self { address, stage: Stage::Probing(PROBES), pace, next, defended: None }
    }

    /// Returns the address that is claimed.
    pub const fn address(&self) -> Ipv4Cidr {
        self.address
    }

    /// Returns whether the address may be used.
    pub const fn is_held(&self) -> bool {
        !matches!(self.stage, Stage::Probing(_))
    }

    /// Returns what is to be sent now; [`Self::sent`] follows when it was.
    pub fn wish(&mut self, now: Instant) -> Option<Wish> {
        if now < self.next {
            return None;
        }
        if self.stage == Stage::Probing(0) {
            self.stage = Stage::Announcing(ANNOUNCEMENTS);
        }
        match self.stage {
            Stage::Probing(_) => Some(Wish::Probe),
            Stage::Announcing(_) => Some(Wish::Announce),
            Stage::Holding => None,
        }
    }

    /// Notes that the wish was sent.
    pub fn sent(&mut self, now: Instant, random: &mut Random) {
        let Pace { least, greatest, last, .. } = self.pace;
        let (stage, delay) = match self.stage {
            Stage::Probing(2..) => {
                let spread = greatest.saturating_sub(least).saturating_add(1);
                let left = if let Stage::Probing(left) = self.stage { left - 1 } else { 0 };
                (Stage::Probing(left), millis(least.saturating_add(random.below(spread))))
            }
            Stage::Probing(_) => (Stage::Probing(0), millis(last)),
            Stage::Announcing(2..) => (Stage::Announcing(1), ANNOUNCE_EVERY),
            Stage::Announcing(_) | Stage::Holding => (Stage::Holding, ANNOUNCE_EVERY),
        };
        (self.stage, self.next) = (stage, now + delay);
    }

    /// Judges a frame that came in. `is_final` says that the address is never given up once it is used.
    pub fn hear(&mut self, arp: &Arp, own: [u8; 6], is_final: bool, now: Instant) -> Verdict {
        let address = self.address.address();
        if arp.mac == own {
            return Verdict::Harmless;
        }
        let is_probe = arp.is_request && arp.sender == Ipv4Addr::UNSPECIFIED && arp.target == address;
        if !self.is_held() {
            return if arp.sender == address || is_probe { Verdict::Lost } else { Verdict::Harmless };
        }
        if is_probe {
            return Verdict::Asked;
        }
        if arp.sender != address {
            return Verdict::Harmless;
        }
        let lately = self.defended.is_some_and(|at| now < at + DEFEND_EVERY);
        if !lately {
            self.defended = Some(now);
            return Verdict::Defended;
        }
        if is_final { Verdict::Harmless } else { Verdict::Lost }
    }
}

fn millis(count: u32) -> Duration {
    Duration::from_millis(u64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: [u8; 6] = [2, 0, 0, 0, 0, 1];
    const OTHER: [u8; 6] = [2, 0, 0, 0, 0, 2];
    const ADDRESS: Ipv4Addr = Ipv4Addr::new(10, 0, 0, 9);

    fn claim() -> (Claim, Random) {
        let mut random = Random::new(1);
        (Claim::new(Ipv4Cidr::new(ADDRESS, 24), Pace::FAST, Instant::ZERO, &mut random), random)
    }

    /// Lets a claim have its way, and returns when it sent what.
    fn undisturbed(claim: &mut Claim, random: &mut Random) -> Vec<(i64, Wish)> {
        let mut sent = Vec::new();
        for now in (0..20_000).map(Instant::from_millis) {
            if let Some(wish) = claim.wish(now) {
                claim.sent(now, random);
                sent.push((now.total_millis(), wish));
            }
        }
        sent
    }

    #[test]
    fn an_address_is_probed_and_then_announced() {
        let (mut claim, mut random) = claim();
        assert!(!claim.is_held());
        let sent = undisturbed(&mut claim, &mut random);
        let wishes: Vec<Wish> = sent.iter().map(|(_, wish)| *wish).collect();
        assert_eq!(wishes, [Wish::Probe, Wish::Probe, Wish::Probe, Wish::Announce, Wish::Announce]);
        assert!(sent.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 200), "{sent:?}");
        assert!(claim.is_held());
    }

    #[test]
    fn a_claim_that_cannot_send_waits() {
        let (mut claim, _) = claim();
        let late = Instant::from_secs(9);
        assert_eq!(claim.wish(late), Some(Wish::Probe));
        assert_eq!(claim.wish(late), Some(Wish::Probe), "until it is sent");
    }

    #[test]
    fn an_owner_or_another_applicant_ends_a_claim_that_is_not_held() {
        let (mut claim, _) = claim();
        let hear = |claim: &mut Claim, arp: Arp| claim.hear(&arp, OWN, false, Instant::ZERO);
        assert_eq!(hear(&mut claim, Arp::probe(OWN, ADDRESS)), Verdict::Harmless, "the own probe comes back");
        assert_eq!(hear(&mut claim, Arp::probe(OTHER, Ipv4Addr::new(10, 0, 0, 8))), Verdict::Harmless);
        assert_eq!(hear(&mut claim, Arp::announcement(OTHER, ADDRESS)), Verdict::Lost);
        assert_eq!(hear(&mut claim, Arp::probe(OTHER, ADDRESS)), Verdict::Lost);
    }

    #[test]
    fn an_address_is_defended_once_and_then_given_up_unless_it_is_final() {
        let (mut claim, mut random) = claim();
        undisturbed(&mut claim, &mut random);
        let at = |s: i64| Instant::from_secs(100 + s);
        let taken = Arp::announcement(OTHER, ADDRESS);
        assert_eq!(claim.hear(&Arp::probe(OTHER, ADDRESS), OWN, false, at(0)), Verdict::Asked);
        assert_eq!(claim.hear(&taken, OWN, true, at(0)), Verdict::Defended);
        assert_eq!(claim.hear(&taken, OWN, true, at(1)), Verdict::Harmless);
        assert_eq!(claim.hear(&taken, OWN, false, at(11)), Verdict::Defended);
        assert_eq!(claim.hear(&taken, OWN, false, at(12)), Verdict::Lost);
    }
}
