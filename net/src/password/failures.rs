//! Wrong passwords and the time they cost: whoever guesses waits longer each time, and so do all when many
//! guess.

use core::net::Ipv4Addr;

use smoltcp::time::{Duration, Instant};

/// Wrong passwords of an address that cost nothing but the attempt.
const FREE: u32 = 4;
/// Wrong passwords of all addresses together that cost nothing, so that nobody alone locks out the owner.
const FREE_OF_ALL: u32 = 19;
/// Powers of two, in seconds, that an address and all together wait at most.
const MOST: u32 = 9;
const MOST_OF_ALL: u32 = 4;
/// Time after the last wrong password after which all are forgotten.
const FORGET: Duration = Duration::from_secs(3_600);
/// Addresses that are remembered.
const ADDRESSES: usize = 8;

/// Wrong passwords from one place.
#[derive(Clone, Copy, Debug)]
struct Tally {
    count: u32,
    last: Instant,
}

impl Tally {
    const NONE: Self = Self { count: 0, last: Instant::ZERO };

    fn is_old(&self, now: Instant) -> bool {
        self.count == 0 || now >= self.last + FORGET
    }

    fn add(&mut self, now: Instant) {
        let before = if self.is_old(now) { 0 } else { self.count };
        *self = Self { count: before.saturating_add(1), last: now };
    }

    /// Returns how long to wait from now on.
    fn wait(&self, free: u32, most: u32, now: Instant) -> Duration {
        if self.is_old(now) || self.count <= free {
            return Duration::ZERO;
        }
        let until = self.last + Duration::from_secs(1 << (self.count - free).min(most));
        if now < until { until - now } else { Duration::ZERO }
    }
}

/// Memory of wrong passwords.
#[derive(Debug)]
pub struct Failures {
    all: Tally,
    by_address: [(Ipv4Addr, Tally); ADDRESSES],
}

impl Failures {
    /// Makes a memory of nothing.
    pub const fn new() -> Self {
        Self { all: Tally::NONE, by_address: [(Ipv4Addr::UNSPECIFIED, Tally::NONE); ADDRESSES] }
    }

    /// Notes a wrong password.
    pub fn add(&mut self, from: Ipv4Addr, now: Instant) {
        self.all.add(now);
        let known = self.by_address.iter().position(|(address, _)| *address == from);
        let oldest = || (0..ADDRESSES).min_by_key(|index| self.by_address.get(*index).map(|(_, tally)| tally.last));
        let Some(index) = known.or_else(oldest) else { return };
        if let Some((address, tally)) = self.by_address.get_mut(index) {
            if *address != from {
                (*address, *tally) = (from, Tally::NONE);
            }
            tally.add(now);
        }
    }

    /// Forgets the wrong passwords of an address, as it has given the right one.
    pub fn forgive(&mut self, from: Ipv4Addr) {
        self.by_address.iter_mut().filter(|(address, _)| *address == from).for_each(|(_, tally)| *tally = Tally::NONE);
    }

    /// Returns how long an address has to wait.
    pub fn wait(&self, from: Ipv4Addr, now: Instant) -> Duration {
        let own = self.by_address.iter().find(|(address, _)| *address == from);
        let own = own.map_or(Duration::ZERO, |(_, tally)| tally.wait(FREE, MOST, now));
        own.max(self.all.wait(FREE_OF_ALL, MOST_OF_ALL, now))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GUESSER: Ipv4Addr = Ipv4Addr::new(10, 0, 0, 66);
    const OWNER: Ipv4Addr = Ipv4Addr::new(10, 0, 0, 1);

    #[test]
    fn the_fifth_wrong_password_costs_time_and_each_more_costs_twice_as_much() {
        let (mut failures, now) = (Failures::new(), Instant::from_secs(5));
        let mut waits = Vec::new();
        for _ in 0..16 {
            failures.add(GUESSER, now);
            waits.push(failures.wait(GUESSER, now).secs());
        }
        assert_eq!(waits[..8], [0, 0, 0, 0, 2, 4, 8, 16]);
        assert_eq!(waits[15], 512);
        assert_eq!(failures.wait(OWNER, now), Duration::ZERO);
        assert_eq!(failures.wait(GUESSER, now + Duration::from_secs(512)), Duration::ZERO);
        failures.forgive(GUESSER);
        assert_eq!(failures.wait(GUESSER, now), Duration::ZERO);
    }

    #[test]
    fn many_who_guess_slow_all_down_but_not_for_long() {
        let (mut failures, now) = (Failures::new(), Instant::from_secs(5));
        for guesser in 0..100 {
            failures.add(Ipv4Addr::new(10, 0, 1, guesser), now);
        }
        assert_eq!(failures.wait(OWNER, now).secs(), 16);
        assert_eq!(failures.wait(OWNER, now + FORGET), Duration::ZERO);
    }
}
