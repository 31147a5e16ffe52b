//! Tests of the transceiver with a model of it and of the other end.

use super::*;
use proptest::prelude::*;

/// The other end of the cable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Partner {
    /// Negotiates, with these bits of its advertisement.
    Negotiates(u16),
    /// Has one speed, which the transceiver detects.
    Fixed(Speed),
}

/// Model of the chip by its data sheet.
struct Chip {
    address: u8,
    second_id: u16,
    control: u16,
    advertisement: u16,
    /// Whether the link was lost since the last reading of the status.
    lost: bool,
    cable: Option<Partner>,
    /// End of the negotiation under way, and of the reset.
    done_at: Option<Micros>,
    reset_until: Micros,
    resets: bool,
    is_there: bool,
    keeps: bool,
}

const NEGOTIATION: Micros = Micros::from_millis(1_500);

impl Chip {
    fn new(address: u8, cable: Option<Partner>) -> Self {
        Self {
            address,
            second_id: 0xC0F1,
            control: 0x0000,
            advertisement: 0x01E1,
            lost: true,
            cable,
            done_at: None,
            reset_until: Micros(0),
            resets: true,
            is_there: true,
            keeps: true,
        }
    }

    fn plug(&mut self, now: Micros, cable: Option<Partner>) {
        self.lost |= self.link(now).is_some();
        self.cable = cable;
        self.done_at = Some(now.plus(NEGOTIATION));
    }

    /// Speed and duplex by the priorities of IEEE 802.3 (28B.3), and by parallel detection.
    fn link(&self, now: Micros) -> Option<(Speed, Duplex)> {
        if self.control & control::KEPT != control::NEGOTIATE || self.done_at.is_none_or(|done| now < done) {
            return None;
        }
        let offered = self.advertisement;
        match self.cable? {
            Partner::Negotiates(theirs) => {
                let common = offered & theirs;
                let order = [(8, Speed::Hundred, Duplex::Full), (7, Speed::Hundred, Duplex::Half)];
                let order = order.into_iter().chain([(6, Speed::Ten, Duplex::Full), (5, Speed::Ten, Duplex::Half)]);
                order.into_iter().find(|(bit, ..)| common >> bit & 1 == 1).map(|(_, speed, duplex)| (speed, duplex))
            }
            Partner::Fixed(Speed::Ten) => (offered >> 5 & 1 == 1).then_some((Speed::Ten, Duplex::Half)),
            Partner::Fixed(Speed::Hundred) => (offered >> 7 & 1 == 1).then_some((Speed::Hundred, Duplex::Half)),
        }
    }

    fn access(&mut self, now: Micros, access: Access) -> u16 {
        if !self.is_there || access.address != self.address {
            return 0xFFFF;
        }
        let link = self.link(now);
        match (access.register, access.write) {
            (0, Some(value)) if value & control::SOFT_RESET != 0 => {
                let fresh = Self::new(self.address, self.cable);
                let kept = (self.resets, self.keeps, self.second_id);
                *self = Self { reset_until: now.plus(Micros::from_millis(25)), ..fresh };
                (self.resets, self.keeps, self.second_id) = kept;
            }
            (0, Some(value)) => {
                assert!(now >= self.reset_until, "not to be written during its reset");
                self.control = value & !control::RESTART;
                if value & control::RESTART != 0 {
                    self.lost |= link.is_some();
                    self.done_at = Some(now.plus(NEGOTIATION));
                }
            }
            (4, Some(value)) => self.advertisement = if self.keeps { value } else { 0 },
            (_, Some(_)) => panic!("{access:?}"),
            (0, None) if now < self.reset_until || !self.resets => return self.control | control::SOFT_RESET,
            (0, None) => return self.control,
            (1, None) => {
                let seen = link.is_some() && !self.lost;
                self.lost = link.is_none();
                return 0x7809 | u16::from(seen) << 2 | u16::from(link.is_some()) << 5;
            }
            (2, None) => return 0x0007,
            (3, None) => return self.second_id,
            (4, None) => return self.advertisement,
            (6, None) => return u16::from(matches!(self.cable, Some(Partner::Negotiates(_)))),
            (31, None) => {
                let code = link.map_or(0, |(speed, duplex)| {
                    let speed = if speed == Speed::Ten { 0b001 } else { 0b010 };
                    speed | if duplex == Duplex::Full { 0b100 } else { 0 }
                });
                return 0x0040 | code << 2 | u16::from(link.is_some()) << 12;
            }
            _ => panic!("{access:?}"),
        }
        0
    }
}

/// Driver, chip and time.
struct Bench {
    phy: Lan8720,
    chip: Chip,
    now: Micros,
    accesses: u32,
    /// Whether there was a moment without a link since the last question.
    was_down: bool,
}

