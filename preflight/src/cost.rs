//! Cost of limits: the time of the same moves with what they ask for, and with what they are given.
//!
//! Both times are those of trapezoids with look-ahead, over a window of moves that goes along with the file;
//! half of it is settled at a time. Limits are lifted one after another, in the order of
//! [`Limit::ALL`], and each costs what the time becomes less by; so the parts make up the whole. A move
//! belongs to the limit that is the strictest for it.
//!
//! Between lifting none and lifting all nothing else changes: corners, lengths and overrides are those of the
//! moves as planned. So a file that asks for no more than it gets costs nothing at all.

use motion::Block;

use super::limits::Limit;

/// Number of moves that are looked ahead at.
const WINDOW: usize = 128;
/// Number of moves settled at a time.
const SETTLED: usize = WINDOW / 2;
/// Value that stands for no limit, in place of its number.
const NONE: u8 = u8::MAX;

/// Values that a move asks for, and is given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wish {
    /// Length of the path, mm.
    pub length: f64,
    /// Squared speed that the move's first corner allows, (mm/s)^2.
    pub corner_sq: f64,
    /// Speed asked for and given, mm/s.
    pub asked: f64,
    pub given: f64,
    /// Acceleration asked for and given, mm/s2.
    pub asked_acceleration: f64,
    pub given_acceleration: f64,
    /// Limits that cut speed and acceleration.
    pub cut_by: [Option<Limit>; 2],
}

impl Wish {
    /// Makes the wish of a block that is given all it asks for.
    pub fn granted(block: &Block, speed: f64) -> Self {
        let (length, corner_sq, acceleration) = (block.length, block.corner_sq, block.acceleration);
        Self {
            length,
            corner_sq,
            asked: speed,
            given: speed,
            asked_acceleration: acceleration,
            given_acceleration: acceleration,
            cut_by: [None; 2],
        }
    }

    /// Whether the move asks for more than it is given.
    pub fn is_cut(&self) -> bool {
        self.asked > self.given || self.asked_acceleration > self.given_acceleration
    }
}

/// Wish in the window: single precision is plenty, for both times are made of the same numbers.
#[derive(Clone, Copy, Debug)]
struct Move {
    length: f32,
    corner_sq: f32,
    speed: [f32; 2],
    acceleration: [f32; 2],
    cut_by: [u8; 2],
}

impl Move {
    /// Returns speed and acceleration with the limits before `lifted` lifted, mm/s and mm/s2.
    fn pace(&self, lifted: u8) -> (f32, f32) {
        let [speed_by, acceleration_by] = self.cut_by;
        let of = |[given, asked]: [f32; 2], by: u8| if by < lifted { asked } else { given };
        (of(self.speed, speed_by), of(self.acceleration, acceleration_by))
    }
}

/// Cost of limits so far, and the moves that are not settled yet.
#[derive(Clone, Debug)]
pub(super) struct Costs {
    window: heapless::Vec<Move, WINDOW>,
    /// Squared speeds at the window's beginning, with so many limits lifted.
    entry_sq: [f32; Limit::COUNT + 1],
    seconds: [f64; Limit::COUNT],
}

impl Default for Costs {
    fn default() -> Self {
        Self { window: heapless::Vec::new(), entry_sq: [0.0; Limit::COUNT + 1], seconds: [0.0; Limit::COUNT] }
    }
}

impl Costs {
    /// Forgets all costs and moves.
    pub fn clear(&mut self) {
        self.window.clear();
        (self.entry_sq, self.seconds) = ([0.0; Limit::COUNT + 1], [0.0; Limit::COUNT]);
    }

    /// Adds the next move to the window.
    pub fn push(&mut self, wish: &Wish) {
        let pair = |given: f64, asked: f64| [given as f32, asked as f32];
        // There is room, as moves are settled in time.
        let _ = self.window.push(Move {
            length: wish.length as f32,
            corner_sq: wish.corner_sq as f32,
            speed: pair(wish.given, wish.asked),
            acceleration: pair(wish.given_acceleration, wish.asked_acceleration),
            cut_by: wish.cut_by.map(|limit| limit.map_or(NONE, |limit| limit.index() as u8)),
        });
    }

    /// Whether [`Self::settle`] must come before another move and the corner before it.
    pub fn is_full(&self) -> bool {
        self.window.len() + 2 > WINDOW
    }