impl Bench {
    fn new(mode: LinkMode, chip: Chip) -> Self {
        Self { phy: Lan8720::new(mode), chip, now: Micros(0), accesses: 0, was_down: true }
    }

    /// Lets time pass, with a look every millisecond, and a frame of management in each.
    fn run(&mut self, time: Micros) -> Option<Link> {
        let end = self.now.plus(time);
        while self.now < end {
            self.now = self.now.plus(Micros::from_millis(1));
            if let Some(access) = self.phy.next(self.now) {
                self.accesses += 1;
                let value = self.chip.access(self.now, access);
                self.phy.answer(self.now, value);
            }
            self.was_down |= self.phy.link().is_none();
        }
        self.phy.link()
    }

    fn plug(&mut self, cable: Option<Partner>) {
        self.chip.plug(self.now, cable);
        self.was_down = false;
    }

    fn truth(&self) -> Option<(Speed, Duplex)> {
        self.chip.link(self.now)
    }
}

/// Longest time from a plug to a link that is known: the search, the reset, the negotiation and a few looks.
const SETTLED: Micros = Micros::from_millis(2_500);

fn any_partner() -> impl Strategy<Value = Option<Partner>> {
    prop_oneof![
        1 => Just(None),
        4 => (0_u16..16).prop_map(|bits| Some(Partner::Negotiates(bits << 5 | 1))),
        1 => Just(Some(Partner::Fixed(Speed::Ten))),
        1 => Just(Some(Partner::Fixed(Speed::Hundred))),
    ]
}

fn any_mode() -> impl Strategy<Value = LinkMode> {
    prop_oneof![Just(LinkMode::Auto), Just(LinkMode::Hundred), Just(LinkMode::Ten)]
}

proptest! {
    #[test]
    fn the_link_is_the_best_that_both_ends_have(mode in any_mode(), cable in any_partner(), address in 0_u8..=1) {
        let mut bench = Bench::new(mode, Chip::new(address, cable));
        let link = bench.run(SETTLED);
        prop_assert_eq!(link.map(|link| (link.speed, link.duplex)), bench.truth());
        prop_assert_eq!(bench.phy.fault(), None);
        if let Some(link) = link {
            prop_assert_eq!(link.is_negotiated, matches!(cable, Some(Partner::Negotiates(_))));
            prop_assert!(mode == LinkMode::Auto || (mode == LinkMode::Ten) == (link.speed == Speed::Ten));
        }
    }

    #[test]
    fn no_change_of_cable_is_missed(changes in prop::collection::vec((any_partner(), 0_u64..4_000), 1..12)) {
        let mut bench = Bench::new(LinkMode::Auto, Chip::new(0, None));
        for (cable, time_ms) in changes {
            let had = bench.truth();
            bench.plug(cable);
            bench.run(Micros::from_millis(time_ms));
            if had.is_some() && time_ms >= 102 {
                prop_assert!(bench.was_down, "a lost link is noticed with the next look, even if it is back");
            }
        }
        let link = bench.run(SETTLED);
        prop_assert_eq!(link.map(|link| (link.speed, link.duplex)), bench.truth());
    }

    #[test]
    fn no_answers_whatever_make_it_stuck_or_hasty(values in prop::collection::vec(any::<u16>(), 0..300)) {
        let mut bench = Bench::new(LinkMode::Auto, Chip::new(0, Some(Partner::Negotiates(0x01E1))));
        for value in values {
            bench.now = bench.now.plus(Micros::from_millis(1));
            if bench.phy.next(bench.now).is_some() {
                bench.phy.answer(bench.now, value);
            }
        }
        // Whatever it has been told, with a chip that answers it finds the link again.
        let link = bench.run(Micros(RESET_LIMIT.0 + RETRY.0 + POLL.0 + SETTLED.0));
        prop_assert_eq!(link.map(|link| (link.speed, link.duplex)), bench.truth());
        bench.accesses = 0;
        bench.run(Micros::from_seconds(1));
        prop_assert!(bench.accesses <= 30, "{} frames of management in a second", bench.accesses);
    }
}

const FULL: Option<Partner> = Some(Partner::Negotiates(0x01E1));

#[test]
fn a_link_that_flaps_between_two_looks_is_seen() {
    let mut bench = Bench::new(LinkMode::Auto, Chip::new(0, FULL));
    assert!(bench.run(SETTLED).is_some());
    bench.was_down = false;
    // Lost and back at once, as after a pulse of noise.
    bench.chip.lost = true;
    assert!(bench.run(Micros::from_millis(120)).is_some());
    assert!(bench.was_down);
}

#[test]
fn no_chip_is_a_fault_and_is_searched_for_again() {
    let mut bench = Bench::new(LinkMode::Auto, Chip::new(1, FULL));
    bench.chip.is_there = false;
    assert_eq!((bench.run(Micros::from_seconds(5)), bench.phy.fault()), (None, Some(Fault::Absent)));
    assert!(bench.accesses <= 12, "two addresses a second");
    bench.chip.is_there = true;
    bench.run(Micros(RETRY.0 + SETTLED.0));
    assert_eq!((bench.phy.link().is_some(), bench.phy.fault()), (true, None));
    // Gone in the middle of it all.
    bench.chip.is_there = false;
    bench.run(Micros::from_millis(200));
    assert_eq!((bench.phy.link(), bench.phy.fault()), (None, Some(Fault::Absent)));
}

#[test]
fn the_other_chip_will_do_and_a_third_will_not() {
    let mut bench = Bench::new(LinkMode::Auto, Chip::new(0, FULL));
    bench.chip.second_id = 0xC131;
    assert!(bench.run(SETTLED).is_some());
    bench.chip.second_id = 0xC120;
    bench.chip.is_there = false;
    bench.run(Micros::from_millis(200));
    bench.chip.is_there = true;
    bench.run(Micros::from_seconds(2));
    assert_eq!((bench.phy.link(), bench.phy.fault()), (None, Some(Fault::Other)));
}

#[test]
fn a_line_at_ground_is_told_from_an_absent_chip() {
    let mut phy = Lan8720::new(LinkMode::Auto);
    for millis in 0..10 {
        if phy.next(Micros::from_millis(millis)).is_some() {
            phy.answer(Micros::from_millis(millis), 0);
        }
    }
    assert_eq!(phy.fault(), Some(Fault::Low));
}

#[test]
fn a_reset_that_does_not_end_has_a_limit() {
    let mut bench = Bench::new(LinkMode::Auto, Chip::new(0, FULL));
    bench.chip.resets = false;
    bench.run(Micros::from_millis(700));
    assert_eq!(bench.phy.fault(), Some(Fault::NoReset));
    bench.chip.resets = true;
    bench.run(Micros(RETRY.0 + SETTLED.0));
    assert_eq!((bench.phy.link().is_some(), bench.phy.fault()), (true, None));
}

#[test]
fn a_chip_that_lost_its_settings_gets_them_again() {
    let mut bench = Bench::new(LinkMode::Ten, Chip::new(0, FULL));
    assert_eq!(bench.run(SETTLED).map(|link| link.speed), Some(Speed::Ten));
    // Its supply failed: all it is strapped for is advertised again, or nothing is negotiated.
    for control in [control::NEGOTIATE, 0, control::POWER_DOWN] {
        bench.chip = Chip { control, done_at: Some(bench.now), ..Chip::new(0, FULL) };
        bench.run(SETTLED);
        assert_eq!(bench.phy.link().map(|link| link.speed), Some(Speed::Ten), "{control:#x}");
        assert_eq!(bench.phy.fault(), None);
    }
    bench.chip.keeps = false;
    bench.chip.advertisement = 0;
    bench.plug(FULL);
    bench.run(SETTLED);
    assert_eq!(bench.phy.link(), None);
}

#[test]
fn a_chip_that_keeps_nothing_is_a_fault() {
    let mut phy = Lan8720::new(LinkMode::Auto);
    let mut now = Micros(0);
    for _ in 0..2_000 {
        now = now.plus(Micros::from_millis(1));
        let Some(access) = phy.next(now) else { continue };
        let value = match access.register {
            0 => 0,
            1 => 0x782D,
            2 => 0x0007,
            3 => 0xC0F1,
            _ => 0x0001,
        };
        phy.answer(now, value);
    }
    assert_eq!((phy.link(), phy.fault()), (None, Some(Fault::Garbled)));
}

#[test]
fn a_bus_that_fails_begins_again() {
    let mut bench = Bench::new(LinkMode::Auto, Chip::new(0, FULL));
    assert!(bench.run(SETTLED).is_some());
    bench.phy.fail(bench.now);
    assert_eq!((bench.phy.link(), bench.phy.fault()), (None, Some(Fault::NoBus)));
    bench.run(Micros(RETRY.0 + SETTLED.0));
    assert_eq!((bench.phy.link().is_some(), bench.phy.fault()), (true, None));
}

#[test]
fn each_fault_says_what_to_do() {
    for fault in [Fault::Absent, Fault::Low, Fault::Other, Fault::NoReset, Fault::Garbled, Fault::NoBus] {
        assert!(fault.message().contains(": "), "{fault:?}");
    }
}