    /// Whether nothing is left to settle.
    pub fn is_settled(&self) -> bool {
        self.window.is_empty()
    }

    /// Settles the first half of a full window.
    pub fn settle(&mut self) {
        let count = SETTLED.min(self.window.len());
        self.settle_first(count);
        self.window.rotate_left(count);
        self.window.truncate(self.window.len() - count);
    }

    /// Settles the rest, as the path ends here.
    pub fn settle_all(&mut self) {
        self.settle_first(self.window.len());
        self.window.clear();
        self.entry_sq = [0.0; Limit::COUNT + 1];
    }

    /// Returns the cost of each limit, seconds.
    pub const fn seconds(&self) -> &[f64; Limit::COUNT] {
        &self.seconds
    }

    fn settle_first(&mut self, count: usize) {
        let Self { window, entry_sq, seconds } = self;
        let cut =
            window.iter().flat_map(|one| one.cut_by).filter(|by| *by != NONE).fold(0_u16, |all, by| all | 1 << by);
        let mut before = None;
        for (lifted, speed_sq) in entry_sq.iter_mut().enumerate() {
            let entry_sq = *speed_sq;
            let limit = lifted.checked_sub(1);
            if let (Some(limit), Some((same_entry, same_exit, _))) = (limit, before)
                && cut & (1 << limit) == 0
                && entry_sq == same_entry
            {
                *speed_sq = same_exit;
                continue;
            }
            let mut own = 0.0;
            *speed_sq = plan(window, lifted as u8, entry_sq, count, |move_seconds| own += f64::from(move_seconds));
            if let (Some((.., longer)), Some(cost)) = (before, limit.and_then(|limit| seconds.get_mut(limit))) {
                *cost += longer - own;
            }
            before = Some((entry_sq, *speed_sq, own));
        }
    }
}

/// Plans moves with the limits before `lifted` lifted, and tells the time of each of the first `count`.
/// Returns the squared speed behind these.
fn plan(moves: &[Move], lifted: u8, entry_sq: f32, count: usize, mut takes: impl FnMut(f32)) -> f32 {
    // Squared speeds at the moves' beginnings, the last move's first.
    let mut entries_sq = heapless::Vec::<f32, WINDOW>::new();
    let mut exit_sq = 0.0;
    let mut backwards = moves.iter().rev().peekable();
    while let Some(own) = backwards.next() {
        let (speed, acceleration) = own.pace(lifted);
        exit_sq = least(exit_sq + 2.0 * acceleration * own.length, speed * speed);
        if let Some(before) = backwards.peek() {
            let (speed_before, acceleration_before) = before.pace(lifted);
            // A corner's speed follows the lesser acceleration.
            let [given, now] = [[own.acceleration[0], before.acceleration[0]], [acceleration, acceleration_before]]
                .map(|[a, b]| least(a, b));
            exit_sq = least(least(exit_sq, speed_before * speed_before), own.corner_sq * now / given);
        }
        // There are no more moves than fit.
        let _ = entries_sq.push(exit_sq);
    }
    let mut speed_sq = entry_sq;
    for own in moves.iter().take(count) {
        let (speed, acceleration) = own.pace(lifted);
        let _own = entries_sq.pop();
        let next_sq = entries_sq.last().copied().unwrap_or(0.0);
        let exit_sq = least(next_sq, speed_sq + 2.0 * acceleration * own.length);
        takes(seconds(own.length, [speed_sq, exit_sq], speed, acceleration));
        speed_sq = exit_sq;
    }
    speed_sq
}

fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns the time of a trapezoid between these squared speeds.
fn seconds(length: f32, [entry_sq, exit_sq]: [f32; 2], speed: f32, acceleration: f32) -> f32 {
    let peak_sq = least(speed * speed, acceleration * length + 0.5 * (entry_sq + exit_sq));
    let [peak, entry, exit] = [peak_sq, entry_sq, exit_sq].map(libm::sqrtf);
    let ramps = (2.0 * peak_sq - entry_sq - exit_sq) / (2.0 * acceleration);
    let even = (length - ramps) / peak;
    let even = if even > 0.0 { even } else { 0.0 };
    (2.0 * peak - entry - exit) / acceleration + even
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use units::Axis;

    const Z: Limit = Limit::AxisSpeed(Axis::Z);

    fn wish(length: f64, asked: f64, given: f64) -> Wish {
        let cut_by = [(given < asked).then_some(Z), None];
        let (asked_acceleration, given_acceleration) = (1_000.0, 1_000.0);
        Wish { length, corner_sq: f64::INFINITY, asked, given, asked_acceleration, given_acceleration, cut_by }
    }

    fn cost_of(wishes: &[Wish]) -> [f64; Limit::COUNT] {
        let mut costs = Costs::default();
        for wish in wishes {
            costs.push(wish);
            if costs.is_full() {
                costs.settle();
            }
        }
        costs.settle_all();
        *costs.seconds()
    }

    /// Returns the time from rest to rest at constant acceleration.
    fn alone(length: f64, speed: f64, acceleration: f64) -> f64 {
        let peak = speed.min((acceleration * length).sqrt());
        2.0 * peak / acceleration + (length - peak * peak / acceleration) / peak
    }

    #[test]
    fn a_move_from_rest_to_rest_costs_the_difference_of_two_trapezoids() {
        for length in [0.5, 5.0, 80.0] {
            let cost = cost_of(&[wish(length, 100.0, 10.0)])[Z.index()];
            let expected = alone(length, 100.0, 1_000.0) - alone(length, 10.0, 1_000.0);
            assert!((cost + expected).abs() < 1e-4, "{length}: {cost} and {expected}");
        }
    }

    #[test]
    fn a_line_in_parts_costs_what_the_line_does() {
        let whole = cost_of(&[wish(100.0, 100.0, 10.0)])[Z.index()];
        let parts = cost_of(&[wish(0.1, 100.0, 10.0); 1_000])[Z.index()];
        assert!((whole - parts).abs() < 0.01 * whole, "{whole} {parts}");
    }

    #[test]
    fn each_limit_costs_its_share() {
        let slow = Wish { cut_by: [Some(Limit::PathSpeed), None], ..wish(10.0, 50.0, 25.0) };
        let lazy = Wish {
            asked_acceleration: 4_000.0,
            cut_by: [None, Some(Limit::MotorAcceleration(units::Actuator::Beta))],
            ..wish(10.0, 50.0, 50.0)
        };
        let stop = |wish: Wish| Wish { corner_sq: 0.0, ..wish };
        let cost = cost_of(&[stop(wish(10.0, 100.0, 10.0)), stop(slow), stop(lazy)]);
        let expected = [
            (Z, alone(10.0, 10.0, 1_000.0) - alone(10.0, 100.0, 1_000.0)),
            (Limit::PathSpeed, alone(10.0, 25.0, 1_000.0) - alone(10.0, 50.0, 1_000.0)),
            (Limit::MotorAcceleration(units::Actuator::Beta), alone(10.0, 50.0, 1_000.0) - alone(10.0, 50.0, 4_000.0)),
        ];
        for (limit, expected) in expected {
            assert!((cost[limit.index()] - expected).abs() < 1e-4, "{limit}: {cost:?} and {expected}");
        }
        let all: f64 = expected.iter().map(|(_, seconds)| seconds).sum();
        assert!((cost.iter().sum::<f64>() - all).abs() < 1e-3);
    }

    prop_compose! {
        fn any_wish()(length in 0.01..20.0_f64, corner in 0.0..200.0_f64, asked in 1.0..300.0_f64,
            share in 0.1..1.5_f64, acceleration in 100.0..5_000.0_f64, more in 0.5..3.0_f64, by in 0..12_usize) -> Wish {
            let (given, asked_acceleration) = (asked * share.min(1.0), acceleration * more.max(1.0));
            let cut_by = [(share < 1.0).then_some(Limit::ALL[by]), (more > 1.0).then_some(Limit::ALL[12 + by % 3])];
            Wish { length, corner_sq: corner * corner, asked, given, asked_acceleration,
                given_acceleration: acceleration, cut_by }
        }
    }

    proptest! {
        #[test]
        fn no_limit_saves_time(wishes in prop::collection::vec(any_wish(), 1..500)) {
            for (limit, cost) in Limit::ALL.into_iter().zip(cost_of(&wishes)) {
                let is_cut = wishes.iter().any(|wish| wish.cut_by.contains(&Some(limit)));
                prop_assert!(if is_cut { cost > -1e-3 } else { cost == 0.0 }, "{limit}: {cost}");
            }
        }
    }
}
